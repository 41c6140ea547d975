#include "modeling/landmarks/face_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/units.h"
#include "modeling/glasses/placement.h"
#include "sim/head.h"
#include "sim/person.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr std::size_t kColumns = 180;

/// A surface whose coefficients are the radius at the splines' centres: a C2 surface near the given one (smoothed by
/// about one knot distance), of intervals `step` mm high.
SplineSurface Sampled(const std::function<double(double theta, double z)>& radius, double z_min, double z_max,
                      double step) {
  const PeriodicCubicBasis theta(kColumns);
  const auto intervals = static_cast<std::size_t>((z_max - z_min) / step);
  const ClampedCubicBasis z(UniformBreakpoints(z_min, z_max, intervals));
  const std::vector<double>& b = z.breakpoints();
  const auto at = [&b](std::ptrdiff_t k) {
    return b[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, static_cast<std::ptrdiff_t>(b.size()) - 1))];
  };
  Eigen::VectorXd coefficients(static_cast<Eigen::Index>(kColumns * z.count()));
  for (std::size_t j = 0; j < z.count(); ++j) {
    // The Greville place: mean of the three inner knots of spline j.
    const auto k = static_cast<std::ptrdiff_t>(j);
    const double height = (at(k - 2) + at(k - 1) + at(k)) / 3.0;
    for (std::size_t i = 0; i < kColumns; ++i) {
      coefficients[static_cast<Eigen::Index>(j * kColumns + i)] =
          radius(static_cast<double>(i) * theta.spacing(), height);
    }
  }
  return SplineSurface(theta, z, coefficients);
}

/// What the ring sees of a subject: first hits of rays towards the axis. 0 where nothing is hit.
SplineSurface Seen(const sim::Subject& subject, double z_min, double z_max, double step) {
  constexpr double kRing = 700.0;
  return Sampled(
      [&subject](double theta, double z) {
        const Ray ray{PointFromCylindrical(theta, kRing, z), -PointFromCylindrical(theta, 1.0, 0.0)};
        const auto hit = subject.Cast(ray, 0.0, kRing);
        return hit ? kRing - hit->distance_mm : 0.0;
      },
      z_min, z_max, step);
}

double Miss(const FacePoint& found, const Vector3d& truth) { return (found.position - truth).norm(); }

TEST(FacePoints, AreFoundOnTheSimulatedHead) {
  const sim::ParametricBody head = sim::MakeHead({});
  const sim::FaceTruth truth = head.face();
  const auto face = FindFacePoints(Seen(head, head.top_mm() - 299.0, head.top_mm() - 1.0, 1.0));
  ASSERT_TRUE(face) << face.error().Text();
  EXPECT_LT(Miss(face->pronasale, truth.pronasale), 2.0);
  EXPECT_LT(Miss(face->sellion, truth.sellion), 4.0);
  EXPECT_LT(Miss(face->eye_right, truth.right_eye), 4.0);
  EXPECT_LT(Miss(face->eye_left, truth.left_eye), 4.0);
  EXPECT_LT(Miss(face->ear_right, truth.right_ear_top), 6.0);
  EXPECT_LT(Miss(face->ear_left, truth.left_ear_top), 6.0);
  EXPECT_NEAR(face->eye_right.position.x() - face->eye_left.position.x(), truth.right_eye.x() - truth.left_eye.x(),
              2.5);
  for (const NamedFacePoint& point : FacePointNames()) {
    EXPECT_EQ(((*face).*point.member).source, LandmarkSource::kDetected) << point.name;
  }
}

TEST(FacePoints, AreFoundOnSmallAndLargeTurnedHeads) {
  for (const double stature : {1450.0, 1950.0}) {
    for (const double yaw : {-0.1, 0.1}) {
      const sim::ParametricBody head = sim::MakeHead({stature, {-4.0, 6.0, yaw}});
      const sim::FaceTruth truth = head.face();
      const auto face = FindFacePoints(Seen(head, head.top_mm() - 259.0, head.top_mm() - 1.0, 1.0));
      ASSERT_TRUE(face) << face.error().Text();
      EXPECT_LT(Miss(face->pronasale, truth.pronasale), 3.0) << stature << " " << yaw;
      EXPECT_LT(Miss(face->eye_right, truth.right_eye), 8.0) << stature << " " << yaw;
      EXPECT_LT(Miss(face->eye_left, truth.left_eye), 8.0) << stature << " " << yaw;
      EXPECT_LT(Miss(face->ear_right, truth.right_ear_top), 8.0) << stature << " " << yaw;
      EXPECT_LT(Miss(face->ear_left, truth.left_ear_top), 8.0) << stature << " " << yaw;
    }
  }
}

TEST(FacePoints, AreFoundOnAStandingPerson) {
  const sim::ParametricBody person = sim::MakePerson({});
  const sim::FaceTruth truth = person.face();
  const auto face = FindFacePoints(Seen(person, person.bottom_mm() + 10.0, person.top_mm() - 2.0, 5.0));
  ASSERT_TRUE(face) << face.error().Text();
  EXPECT_LT(Miss(face->pronasale, truth.pronasale), 6.0);
  EXPECT_LT(Miss(face->eye_right, truth.right_eye), 10.0);
  EXPECT_LT(Miss(face->eye_left, truth.left_eye), 10.0);
  EXPECT_LT(Miss(face->ear_right, truth.right_ear_top), 12.0);
  EXPECT_LT(Miss(face->ear_left, truth.left_ear_top), 12.0);
}

TEST(FacePoints, SayWhenAnEarWasPlacedByProportion) {
  // An upright egg with a nose and nothing else: r = 75 + 20 sin²θ, a Gaussian nose 18 mm high, 7° wide.
  const auto radius = [](double theta, double z) {
    const double across = AngleDifference(theta, RadiansFromDegrees(90.0)) / RadiansFromDegrees(7.0);
    const double along = (z - 1550.0) / 14.0;
    const double front = std::sin(theta);
    return 75.0 + 20.0 * front * front + 18.0 * std::exp(-0.5 * (across * across + along * along));
  };
  const auto face = FindFacePoints(Sampled(radius, 1400.0, 1690.0, 2.0));
  ASSERT_TRUE(face) << face.error().Text();
  EXPECT_EQ(face->pronasale.source, LandmarkSource::kDetected);
  EXPECT_NEAR(face->pronasale.position.z(), 1550.0, 2.0);
  EXPECT_EQ(face->ear_right.source, LandmarkSource::kProportion);
  EXPECT_EQ(face->ear_left.source, LandmarkSource::kProportion);
  EXPECT_EQ(face->eye_right.source, LandmarkSource::kProportion);
  EXPECT_NEAR(face->eye_right.position.x(), 31.5, 1e-6);
  EXPECT_NEAR(face->eye_left.position.x(), -31.5, 1e-6);
  // Even so a frame can be placed.
  EXPECT_TRUE(PlaceFrame(test::PaperStyle("round"), *face));
}

TEST(FacePoints, RefuseACylinderAndAShortPiece) {
  const auto constant = [](double, double) { return 90.0; };
  const auto cylinder = FindFacePoints(Sampled(constant, 0.0, 300.0, 5.0));
  ASSERT_FALSE(cylinder);
  EXPECT_THAT(cylinder.error().Text(), HasSubstr("nose"));
  const auto piece = FindFacePoints(Sampled(constant, 0.0, 100.0, 5.0));
  ASSERT_FALSE(piece);
  EXPECT_THAT(piece.error().Text(), HasSubstr("100 mm high"));
}

TEST(FacePoints, LetAFrameBePlacedAndClearedOnTheSimulatedHead) {
  const sim::ParametricBody head = sim::MakeHead({});
  const SplineSurface surface = Seen(head, head.top_mm() - 299.0, head.top_mm() - 1.0, 1.0);
  const FacePoints face = FindFacePoints(surface).value();
  for (const test::FrameStyle& style : test::FrameStyles()) {
    const auto placed = PlaceFrame(style.parameters, face);
    ASSERT_TRUE(placed) << style.name << placed.error().Text();
    const auto worn = ClearHead(*placed, surface);
    ASSERT_TRUE(worn) << style.name << worn.error().Text();
    EXPECT_LE(worn->residuals.ear_right, 1e-6);
    // A rim as high as it is wide stands on the cheeks; nothing needs the 40 mm at which ClearHead gives up.
    EXPECT_LT(worn->forward_shift, 22.0) << style.name;
  }
}

}  // namespace
}  // namespace annulus
