#include "modeling/glasses/pose_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/random_head.h"
#include "tests/modeling_glasses_fit/test_frames.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A front of two flat lenses, 50 × 40 mm, 70 mm between their centres, in the plane y = 0.
FrontShape FlatFront() {
  FrontShape front;
  for (std::size_t side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    front.lenses[side].centre = {sign * 35.0, 0.0, 0.0};
    front.lenses[side].a = 50.0;
    front.lenses[side].b = 40.0;
    front.hinges[side] = {sign * 68.0, 0.0, 10.0};
  }
  return front;
}

GoalInputs EyesAt(double lateral) {
  GoalInputs inputs;
  inputs.eyes = {Vector3d(lateral, 0.0, 0.0), Vector3d(-lateral, 0.0, 0.0)};
  inputs.ears = {Vector3d(75.0, -90.0, 10.0), Vector3d(-75.0, -90.0, 10.0)};
  return inputs;
}

TEST(GoalNumbers, FollowPlaneGeometry) {
  FrontPose pose;
  pose.shift = {0.0, 15.0, -3.0};
  const auto upright = NumbersOf(FlatFront(), EyesAt(32.0), pose);
  EXPECT_NEAR(upright.vertex_distance[0], 15.0 - kLensBackBehindRim, 1e-12);
  EXPECT_NEAR(upright.decentration[0], 3.0, 1e-12);
  EXPECT_NEAR(upright.decentration[1], 3.0, 1e-12);
  EXPECT_NEAR(upright.pupil_above_centre[0], 3.0, 1e-12);
  EXPECT_NEAR(upright.pantoscopic_tilt, 0.0, 1e-12);
  EXPECT_NEAR(upright.temple_splay[0], std::atan2(75.0 - 68.0, 105.0), 1e-12);

  pose.shift = {0.0, 15.0, 0.0};
  pose.tilt = RadiansFromDegrees(10.0);
  const auto tilted = NumbersOf(FlatFront(), EyesAt(35.0), pose);
  EXPECT_NEAR(DegreesFromRadians(tilted.pantoscopic_tilt), 10.0, 1e-9);
  // The back, 2 mm behind along the normal, is met 2 / cos 10° earlier.
  EXPECT_NEAR(tilted.vertex_distance[1], 15.0 - 2.0 / std::cos(pose.tilt), 1e-12);
  EXPECT_NEAR(tilted.pupil_above_centre[1], 0.0, 1e-12);

  pose.tilt = 0.0;
  pose.yaw = RadiansFromDegrees(4.0);
  const auto turned = NumbersOf(FlatFront(), EyesAt(35.0), pose);
  EXPECT_NEAR(DegreesFromRadians(turned.yaw), 4.0, 1e-9);
  EXPECT_NEAR(turned.face_form, 0.0, 1e-12);
  // Turned to the left, the right lens comes forward: by x·tan about the middle.
  EXPECT_NEAR(turned.vertex_distance[0] - turned.vertex_distance[1], 2.0 * 35.0 * std::tan(pose.yaw), 1e-9);
}

TEST(GoalNumbers, FaceFormIsHowFarTheLensesTurnOutward) {
  FrontShape front = FlatFront();
  const double wrap = RadiansFromDegrees(6.0);
  for (std::size_t side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    front.lenses[side].forward = {sign * std::sin(wrap), std::cos(wrap), 0.0};
    front.lenses[side].right = {std::cos(wrap), -sign * std::sin(wrap), 0.0};
  }
  EXPECT_NEAR(DegreesFromRadians(NumbersOf(front, EyesAt(33.0), FrontPose()).face_form), 6.0, 1e-9);
}

TEST(FrontPose, ReadsBackFromItsTransform) {
  FrontPose pose;
  pose.shift = {1.0, -2.0, 3.0};
  pose.tilt = 0.15;
  pose.roll = -0.07;
  pose.yaw = 0.04;
  const FrontPose again = PoseFrom(pose.HeadFromFrame());
  EXPECT_LT((again.shift - pose.shift).norm(), 1e-12);
  EXPECT_NEAR(again.tilt, pose.tilt, 1e-12);
  EXPECT_NEAR(again.roll, pose.roll, 1e-12);
  EXPECT_NEAR(again.yaw, pose.yaw, 1e-12);
  // A positive tilt brings the lower edge nearer to the face.
  EXPECT_LT((pose.HeadFromFrame().linear() * Vector3d(0, 0, -1)).y(), 0.0);
}

class PoseProblemOnAHead : public testing::Test {
 protected:
  PoseProblemOnAHead()
      : body_(sim::MakeRandomHead(11)),
        model_(test::HeadSurface(body_)),
        measured_(MeasuredSurface::FromModel(model_).value()),
        head_(WearerHead::Look(measured_, {}).value()) {}

  [[nodiscard]] PoseTask Task(const FrameDesign& design, FitSize size) const {
    PoseTask task;
    task.head = &head_;
    task.design = design;
    task.size = size;
    const Eigen::Isometry3d head_from_station = head_.station_from_head().inverse();
    task.inputs.eyes = {head_from_station * head_.eye(Eye::kRight), head_from_station * head_.eye(Eye::kLeft)};
    task.inputs.ears = {head_from_station * head_.ear(Eye::kRight), head_from_station * head_.ear(Eye::kLeft)};
    return task;
  }

  sim::ParametricBody body_;
  SurfaceModel model_;
  MeasuredSurface measured_;
  WearerHead head_;
};

TEST_F(PoseProblemOnAHead, ItsJacobianIsThatOfNumericDifferences) {
  std::mt19937_64 random(20260202);
  std::uniform_real_distribution<double> shift(-1.5, 1.5);
  std::uniform_real_distribution<double> angle(-0.05, 0.05);
  for (const FitSize size : {FitSize::kKept, FitSize::kMadeToMeasure}) {
    for (const char* style : {"panto", "wellington"}) {
      const auto problem = PoseProblem::Make(Task(test::LibraryDesign(style, "medium"), size));
      ASSERT_TRUE(problem) << problem.error().Text();
      FrontState state = problem->Start();
      state.pose.shift += Vector3d(shift(random), shift(random), shift(random));
      state.pose.tilt += angle(random);
      state.pose.roll += angle(random);
      state.pose.yaw += angle(random);
      Eigen::VectorXd residuals;
      Eigen::MatrixXd jacobian;
      ASSERT_TRUE(problem->Evaluate(state, residuals, &jacobian));
      ASSERT_EQ(residuals.size(), problem->residual_count());
      for (int k = 0; k < FrontState::kSize; ++k) {
        if (!problem->IsFree(k)) continue;
        // The size's columns are differences of the frame themselves, over 1e-3.
        const double step = k < FrontState::kPoseSize ? 1e-5 : 5e-3;
        Eigen::VectorXd above;
        Eigen::VectorXd below;
        auto values = state.Vector();
        values[k] += step;
        ASSERT_TRUE(problem->Evaluate(FrontState::FromVector(values.data()), above, nullptr));
        values[k] -= 2.0 * step;
        ASSERT_TRUE(problem->Evaluate(FrontState::FromVector(values.data()), below, nullptr));
        const Eigen::VectorXd numeric = (above - below) / (2.0 * step);
        const double difference = (jacobian.col(k) - numeric).norm();
        const double share = k < FrontState::kPoseSize ? 1e-5 : 3e-2;
        EXPECT_LE(difference, share * numeric.norm() + 1e-4) << style << " variable " << k;
      }
    }
  }
}

TEST_F(PoseProblemOnAHead, StartsWithThePupilsWhereTheyAreWanted) {
  const auto problem = PoseProblem::Make(Task(test::LibraryDesign("panto", "medium"), FitSize::kKept));
  ASSERT_TRUE(problem);
  const FrontState start = problem->Start();
  const auto front = problem->Front(start);
  ASSERT_TRUE(front);
  const auto numbers = NumbersOf(*front, problem->task().inputs, start.pose);
  EXPECT_NEAR(0.5 * (numbers.vertex_distance[0] + numbers.vertex_distance[1]), 13.0, 1.0);
  EXPECT_NEAR(DegreesFromRadians(numbers.pantoscopic_tilt), 10.0, 1.0);  // the face form tilts the lenses a little
  EXPECT_NEAR(0.5 * (numbers.pupil_above_centre[0] + numbers.pupil_above_centre[1]), 3.0, 3.0);
}

TEST_F(PoseProblemOnAHead, ASolutionIsNoWorseThanItsNeighbours) {
  const auto problem = PoseProblem::Make(Task(test::LibraryDesign("panto", "medium"), FitSize::kKept));
  ASSERT_TRUE(problem);
  const auto solved = problem->Solve(problem->Start());
  Eigen::VectorXd residuals;
  for (int k = 0; k < FrontState::kPoseSize; ++k) {
    for (const double step : {-0.02, 0.02}) {
      auto values = solved.state.Vector();
      values[k] += step;
      ASSERT_TRUE(problem->Evaluate(FrontState::FromVector(values.data()), residuals, nullptr));
      EXPECT_GE(0.5 * residuals.squaredNorm(), solved.cost - 1e-3) << k;
    }
  }
}

}  // namespace
}  // namespace annulus
