#include "modeling/landmarks/eyeball.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "base/frames.h"
#include "modeling/landmarks/face_from_landmarks.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/landmarks/nose_flank.h"
#include "sim/random_head.h"
#include "tests/modeling_measure/interpolated_body.h"
#include "tests/support/head_surface.h"
#include "tests/support/scanned_head.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A column of radius 88 mm with balls of 12.4 mm radius sunk in it; the smooth maximum of both.
struct BallsInAColumn {
  Vector3d right{31.0, 75.5, 1580.0};
  Vector3d left{-33.0, 74.5, 1581.5};

  [[nodiscard]] double Radius(double theta, double z) const {
    constexpr double kColumn = 85.0;
    double r = kColumn;
    for (const Vector3d& ball : {right, left}) {
      const double squared = 12.4 * 12.4 - (z - ball.z()) * (z - ball.z());
      const double along = ball.x() * std::cos(theta) + ball.y() * std::sin(theta);
      const double across = ball.x() * std::sin(theta) - ball.y() * std::cos(theta);
      if (squared > across * across) r = std::max(r, along + std::sqrt(squared - across * across));
    }
    return r;
  }
  [[nodiscard]] SurfaceModel Model() const {
    return test::InterpolatedBody([this](double theta, double z) { return Radius(theta, z); }, 360,
                                  UniformBreakpoints(1500.0, 1680.0, 180));
  }
};

MidPlane Ahead() {
  MidPlane plane;
  plane.yaw = kPi / 2.0;
  plane.z = 1580.0;
  return plane;
}
const Vector3d kRoot(0.0, 95.0, 1586.0);

TEST(Eyeball, IsFoundWhereBallsAreSunkInAColumn) {
  const BallsInAColumn balls;
  const SurfaceModel model = balls.Model();
  const SplineSurface& surface = model.main().surface;
  const Eyeballs eyes = FindEyeballs(surface, HeadGrid(surface, 180.0), Ahead(), kRoot);
  ASSERT_TRUE(eyes.right && eyes.left);
  EXPECT_LT((eyes.right->centre - balls.right).norm(), 0.25);
  EXPECT_LT((eyes.left->centre - balls.left).norm(), 0.25);
  EXPECT_NEAR(eyes.right->radius, 12.4, 0.2);
  EXPECT_GT(eyes.right->share, 0.8);
  EXPECT_LT(eyes.right->spread, 0.1);
}

TEST(Eyeball, IsNotInventedOnAColumn) {
  const SurfaceModel model =
      test::InterpolatedBody([](double, double) { return 90.0; }, 180, UniformBreakpoints(1500.0, 1680.0, 90));
  const SplineSurface& surface = model.main().surface;
  const Eyeballs eyes = FindEyeballs(surface, HeadGrid(surface, 180.0), Ahead(), kRoot);
  EXPECT_FALSE(eyes.right);
  EXPECT_FALSE(eyes.left);
}

TEST(Eyeball, MovesWithTheSurfaceAsItsGradientSays) {
  // Smooth patterns of errors: the fit's weights and window follow them too, which the gradient leaves out.
  const BallsInAColumn balls;
  const SurfaceModel model = balls.Model();
  const SplineSurface& surface = model.main().surface;
  const Eyeball ball = *FindEyeballs(surface, HeadGrid(surface, 180.0), Ahead(), kRoot).right;
  const EyeballEstimates estimates = EstimateEyeball(surface, Ahead(), ball);
  EXPECT_NEAR(estimates.lateral.value, ball.centre.x(), 1e-12);
  EXPECT_NEAR(estimates.z.value, ball.centre.z(), 1e-12);
  for (const double phase : {0.0, 1.0, 2.0}) {
    Eigen::VectorXd pattern(surface.coefficients().size());
    for (Eigen::Index k = 0; k < pattern.size(); ++k) {
      const auto column = static_cast<double>(k % 360);
      const auto row = static_cast<double>(k / 360);
      pattern[k] = std::sin(0.15 * column + 0.12 * row + phase);
    }
    const auto along = [&](double step) {
      const SplineSurface changed(surface.theta_basis(), surface.z_basis(), surface.coefficients() + step * pattern);
      return FindEyeballs(changed, HeadGrid(changed, 180.0), Ahead(), kRoot).right->centre;
    };
    constexpr double kStep = 0.02;
    const Vector3d by_step = (along(kStep) - along(-kStep)) / (2.0 * kStep);
    EXPECT_NEAR(estimates.lateral.gradient.dot(pattern), by_step.x(), 0.35 * std::abs(by_step.x()) + 0.15) << phase;
    EXPECT_NEAR(estimates.z.gradient.dot(pattern), by_step.z(), 0.35 * std::abs(by_step.z()) + 0.15) << phase;
  }
}

TEST(FaceFromLandmarks, NamesWhatIsMissing) {
  const SurfaceModel model = test::HeadSurface(sim::MakeRandomHead(3));
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(body);
  const auto none = FaceFromLandmarks({}, *body);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().Text().find("eye_right"), std::string::npos);
  Landmarks landmarks = FindLandmarks(*body, {});
  const auto face = FaceFromLandmarks(landmarks, *body);
  ASSERT_TRUE(face) << face.error().Text();
  // Without a covariance it is the placing: half a millimetre both ways along the surface.
  EXPECT_NEAR(std::sqrt(face->eye_right.covariance(2, 2)), 0.5, 0.1);
  EXPECT_EQ(face->eye_right.position, landmarks.Find("eye_right")->position);
  EXPECT_GT(face->forehead.position.z(), face->sellion.position.z() + 20.0);
}

/// Scans of different heads: 4; ANNULUS_LONG: 24.
TEST(ScannedHeads, HaveTheirEyesWithinTheirUncertainty) {
  const std::uint64_t count = std::getenv("ANNULUS_LONG") != nullptr ? 24 : 4;
  int values = 0;
  int outside = 0;
  double squares = 0.0;
  double distances = 0.0;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    const sim::ParametricBody head = sim::MakeRandomHead(seed);
    const sim::FaceTruth truth = head.face();
    const auto fit = test::ScannedHead(head, seed);
    ASSERT_TRUE(fit) << fit.error().Text();
    const auto body = MeasuredSurface::FromModel(fit->model);
    ASSERT_TRUE(body) << body.error().Text();
    const auto face = FaceFromLandmarks(FindLandmarks(*body, {}), *body);
    ASSERT_TRUE(face) << face.error().Text();
    for (const auto& [found, at] :
         {std::pair{face->eye_right, truth.right_eye}, std::pair{face->eye_left, truth.left_eye}}) {
      for (const int axis : {0, 2}) {
        const double sigma = std::sqrt(found.covariance(axis, axis));
        const double relative = (found.position[axis] - at[axis]) / sigma;
        squares += relative * relative;
        if (std::abs(relative) > 2.5) ++outside;
        ++values;
      }
    }
    distances = std::max(distances, std::abs((face->eye_right.position - face->eye_left.position).head<2>().norm() -
                                             (truth.right_eye - truth.left_eye).head<2>().norm()));
    const auto found = FindFaceAndEars(body->surface(), HeadGrid(body->surface(), kHeadDepth));
    const auto nose = CutNose(body->surface(), found->plane, found->face, truth.sellion.z() - 9.0);
    ASSERT_TRUE(nose);
    const auto flank = FindNoseFlank(*body, found->plane, *nose, BodySide::kLeft, 7.0);
    ASSERT_TRUE(flank);
    EXPECT_GT(flank->sigma, 0.01);
    EXPECT_LT(flank->sigma, 0.5);
  }
  std::printf("eyes of %zu scanned heads: errors over sigma rms %.2f, PD within %.2f mm\n",
              static_cast<std::size_t>(count), std::sqrt(squares / values), distances);
  EXPECT_LT(std::sqrt(squares / values), 1.6);
  EXPECT_LE(outside, values / 8);
  EXPECT_LT(distances, 2.0);
}

}  // namespace
}  // namespace annulus
