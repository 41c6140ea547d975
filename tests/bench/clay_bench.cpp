#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "modeling/clay/clay_closest.h"
#include "modeling/clay/clay_field.h"
#include "modeling/clay/clay_girths.h"
#include "modeling/clay/clay_operation.h"
#include "modeling/clay/clay_region.h"
#include "modeling/clay/clay_shapes.h"
#include "modeling/clay/clay_stroke.h"
#include "modeling/clay/patch_volume.h"

namespace annulus::bench {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 8.0;  ///< mm, of a finger.
constexpr double kDepth = 2.0;
constexpr double kRho = 2.0;

/// A block of 300 × 300 × 150 mm, `count` patches along its long edges, kneaded so that nothing of it is flat: 6,006
/// patches for 39, 24,024 for 78. Made once.
const ClayBody& Kneaded(std::int64_t count) {
  static std::map<std::int64_t, ClayBody> made;
  const auto found = made.find(count);
  if (found != made.end()) return found->second;
  const auto n = static_cast<std::size_t>(count);
  ClayBody body = std::move(*ClayBody::Make(ClayBlock(300.0, 150.0, n, (n - 1) / 2)));
  if (!Perform(body, KneadAct{8.0, 200.0, 3})) std::abort();
  return made.emplace(count, std::move(body)).first->second;
}

std::vector<double> Levels() { return {-125.0, -100.0, -75.0, -50.0, -25.0}; }

/// Where a finger acts in turn: along a side, at the height of the middle girth.
std::vector<ToolHold> HoldsOn(const ClayBody& body) {
  std::vector<ToolHold> holds;
  for (int n = -7; n <= 8; ++n) {
    ToolHold hold;
    hold.at = ClosestAddress(body, Vector3d(150.0, 14.0 * n, -75.0));
    hold.radius_mm = kRadius;
    hold.direction = Vector3d(-1.0, 0.0, 0.0);
    holds.push_back(hold);
  }
  return holds;
}

/// One push, or one pull that undoes it, whole: cut, deform, keep the volume, look for crossings, merge; then five
/// girths and tapes. `model`: 1 a rim rises, 2 the whole body swells.
void ClayPush(benchmark::State& state) {
  ClayBody body = Kneaded(state.range(0));
  const double start = body.volume();
  const std::vector<ToolHold> holds = HoldsOn(body);
  ClayGirths girths(body, Levels());
  std::size_t turn = 0;
  double worst = 0.0;
  double touched = 0.0;
  for (auto unused : state) {
    const double depth = turn % 2 == 0 ? kDepth : -kDepth;
    const auto report =
        Perform(body, PushAct{holds[turn / 2 % holds.size()], depth, static_cast<int>(state.range(1)), kRho});
    if (!report) return state.SkipWithError(report.error().Text().c_str());
    girths.Follow(body);
    for (std::size_t level = 0; level < girths.levels().size(); ++level) {
      benchmark::DoNotOptimize(girths.Perimeter(level));
      benchmark::DoNotOptimize(girths.Tape(level));
    }
    worst = std::max(worst, std::abs(report->volume_after_mm3 / start - 1.0));
    touched += static_cast<double>(report->touched);
    ++turn;
  }
  state.counters["patches"] = static_cast<double>(Kneaded(state.range(0)).mesh().leaf_count());
  state.counters["patches_afterwards"] = static_cast<double>(body.mesh().leaf_count());
  state.counters["touched"] = touched / static_cast<double>(turn);
  state.counters["volume_error"] = worst;
}
BENCHMARK(ClayPush)->ArgNames({"count", "model"})->ArgsProduct({{39, 78}, {1, 2}})->Unit(benchmark::kMillisecond);

/// The peer's deformation: the same dent and rim on a body that is cut already.
struct Cut {
  ClayBody body;
  ClayDeformation deformation;
};

Cut CutForAPush(std::int64_t count) {
  Cut cut{Kneaded(count), {}};
  const ToolHold hold = HoldsOn(cut.body).front();
  ToolPlace place;
  place.origin = cut.body.Point(hold.at);
  place.out = Vector3d::UnitX();
  place.along = Vector3d::UnitY();
  place.radius_along = place.radius_across = kRadius;
  place.reach = kRho * kRadius;
  if (!RefineAround(cut.body, hold.at, place.origin, kRho * kRadius, 0.5 * kRadius)) std::abort();
  const ClayMesh& mesh = cut.body.mesh();
  const ClayRegion region = RegionAround(mesh, mesh.Locate(hold.at).patch, place.origin, kRho * kRadius);
  const MaskWeight free(cut.body, {});
  cut.deformation.direct = MotionsOf(mesh, region.vertices, DentField(place, kDepth), free);
  cut.deformation.indirect = MotionsOf(mesh, region.vertices, RimField(place, kRho), free);
  return cut;
}

/// The peer: k by bisection, each time with the volume of the whole body integrated anew. It neither cuts nor merges
/// nor looks for crossings, and it has our quadrature, which is exact; a rule that is not would need more nodes.
void NaiveSearchForK(benchmark::State& state) {
  const Cut cut = CutForAPush(state.range(0));
  const ClayMesh& mesh = cut.body.mesh();
  VisitMarks marks;
  const ClayTrial trial(mesh, marks, cut.deformation);
  const auto volume_at = [&](double k) {
    double sum = 0.0;
    for (PatchIndex leaf = 0; leaf < mesh.patches().size(); ++leaf) {
      if (!mesh.alive(leaf)) continue;
      sum += ConeVolume(marks.Has(leaf) ? trial.NetAt(marks.Slot(leaf), k) : mesh.patch(leaf).net, Vector3d::Zero());
    }
    return sum;
  };
  const double wanted = cut.body.kept_volume();
  double error = 0.0;
  int integrals = 0;
  for (auto unused : state) {
    double low = 0.0;
    double high = 1.0;
    for (integrals = 1; volume_at(high) < wanted; ++integrals) high *= 2.0;
    error = 1.0;
    for (int step = 0; step < 60 && std::abs(error) > 1e-12; ++step, ++integrals) {
      const double middle = 0.5 * (low + high);
      error = volume_at(middle) / wanted - 1.0;
      (error < 0.0 ? low : high) = middle;
    }
    benchmark::DoNotOptimize(low);
  }
  state.counters["integrals"] = integrals;
  state.counters["volume_error"] = std::abs(error);
}
BENCHMARK(NaiveSearchForK)->ArgName("count")->Arg(39)->Arg(78)->Unit(benchmark::kMillisecond);

/// Ours, of the same deformation: a polynomial of the touched leaves alone, its root, the search for crossings, and
/// the body moved there.
void OurSearchForK(benchmark::State& state) {
  const Cut cut = CutForAPush(state.range(0));
  ClayBody body = cut.body;
  double error = 0.0;
  for (auto unused : state) {
    const auto change = body.Deform(cut.deformation, VolumeRule::kKept);
    if (!change) return state.SkipWithError(change.error().Text().c_str());
    error = std::max(error, std::abs(change->volume_after_mm3 / cut.body.kept_volume() - 1.0));
    state.PauseTiming();
    body = cut.body;
    state.ResumeTiming();
  }
  state.counters["volume_error"] = error;
}
BENCHMARK(OurSearchForK)->ArgName("count")->Arg(39)->Arg(78)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus::bench
