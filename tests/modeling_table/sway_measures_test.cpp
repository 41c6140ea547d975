// What sway does to measurements: simulated people who sway, scanned, corrected and fitted, against the resting figure.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "fitting/fit_surface.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/measure/plane_cut.h"
#include "modeling/measure/section.h"
#include "modeling/measure/slab.h"
#include "modeling/table/table.h"
#include "tests/fitting/swaying_person.h"

namespace annulus {
namespace {

using test::Displacing;
using test::SwayingPerson;
using test::SwayingScan;
using test::SweepPlan;

bool IsLong() { return std::getenv("ANNULUS_LONG") != nullptr; }

const SurfaceModel& Figure() {
  static const SurfaceModel model = test::StandingFigure({1700.0, 1.0, {6.0, -4.0, 0.03}});
  return model;
}

SwayingPerson PersonOf(std::uint64_t seed, Displacing displacing, double sway = 1.0) {
  sim::MotionOptions motion;
  motion.sway_scale = sway;
  motion.seed = seed;
  return {Figure().main().surface, motion, displacing};
}

SurfaceModel FitOf(const SwayingPerson& person, const SweepPlan& plan, std::uint64_t seed) {
  SwayEstimate sway = EstimateSway(SwayingScan(person, plan, seed), {}, {});
  auto fit = FitSurface(sway.corrected, {}, {});
  if (!fit) throw std::runtime_error(fit.error().Text());
  if (sway.errors) fit->model.systematic = SystematicErrors{{}, *sway.errors};
  return std::move(fit->model);
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

/// Errors of the tape at 1050 … 1225 mm, mm.
std::vector<double> GirthErrors(const SurfaceModel& model, const SurfaceModel& truth) {
  const MeasuredSurface body = Measured(model);
  const MeasuredSurface rest = Measured(truth);
  std::vector<double> errors;
  for (double z = 1050.0; z <= 1225.0; z += 25.0) {
    const auto measured = MeasureSection(body, z);
    const auto known = MeasureSection(rest, z);
    if (!measured || !known) throw std::runtime_error("no section");
    errors.push_back(measured->tape.value - known->tape.value);
  }
  return errors;
}

double MeanSize(const std::vector<double>& errors) {
  double sum = 0.0;
  for (const double error : errors) sum += std::abs(error) / static_cast<double>(errors.size());
  return sum;
}

double Largest(const std::vector<double>& errors) {
  double largest = 0.0;
  for (const double error : errors) largest = std::max(largest, std::abs(error));
  return largest;
}

/// The rigid displacement that is nearest to those of the sections, mean of all sweeps: what is no error of a shape.
SwayMotion RigidOf(const SwayingPerson& person, const SweepPlan& plan) {
  std::vector<SurfaceSample> levels = SwayingScan(person, plan, 1);
  std::erase_if(levels, [](const SurfaceSample& s) { return s.sensor != 0; });
  Eigen::MatrixXd heights(static_cast<Eigen::Index>(levels.size()), 2);
  Eigen::MatrixXd displaced(heights.rows(), 2);
  for (Eigen::Index k = 0; k < heights.rows(); ++k) {
    const SurfaceSample& level = levels[static_cast<std::size_t>(k)];
    heights.row(k) << level.z / kSwayHeight, 1.0;
    displaced.row(k) = person.MotionAt(level.time_s).At(level.z).transpose();
  }
  const Eigen::Matrix2d fit = heights.colPivHouseholderQr().solve(displaced);
  return {fit(0, 0), fit(0, 1), 0.0, fit(1, 0), fit(1, 1)};
}

/// The plane that a rigid displacement takes a plane of the resting body to.
CuttingPlane Displaced(const CuttingPlane& plane, const SwayMotion& motion) {
  const Eigen::Vector3d at = plane.offset * plane.normal;
  const Eigen::Vector3d u = plane.normal.unitOrthogonal();
  const Eigen::Vector3d v = plane.normal.cross(u);
  const Eigen::Vector3d moved = StationFromRest(at, motion);
  const Eigen::Vector3d normal =
      (StationFromRest(at + u, motion) - moved).cross(StationFromRest(at + v, motion) - moved).normalized();
  return {normal, normal.dot(moved)};
}

/// Errors of girths in planes that are tilted by 20° forward, aside and backward.
std::vector<double> TiltedErrors(const SurfaceModel& model, const SwayMotion& rigid) {
  const MeasuredSurface body = Measured(model);
  const MeasuredSurface rest = Measured(Figure());
  std::vector<double> errors;
  for (const double azimuth : {90.0, 0.0, 270.0, 180.0}) {
    for (const double z : {1000.0, 1080.0, 1160.0}) {
      const double tilt = RadiansFromDegrees(20.0);
      const Eigen::Vector3d normal = PointFromCylindrical(RadiansFromDegrees(azimuth), std::sin(tilt), std::cos(tilt));
      const CuttingPlane plane{normal, normal.z() * z};
      const auto known = GirthInPlane(rest, plane);
      const auto measured = GirthInPlane(body, Displaced(plane, rigid));
      if (!known || !measured) throw std::runtime_error("no girth");
      errors.push_back(measured->tape.value - known->tape.value);
    }
  }
  return errors;
}

SweepPlan PlanOf(std::uint32_t sweeps, double duration_s) {
  SweepPlan plan;
  plan.sweeps = sweeps;
  plan.duration_s = duration_s;
  return plan;
}

// Against the same body, scanned alike but standing still with the same noise: what is left is of sway.
TEST(SwayMeasures, HorizontalGirthsUnderPureTranslationStay) {
  const SurfaceModel still = FitOf(PersonOf(1, Displacing::kTranslation, 0.0), PlanOf(4, 6.0), 3);
  std::vector<double> all;
  for (std::uint64_t seed = 100; seed < (IsLong() ? 120U : 103U); ++seed) {
    const auto errors = GirthErrors(FitOf(PersonOf(seed, Displacing::kTranslation), PlanOf(4, 6.0), 3), still);
    all.insert(all.end(), errors.begin(), errors.end());
  }
  std::printf("girths under translation: mean |error| %.3f, largest %.3f mm\n", MeanSize(all), Largest(all));
  EXPECT_LE(MeanSize(all), 0.1);
  EXPECT_LE(Largest(all), 0.2);
}

TEST(SwayMeasures, HorizontalGirthsUnderLeanAreGoodToAFewTenths) {
  std::vector<double> all;
  for (std::uint64_t seed = 100; seed < (IsLong() ? 150U : 103U); ++seed) {
    const auto errors = GirthErrors(FitOf(PersonOf(seed, Displacing::kLean), PlanOf(4, 6.0), seed), Figure());
    all.insert(all.end(), errors.begin(), errors.end());
  }
  std::printf("girths under lean: mean |error| %.3f, largest %.3f mm\n", MeanSize(all), Largest(all));
  EXPECT_LE(MeanSize(all), 0.3);
  EXPECT_LE(Largest(all), 1.0);
}

TEST(SwayMeasures, TiltedGirthsGainByMoreSweeps) {
  std::map<std::string, std::vector<double>> all;
  for (const auto& [name, plan] : {std::pair<std::string, SweepPlan>{"1 x 12 s", PlanOf(1, 12.0)},
                                   {"2 x 12 s", PlanOf(2, 12.0)},
                                   {"4 x 6 s", PlanOf(4, 6.0)}}) {
    for (std::uint64_t seed = 100; seed < (IsLong() ? 150U : 104U); ++seed) {
      const SwayingPerson person = PersonOf(seed, Displacing::kLean);
      const auto errors = TiltedErrors(FitOf(person, plan, seed), RigidOf(person, plan));
      all[name].insert(all[name].end(), errors.begin(), errors.end());
    }
    std::printf("tilted girths, %s: mean |error| %.3f, largest %.3f mm\n", name.c_str(), MeanSize(all[name]),
                Largest(all[name]));
  }
  EXPECT_LE(MeanSize(all["4 x 6 s"]), (IsLong() ? 0.5 : 0.8) * MeanSize(all["1 x 12 s"]));
  EXPECT_LE(MeanSize(all["2 x 12 s"]), (IsLong() ? 1.0 : 1.3) * MeanSize(all["1 x 12 s"]));
}

struct Series {
  std::vector<double> values;
  int held = 0;
  double sway_square = 0.0;

  [[nodiscard]] double Mean() const {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }
  [[nodiscard]] double Deviation() const {
    double sum = 0.0;
    for (const double value : values) sum += (value - Mean()) * (value - Mean());
    return std::sqrt(sum / static_cast<double>(values.size() - 1));
  }
};

// One figure, scanned again and again while it sways: how its numbers repeat, and whether their intervals hold those of
// the same rules on the resting figure.
TEST(SwayMeasures, RepeatAndTheirIntervalsHold) {
  const MeasuredSurface rest = Measured(Figure());
  const auto known = MeasureTable(rest, FindLandmarks(rest, {}));
  ASSERT_TRUE(known) << known.error().Text();
  std::map<std::string, double> truth;
  for (const Measurement& m : known->measurements) truth[m.id] = m.value.value;
  std::map<std::string, Series> series;
  Series slab;
  for (std::uint64_t seed = 200; seed < (IsLong() ? 250U : 205U); ++seed) {
    const SurfaceModel model = FitOf(PersonOf(seed, Displacing::kLean), PlanOf(4, 6.0), seed);
    const MeasuredSurface body = Measured(model);
    const auto table = MeasureTable(body, FindLandmarks(body, {}));
    ASSERT_TRUE(table) << table.error().Text();
    for (const Measurement& m : table->measurements) {
      if (truth.count(m.id) == 0) continue;
      Series& s = series[m.id];
      s.values.push_back(m.value.value);
      s.held += std::abs(m.value.value - truth[m.id]) <= 1.96 * m.value.sigma ? 1 : 0;
      s.sway_square += m.budget.sway * m.budget.sway;
    }
    const auto volume = MeasureSlab(body, 850.0, 1250.0);
    ASSERT_TRUE(volume);
    slab.values.push_back(volume->volume.value);
  }
  double held = 0.0;
  double all = 0.0;
  for (const auto& [id, s] : series) {
    const auto count = static_cast<double>(s.values.size());
    std::printf("%-32s truth %.2f, mean %.2f, sd %.3f, sway in sigma %.3f, held %.2f\n", id.c_str(), truth[id],
                s.Mean(), s.Deviation(), std::sqrt(s.sway_square / count), s.held / count);
    held += s.held;
    all += count;
  }
  std::printf("intervals held %.3f of %.0f; slab of the trunk: sd %.4f %%\n", held / all, all,
              100.0 * slab.Deviation() / slab.Mean());
  EXPECT_GE(held / all, 0.9);
  EXPECT_LE(slab.Deviation(), 0.0015 * slab.Mean());
  for (const char* id : {"chest_girth", "waist_girth", "hip_girth"}) {
    ASSERT_EQ(series.count(id), 1U) << id;
    EXPECT_LE(series[id].Deviation(), 1.5) << id;
  }
  for (const char* id : {"head_girth", "neck_girth"}) {
    ASSERT_EQ(series.count(id), 1U) << id;
    EXPECT_LE(series[id].Deviation(), 1.0) << id;
  }
}

}  // namespace
}  // namespace annulus
