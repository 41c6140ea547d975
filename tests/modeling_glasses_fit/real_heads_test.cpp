// Every style of the library on two scanned heads, judged by the search over all patches, which no fit uses.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "acquisition/csv_scan.h"
#include "base/storage.h"
#include "fitting/fit_surface.h"
#include "modeling/glasses/glasses_fit.h"
#include "modeling/landmarks/head_without_ears.h"
#include "modeling/measure/closest_point.h"
#include "tests/modeling_glasses_fit/test_frames.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// The folder with the shared scans: $ANNULUS_DATA, else ../shared/data beside the project.
std::filesystem::path DataFolder() {
  const char* const given = std::getenv("ANNULUS_DATA");
  return given != nullptr ? given : std::filesystem::path(test::SourceFolder()) / ".." / "shared" / "data";
}

/// Whether a point is between the surface and the ring's axis.
bool IsInside(const SplineSurface& surface, const Vector3d& p) {
  if (p.z() < surface.z_min() || p.z() > surface.z_max()) return false;
  return std::hypot(p.x(), p.y()) < surface.Radius(std::atan2(p.y(), p.x()), p.z());
}

/// Deepest entry of a worn frame, and the least distance of each pad, mm.
struct Judgement {
  double penetration = 0.0;
  std::string deepest;
  double pad_right = 1e3;
  double pad_left = 1e3;
};

Judgement Judge(const WornFrame& worn, const MeasuredSurface& head, const MeasuredSurface& without_ears) {
  Judgement judgement;
  const Frame frame = BuildWornFrame(worn).value();
  for (const FrameMesh& part : TessellateFrameParts(frame, {24, 16})) {
    const bool is_temple = part.name.starts_with("temple") || part.name.starts_with("arm");
    double* pad = part.name == "pad_right" ? &judgement.pad_right : nullptr;
    if (part.name == "pad_left") pad = &judgement.pad_left;
    double least = 1e3;
    Vector3d nearest = Vector3d::Zero();
    for (const Vector3d& p : part.mesh.vertices) {
      const double ear_y = p.x() > 0.0 ? worn.adjustment.temple_right.ear.y() : worn.adjustment.temple_left.ear.y();
      const MeasuredSurface& obstacle = is_temple && p.y() < ear_y - 3.0 ? without_ears : head;
      const Vector3d p_in_station = worn.station_from_frame * p;
      if (IsInside(obstacle.surface(), p_in_station)) {
        const auto closest = NearestOnSurface(obstacle, p_in_station);
        const double depth = closest ? -closest->signed_distance.value : 1e3;
        if (depth > judgement.penetration) judgement = {depth, part.name, judgement.pad_right, judgement.pad_left};
      }
      if (pad == nullptr) continue;
      const SplineSurface& skin = head.surface();
      const double gap = std::hypot(p_in_station.x(), p_in_station.y()) -
                         skin.Radius(std::atan2(p_in_station.y(), p_in_station.x()), p_in_station.z());
      if (gap >= least) continue;
      least = gap;
      nearest = p_in_station;
    }
    if (pad == nullptr) continue;
    const auto closest = NearestOnSurface(head, nearest);
    if (closest) *pad = closest->signed_distance.value;
  }
  return judgement;
}

class FitOnScannedHeads : public testing::TestWithParam<const char*> {};

TEST_P(FitOnScannedHeads, NothingEntersAndPadsTouchWhateverTheStyle) {
  const std::filesystem::path file = DataFolder() / (std::string(GetParam()) + "_noisy.csv.gz");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no data";
  PosixStorage storage;
  const auto scan = ReadCsvScan(storage, file.string());
  ASSERT_TRUE(scan) << scan.error().Text();
  const auto fitted = FitSurface(BuildSamples(*scan), {}, {});
  ASSERT_TRUE(fitted) << fitted.error().Text();
  const auto measured = MeasuredSurface::FromModel(fitted->model);
  ASSERT_TRUE(measured);
  const auto head = WearerHead::Look(*measured, {});
  ASSERT_TRUE(head) << head.error().Text();
  const auto bare = HeadWithoutEars::Find(measured->surface());
  ASSERT_TRUE(bare);
  SurfaceModel bare_model;
  bare_model.segments.push_back({"head", bare->surface(), fitted->model.main().knowledge, {}});
  const auto bare_measured = MeasuredSurface::FromModel(bare_model);
  ASSERT_TRUE(bare_measured);
  int padded = 0;
  int touching = 0;
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    if (style.sizes.empty()) continue;  // the paper's examples stand on rims and bridge
    SCOPED_TRACE(style.name);
    const auto fit = FitGlasses(*head, test::LibraryDesign(style.name, style.sizes.back().name), {});
    ASSERT_TRUE(fit) << fit.error().Text();
    const Judgement judgement = Judge(fit->worn, *measured, *bare_measured);
    EXPECT_LE(judgement.penetration, 0.05) << judgement.deepest;
    if (style.design.details.pads != PadForm::kNone) {
      ++padded;
      const bool touches = judgement.pad_right <= 0.3 && judgement.pad_left <= 0.3;
      if (touches) ++touching;
      // Where a saddle bridge meets the nose before the pads do, the frame is not for this nose and says so.
      EXPECT_TRUE(touches || !fit->wearable);
      if (!touches) {
        EXPECT_THAT(fit->advice, testing::Contains(testing::HasSubstr("does not touch the nose")));
      }
    }
    for (const FitGoal& goal : fit->goals) EXPECT_EQ(goal.met, goal.advice.empty()) << goal.id;
  }
  EXPECT_GE(touching, padded - 3);
}

INSTANTIATE_TEST_SUITE_P(Shared, FitOnScannedHeads, testing::Values("head_leeperrysmith", "head_ict_mix"));

}  // namespace
}  // namespace annulus
