/// One small scan through fit, section, slab and girth, against stored numbers: tells when results move, even within
/// what the other tests allow. The scan is made here from a formula and a fixed seed.
///
/// Where a change is meant to move the numbers, store them again from the repository's folder with
///   ANNULUS_UPDATE_GOLDEN=1 build/release/golden_test
/// and say in the commit by how much they moved.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "fitting/fit_surface.h"
#include "modeling/measure/section.h"
#include "modeling/measure/slab.h"
#include "tests/fitting/synthetic_scan.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTolerance = 0.02;  // mm; areas and volumes: times a length of the body

/// A trunk with a ridge and a crease, 60 levels of 90 sensors, 0.3 mm noise, 1 % dropouts, a few outliers.
std::vector<SurfaceSample> Scan() {
  const auto radius = [](double theta, double z) {
    const double from_ridge = AngleDifference(theta, 1.5) * 150.0;
    const double from_crease = z - 160.0;
    return test::SmoothTrunk(theta, z) + 12.0 * std::exp(-from_ridge * from_ridge / 400.0) -
           6.0 * std::exp(-from_crease * from_crease / 80.0);
  };
  test::ScanShape shape;
  shape.noise = 0.3;
  shape.seed = 20'260'101;
  std::vector<SurfaceSample> samples = test::SyntheticScan(radius, shape);
  std::mt19937_64 random(5);
  std::vector<SurfaceSample> kept;
  for (SurfaceSample& sample : samples) {
    const std::uint64_t fate = random() % 1000;
    if (fate < 10) continue;
    if (fate < 13) sample.radius += 150.0;
    kept.push_back(sample);
  }
  return kept;
}

/// Name of a number, the number, and how far it may move.
struct Entry {
  const char* name;
  double value;
  double tolerance;
};

std::vector<Entry> Measure() {
  const auto fit = FitSurface(Scan(), {}, {});
  if (!fit) throw std::runtime_error(fit.error().Text());
  const auto body = MeasuredSurface::FromModel(fit->model);
  if (!body) throw std::runtime_error(body.error().Text());
  const auto low = MeasureSection(*body, 75.0);
  const auto crease = MeasureSection(*body, 160.0);
  const auto slab = MeasureSlab(*body, 20.0, 280.0);
  const auto front = MeridianLength(*body, 1.5, 20.0, 280.0);
  if (!low || !crease || !slab || !front) throw std::runtime_error("the body cannot be measured");
  return {{"noise_sigma_mm", fit->summary.noise_sigma_mm, 0.005},
          {"rejected", static_cast<double>(fit->summary.rejected.size()), 1.0},
          {"low_perimeter_mm", low->perimeter.value, kTolerance},
          {"low_tape_mm", low->tape.value, kTolerance},
          {"low_tape_sigma_mm", low->tape.sigma, 0.005},
          {"low_area_mm2", low->area.value, kTolerance * 150.0},
          {"crease_perimeter_mm", crease->perimeter.value, 2.0 * kTolerance},
          {"crease_area_mm2", crease->area.value, 2.0 * kTolerance * 150.0},
          {"slab_volume_mm3", slab->volume.value, kTolerance * 150.0 * 260.0},
          {"slab_area_mm2", slab->area.value, 3.0 * kTolerance * 260.0},
          {"front_length_mm", front->value, kTolerance}};
}

TEST(Golden, FittedScanMeasuresAsItDid) {
  const std::string path = test::SourceFolder() + "/tests/golden/fitted_scan.json";
  const std::vector<Entry> entries = Measure();
  if (std::getenv("ANNULUS_UPDATE_GOLDEN") != nullptr) {
    Json json;
    for (const Entry& entry : entries) json[entry.name] = entry.value;
    std::ofstream(path) << json.dump(1) << "\n";
    GTEST_SKIP() << "stored " << path;
  }
  std::ifstream file(path);
  ASSERT_TRUE(file) << path;
  const Json json = Json::parse(file);
  ASSERT_EQ(json.size(), entries.size());
  for (const Entry& entry : entries) {
    EXPECT_NEAR(entry.value, json.at(entry.name).get<double>(), entry.tolerance) << entry.name;
  }
}

}  // namespace
}  // namespace annulus
