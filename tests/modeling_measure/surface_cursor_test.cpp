#include "modeling/measure/surface_cursor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

const std::vector<double> kBreaks = UniformBreakpoints(0.0, 300.0, 60);
const double kNan = std::numeric_limits<double>::quiet_NaN();

SurfaceModel Cylinder() {
  return InterpolatedBody([](double, double) { return 100.0; }, 36, kBreaks);
}

/// r = 150 - z/4.
SurfaceModel Cone() {
  return InterpolatedBody([](double, double z) { return 150.0 - 0.25 * z; }, 36, kBreaks);
}

SurfaceModel Wavy() {
  return InterpolatedBody(
      [](double theta, double z) { return 120.0 + 15.0 * std::cos(3.0 * theta) + 10.0 * std::sin(z / 25.0 + theta); },
      120, kBreaks);
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

CursorMove Value(const Result<CursorMove>& move) {
  if (!move) throw std::runtime_error(move.error().Text());
  return *move;
}

TEST(SurfaceCursor, GoesStraightOnACylinderOnAHelix) {
  // Unrolled, a cylinder is a plane: theta = s cos(h) / R, z = z0 + s sin(h); the heading stays.
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  for (const double heading : {0.0, 0.3, 1.2, 2.0, -0.4}) {
    const CursorMove move = Value(MoveCursorStraight(body, {6.0, 150.0}, heading, 123.4));
    EXPECT_EQ(move.stop, CursorStop::kArrived);
    EXPECT_NEAR(AngleDifference(move.place.theta, 6.0 + 1.234 * std::cos(heading)), 0.0, 1e-10);
    EXPECT_NEAR(move.place.z, 150.0 + 123.4 * std::sin(heading), 1e-8);
    EXPECT_NEAR(AngleDifference(move.heading, heading), 0.0, 1e-9);
    EXPECT_NEAR(move.travelled, 123.4, 1e-9);
    EXPECT_GE(move.place.theta, 0.0);
    EXPECT_LT(move.place.theta, kTwoPi);
  }
}

TEST(SurfaceCursor, GoesStraightOnAConeAsOnItsUnrolledSector) {
  // Slant distance to the apex is rho = r·√(1+k²)/k, the sector's angle phi = theta·k/√(1+k²), k = 1/4. A straight line
  // there: from (rho0, phi = 0) at heading h (towards the apex = up): x = rho0 - s sin(h), y = s cos(h).
  const SurfaceModel model = Cone();
  const MeasuredSurface body = Measured(model);
  const double slope = 0.25;
  const double slant = std::hypot(1.0, slope);
  const double z0 = 40.0;
  const double rho0 = (150.0 - slope * z0) * slant / slope;
  for (const double heading : {0.2, 0.8, 1.5}) {
    const double s = 180.0;
    const CursorMove move = Value(MoveCursorStraight(body, {1.0, z0}, heading, s));
    const double x = rho0 - s * std::sin(heading);
    const double y = s * std::cos(heading);
    const double rho = std::hypot(x, y);
    const double phi = std::atan2(y, x);
    EXPECT_NEAR(move.place.theta, 1.0 + phi * slant / slope, 1e-8);
    EXPECT_NEAR(move.place.z, (150.0 - rho * slope / slant) / slope, 1e-6);
    EXPECT_NEAR(AngleDifference(move.heading, heading - phi), 0.0, 1e-8);  // the line is straight, the level turns
  }
}

TEST(SurfaceCursor, GoesStraightOnASphereOnAGreatCircle) {
  const double radius = 200.0;
  const SurfaceModel model =
      InterpolatedBody([&](double, double z) { return std::sqrt(radius * radius - (z - 150.0) * (z - 150.0)); }, 72,
                       UniformBreakpoints(0.0, 300.0, 300));
  const MeasuredSurface body = Measured(model);
  const double heading = 0.5;
  const CursorMove move = Value(MoveCursorStraight(body, {0.0, 150.0}, heading, 250.0));
  // From (R, 0, 0) with the unit tangent t = (0, cos h, sin h): P = cos(s/R) (R,0,0) + sin(s/R) R t.
  const double angle = 250.0 / radius;
  const Eigen::Vector3d expected(radius * std::cos(angle), radius * std::sin(angle) * std::cos(heading),
                                 150.0 + radius * std::sin(angle) * std::sin(heading));
  EXPECT_LT((move.path.back().position - expected).norm(), 1e-5);
}

TEST(SurfaceCursor, ComesBackTheWayItWent) {
  const SurfaceModel model = Wavy();
  const MeasuredSurface body = Measured(model);
  const SurfacePlace start{2.0, 120.0};
  for (const double heading : {0.3, 1.9, 4.0}) {
    const CursorMove there = Value(MoveCursorStraight(body, start, heading, 90.0));
    ASSERT_EQ(there.stop, CursorStop::kArrived);
    const CursorMove back = Value(MoveCursorStraight(body, there.place, there.heading, -90.0));
    // The third derivatives of the surface jump at knots, which the rule's order does not know.
    EXPECT_NEAR(back.place.theta, start.theta, 1e-6);
    EXPECT_NEAR(back.place.z, start.z, 1e-4);
    EXPECT_NEAR(AngleDifference(back.heading, heading + kPi), 0.0, 1e-5);
  }
}

TEST(SurfaceCursor, TravelsWhatItsPathIsLong) {
  const SurfaceModel model = Wavy();
  const MeasuredSurface body = Measured(model);
  for (const CursorMove& move : {Value(MoveCursorStraight(body, {1.0, 100.0}, 0.7, 150.0)),
                                 Value(MoveCursorAlong(body, {1.0, 100.0}, ParameterLine::kAroundTheBody, -300.0)),
                                 Value(MoveCursorAlong(body, {1.0, 100.0}, ParameterLine::kAlongTheAxis, 150.0)),
                                 Value(StepCursor(body, {1.0, 100.0}, -2.0, 80.0))}) {
    double length = 0.0;
    for (std::size_t k = 1; k < move.path.size(); ++k) {
      const double step = (move.path[k].position - move.path[k - 1].position).norm();
      EXPECT_LE(step, 1.0);
      length += step;
    }
    EXPECT_NEAR(move.travelled, length, 1e-4 * length);
    EXPECT_EQ(move.stop, CursorStop::kArrived);
  }
}

TEST(SurfaceCursor, GoesAroundAnEllipseByItsArc) {
  // Semi-axes 130 and 90 mm; the length from theta = 0 to 90 degrees is a quarter of the perimeter:
  // from scipy.special import ellipe; 130 * ellipe(1 - (90/130)**2) = 174.21856771807546
  const SurfaceModel model = InterpolatedBody(
      [](double theta, double) { return 1.0 / std::hypot(std::cos(theta) / 130.0, std::sin(theta) / 90.0); }, 360,
      kBreaks);
  const MeasuredSurface body = Measured(model);
  const double quarter = 174.21856771807546;
  const CursorMove forward = Value(MoveCursorAlong(body, {0.0, 70.0}, ParameterLine::kAroundTheBody, quarter));
  EXPECT_NEAR(forward.place.theta, 0.5 * kPi, 1e-6);
  EXPECT_EQ(forward.place.z, 70.0);
  EXPECT_NEAR(forward.heading, 0.0, 1e-9);
  const CursorMove backward = Value(MoveCursorAlong(body, {0.0, 70.0}, ParameterLine::kAroundTheBody, -2.0 * quarter));
  EXPECT_NEAR(backward.place.theta, kPi, 1e-6);
  EXPECT_NEAR(backward.heading, kPi, 1e-9);
}

TEST(SurfaceCursor, ClimbsASlopeByItsSlant) {
  const SurfaceModel model = Cone();
  const MeasuredSurface body = Measured(model);
  const CursorMove move = Value(MoveCursorAlong(body, {2.0, 100.0}, ParameterLine::kAlongTheAxis, 80.0));
  EXPECT_NEAR(move.place.z, 100.0 + 80.0 / std::hypot(1.0, 0.25), 1e-9);
  EXPECT_EQ(move.place.theta, 2.0);
  EXPECT_NEAR(move.heading, 0.5 * kPi, 1e-9);
}

TEST(SurfaceCursor, StepsInTheParameters) {
  const SurfaceModel model = Cone();
  const MeasuredSurface body = Measured(model);
  const CursorMove move = Value(StepCursor(body, {0.2, 100.0}, -0.5, 30.0));
  EXPECT_NEAR(move.place.theta, 0.2 - 0.5 + kTwoPi, 1e-12);
  EXPECT_NEAR(move.place.z, 130.0, 1e-9);
  // Length of theta = -t/60, z = 100 + t on the cone: ∫ √(1 + k² + (r/60)²) dt, t = 0 … 30:
  // from scipy.integrate import quad
  // quad(lambda t: (1 + 1/16 + ((150 - (100 + t)/4)/60)**2)**.5, 0, 30)[0] = 68.05793602235389
  EXPECT_NEAR(move.travelled, 68.05793602, 1e-6);
  const CursorMove nowhere = Value(StepCursor(body, {0.2, 100.0}, 0.0, 0.0));
  EXPECT_EQ(nowhere.travelled, 0.0);
  EXPECT_EQ(nowhere.place.z, 100.0);
  EXPECT_EQ(nowhere.stop, CursorStop::kArrived);
}

TEST(SurfaceCursor, StopsAtTheEndsOfTheScanAndSaysSo) {
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const CursorMove up = Value(MoveCursorStraight(body, {1.0, 250.0}, 0.5 * kPi, 1000.0));
  EXPECT_EQ(up.stop, CursorStop::kTop);
  EXPECT_NEAR(up.place.z, 300.0, 1e-6);
  EXPECT_LE(up.place.z, 300.0);
  EXPECT_NEAR(up.travelled, 50.0, 1e-6);
  EXPECT_THAT(std::string(CursorStopText(up.stop)), HasSubstr("upper end"));
  const CursorMove down = Value(StepCursor(body, {1.0, 250.0}, 0.5, -500.0));
  EXPECT_EQ(down.stop, CursorStop::kBottom);
  EXPECT_NEAR(down.place.z, 0.0, 1e-6);
  EXPECT_GE(down.place.z, 0.0);
  EXPECT_NEAR(down.place.theta, 1.25, 1e-6);
  const CursorMove at_once = Value(MoveCursorAlong(body, {1.0, 300.0}, ParameterLine::kAlongTheAxis, 5.0));
  EXPECT_EQ(at_once.stop, CursorStop::kTop);
  EXPECT_EQ(at_once.travelled, 0.0);
}

TEST(SurfaceCursor, StopsBeforeWhatWasNotSeen) {
  SurfaceModel model = Cylinder();
  // Column 9 of 36 holds theta from 85 to 95 degrees.
  KnowledgeMap& map = model.segments.front().knowledge;
  for (std::size_t row = 0; row < map.rows(); ++row) map.SetCell(9, row, Knowledge::kUnknown);
  const MeasuredSurface body = Measured(model);
  const double edge = 85.0 * kPi / 180.0;
  for (const CursorMove& move :
       {Value(MoveCursorStraight(body, {1.0, 150.0}, 0.0, 200.0)), Value(StepCursor(body, {1.0, 150.0}, 2.0, 0.0)),
        Value(MoveCursorAlong(body, {1.0, 150.0}, ParameterLine::kAroundTheBody, 200.0))}) {
    EXPECT_EQ(move.stop, CursorStop::kUnseen);
    EXPECT_NEAR(move.place.theta, edge, 1e-6);
    EXPECT_NE(body.KnowledgeAt(move.place.theta, move.place.z), Knowledge::kUnknown);
    EXPECT_NEAR(move.travelled, 100.0 * (edge - 1.0), 1e-4);
  }
}

TEST(SurfaceCursor, StopsWhereTheSurfaceMeetsTheAxis) {
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 100.0 - 0.5 * z; }, 12, kBreaks);
  const MeasuredSurface body = Measured(model);
  const CursorMove move = Value(MoveCursorAlong(body, {0.0, 150.0}, ParameterLine::kAlongTheAxis, 1000.0));
  EXPECT_EQ(move.stop, CursorStop::kAxis);
  EXPECT_NEAR(move.place.z, 200.0, 0.1);
}

TEST(SurfaceCursor, RefusesStartsAndMovesThatMakeNoSense) {
  SurfaceModel model = Cylinder();
  model.segments.front().knowledge.SetCell(0, 0, Knowledge::kUnknown);
  const MeasuredSurface body = Measured(model);
  const auto seen = [&](const SurfacePlace& from, double heading, double distance) {
    const auto move = MoveCursorStraight(body, from, heading, distance);
    return move ? std::string("moved") : move.error().Text();
  };
  EXPECT_THAT(seen({1.0, 301.0}, 0.0, 1.0), HasSubstr("outside the scanned range"));
  EXPECT_THAT(seen({1.0, kNan}, 0.0, 1.0), HasSubstr("outside the scanned range"));
  EXPECT_THAT(seen({kNan, 100.0}, 0.0, 1.0), HasSubstr("theta"));
  EXPECT_THAT(seen({0.0, 1.0}, 0.0, 1.0), HasSubstr("not seen"));
  EXPECT_THAT(seen({1.0, 100.0}, kNan, 1.0), HasSubstr("heading"));
  EXPECT_THAT(seen({1.0, 100.0}, 0.0, kNan), HasSubstr("too long"));
  EXPECT_THAT(seen({1.0, 100.0}, 0.0, 1e9), HasSubstr("too long"));
  EXPECT_FALSE(StepCursor(body, {1.0, 100.0}, kNan, 1.0));
  EXPECT_FALSE(StepCursor(body, {1.0, 100.0}, 0.0, std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(StepCursor(body, {1.0, 100.0}, 7.0, 0.0));
  EXPECT_FALSE(MoveCursorAlong(body, {1.0, 100.0}, ParameterLine::kAlongTheAxis, -1e9));
}

}  // namespace
}  // namespace annulus
