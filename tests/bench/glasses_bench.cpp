// What a slider of the glasses' page costs: the design adjusted, the frame built, all bodies as meshes.

#include <benchmark/benchmark.h>

#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_adjust.h"
#include "modeling/glasses/frame_mass.h"
#include "modeling/glasses/frame_walls.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

/// A frame with everything: grooves, bowed bridge, pads on wires, hinges, tips, frame curve and face form.
FrameDesign FullDesign() {
  FrameDesign design(test::PaperStyle("boston"));
  FrameDetails& details = design.details;
  details.bridge = BridgeForm::kSaddle;
  details.pads = PadForm::kAdjustable;
  details.temple = TempleForm::kSkull;
  details.hinge = HingeForm::kBarrel;
  details.bridge_gap = 18.0;
  details.arm_width = 4.0;
  details.groove_depth = 0.8;
  details.groove_width = 1.2;
  details.frame_curve = 4.0;
  details.face_form = 0.08;
  details.end_piece = 6.0;
  return design;
}

/// Arg: 0 the paper's frame, 1 the full one, 2 the full one with a size that must be adjusted.
void SliderChange(benchmark::State& state) {
  FrameDesign design = state.range(0) == 0 ? FrameDesign(test::PaperStyle("example4")) : FullDesign();
  if (state.range(0) == 2) design.parameters.bridge_height = 60.0;
  std::size_t triangles = 0;
  for (auto _ : state) {
    design.parameters.height += 1e-6;  // a slider that moves
    const auto adjusted = AdjustDesign(design);
    const auto frame = BuildFrame(adjusted->design, StandardAdjustment(adjusted->design));
    triangles = 0;
    for (const FrameBody& body : FrameBodies(*frame)) {
      for (const PatchShell& shell : body.shells) {
        const TriangleMesh mesh = Tessellate(shell, {12, 10, 1});
        triangles += mesh.faces.size();
        benchmark::DoNotOptimize(mesh.vertices.data());
      }
    }
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(SliderChange)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void FrameMassAndBalance(benchmark::State& state) {
  const auto frame = BuildFrame(FullDesign(), StandardAdjustment(FullDesign()));
  for (auto _ : state) benchmark::DoNotOptimize(MassOf(*frame, 1.28).mass);
}
BENCHMARK(FrameMassAndBalance)->Unit(benchmark::kMillisecond);

void FrameWalls(benchmark::State& state) {
  const auto frame = BuildFrame(FullDesign(), StandardAdjustment(FullDesign()));
  for (auto _ : state) benchmark::DoNotOptimize(WallsOf(*frame).size());
}
BENCHMARK(FrameWalls)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus
