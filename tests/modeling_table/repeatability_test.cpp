// One simulated person, scanned again and again: every time with other noise and standing elsewhere.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "fitting/fit_surface.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/measure/slab.h"
#include "modeling/table/table.h"
#include "tests/modeling_table/simulated_torso.h"

namespace annulus {
namespace {

struct Series {
  std::vector<double> values;
  double sigma_square = 0.0;  ///< Sum of the variances that the program states, without the placing of landmarks.

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

using SeriesById = std::map<std::string, Series>;

struct Repeated {
  int scans = 0;
  SeriesById table;
  SeriesById slabs;  ///< Between heights that do not move.
};

sim::Placement AnywhereNear(std::mt19937_64& random) {
  sim::Placement placement;
  placement.x_mm = test::Uniform(random, -8.0, 8.0);
  placement.y_mm = test::Uniform(random, -8.0, 8.0);
  placement.yaw_rad = test::Uniform(random, -0.08, 0.08);
  return placement;
}

void ScanOnce(std::uint64_t seed, Repeated& repeated) {
  std::mt19937_64 random(seed);
  const test::SimulatedTorso torso = test::PersonTorso({1690.0, 1.04, AnywhereNear(random)});
  const auto fit = FitSurface(test::NoisyScan(torso, test::CleanRadii(torso), seed + 500), {}, {});
  ASSERT_TRUE(fit) << fit.error().Text();
  const auto body = MeasuredSurface::FromModel(fit->model);
  ASSERT_TRUE(body) << body.error().Text();
  const auto table = MeasureTable(*body, FindLandmarks(*body, {}));
  ASSERT_TRUE(table) << table.error().Text();
  for (const Measurement& m : table->measurements) {
    Series& series = repeated.table[m.id];
    series.values.push_back(m.value.value);
    series.sigma_square += m.value.sigma * m.value.sigma - m.budget.landmarks * m.budget.landmarks;
  }
  for (const auto& [id, low, high] : {std::tuple{"trunk, 850 … 1250 mm", 850.0, 1250.0},
                                      {"hip, 850 … 950 mm", 850.0, 950.0},
                                      {"head, 1500 … 1650 mm", 1500.0, 1650.0}}) {
    const auto slab = MeasureSlab(*body, low, high);
    ASSERT_TRUE(slab) << slab.error().Text();
    Series& series = repeated.slabs[id];
    series.values.push_back(slab->volume.value);
    series.sigma_square += slab->volume.sigma * slab->volume.sigma;
  }
  ++repeated.scans;
}

/// 12 scans; ANNULUS_LONG: 50.
const Repeated& AllScans() {
  static const Repeated all = [] {
    const std::uint64_t scans = std::getenv("ANNULUS_LONG") != nullptr ? 50 : 12;
    Repeated repeated;
    for (std::uint64_t k = 0; k < scans && !testing::Test::HasFatalFailure(); ++k)
      ScanOnce(63'000 + 1'000 * k, repeated);
    return repeated;
  }();
  return all;
}

void Print(const std::string& id, const Series& s, std::string_view unit) {
  std::printf("%-34s %2zu scans: mean %.2f, sd %.3f %s (%.4f %%), stated %.3f\n", id.c_str(), s.values.size(), s.Mean(),
              s.Deviation(), unit.data(), 100.0 * s.Deviation() / s.Mean(),
              std::sqrt(s.sigma_square / static_cast<double>(s.values.size())));
}

void ExpectDeviations(const std::vector<std::string>& ids, double limit) {
  const Repeated& all = AllScans();
  for (const std::string& id : ids) {
    const auto found = all.table.find(id);
    ASSERT_NE(found, all.table.end()) << id;
    EXPECT_EQ(found->second.values.size(), static_cast<std::size_t>(all.scans)) << id;
    Print(id, found->second, "mm");
    EXPECT_LE(found->second.Deviation(), limit) << id;
  }
}

// Known to fall short: under_bust_girth, sd 2.4 mm (50 scans), as the fold below the chest is found to 2 mm of height
// on levels 5 mm apart; neck_base_girth, 3.3 mm, as its plane is tilted by two points. Their intervals say so.
TEST(Repeatability, OfLargeGirthsIsHalfAMillimetre) {
  ExpectDeviations({"chest_girth", "waist_girth", "omphalion_girth", "top_hip_girth", "hip_girth"}, 0.5);
}

TEST(Repeatability, OfSmallGirthsIsThreeTenthsOfAMillimetre) { ExpectDeviations({"head_girth", "neck_girth"}, 0.3); }

TEST(Repeatability, OfVolumesBetweenFixedHeightsIsHalfAPerThousand) {
  for (const auto& [id, series] : AllScans().slabs) {
    Print(id, series, "mm3");
    EXPECT_LE(series.Deviation(), 0.0005 * series.Mean()) << id;
  }
}

TEST(Repeatability, OfEveryOtherNumberIsPrinted) {
  for (const auto& [id, series] : AllScans().table) Print(id, series, "");
}

}  // namespace
}  // namespace annulus
