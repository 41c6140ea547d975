// Frames on heads that are known exactly: every claim of a fit is judged on the head's own shape.

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <vector>

#include "modeling/glasses/glasses_fit.h"
#include "sim/random_head.h"
#include "tests/modeling_glasses_fit/test_frames.h"
#include "tests/modeling_glasses_fit/true_head.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kBehindEar = 3.0;  // mm: from there on a temple lies behind the ear

/// 20 heads, or 200 when there is time.
int HeadCount() { return std::getenv("ANNULUS_LONG") != nullptr ? 200 : 20; }

/// A finer surface than usual, so that it is the fit that is judged.
test::HeadSurfaceOptions FineSurface() {
  test::HeadSurfaceOptions options;
  options.columns = 720;
  options.face_step_mm = 0.5;
  options.elsewhere_step_mm = 1.5;
  return options;
}

struct TriedFrame {
  std::string name;
  FrameDesign design;
  FitSize size;
};

std::vector<TriedFrame> TriedFrames() {
  return {{"metal with pads on arms, as it is", test::LibraryDesign("panto", "medium"), FitSize::kKept},
          {"acetate with fixed pads, made to measure", test::LibraryDesign("wellington", "medium"),
           FitSize::kMadeToMeasure},
          {"rimless, as it is", test::LibraryDesign("rimless-oval", "medium"), FitSize::kKept}};
}

/// What is worst over all points of a worn frame, by the true head.
struct Judgement {
  double penetration = 0.0;
  std::string deepest;
  double pad_right = 1e3;
  double pad_left = 1e3;
};

Judgement Judge(const WornFrame& worn, const sim::ParametricBody& body, const sim::ParametricBody& without_ears) {
  const test::TrueHead head(body);
  const test::TrueHead bare(without_ears);
  Judgement judgement;
  const Frame frame = BuildWornFrame(worn).value();
  for (const FrameMesh& part : TessellateFrameParts(frame, {24, 16})) {
    const bool is_temple = part.name.starts_with("temple");
    const bool is_pad = part.name.starts_with("pad_right") || part.name.starts_with("pad_left");
    for (const Vector3d& p : part.mesh.vertices) {
      const double ear_y = p.x() > 0.0 ? worn.adjustment.temple_right.ear.y() : worn.adjustment.temple_left.ear.y();
      const test::TrueHead& obstacle = is_temple && p.y() < ear_y - kBehindEar ? bare : head;
      const Vector3d p_in_station = worn.station_from_frame * p;
      const double gap = obstacle.RadialGap(p_in_station);
      if (gap < 0.0) {
        const double depth = -obstacle.Distance(p_in_station, 20.0);
        if (depth > judgement.penetration) {
          judgement.penetration = depth;
          judgement.deepest = part.name;
        }
      }
      if (is_pad && gap < 3.0) {
        double& least = p.x() > 0.0 ? judgement.pad_right : judgement.pad_left;
        least = std::min(least, obstacle.Distance(p_in_station, 3.0));
      }
    }
  }
  return judgement;
}

const FitGoal& Goal(const GlassesFit& fit, const std::string& id) {
  for (const FitGoal& goal : fit.goals) {
    if (goal.id == id) return goal;
  }
  ADD_FAILURE() << "no goal " << id;
  return fit.goals.front();
}

/// Where the line of sight from the true eye meets the plane of its lens: from the frame's middle, and above the box.
struct TruePupil {
  double pd = 0.0;
  double height = 0.0;
};

TruePupil PupilOf(const WornFrame& worn, const Vector3d& eye, const Vector3d& sight, Eye side) {
  const Frame frame = BuildWornFrame(worn).value();
  const double sign = side == Eye::kRight ? 1.0 : -1.0;
  const Eigen::Isometry3d frame_from_station = worn.station_from_frame.inverse();
  // The left side is the mirror image of the right one.
  const auto mirrored = [sign](const Vector3d& v) { return Vector3d(sign * v.x(), v.y(), v.z()); };
  const Eigen::Isometry3d rim_from_frame = frame.rim.frame_from_rim.inverse();
  const Vector3d from = rim_from_frame * mirrored(frame_from_station * eye);
  const Vector3d along = rim_from_frame.linear() * mirrored(frame_from_station.linear() * sight);
  const Vector3d hit = from - from.y() / along.y() * along;
  const LensBox box = BoxOf(LensOutlineOf(frame, Eye::kRight));
  return {(frame.rim.frame_from_rim * hit).x(), hit.z() - (box.centre.y() - 0.5 * box.b)};
}

class FitOnHeads : public testing::TestWithParam<int> {};

TEST_P(FitOnHeads, NothingEntersTheTrueHeadPadsTouchAndPupilsAreWhereTheyAre) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const sim::HeadVariation variation = sim::DrawHeadVariation(seed);
  const sim::ParametricBody body = sim::MakeVariedHead(variation);
  const sim::ParametricBody without_ears = sim::MakeVariedHeadWithoutEars(variation);
  const SurfaceModel model = test::HeadSurface(body, FineSurface());
  const auto measured = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(measured);
  // The simulated person looks straight ahead; a Frankfurt plane is nothing that its shape was made by.
  FaceOverrides level;
  level.head_tilt = 0.0;
  const auto head = WearerHead::Look(*measured, level);
  ASSERT_TRUE(head) << head.error().Text();
  const Vector3d sight = Eigen::AngleAxisd(body.placement().yaw_rad, Vector3d::UnitZ()) * Vector3d::UnitY();
  for (const TriedFrame& tried : TriedFrames()) {
    SCOPED_TRACE(tried.name);
    GlassesFitOptions options;
    options.size = tried.size;
    const std::clock_t start = std::clock();
    const auto fit = FitGlasses(*head, tried.design, options);
    EXPECT_LE(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 1.0);
    ASSERT_TRUE(fit) << fit.error().Text();
    const Judgement judgement = Judge(fit->worn, body, without_ears);
    EXPECT_LE(judgement.penetration, 0.05) << judgement.deepest;
    EXPECT_LE(judgement.pad_right, 0.3);
    EXPECT_LE(judgement.pad_left, 0.3);
    for (const FitGoal& goal : fit->goals) EXPECT_EQ(goal.met, goal.advice.empty()) << goal.id;
    EXPECT_EQ(fit->wearable, fit->advice.empty());
    const TruePupil right = PupilOf(fit->worn, body.face().right_eye, sight, Eye::kRight);
    const TruePupil left = PupilOf(fit->worn, body.face().left_eye, sight, Eye::kLeft);
    EXPECT_NEAR(Goal(*fit, "pd_right").value, right.pd, 0.5);
    EXPECT_NEAR(Goal(*fit, "pd_left").value, left.pd, 0.5);
    EXPECT_NEAR(Goal(*fit, "pd_right").value + Goal(*fit, "pd_left").value, right.pd + left.pd, 0.5);
    EXPECT_NEAR(Goal(*fit, "pupil_height_right").value, right.height, 0.5);
    EXPECT_NEAR(Goal(*fit, "pupil_height_left").value, left.height, 0.5);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, FitOnHeads, testing::Range(1, HeadCount() + 1));

}  // namespace
}  // namespace annulus
