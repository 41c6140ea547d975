#include "station/body_maps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "modeling/glasses/frame_library.h"
#include "modeling/glasses/glasses_fit.h"
#include "sim/head.h"
#include "station/clearance_map.h"
#include "station/compare.h"
#include "station/difference_map.h"
#include "station/mesh_distance.h"
#include "station/residual_map.h"
#include "station/values_map.h"
#include "tests/modeling_measure/interpolated_body.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using test::RadiusFunction;

/// A model with knots every 2 mm over z = -100 … 100 mm and its measured surface.
struct Body {
  SurfaceModel model;
  MeasuredSurface measured;

  explicit Body(const RadiusFunction& radius, std::size_t columns = 90)
      : Body(InterpolatedBody(radius, columns, UniformBreakpoints(-100.0, 100.0, 100))) {}
  explicit Body(SurfaceModel made) : model(std::move(made)), measured(MeasuredSurface::FromModel(model).value()) {}
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
};

double Cylinder(double, double) { return 100.0; }
double Ball(double, double z) { return std::sqrt(150.0 * 150.0 - z * z); }
/// The inner side of a ring of radius 150 mm and thickness 200 mm: a saddle.
double Saddle(double, double z) { return 160.0 - std::sqrt(120.0 * 120.0 - z * z); }

TEST(CurvatureMap, IsThatOfCylinderBallAndSaddle) {
  const Body cylinder(Cylinder);
  const Body ball(Ball);
  const Body saddle(Saddle);
  const auto at = [](const Body& body, MapKind kind, double z) {
    return CurvatureField(body.measured, kind).value({0, 1.1, z});
  };
  EXPECT_NEAR(at(cylinder, MapKind::kMeanCurvature, 20.0), 5.0, 1e-6);  // 1 / 200 mm
  EXPECT_NEAR(at(cylinder, MapKind::kGaussianCurvature, 20.0), 0.0, 1e-6);
  EXPECT_NEAR(at(cylinder, MapKind::kLargestCurvature, 20.0), 10.0, 1e-6);
  EXPECT_NEAR(at(cylinder, MapKind::kSmallestCurvature, 20.0), 0.0, 1e-6);
  EXPECT_NEAR(at(ball, MapKind::kMeanCurvature, 40.0), 1e3 / 150.0, 1e-3);
  EXPECT_NEAR(at(ball, MapKind::kGaussianCurvature, 40.0), 1e6 / 22500.0, 1e-2);
  // At its waist of radius 40 mm the saddle bends by 1/40 around and by -1/120 upward.
  EXPECT_NEAR(at(saddle, MapKind::kLargestCurvature, 0.0), 25.0, 1e-2);
  EXPECT_NEAR(at(saddle, MapKind::kSmallestCurvature, 0.0), -1e3 / 120.0, 1e-2);
  EXPECT_NEAR(at(saddle, MapKind::kGaussianCurvature, 0.0), -1e6 / 4800.0, 0.5);
  EXPECT_NEAR(at(saddle, MapKind::kMeanCurvature, 0.0), 500.0 * (1.0 / 40.0 - 1.0 / 120.0), 1e-2);
}

TEST(StrainMap, IsThatOfSectionsScaledEvenly) {
  // An oval whose sections grow by a tenth: along them 10 %, upward nothing, wherever.
  const auto oval = [](double theta, double) { return 100.0 + 15.0 * std::cos(2.0 * theta); };
  const Body before(oval);
  const Body after([&](double theta, double z) { return 1.1 * oval(theta, z); });
  for (const double theta : {0.2, 1.0, 2.5, 4.0}) {
    const BodyPlace place{0, theta, 10.0};
    EXPECT_NEAR(StrainField(before.measured, after.measured, MapKind::kLargestStrain).value(place), 10.0, 1e-6);
    EXPECT_NEAR(StrainField(before.measured, after.measured, MapKind::kSmallestStrain).value(place), 0.0, 1e-6);
    EXPECT_NEAR(StrainField(before.measured, after.measured, MapKind::kAreaStrain).value(place), 10.0, 1e-6);
  }
}

TEST(StrainMap, IsThatOfAConeThatOpens) {
  // r = 100 + a z becomes s r: around s, along the generator sqrt((1 + (s a)^2) / (1 + a^2)).
  constexpr double kSlope = 0.4;
  constexpr double kScale = 0.8;
  const Body before([](double, double z) { return 100.0 + kSlope * z; });
  const Body after([](double, double z) { return kScale * (100.0 + kSlope * z); });
  const double along = std::sqrt((1.0 + kScale * kScale * kSlope * kSlope) / (1.0 + kSlope * kSlope));
  const BodyPlace place{0, 3.0, -30.0};
  EXPECT_NEAR(StrainField(before.measured, after.measured, MapKind::kLargestStrain).value(place), 100.0 * (along - 1.0),
              1e-6);
  EXPECT_NEAR(StrainField(before.measured, after.measured, MapKind::kSmallestStrain).value(place), -20.0, 1e-6);
  EXPECT_NEAR(StrainField(before.measured, after.measured, MapKind::kAreaStrain).value(place),
              100.0 * (along * kScale - 1.0), 1e-6);
}

TEST(StrainMap, SeesAShearThatNeitherRadiusNorHeightChanges) {
  // The tangent of a helix bump: C = A^-1 B by hand for r = 100, r_theta = 0, r_z = 0 before and r_theta = 30,
  // r_z = 0.5 after: B = [[100^2 + 900, 15], [15, 1.25]], A = diag(100^2, 1).
  const Body before(Cylinder, 360);
  const Body after([](double theta, double z) { return 100.0 + 30.0 * std::sin(theta) + 0.5 * z * std::cos(theta); },
                   360);
  const SurfaceStretch s = StretchAt(before.measured.surface(), after.measured.surface(), {0.0, 0.0});
  const double trace = (1e4 + 900.0) / 1e4 + 1.25;
  const double determinant = ((1e4 + 900.0) * 1.25 - 225.0) / 1e4;
  const double root = std::sqrt(0.25 * trace * trace - determinant);
  EXPECT_NEAR(s.largest, std::sqrt(0.5 * trace + root), 1e-5);
  EXPECT_NEAR(s.smallest, std::sqrt(0.5 * trace - root), 1e-5);
}

/// The returns of an even scan of a cylinder of 100 mm with an error that depends on the place: 180 sensors, 1 mm.
std::vector<SurfaceSample> Returns(const std::function<double(double, double)>& error) {
  std::vector<SurfaceSample> samples;
  for (std::uint32_t level = 0; level < 199; ++level) {
    for (std::uint16_t sensor = 0; sensor < 180; ++sensor) {
      SurfaceSample sample;
      sample.theta = kTwoPi * sensor / 180.0;
      sample.z = -99.0 + level;
      sample.radius = 100.0 + error(sample.theta, sample.z);
      sample.level = level;
      sample.sensor = sensor;
      samples.push_back(sample);
    }
  }
  return samples;
}

TEST(ResidualMap, ShowsTheErrorThatTheReturnsWereGiven) {
  const Body body(Cylinder);
  const auto error = [](double theta, double z) { return 0.8 * std::cos(3.0 * theta) + 0.005 * z; };
  const auto field = ResidualField(body.model, Returns(error));
  ASSERT_TRUE(field.has_value());
  for (const double theta : {0.0, 0.7, 2.0, 4.4, 6.2}) {
    for (const double z : {-80.0, -3.0, 60.0}) {
      // Cells of at most 6 degrees and 4 mm flatten cos 3θ by less than 0.05 and a slope by nothing.
      EXPECT_NEAR(field->value({0, theta, z}), error(theta, z), 0.05) << theta << " " << z;
    }
  }
  EXPECT_NE(field->definition.find("35820 of 35820"), std::string::npos) << field->definition;
}

TEST(ResidualMap, LeavesOutWhatIsNotTheSurfaceAndWhereNothingIs) {
  const Body body(Cylinder);
  std::vector<SurfaceSample> samples = Returns([](double, double) { return 0.5; });
  std::erase_if(samples, [](const SurfaceSample& s) { return s.theta > 2.0 && s.theta < 2.6; });
  for (std::size_t k = 0; k < samples.size(); k += 7) samples[k].radius = 160.0;  // a hand
  for (std::size_t k = 3; k < samples.size(); k += 7) {
    samples[k].radius = 95.0;
    samples[k].weight = 0.0F;
  }
  const auto field = ResidualField(body.model, samples);
  ASSERT_TRUE(field.has_value());
  EXPECT_NEAR(field->value({0, 1.0, 5.0}), 0.5, 1e-9);
  EXPECT_TRUE(std::isnan(field->value({0, 2.3, 5.0})));
  EXPECT_FALSE(ResidualField(body.model, {}).has_value());
}

TEST(KnowledgeMap, ShowsItsClassesAndTheirAreas) {
  Body body(Cylinder);
  KnowledgeMap& known = body.model.segments[0].knowledge;
  for (std::size_t row = 0; row < known.rows(); ++row) {
    for (std::size_t column = 0; column < known.columns() / 2; ++column) {
      known.SetCell(column, row, row < known.rows() / 2 ? Knowledge::kUnknown : Knowledge::kInferred);
    }
  }
  const BodyField field = KnowledgeField(body.model);
  ASSERT_EQ(field.categories.size(), 3U);
  const UnrolledMap map = Unroll(body.model, field, 360, 100);
  double unknown = 0.0;
  double inferred = 0.0;
  double all = 0.0;
  for (const WeightedValue& one : map.weighted) {
    all += one.weight;
    if (one.value == 2.0) unknown += one.weight;
    if (one.value == 1.0) inferred += one.weight;
  }
  EXPECT_NEAR(unknown / all, 0.25, 0.01);
  EXPECT_NEAR(inferred / all, 0.25, 0.01);
  EXPECT_EQ(map.values(0, 90), 1.0);   // the upper half, theta = 90 degrees
  EXPECT_EQ(map.values(99, 90), 2.0);  // row 0 is the top
  EXPECT_EQ(map.values(99, 270), 0.0);
}

TEST(DifferenceMap, IsTheDistanceAlongTheNormalOfACone) {
  // Two cones 2 mm of radius apart: along the normal 2 cos(slope).
  const Body before([](double, double z) { return 100.0 + 0.5 * z; });
  const Body after([](double, double z) { return 102.0 + 0.5 * z; });
  const BodyField field = DifferenceField(before.model, before.measured, after.model, after.measured);
  EXPECT_NEAR(field.value({0, 0.3, 12.0}), 2.0 / std::sqrt(1.25), 1e-6);
  EXPECT_FALSE(field.hatched({0, 0.3, 12.0}));  // without a covariance nothing is tested
  const BodyField back = DifferenceField(after.model, after.measured, before.model, before.measured);
  EXPECT_NEAR(back.value({0, 0.3, 12.0}), -2.0 / std::sqrt(1.25), 1e-6);
}

/// The same with independent coefficients of sd `sigma`: at a knot of evenly spaced cubic splines a radius has half of
/// it, since (1/6)^2 + (4/6)^2 + (1/6)^2 = 1/2 in each direction.
SurfaceModel WithSigma(SurfaceModel model, double sigma) {
  const Eigen::Index n = model.main().surface.coefficients().size();
  Eigen::SparseMatrix<double> precision(n, n);
  precision.setIdentity();
  model.segments[0].normal_matrix = precision / (sigma * sigma);
  return model;
}

TEST(DifferenceMap, HatchesWhatHolmsTestOverAllCellsDoesNotFind) {
  // Knots every 10 degrees and 5 mm, so that the middles of the cells are knots. The front differs by six sds, the rest
  // by one and a half.
  const auto breakpoints = UniformBreakpoints(-100.0, 100.0, 40);
  const double sd = 0.5 * std::sqrt(2.0) * 0.4;
  const auto differs = [&](double theta, double) {
    const double front = std::abs(theta - kPi / 2.0);
    return 100.0 + (front < 0.9 ? 6.0 * sd : 1.5 * sd);
  };
  const Body before(WithSigma(InterpolatedBody(Cylinder, 36, breakpoints), 0.4));
  const Body after(WithSigma(InterpolatedBody(differs, 36, breakpoints), 0.4));
  const BodyField field = DifferenceField(before.model, before.measured, after.model, after.measured);
  EXPECT_FALSE(field.hatched({0, kPi / 2.0, 5.0}));
  EXPECT_FALSE(field.hatched({0, kPi / 3.0, -45.0}));
  EXPECT_TRUE(field.hatched({0, 3.0 * kPi / 2.0, 5.0}));
  EXPECT_TRUE(field.hatched({0, kPi, 65.0}));
  // 36 cells around times 20 upward, of which 11 around lie within 0.9 rad of the front.
  EXPECT_NE(field.definition.find("220 of 720"), std::string::npos) << field.definition;
  EXPECT_EQ(field.hatch_label, "not significant");
}

TEST(ValuesMap, IsLinearBetweenThePlacesOfAGridAndAcrossTheTurn) {
  const Body body(Cylinder);
  std::string csv = "# made by hand\nz_mm,theta_deg,value\n";
  for (int z = -100; z <= 100; z += 20) {
    for (int theta = 0; theta < 360; theta += 15) {
      csv += std::to_string(z) + "," + std::to_string(theta) + "," + std::to_string(z + 10 * (theta % 45)) + "\n";
    }
  }
  const auto field = ValuesField(body.model, csv, "numbers.csv");
  ASSERT_TRUE(field.has_value()) << field.error().Text();
  const auto at = [&](double degrees, double z) { return field->value({0, RadiansFromDegrees(degrees), z}); };
  EXPECT_NEAR(at(15.0, 20.0), 20.0 + 150.0, 1e-9);
  EXPECT_NEAR(at(22.5, 30.0), 30.0 + 225.0, 1e-9);
  EXPECT_NEAR(at(352.5, -10.0), -10.0 + 150.0, 1e-9);  // halfway from 300 at 345 degrees to 0 at 0 degrees
}

TEST(ValuesMap, TakesTheNearestOfScatteredPlacesAndNoneFarAway) {
  const Body body(Cylinder);
  const auto field = ValuesField(body.model, "theta_deg,z_mm,value\n10,0,1\n14,3,2\n190,50,\n192,52,7\n", "f.csv");
  ASSERT_TRUE(field.has_value());
  EXPECT_DOUBLE_EQ(field->value({0, RadiansFromDegrees(10.5), 0.2}), 1.0);
  EXPECT_DOUBLE_EQ(field->value({0, RadiansFromDegrees(14.2), 3.1}), 2.0);
  EXPECT_TRUE(std::isnan(field->value({0, RadiansFromDegrees(190.0), 50.0})));
  EXPECT_FALSE(ValuesField(body.model, "theta_deg,z_mm\n1,2\n", "f.csv").has_value());
  EXPECT_FALSE(ValuesField(body.model, "theta_deg,z_mm,value\n1,2,x\n", "f.csv").has_value());
  EXPECT_FALSE(ValuesField(body.model, "theta_deg,z_mm,value\n", "f.csv").has_value());
  EXPECT_FALSE(ValuesField(body.model, "", "f.csv").has_value());
}

TEST(MeshDistance, OfAPlaneBeforeACylinderIsTheGapBetweenThem) {
  // A lens-like sheet at y = 112 mm before a cylinder of radius 100 mm.
  TriangleMesh sheet;
  sheet.vertices = {{-40, 112, -30}, {40, 112, -30}, {40, 112, 30}, {-40, 112, 30}};
  sheet.faces = {{0, 1, 2}, {0, 2, 3}};
  const MeshDistance distance({}, {sheet}, 30.0);
  for (const double degrees : {70.0, 80.0, 90.0, 105.0, 112.0}) {
    const double theta = RadiansFromDegrees(degrees);
    const Eigen::Vector3d p(100.0 * std::cos(theta), 100.0 * std::sin(theta), 7.0);
    EXPECT_NEAR(distance.At(p), 112.0 - 100.0 * std::sin(theta), 1e-9);
  }
  EXPECT_NEAR(distance.At({50.0, 112.0, 40.0}), std::hypot(10.0, 10.0), 1e-9);  // to the corner
  EXPECT_TRUE(std::isnan(distance.At({0.0, 70.0, 0.0})));
}

TEST(MeshDistance, IsNegativeInsideOfASolid) {
  TriangleMesh box;
  box.vertices = {{0, 0, 0}, {20, 0, 0}, {20, 10, 0}, {0, 10, 0}, {0, 0, 8}, {20, 0, 8}, {20, 10, 8}, {0, 10, 8}};
  box.faces = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
               {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  const MeshDistance distance({box}, {}, 15.0);
  EXPECT_NEAR(distance.At({10.0, 5.0, 3.0}), -3.0, 1e-12);
  EXPECT_NEAR(distance.At({10.0, 5.0, -3.0}), 3.0, 1e-12);
  EXPECT_NEAR(distance.At({22.0, 12.0, 9.0}), 3.0, 1e-12);  // sqrt(4 + 4 + 1)
  EXPECT_TRUE(std::isnan(distance.At({10.0, 5.0, 30.0})));
}

TEST(ClearanceMap, SaysOfAFrameWhatItsFitterSays) {
  const SurfaceModel model = test::HeadSurface(sim::MakeHead({}));
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(body.has_value());
  const auto fit = FitGlasses(*body, BuiltInFrameLibrary().styles.front().design, {});
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  const auto maps = ClearanceOf(model, *body, fit->worn);
  ASSERT_TRUE(maps.has_value()) << maps.error().Text();
  // The fitter's places lie on the same skin, a few mm from a vertex of the map: the distances differ by no more than
  // the way between them.
  int compared = 0;
  for (const Clearance& place : fit->clearance) {
    // The fitter measures from a lens' back; behind an ear the head changes to that without ears, which is no way.
    if (place.part.starts_with("lens") || place.part.starts_with("temple")) continue;
    if (place.distance > 30.0) continue;  // only to first order there
    double nearest = 3.0;
    double distance = 0.0;
    for (const MapMesh& part : maps->frame) {
      for (std::size_t k = 0; k < part.values.size(); ++k) {
        const double apart = (part.mesh.vertices[k] - place.position).norm();
        if (apart >= nearest) continue;
        nearest = apart;
        distance = part.values[k];
      }
    }
    if (nearest >= 3.0) continue;
    EXPECT_NEAR(distance, place.distance, nearest + 0.05) << place.part;
    ++compared;
  }
  EXPECT_GT(compared, 200);
  // Seen from the head, no place is nearer than the nearest place of the frame.
  double least = 1e9;
  for (const MapMesh& part : maps->frame) {
    least = std::min(least, *std::min_element(part.values.begin(), part.values.end()));
  }
  const UnrolledMap map = Unroll(model, maps->head, 180, 90);
  EXPECT_GT(map.values.minCoeff(), least - 0.5);
  EXPECT_LT(map.values.minCoeff(), 5.0);
}

TEST(MapKinds, HaveTheNamesThatTheManualGives) {
  EXPECT_EQ(MapKindName(MapKind::kResidual), "residual");
  EXPECT_EQ(MapKindName(MapKind::kMeanCurvature), "curvature");
  EXPECT_EQ(MapKindName(MapKind::kAreaStrain), "strain");
  EXPECT_EQ(MapKindName(MapKind::kValues), "values");
  std::set<std::string_view> names;
  for (int k = 0; k <= static_cast<int>(MapKind::kValues); ++k) names.insert(MapKindName(static_cast<MapKind>(k)));
  EXPECT_EQ(names.size(), 13U);
}

}  // namespace
}  // namespace annulus
