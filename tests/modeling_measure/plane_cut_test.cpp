#include "modeling/measure/plane_cut.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "modeling/measure/cut_path.h"
#include "modeling/measure/gauss.h"
#include "modeling/measure/paper_lattice.h"
#include "modeling/measure/section.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

/// A model and its surface, which borrows it.
struct Body {
  explicit Body(SurfaceModel m) : model(std::make_unique<SurfaceModel>(std::move(m))) {}
  [[nodiscard]] MeasuredSurface operator*() const { return *MeasuredSurface::FromModel(*model); }
  std::unique_ptr<SurfaceModel> model;
};

const std::vector<double> kBreaks = UniformBreakpoints(0.0, 200.0, 10);

Body Cylinder() {
  return Body(InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks));
}
Body Cone() {
  return Body(InterpolatedBody([](double, double z) { return 120.0 - 0.3 * z; }, 12, kBreaks));
}
Body Sphere() {
  // Radius 100 about (0, 0, 100), |z - 100| <= 80.
  return Body(InterpolatedBody([](double, double z) { return std::sqrt(1e4 - (z - 100.0) * (z - 100.0)); }, 12,
                               UniformBreakpoints(20.0, 180.0, 160)));
}
Body Bumpy() {
  return Body(InterpolatedBody(
      [](double t, double z) {
        return 100.0 + 12.0 * std::cos(2.0 * t + 0.02 * z) + 4.0 * std::sin(5.0 * t) * std::cos(0.07 * z);
      },
      36, UniformBreakpoints(0.0, 200.0, 25)));
}

/// The place of the cylinder of radius 90 on the plane z = 100 + 60 cos(theta)/… at theta.
SurfacePlace OnTilt(double theta) { return {theta, 100.0 + 0.5 * 90.0 * std::cos(theta)}; }

/// Arc of the ellipse in which z = 100 + x/2 cuts the cylinder of radius 90, by 4-point Gauss in 400 parts.
double TiltedArc(double from, double to) {
  double length = 0.0;
  for (const QuadratureNode& at : PiecewiseGauss(UniformBreakpoints(from, to, 400))) {
    length += at.weight * 90.0 * std::sqrt(1.0 + 0.25 * std::sin(at.x) * std::sin(at.x));
  }
  return length;
}

TEST(PlaneThrough, HoldsItsPointsAndTellsWhichOnesDoNotSpanIt) {
  const Eigen::Vector3d a(1.0, 2.0, 3.0);
  const Eigen::Vector3d b(4.0, -1.0, 2.0);
  const Eigen::Vector3d c(-2.0, 0.5, 7.0);
  const auto plane = PlaneThrough({"A", a}, {"B", b}, {"C", c});
  ASSERT_TRUE(plane.has_value());
  EXPECT_NEAR(plane->normal.norm(), 1.0, 1e-14);
  for (const Eigen::Vector3d& p : {a, b, c}) EXPECT_NEAR(plane->Height(p), 0.0, 1e-14);
  EXPECT_GT(plane->normal.dot((a - c).cross(b - c)), 0.0);
  EXPECT_THAT(PlaneThrough({"A", a}, {"B", b}, {"C", a}).error().Text(), HasSubstr("A and C are the same point"));
  EXPECT_THAT(PlaneThrough({"A", a}, {"B", b}, {"C", 0.3 * a + 0.7 * b}).error().Text(),
              HasSubstr("A, B and C lie on one line"));
  EXPECT_THAT(PlaneThrough({"A", a}, {"B", {std::nan(""), 0.0, 0.0}}, {"C", c}).error().Text(), HasSubstr("B"));
}

TEST(ViewPlane, HoldsItsPointsAndTheView) {
  const Eigen::Vector3d a(1.0, 2.0, 3.0);
  const Eigen::Vector3d b(4.0, -1.0, 2.0);
  const Eigen::Vector3d view(0.0, -7.0, 1.0);
  const auto plane = ViewPlane({"A", a}, {"B", b}, view);
  ASSERT_TRUE(plane.has_value());
  for (const Eigen::Vector3d& p : {a, b, Eigen::Vector3d(a + view)}) EXPECT_NEAR(plane->Height(p), 0.0, 1e-13);
  EXPECT_THAT(ViewPlane({"A", a}, {"B", b}, b - a).error().Text(), HasSubstr("A lies behind B"));
  EXPECT_THAT(ViewPlane({"A", a}, {"B", a}, view).error().Text(), HasSubstr("the same point"));
  EXPECT_FALSE(ViewPlane({"A", a}, {"B", b}, Eigen::Vector3d::Zero()).has_value());
  EXPECT_FALSE(ViewPlane({"A", a}, {"B", b}, {1.0, std::nan(""), 0.0}).has_value());
  EXPECT_TRUE(ViewPlane({"A", a}, {"B", b}, 1e300 * view.normalized()).has_value());
}

TEST(DistanceByPlane, OnACylinderIsTheArcOfAnEllipse) {
  const Body body = Cylinder();
  const auto d = DistanceByPlane(*body, OnTilt(0.3), OnTilt(1.0), OnTilt(2.5), CutMethod::kSpline);
  ASSERT_TRUE(d.has_value()) << d.error().Text();
  EXPECT_NEAR(d->length.value, TiltedArc(0.3, 2.5), 1e-9);
  EXPECT_NEAR(d->knowledge.measured, 1.0, 1e-12);
  EXPECT_NEAR((d->path.front().position - (*body).Point(0.3, OnTilt(0.3).z)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((d->path.back().position - (*body).Point(2.5, OnTilt(2.5).z)).norm(), 0.0, 1e-9);
  for (const PathPoint& p : d->path) EXPECT_NEAR(p.position.z(), 100.0 + 0.5 * p.position.x(), 1e-8);
}

TEST(DistanceByPlane, GoesTheWayThatPassesTheThirdPoint) {
  const Body body = Cylinder();
  const auto around = DistanceByPlane(*body, OnTilt(0.3), OnTilt(-1.0), OnTilt(2.5), CutMethod::kSpline);
  ASSERT_TRUE(around.has_value()) << around.error().Text();
  EXPECT_NEAR(around->length.value, TiltedArc(2.5, kTwoPi + 0.3), 1e-9);
  const auto back = DistanceByPlane(*body, OnTilt(2.5), OnTilt(5.0 + kTwoPi), OnTilt(0.3 - kTwoPi), CutMethod::kSpline);
  ASSERT_TRUE(back.has_value());
  EXPECT_NEAR(back->length.value, around->length.value, 1e-9);
}

TEST(DistanceByPlane, OnASphereIsTheArcOfACircle) {
  const Body body = Sphere();
  const MeasuredSurface surface = *body;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> theta(0.0, 2.0);
  std::uniform_real_distribution<double> z(60.0, 140.0);
  for (int k = 0; k < 20; ++k) {
    const SurfacePlace a{theta(random), z(random)};
    const SurfacePlace b{theta(random), z(random)};
    const SurfacePlace c{theta(random), z(random)};
    const Eigen::Vector3d p = surface.Point(a.theta, a.z);
    const Eigen::Vector3d q = surface.Point(b.theta, b.z);
    const Eigen::Vector3d s = surface.Point(c.theta, c.z);
    // Chord |PQ| seen from S on the circle of radius rho: the arc without S is 2 rho·angle, the arc with S the rest.
    const double angle = std::atan2((p - s).cross(q - s).norm(), (p - s).dot(q - s));
    const double rho = (p - q).norm() / (2.0 * std::sin(angle));
    const auto d = DistanceByPlane(surface, a, c, b, CutMethod::kSpline);
    if (!d) {  // a steep circle may leave the band
      EXPECT_THAT(d.error().Text(), HasSubstr("leaves the scanned range"));
      continue;
    }
    EXPECT_NEAR(d->length.value, 2.0 * rho * (kPi - angle), 1e-6 * d->length.value);
  }
}

TEST(DistanceByPlane, TellsWhatIsWrong) {
  const Body body = Cylinder();
  const auto fails = [&](SurfacePlace a, SurfacePlace via, SurfacePlace b, const char* says) {
    for (const CutMethod method : {CutMethod::kSpline, CutMethod::kPaper}) {
      const auto d = DistanceByPlane(*body, a, via, b, method);
      ASSERT_FALSE(d.has_value()) << says;
      EXPECT_THAT(d.error().Text(), HasSubstr(says));
    }
  };
  fails({0.0, 100.0}, {0.0, 100.0}, {1.0, 100.0}, "are the same point");
  fails({0.0, 100.0}, {kTwoPi, 100.0}, {1.0, 100.0}, "are the same point");
  fails({0.0, 50.0}, {0.0, 60.0}, {0.0, 90.0}, "lie on one line");
  fails({0.0, 250.0}, {0.5, 100.0}, {1.0, 100.0}, "from 0 to 200 mm");
  fails({0.0, std::nan("")}, {0.5, 100.0}, {1.0, 100.0}, "from 0 to 200 mm");
  fails({std::nan(""), 100.0}, {0.5, 100.0}, {1.0, 100.0}, "not a finite number");
  // A steep plane whose way over the third point runs out of the top.
  const auto out = DistanceByPlane(*body, {0.0, 10.0}, {kPi, 190.0}, {0.1, 20.0}, CutMethod::kSpline);
  ASSERT_FALSE(out.has_value());
  EXPECT_THAT(out.error().Text(), HasSubstr("leaves the scanned range"));
}

TEST(DistanceByPlane, RefusesAWayOverWhatWasNotSeen) {
  Body body = Cylinder();
  body.model->segments.front().knowledge.SetCell(6, 20, Knowledge::kUnknown);  // theta 60 deg, z 100 … 105
  const auto over = DistanceByPlane(*body, {0.5, 102.0}, {0.7, 102.0}, {1.5, 102.0}, CutMethod::kSpline);
  ASSERT_FALSE(over.has_value());
  EXPECT_THAT(over.error().Text(), HasSubstr("not seen"));
  body.model->segments.front().knowledge.SetCell(6, 20, Knowledge::kInferred);
  const auto inferred = DistanceByPlane(*body, {0.5, 102.0}, {0.7, 102.0}, {1.5, 102.0}, CutMethod::kSpline);
  ASSERT_TRUE(inferred.has_value());
  EXPECT_NEAR(inferred->knowledge.measured, 1.0 - kPi / 18.0, 0.02);
}

TEST(DistanceByView, GoesTheWayThatFacesTheViewer) {
  const Body body = Cylinder();
  // Seen horizontally from the front (+y), the plane through two points of equal height is horizontal.
  const SurfacePlace right{0.2, 80.0};
  const SurfacePlace left{2.8, 80.0};
  const auto front = DistanceByView(*body, right, left, {0.0, -1.0, 0.0}, CutMethod::kSpline);
  ASSERT_TRUE(front.has_value()) << front.error().Text();
  EXPECT_NEAR(front->length.value, 90.0 * 2.6, 1e-9);
  const auto back = DistanceByView(*body, right, left, {0.0, 5.0, 0.0}, CutMethod::kSpline);
  ASSERT_TRUE(back.has_value());
  EXPECT_NEAR(back->length.value, 90.0 * (kTwoPi - 2.6), 1e-9);
  // Vertical plane: only the way along the skin's one side stays on the scan, whoever looks.
  for (const double y : {1.0, -1.0}) {
    const auto up = DistanceByView(*body, {kPi / 2.0, 20.0}, {kPi / 2.0, 180.0}, {0.0, y, 0.1}, CutMethod::kSpline);
    ASSERT_TRUE(up.has_value()) << up.error().Text();
    EXPECT_NEAR(up->length.value, 160.0, 1e-9);
  }
  EXPECT_THAT(DistanceByView(*body, {0.0, 20.0}, {0.0, 50.0}, {0.0, 0.0, 1.0}, CutMethod::kSpline).error().Text(),
              HasSubstr("behind"));
}

TEST(PaperDistance, ConvergesToTheSplinesWithTheSquareOfTheMesh) {
  const Body body = Bumpy();
  const std::array<Click, 3> clicks{{{"A", {0.31, 52.0}}, {"C", {1.12, 97.0}}, {"B", {2.43, 141.0}}}};
  const auto exact = DistanceByPlane(*body, clicks[0].place, clicks[1].place, clicks[2].place, CutMethod::kSpline);
  ASSERT_TRUE(exact.has_value()) << exact.error().Text();
  std::vector<double> error;
  for (const std::size_t n : {90, 180, 360, 720}) {
    const auto path = LatticeCut(*body, {n, n + 1}, clicks);
    const auto d = LatticeDistance(*body, path);
    ASSERT_TRUE(d.has_value()) << d.error().Text();
    error.push_back(std::abs(d->length.value - exact->length.value));
  }
  EXPECT_LT(error[0], 0.3);
  EXPECT_LT(error[3], error[0] / 16.0);
  EXPECT_LT(error[3], 0.01);
  const auto scan = DistanceByPlane(*body, clicks[0].place, clicks[1].place, clicks[2].place, CutMethod::kPaper);
  ASSERT_TRUE(scan.has_value()) << scan.error().Text();
  EXPECT_NEAR(scan->length.value, exact->length.value, 0.01 * exact->length.value);
}

TEST(PaperDistance, GoesTheSameWayAsTheSplines) {
  const Body body = Cylinder();
  for (const double via : {1.0, -1.0}) {
    const auto spline = DistanceByPlane(*body, OnTilt(0.3), OnTilt(via), OnTilt(2.5), CutMethod::kSpline);
    const auto paper = DistanceByPlane(*body, OnTilt(0.3), OnTilt(via), OnTilt(2.5), CutMethod::kPaper);
    ASSERT_TRUE(spline && paper) << paper.error().Text();
    EXPECT_NEAR(paper->length.value, spline->length.value, 0.01 * spline->length.value);
  }
  for (const double y : {-1.0, 1.0}) {
    const auto spline = DistanceByView(*body, {0.2, 80.0}, {2.8, 90.0}, {0.0, y, 0.0}, CutMethod::kSpline);
    const auto paper = DistanceByView(*body, {0.2, 80.0}, {2.8, 90.0}, {0.0, y, 0.0}, CutMethod::kPaper);
    ASSERT_TRUE(spline && paper);
    EXPECT_NEAR(paper->length.value, spline->length.value, 0.01 * spline->length.value);
  }
}

TEST(GirthInPlane, OfAConeIsAnEllipse) {
  // Plane z = 100 + t x, cone r = m (400 - z), m = 0.3: with h = 300, k = m²t² the semi-axes are m h sqrt(1 + t²)/(1 -
  // k) in the plane and m h/sqrt(1 - k) across.
  const Body body = Cone();
  for (const double t : {0.0, 0.2, -0.5}) {
    const CuttingPlane plane{Eigen::Vector3d(-t, 0.0, 1.0).normalized(), 100.0 / std::hypot(1.0, t)};
    const auto girth = GirthInPlane(*body, plane);
    ASSERT_TRUE(girth.has_value()) << girth.error().Text();
    const double k = 0.09 * t * t;
    const double a = 90.0 * std::hypot(1.0, t) / (1.0 - k);
    const double b = 90.0 / std::sqrt(1.0 - k);
    const double longer = std::max(a, b);
    const double shorter = std::min(a, b);
    const double perimeter = 4.0 * longer * std::comp_ellint_2(std::sqrt(1.0 - shorter * shorter / (longer * longer)));
    EXPECT_NEAR(girth->perimeter.value, perimeter, 1e-7 * perimeter);
    EXPECT_NEAR(girth->tape.value, perimeter, 1e-6 * perimeter);
    EXPECT_NEAR(girth->area.value, kPi * a * b, 1e-7 * kPi * a * b);
  }
}

TEST(GirthInPlane, LevelIsTheSection) {
  const Body body = Bumpy();
  const auto girth = GirthInPlane(*body, {Eigen::Vector3d::UnitZ(), 77.0});
  const auto section = SectionAt(*body, 77.0);
  ASSERT_TRUE(girth && section);
  EXPECT_NEAR(girth->perimeter.value, section->perimeter.value, 1e-6 * section->perimeter.value);
  EXPECT_NEAR(girth->tape.value, section->tape.value, 2e-5 * section->tape.value);
  EXPECT_NEAR(girth->area.value, section->area.value, 1e-7 * section->area.value);
  EXPECT_LT((Eigen::VectorXd(girth->perimeter.gradient) - Eigen::VectorXd(section->perimeter.gradient)).norm(),
            0.02 * Eigen::VectorXd(section->perimeter.gradient).norm());
  EXPECT_LT((Eigen::VectorXd(girth->area.gradient) - Eigen::VectorXd(section->area.gradient)).norm(),
            1e-4 * Eigen::VectorXd(section->area.gradient).norm());
}

TEST(GirthInPlane, NeedsOneLoopAroundTheAxis) {
  const Body body = Cylinder();
  EXPECT_THAT(GirthInPlane(*body, {Eigen::Vector3d::UnitX(), 10.0}).error().Text(), HasSubstr("does not go around"));
  EXPECT_THAT(GirthInPlane(*body, {Eigen::Vector3d::UnitZ(), 300.0}).error().Text(), HasSubstr("does not go around"));
  EXPECT_THAT(GirthInPlane(*body, {Eigen::Vector3d(0.0, 0.0, 2.0), 100.0}).error().Text(), HasSubstr("length 1"));
  const Eigen::Vector3d steep = Eigen::Vector3d(-2.0, 0.0, 1.0).normalized();
  EXPECT_THAT(GirthInPlane(*body, {steep, 10.0 * steep.z()}).error().Text(), HasSubstr("leaves the scanned range"));
}

/// Largest deviation of a gradient from central differences over coefficients, relative to the largest derivative.
template <class Measure>
double GradientError(const SurfaceModel& model, const Measure& measure) {
  const Eigen::VectorXd gradient = measure(*MeasuredSurface::FromModel(model)).gradient;
  constexpr double kStep = 1e-3;
  double worst = 0.0;
  const SplineSurface& surface = model.main().surface;
  for (Eigen::Index k = 0; k < gradient.size(); k += 7) {
    std::array<double, 2> value{};
    for (const int side : {0, 1}) {
      SurfaceModel moved;
      Eigen::VectorXd c = surface.coefficients();
      c[k] += side == 0 ? -kStep : kStep;
      moved.segments.push_back(
          {"body", {surface.theta_basis(), surface.z_basis(), c}, model.main().knowledge, {}, {}, {}});
      value[static_cast<std::size_t>(side)] = measure(*MeasuredSurface::FromModel(moved)).value;
    }
    worst = std::max(worst, std::abs((value[1] - value[0]) / (2.0 * kStep) - gradient[k]));
  }
  return worst / gradient.cwiseAbs().maxCoeff();
}

TEST(Gradient, OfADistanceByPlaneFollowsTheSurfaceAndItsClicks) {
  const Body body = Bumpy();
  const auto by_plane = [](const MeasuredSurface& s) {
    return DistanceByPlane(s, {0.31, 52.0}, {1.12, 97.0}, {2.43, 141.0}, CutMethod::kSpline)->length;
  };
  EXPECT_LT(GradientError(*body.model, by_plane), 0.02);
  const auto by_view = [](const MeasuredSurface& s) {
    return DistanceByView(s, {0.31, 52.0}, {2.43, 141.0}, {0.3, -1.0, 0.2}, CutMethod::kSpline)->length;
  };
  EXPECT_LT(GradientError(*body.model, by_view), 0.02);
}

TEST(Gradient, OfATiltedGirthFollowsTheSurface) {
  const Body body = Bumpy();
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.3, 0.2, 1.0).normalized();
  const CuttingPlane plane{normal, 100.0 * normal.z()};
  EXPECT_LT(GradientError(*body.model, [&](const MeasuredSurface& s) { return GirthInPlane(s, plane)->perimeter; }),
            0.02);
  EXPECT_LT(GradientError(*body.model, [&](const MeasuredSurface& s) { return GirthInPlane(s, plane)->tape; }), 0.05);
  EXPECT_LT(GradientError(*body.model, [&](const MeasuredSurface& s) { return GirthInPlane(s, plane)->area; }), 1e-4);
}

}  // namespace
}  // namespace annulus
