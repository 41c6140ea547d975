#include <benchmark/benchmark.h>

#include <cstdint>
#include <numbers>
#include <vector>

#include "base/storage.h"
#include "modeling/flatten/flat_element.h"
#include "modeling/flatten/flat_pattern.h"
#include "modeling/flatten/flatten.h"
#include "modeling/flatten/pattern_json.h"
#include "tests/modeling_flatten/flat_bodies.h"
#include "tests/modeling_flatten/sheet_shapes.h"
#include "tests/support/folders.h"

namespace annulus::bench {
namespace {

/// A hemisphere of 100 mm: 6·range² triangles.
CurvedSheet Hemisphere(std::int64_t rings) {
  return SheetOfMesh(test::Cap(100.0, 0.5 * std::numbers::pi, static_cast<std::uint32_t>(rings)));
}

double EnergyOf(const CurvedSheet& sheet, const std::vector<Eigen::Vector2d>& flat) {
  const std::vector<FlatElement> elements = ElementsOf(sheet);
  const Eigen::Matrix3d stiffness = Stiffness({});
  double energy = 0.0;
  for (std::size_t f = 0; f < elements.size(); ++f) {
    FlatElement::Corners corners;
    for (std::size_t k = 0; k < 3; ++k) corners.col(static_cast<Eigen::Index>(k)) = flat[sheet.faces[f][k]];
    energy += elements[f].Energy(corners, stiffness);
  }
  return energy;
}

void FlattenElastic(benchmark::State& state) {
  const CurvedSheet sheet = Hemisphere(state.range(0));
  double energy = 0.0;
  for (auto unused : state) energy = Flatten(sheet, {})->energy;
  state.counters["energy"] = energy;
}
BENCHMARK(FlattenElastic)->Arg(10)->Arg(29)->Unit(benchmark::kMillisecond);

/// The peer: the conformal map alone. Its energy over ours is what the elastic body is worth.
void FlattenConformal(benchmark::State& state) {
  const CurvedSheet sheet = Hemisphere(state.range(0));
  const auto topology = CheckSheet(sheet);
  std::vector<Eigen::Vector2d> flat;
  for (auto unused : state) flat = ConformalMap(sheet, *topology, {{0, 1}});
  state.counters["energy"] = EnergyOf(sheet, flat);
  state.counters["energy_ratio"] = EnergyOf(sheet, flat) / Flatten(sheet, {})->energy;
}
BENCHMARK(FlattenConformal)->Arg(10)->Arg(29)->Unit(benchmark::kMillisecond);

/// The bodice of docs/examples on a trunk: from the lines to the flat pieces.
void FlattenBodice(benchmark::State& state) {
  PosixStorage storage;
  const auto text = ReadTextFile(storage, test::SourceFolder() + "/docs/examples/flatten/bodice.json");
  const auto pattern = PatternFromJson(*text, "bodice.json");
  const SurfaceSegment trunk = test::Trunk(130.0, 25.0);
  std::size_t triangles = 0;
  for (auto unused : state) {
    const auto flat = FlattenPattern(*pattern, test::OnTrunk(trunk), {});
    triangles = 0;
    for (const FlatPiece& piece : flat->pieces) triangles += piece.strains.size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(FlattenBodice)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus::bench
