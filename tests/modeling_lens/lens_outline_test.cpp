#include "modeling/glasses/lens_outline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/modeling_lens/lens_shapes.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

using test::Ellipse;
using test::Rectangle;
using testing::HasSubstr;

std::string Complaint(const LensOutline& outline) {
  const Status status = Validate(outline);
  return status ? "valid" : status.error().Text();
}

TEST(LensOutline, BoxOfARectangleIsTheRectangle) {
  const LensBox box = BoxOf(Rectangle(52.0, 38.0));
  EXPECT_DOUBLE_EQ(box.a, 52.0);
  EXPECT_DOUBLE_EQ(box.b, 38.0);
  EXPECT_DOUBLE_EQ(box.ed, std::hypot(52.0, 38.0));
  EXPECT_NEAR(box.circumference, 2.0 * (52.0 + 38.0), 1e-9);
  EXPECT_NEAR(box.centre.norm(), 0.0, 1e-12);
}

TEST(LensOutline, BoxOfAnEllipseOffTheOriginFollowsIt) {
  const LensBox box = BoxOf(Ellipse(50.0, 40.0, 3600, {3.0, -2.0}));
  EXPECT_NEAR(box.a, 50.0, 1e-9);
  EXPECT_NEAR(box.b, 40.0, 1e-9);
  EXPECT_NEAR(box.ed, 50.0, 1e-9);
  EXPECT_NEAR(box.centre.x(), 3.0, 1e-9);
  EXPECT_NEAR(box.centre.y(), -2.0, 1e-9);
  // Ramanujan's second formula for the perimeter of an ellipse.
  const double h = std::pow(5.0 / 45.0, 2);
  EXPECT_NEAR(box.circumference, kPi * 45.0 * (1.0 + 3.0 * h / (10.0 + std::sqrt(4.0 - 3.0 * h))), 1e-3);
}

TEST(LensOutline, RadiiOfARectangleAreThoseOfItsSides) {
  const std::vector<double> radii = RadiiOf(Rectangle(60.0, 40.0), 720);
  ASSERT_EQ(radii.size(), 720U);
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const double angle = kTwoPi * static_cast<double>(i) / 720.0;
    const double expected = std::min(30.0 / std::abs(std::cos(angle)), 20.0 / std::abs(std::sin(angle)));
    EXPECT_NEAR(radii[i], expected, 1e-9) << i;
  }
}

TEST(LensOutline, RadiiGiveTheSameOutlineBack) {
  const LensOutline outline = OutlineFromRadii(RadiiOf(Ellipse(51.0, 37.0, 800, {2.0, 9.0}), 800));
  ASSERT_EQ(Complaint(outline), "valid");
  for (const Eigen::Vector2d& point : outline.points) {
    EXPECT_NEAR(std::pow(point.x() / 25.5, 2) + std::pow(point.y() / 18.5, 2), 1.0, 1e-4);
  }
  const std::vector<double> once = RadiiOf(outline, 800);
  const std::vector<double> twice = RadiiOf(OutlineFromRadii(once), 800);
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_NEAR(once[i], twice[i], 1e-9);
}

TEST(LensOutline, MirroredTwiceIsTheOutlineAndMirroredOnceIsValid) {
  const LensOutline outline = Ellipse(48.0, 36.0, 200, {4.0, 1.0});
  const LensOutline mirrored = Mirrored(outline);
  EXPECT_EQ(Complaint(mirrored), "valid");
  EXPECT_NEAR(BoxOf(mirrored).centre.x(), -4.0, 1e-12);
  const LensOutline again = Mirrored(mirrored);
  EXPECT_EQ(again.points, outline.points);
}

TEST(LensOutline, RefusesWhatIsNoOutline) {
  EXPECT_THAT(Complaint(Ellipse(50.0, 40.0, 89)), HasSubstr("it has 89 points, fewer than 90"));
  LensOutline clockwise = Ellipse(50.0, 40.0);
  std::reverse(clockwise.points.begin(), clockwise.points.end());
  EXPECT_THAT(Complaint(clockwise), HasSubstr("counter-clockwise"));
  LensOutline broken = Ellipse(50.0, 40.0);
  broken.points[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Complaint(broken), HasSubstr("point 7 is not a number"));
  LensOutline folded = Ellipse(50.0, 40.0);
  std::swap(folded.points[10], folded.points[11]);
  EXPECT_THAT(Complaint(folded), HasSubstr("box centre"));
  LensOutline twice = Ellipse(50.0, 40.0);
  const auto once = twice.points;
  twice.points.insert(twice.points.end(), once.begin(), once.end());
  EXPECT_THAT(Complaint(twice), HasSubstr("more than once"));
  // A crescent: its box centre lies outside.
  LensOutline crescent;
  for (int i = 0; i <= 100; ++i) {
    const double t = -1.4 + 2.8 * i / 100.0;
    crescent.points.emplace_back(30.0 * std::cos(t), 30.0 * std::sin(t));
  }
  for (int i = 100; i >= 0; --i) {
    const double t = -1.4 + 2.8 * i / 100.0;
    crescent.points.emplace_back(30.0 * std::cos(t) - 2.0, 29.0 * std::sin(t));
  }
  EXPECT_THAT(Complaint(crescent), HasSubstr("box centre"));
}

TEST(LensOutline, RadiiOfRandomStarsAreTheRadiiTheyWereMadeOf) {
  test::Dice dice(11);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> radii(180);
    // Symmetric about both axes, so that the origin is the box centre.
    std::vector<double> quarter(46);
    for (double& radius : quarter) radius = dice.Between(18.0, 20.0);
    for (std::size_t i = 0; i < 180; ++i) {
      const std::size_t folded = i % 90 <= 45 ? i % 90 : 90 - i % 90;
      radii[i] = quarter[folded];
    }
    const LensOutline outline = OutlineFromRadii(radii);
    ASSERT_EQ(Complaint(outline), "valid");
    const std::vector<double> read = RadiiOf(outline, 180);
    for (std::size_t i = 0; i < 180; ++i) EXPECT_NEAR(read[i], radii[i], 1e-9);
  }
}

}  // namespace
}  // namespace annulus
