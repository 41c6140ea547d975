#include "modeling/elastic/elastic_edit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace annulus {
namespace {

constexpr double kPi = std::numbers::pi;

/// A trunk: an ellipse-like radius that changes with the height.
SurfaceModel Trunk() {
  std::vector<double> breaks;
  for (int i = 0; i <= 60; ++i) breaks.push_back(900.0 + 10.0 * i);
  const PeriodicCubicBasis theta(90);
  const ClampedCubicBasis z(breaks);
  Eigen::VectorXd coefficients(static_cast<Eigen::Index>(theta.count() * z.count()));
  for (Eigen::Index n = 0; n < coefficients.size(); ++n) {
    const double angle = 2.0 * kPi * static_cast<double>(n % 90) / 90.0;
    coefficients[n] = 140.0 + 25.0 * std::cos(2.0 * angle) + 8.0 * std::sin(0.1 * static_cast<double>(n / 90));
  }
  KnowledgeMap knowledge(90, 60, 900.0, 1500.0);
  for (std::size_t row = 0; row < 60; ++row) {
    for (std::size_t column = 0; column < 90; ++column) {
      knowledge.SetCell(column, row, column == 7 ? Knowledge::kInferred : Knowledge::kMeasured);
    }
  }
  SurfaceModel model;
  model.segments.push_back({"body", SplineSurface(theta, z, coefficients), knowledge, {}});
  model.provenance.method = "adaptive";
  return model;
}

RegionRequest AllAround(double z_min, double z_max) {
  RegionRequest region;
  region.z_min = z_min;
  region.z_max = z_max;
  region.thickness = 20.0;
  region.spacing = 12.0;
  return region;
}

TEST(ElasticRegion, LiesOnTheSkinAndIsHeldBelowAndAtItsRim) {
  const SurfaceModel model = Trunk();
  RegionRequest request = AllAround(1100.0, 1220.0);
  request.theta_from = 0.5;
  request.theta_to = 2.5;
  const auto region = MakeElasticRegion(model.main(), request);
  ASSERT_TRUE(region) << region.error().Text();
  const GridShape& shape = region->grid.shape;
  EXPECT_EQ(shape.closure, GridClosure::kOpen);
  EXPECT_EQ(shape.rows, 11U);
  for (std::size_t stack = 0; stack < shape.stacks(); ++stack) {
    const Eigen::Vector3d skin = region->grid.nodes[region->SkinNode(stack)];
    EXPECT_LE(
        (skin - model.main().Point(region->theta[stack % shape.columns], region->z[stack / shape.columns])).norm(),
        1e-9);
    EXPECT_NEAR((skin - region->grid.nodes[stack * shape.layers]).norm(), 20.0, 1e-9);
    EXPECT_EQ(region->held[3 * stack * shape.layers], 1);
    EXPECT_EQ(region->held[3 * region->SkinNode(stack)], region->OnRim(stack) ? 1 : 0);
  }
  request.z_max = 2000.0;
  EXPECT_FALSE(MakeElasticRegion(model.main(), request));
  request.z_max = 1220.0;
  request.thickness = 300.0;
  EXPECT_FALSE(MakeElasticRegion(model.main(), request));
}

TEST(SegmentVolume, IsThatOfACylinder) {
  SurfaceModel model = Trunk();
  SplineSurface& surface = model.segments[0].surface;
  surface = SplineSurface(surface.theta_basis(), surface.z_basis(),
                          Eigen::VectorXd::Constant(surface.coefficients().size(), 120.0));
  EXPECT_NEAR(SegmentVolume(model.main()) / (kPi * 120.0 * 120.0 * 600.0), 1.0, 1e-12);
}

TEST(DisplacedSkin, GrowsByWhatItIsMovedOutwards) {
  const SurfaceModel model = Trunk();
  const auto region = MakeElasticRegion(model.main(), AllAround(1100.0, 1220.0));
  ASSERT_TRUE(region);
  const GridShape& shape = region->grid.shape;
  std::vector<Eigen::Vector3d> displacement(shape.stacks(), Eigen::Vector3d::Zero());
  for (std::size_t stack = 0; stack < shape.stacks(); ++stack) {
    if (!region->OnRim(stack)) displacement[stack] = Eigen::Vector3d(0.0, 0.0, 3.0);
  }
  const DisplacedSkin skin(model.main(), *region, displacement);
  // Well inside the skin moves up as a whole: its new radius is the old one 3 mm below.
  for (const double theta : {0.1, 1.3, 2.9, 5.5}) {
    const auto growth = skin.Growth(theta, 1160.0);
    ASSERT_TRUE(growth);
    EXPECT_NEAR(*growth, model.main().surface.Radius(theta, 1157.0) - model.main().surface.Radius(theta, 1160.0), 1e-8);
    EXPECT_NEAR(*skin.Growth(theta, 1050.0), 0.0, 1e-10);
  }
}

TEST(ElasticEdit, FreeEditRaisesTheSkinWhereItIsAsked) {
  const SurfaceModel model = Trunk();
  ElasticScript script;
  script.edits.push_back({kPi / 2.0, 1200.0, 8.0, 60.0});
  script.girths = {1000.0, 1200.0};
  const auto edit = EditElastically(model, script, {});
  ASSERT_TRUE(edit) << edit.error().Text();
  const SplineSurface& before = model.main().surface;
  const SplineSurface& after = edit->model.main().surface;
  EXPECT_NEAR(after.Radius(kPi / 2.0, 1200.0) - before.Radius(kPi / 2.0, 1200.0), 8.0, 0.05);
  EXPECT_NEAR(after.Radius(kPi / 2.0, 1000.0), before.Radius(kPi / 2.0, 1000.0), 1e-6);
  EXPECT_NEAR(after.Radius(-kPi / 2.0, 1200.0), before.Radius(-kPi / 2.0, 1200.0), 1e-6);
  EXPECT_LE(edit->edits.at(0).largest_error, 0.1);
  EXPECT_GT(edit->volume_after, edit->volume_before);
  EXPECT_NEAR(edit->girths[0].tape_after, edit->girths[0].tape_before, 1e-6);
  EXPECT_GT(edit->girths[1].tape_after, edit->girths[1].tape_before + 1.0);
  EXPECT_EQ(edit->model.provenance.method, "adaptive+elastic");
  EXPECT_EQ(edit->model.main().knowledge.Cell(7, 10), Knowledge::kInferred);
}

TEST(ElasticEdit, LoadMovesTheSkinAndSwellsBesideIt) {
  const SurfaceModel model = Trunk();
  ElasticScript script;
  script.region = AllAround(1080.0, 1320.0);
  script.region->theta_from = 0.4;
  script.region->theta_to = 2.7;
  script.material.poisson = 0.49;
  script.loads.push_back({{kPi / 2.0, 1200.0, -5.0, 40.0}, BumpLoad::As::kDisplacement, 0.0});
  const auto edit = EditElastically(model, script, {});
  ASSERT_TRUE(edit) << edit.error().Text();
  const ElasticSolution& solution = edit->elastic->solution;
  EXPECT_EQ(solution.termination, "converged");
  EXPECT_NEAR(edit->elastic->loads.at(0).movement, -5.0, 0.05);
  EXPECT_LT(edit->elastic->loads.at(0).force, 0.0);
  for (std::size_t n = 1; n < solution.potential.size(); ++n) {
    EXPECT_LE(solution.potential[n], solution.potential[n - 1] * (1.0 + 1e-12));
  }
  // Nearly incompressible: what is pushed in comes out beside it.
  EXPECT_GT(*std::max_element(edit->elastic->maps.outward.begin(), edit->elastic->maps.outward.end()), 0.1);
  ElasticScript free = script;
  free.loads.clear();
  free.edits.push_back({kPi / 2.0, 1200.0, -5.0, 40.0});
  const auto dented = EditElastically(model, free, {});
  ASSERT_TRUE(dented);
  EXPECT_LT(std::abs(edit->volume_after - edit->volume_before),
            0.5 * std::abs(dented->volume_after - dented->volume_before));
}

TEST(ElasticEdit, BandBringsTheGirthThatIsAskedFor) {
  const SurfaceModel model = Trunk();
  ElasticScript script;
  script.region = AllAround(1080.0, 1320.0);
  BandLoad band;
  band.z = 1200.0;
  band.width = 30.0;
  const auto loose = EditElastically(model, script, {});
  ASSERT_TRUE(loose);
  EXPECT_EQ(loose->volume_after, loose->volume_before);
  band.girth = 885.0;
  script.bands.push_back(band);
  script.girths = {1200.0};
  const auto edit = EditElastically(model, script, {});
  ASSERT_TRUE(edit) << edit.error().Text();
  const BandResult& result = edit->elastic->bands.at(0);
  EXPECT_GT(result.girth_before, 895.0);
  for (const FibreState& thread : edit->elastic->solution.fibres) EXPECT_NEAR(thread.length, 885.0, 1e-3);
  // The surface is written in its own knots: its girth is off by no more than its radius is.
  EXPECT_NEAR(result.girth_after, 885.0, 2.0 * kPi * edit->written->largest_error);
  EXPECT_NEAR(edit->girths[0].tape_after, result.girth_after, 0.2);
  EXPECT_GT(result.tension, 0.0);
  EXPECT_GE(result.pressure_largest, result.pressure_mean);
  EXPECT_LT(std::abs(edit->volume_after / edit->volume_before - 1.0), 2e-3);
}

/// A band and a dent.
ElasticScript BandAndDent() {
  ElasticScript script;
  script.region = AllAround(1080.0, 1320.0);
  script.region->spacing = 8.0;
  BandLoad band;
  band.z = 1160.0;
  band.girth = 905.0;
  script.bands.push_back(band);
  script.loads.push_back({{0.3, 1250.0, -4.0, 40.0}, BumpLoad::As::kDisplacement, 0.0});
  script.girths = {1160.0, 1250.0};
  return script;
}

TEST(ElasticEdit, OfALimbBesideTheRingsAxisIsTheSame) {
  const SurfaceModel trunk = Trunk();
  SurfaceModel limb = trunk;
  limb.segments[0].axis.at = {210.0, -60.0};
  const auto one = EditElastically(trunk, BandAndDent(), {});
  const auto other = EditElastically(limb, BandAndDent(), {});
  ASSERT_TRUE(one && other);
  const Eigen::VectorXd& expected = one->model.main().surface.coefficients();
  EXPECT_LE((other->model.main().surface.coefficients() - expected).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_NEAR(other->elastic->bands[0].girth_before, one->elastic->bands[0].girth_before, 1e-9);
  EXPECT_NEAR(other->girths[1].tape_after, one->girths[1].tape_after, 1e-3);
}

TEST(ElasticEdit, FollowsALimbsBentAxis) {
  SurfaceModel limb = Trunk();
  limb.segments[0].axis = {1200.0, {150.0, 20.0}, {0.2, -0.05}, {2e-4, 1e-4}};
  const auto edit = EditElastically(limb, BandAndDent(), {});
  ASSERT_TRUE(edit) << edit.error().Text();
  const ElasticOutcome& outcome = *edit->elastic;
  EXPECT_EQ(outcome.solution.termination, "converged");
  const ElasticRegion& region = outcome.region;
  for (std::size_t stack = 0; stack < region.grid.shape.stacks(); stack += 7) {
    const Eigen::Vector3d at =
        limb.main().Point(region.theta[stack % region.grid.shape.columns], region.z[stack / region.grid.shape.columns]);
    EXPECT_LE((region.grid.nodes[region.SkinNode(stack)] - at).norm(), 1e-9);
  }
  for (const FibreState& thread : outcome.solution.fibres) EXPECT_NEAR(thread.length, 905.0, 1e-3);
  EXPECT_NEAR(outcome.bands[0].girth_after, 905.0, 2.0 * kPi * edit->written->largest_error);
  // A node's place of rest and its displacement give a point of the written surface.
  const std::size_t stack = region.grid.shape.columns * 12 + 3;
  Eigen::Vector3d moved = region.grid.nodes[region.SkinNode(stack)];
  moved += outcome.solution.displacement[region.SkinNode(stack)];
  const Eigen::Vector2d from_axis = moved.head<2>() - limb.main().axis.At(moved.z());
  EXPECT_NEAR(edit->model.main().surface.Radius(std::atan2(from_axis.y(), from_axis.x()), moved.z()), from_axis.norm(),
              edit->written->largest_error);
}

TEST(ElasticEdit, LaysATiltedBandAlongTheEllipseOfACylinder) {
  SurfaceModel model = Trunk();
  SplineSurface& surface = model.segments[0].surface;
  surface = SplineSurface(surface.theta_basis(), surface.z_basis(),
                          Eigen::VectorXd::Constant(surface.coefficients().size(), 100.0));
  ElasticScript script;
  script.region = AllAround(1050.0, 1350.0);
  BandLoad band;
  const double tilt = 25.0 * kPi / 180.0;
  band.normal = {0.0, std::sin(tilt), std::cos(tilt)};
  band.z = 1200.0;
  // scipy.special: b = 100; a = b/cos(25 deg); 4*a*ellipe(1 - b*b/a/a)
  constexpr double kEllipse = 661.194772836;
  band.girth = 0.98 * kEllipse;
  script.bands.push_back(band);
  const auto edit = EditElastically(model, script, {});
  ASSERT_TRUE(edit) << edit.error().Text();
  EXPECT_NEAR(edit->elastic->bands[0].girth_before, kEllipse, 0.01);
  EXPECT_EQ(edit->elastic->solution.termination, "converged");
  EXPECT_LE(edit->elastic->solution.steps, 20);  // Newton's, though the thread couples nodes of different rows
  for (const FibreState& thread : edit->elastic->solution.fibres) EXPECT_NEAR(thread.length, 0.98 * kEllipse, 1e-3);
  EXPECT_NEAR(edit->elastic->bands[0].girth_after, 0.98 * kEllipse, 2.0 * kPi * edit->written->largest_error);
  // The deepest place of the front is where the plane is lowest, that of the back where it is highest.
  const SplineSurface& after = edit->model.main().surface;
  const double rise = 100.0 * std::tan(tilt);
  EXPECT_LT(after.Radius(kPi / 2.0, 1200.0 - rise), 99.5);
  EXPECT_GT(after.Radius(kPi / 2.0, 1200.0 + rise), 99.5);
  EXPECT_LT(after.Radius(-kPi / 2.0, 1200.0 + rise), 99.5);
}

TEST(ElasticEdit, RefusesABandThatWouldSqueezeTheLayerFlat) {
  ElasticScript script = BandAndDent();
  script.region->spacing = 16.0;
  script.bands[0].girth = 790.0;
  const auto edit = EditElastically(Trunk(), script, {});
  ASSERT_FALSE(edit);
  EXPECT_NE(edit.error().Text().find("thicker layer"), std::string::npos) << edit.error().Text();
}

TEST(ElasticEdit, SaysWhatIsWrong) {
  const SurfaceModel model = Trunk();
  ElasticScript script;
  script.segment = "arm";
  EXPECT_FALSE(EditElastically(model, script, {}));
  script.segment.reset();
  script.edits.push_back({0.0, 5000.0, 1.0, 10.0});
  EXPECT_FALSE(EditElastically(model, script, {}));
  script.edits = {{0.0, 1200.0, -900.0, 60.0}};
  EXPECT_FALSE(EditElastically(model, script, {}));
  script.edits.clear();
  script.region = AllAround(1080.0, 1320.0);
  script.loads.push_back({{0.0, 1450.0, 5.0, 20.0}, BumpLoad::As::kPressure, 0.0});
  EXPECT_FALSE(EditElastically(model, script, {}));
  script.loads.clear();
  BandLoad band;
  band.z = 1310.0;
  band.width = 40.0;
  band.girth = 800.0;
  script.bands.push_back(band);
  EXPECT_FALSE(EditElastically(model, script, {}));
}

}  // namespace
}  // namespace annulus
