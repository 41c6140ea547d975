// The 95 % band of the radius, as `eval` writes it, against bodies that are known exactly.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "fitting/fit_surface.h"
#include "modeling/measure/section.h"
#include "sim/head.h"
#include "sim/person.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

using test::Normal;
using test::RadiusFunction;
using test::Uniform;

/// How a body is scanned.
struct Scanning {
  std::uint32_t levels = 80;
  std::uint16_t sensors = 60;
  double pitch = 5.0;     ///< mm
  double z_min = 0.0;     ///< mm
  double noise = 0.5;     ///< sd, mm
  double dropouts = 0.0;  ///< Share of returns that are lost.
  bool off_grid = false;  ///< Whether every return has a direction and a height of its own.
  bool has_hole = false;  ///< Whether 8 × 12 cells are not seen.
  std::uint64_t seed = 1;
};

std::vector<SurfaceSample> Scan(const RadiusFunction& radius, const Scanning& how) {
  std::mt19937_64 random(how.seed);
  std::vector<SurfaceSample> samples;
  for (std::uint32_t level = 0; level < how.levels; ++level) {
    for (std::uint16_t sensor = 0; sensor < how.sensors; ++sensor) {
      const double aside = how.off_grid ? Uniform(random, -0.1, 0.1) : 0.0;
      const double above = how.off_grid ? Uniform(random, -0.1, 0.1) : 0.0;
      const bool is_lost = Uniform(random, 0.0, 1.0) < how.dropouts;
      const double noise = how.noise * Normal(random);
      const bool is_hidden = how.has_hole && sensor >= 20 && sensor < 28 && level >= 30 && level < 42;
      if (is_lost || is_hidden) continue;
      SurfaceSample sample;
      sample.theta = WrapAngle(kTwoPi * (sensor + aside) / how.sensors);
      sample.z = how.z_min + how.pitch * (level + above);
      sample.radius = radius(sample.theta, sample.z) + noise;
      if (!(sample.radius > 0.0)) continue;
      sample.ray_direction = -PointFromCylindrical(sample.theta, 1.0, 0.0).cast<float>();
      sample.level = level;
      sample.sensor = sensor;
      samples.push_back(sample);
    }
  }
  return samples;
}

/// The truth at the cells of a scan: radii, and which cells are smooth. Smooth is a cell in whose 7 × 7 cells no second
/// difference of the truth, around or upwards, exceeds 2 mm (between those lie noses, ears, creases and the edges of
/// arms), on any level but the two lowest and the two highest.
struct Truth {
  std::vector<double> radius;
  std::vector<char> smooth;

  Truth(const RadiusFunction& truth, const Scanning& how) {
    constexpr double kSteepest = 2.0;  // mm
    constexpr std::ptrdiff_t kReach = 3;
    const auto columns = static_cast<std::ptrdiff_t>(how.sensors);
    const auto rows = static_cast<std::ptrdiff_t>(how.levels);
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      for (std::ptrdiff_t c = 0; c < columns; ++c) {
        radius.push_back(
            truth(kTwoPi * static_cast<double>(c) / how.sensors, how.z_min + how.pitch * static_cast<double>(row)));
      }
    }
    const auto at = [&](std::ptrdiff_t row, std::ptrdiff_t c) {
      return radius[static_cast<std::size_t>(row * columns + (c + columns) % columns)];
    };
    smooth.assign(radius.size(), 1);
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      for (std::ptrdiff_t c = 0; c < columns; ++c) {
        const double around = at(row, c - 1) - 2.0 * at(row, c) + at(row, c + 1);
        const bool at_end = row == 0 || row + 1 == rows;
        const double upwards = at_end ? 0.0 : at(row - 1, c) - 2.0 * at(row, c) + at(row + 1, c);
        if (std::abs(around) <= kSteepest && std::abs(upwards) <= kSteepest) continue;  // NaN is not smooth
        for (std::ptrdiff_t r = std::max<std::ptrdiff_t>(0, row - kReach); r <= std::min(rows - 1, row + kReach); ++r) {
          for (std::ptrdiff_t k = c - kReach; k <= c + kReach; ++k) {
            smooth[static_cast<std::size_t>(r * columns + (k + columns) % columns)] = 0;
          }
        }
      }
    }
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      if (row >= 2 && row < rows - 2) continue;
      for (std::ptrdiff_t c = 0; c < columns; ++c) smooth[static_cast<std::size_t>(row * columns + c)] = 0;
    }
  }
};

/// What was counted over the smooth cells of some scans.
struct Count {
  double cells = 0.0;
  double covered = 0.0;
  double scans = 0.0;
  double chi_square = 0.0;  ///< Sum over scans of estimated over true noise variance.

  [[nodiscard]] double coverage() const { return covered / cells; }
  void Add(const Count& other) {
    cells += other.cells;
    covered += other.covered;
    scans += other.scans;
    chi_square += other.chi_square;
  }
};

/// Fits one scan and counts. A cell counts if it is smooth and at least 7 of its 3 × 3 cells gave a return: cells in
/// or beside holes do not.
Count CountOne(const RadiusFunction& body, const Truth& truth, const Scanning& how) {
  const std::vector<SurfaceSample> samples = Scan(body, how);
  std::vector<char> seen(truth.radius.size(), 0);
  for (const SurfaceSample& s : samples) seen[std::size_t{s.level} * how.sensors + s.sensor] = 1;
  const auto fit = FitSurface(samples, {}, {});
  EXPECT_TRUE(fit.has_value()) << fit.error().Text();
  const auto surface = MeasuredSurface::FromModel(fit->model);
  EXPECT_TRUE(surface.has_value()) << surface.error().Text();
  Count count;
  for (std::size_t level = 2; level + 2 < how.levels; ++level) {
    for (std::size_t sensor = 0; sensor < how.sensors; ++sensor) {
      const std::size_t cell = level * how.sensors + sensor;
      if (truth.smooth[cell] == 0) continue;
      int neighbours = 0;
      for (std::size_t r = level - 1; r <= level + 1; ++r) {
        for (const std::size_t c : {sensor + how.sensors - 1, sensor, sensor + 1}) {
          neighbours += seen[r * how.sensors + c % how.sensors];
        }
      }
      if (neighbours < 7) continue;
      const double theta = kTwoPi * static_cast<double>(sensor) / how.sensors;
      const double z = how.z_min + how.pitch * static_cast<double>(level);
      const double error = surface->Radius(theta, z) - truth.radius[cell];
      count.cells += 1.0;
      if (std::abs(error) <= 1.96 * surface->RadiusSigma(theta, z)) count.covered += 1.0;
    }
  }
  count.scans = 1.0;
  count.chi_square = std::pow(fit->summary.noise_sigma_mm / how.noise, 2);
  return count;
}

/// A body, how it is scanned, and how often with each noise. A body may differ with its seed.
struct Case {
  std::string name;
  std::function<RadiusFunction(std::uint64_t seed)> body;
  Scanning how;
  std::uint64_t seeds = 1;  ///< For each of three noises.
  bool same_body = true;
};

/// The radius at which a ring's ray meets a subject; NaN where it meets none.
RadiusFunction RadiusOf(const sim::ParametricBody& subject) {
  return [&subject](double theta, double z) {
    constexpr double kRing = 900.0;  // mm
    const Ray ray{PointFromCylindrical(theta, kRing, z), -PointFromCylindrical(theta, 1.0, 0.0)};
    const auto hit = subject.Cast(ray, 0.0, kRing);
    return hit ? kRing - hit->distance_mm : std::numeric_limits<double>::quiet_NaN();
  };
}

/// An elliptic trunk with a waist.
double Waisted(double theta, double z) {
  const double waist = 1.0 - 0.18 * std::exp(-std::pow((z - 210.0) / 70.0, 2));
  return waist * 170.0 * 120.0 / std::hypot(120.0 * std::cos(theta), 170.0 * std::sin(theta));
}

/// A chest with two swells and a groove down the back.
double Chest(double theta, double z) {
  const auto swell = [&](double at) {
    return 30.0 * std::exp(-std::pow(AngleDifference(theta, at) / 0.38, 2) - std::pow((z - 230.0) / 45.0, 2));
  };
  return 140.0 + 14.0 * std::cos(2.0 * theta) + swell(1.2) + swell(1.95) -
         9.0 * std::exp(-std::pow(AngleDifference(theta, 4.71) / 0.22, 2)) + 6.0 * std::sin(z / 60.0);
}

/// A sum of 40 random waves whose amplitude falls with the square of their number, 5 … 40 mm in all.
RadiusFunction RandomBody(std::uint64_t seed) {
  struct Wave {
    double around, upwards, phase, amplitude;
  };
  std::mt19937_64 random(seed);
  const double size = Uniform(random, 8.0, 25.0);
  std::vector<Wave> waves;
  for (int k = 0; k < 40; ++k) {
    const double around = std::floor(Uniform(random, 0.0, 9.0));
    const double upwards = Uniform(random, 0.0, 8.0);
    waves.push_back({around, upwards * kTwoPi / 400.0, Uniform(random, 0.0, kTwoPi),
                     size / (1.0 + around * around + upwards * upwards)});
  }
  return [waves](double theta, double z) {
    double radius = 150.0;
    for (const Wave& w : waves) radius += w.amplitude * std::cos(w.around * theta + w.upwards * z + w.phase);
    return radius;
  };
}

std::vector<Case> Cases() {
  static const sim::ParametricBody kHead = sim::MakeHead({1580.0, {-2.0, 4.0, -0.1}});
  static const sim::ParametricBody kPerson = sim::MakePerson({1820.0, 1.08, {-3.0, 5.0, 0.1}});
  const auto always = [](const RadiusFunction& body) { return [body](std::uint64_t) { return body; }; };
  const auto how = [](const std::function<void(Scanning&)>& change) {
    Scanning scanning;
    change(scanning);
    return scanning;
  };
  return {{"waisted trunk", always(Waisted), how([](Scanning& s) { s.dropouts = 0.02; }), 14},
          {"chest, off the grid", always(Chest), how([](Scanning& s) {
             s.dropouts = 0.02;
             s.off_grid = true;
           }),
           14},
          {"random bodies", RandomBody, how([](Scanning& s) { s.dropouts = 0.05; }), 24, false},
          {"random bodies with a hole", RandomBody, how([](Scanning& s) { s.has_hole = true; }), 10, false},
          {"person's trunk", always(RadiusOf(kPerson)), how([](Scanning& s) {
             s.levels = 90;
             s.sensors = 90;
             s.z_min = 930.0;
           }),
           4},
          {"head", always(RadiusOf(kHead)), how([](Scanning& s) {
             s.levels = 90;
             s.sensors = 120;
             s.pitch = 2.5;
             s.z_min = 1340.0;
             s.dropouts = 0.02;
           }),
           4}};
}

TEST(Coverage, OfTheBandOnSmoothRegionsIsItsProbability) {
  // ANNULUS_LONG: four times as many scans.
  const std::uint64_t longer = std::getenv("ANNULUS_LONG") != nullptr ? 4 : 1;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr std::uint64_t kShare = 4;  // of the scans: these builds are slow
#else
  constexpr std::uint64_t kShare = 1;
#endif
  Count all;
  std::uint64_t seed = 71'000;
  for (const Case& c : Cases()) {
    for (const double noise : {0.25, 0.5, 1.0}) {
      Count count;
      std::optional<Truth> truth;
      const std::uint64_t seeds = std::max<std::uint64_t>(1, c.seeds * longer / kShare);
      for (std::uint64_t k = 0; k < seeds; ++k) {
        Scanning how = c.how;
        how.noise = noise;
        how.seed = ++seed;
        const RadiusFunction body = c.body(seed);
        if (!truth || !c.same_body) truth.emplace(body, how);
        const Count one = CountOne(body, *truth, how);
        // 4,800 returns: chi-square scatters by 0.02, and a rough body's fit by as much again.
        EXPECT_NEAR(one.chi_square, 1.0, 0.15) << c.name << ", noise " << noise << ", seed " << seed;
        count.Add(one);
      }
      std::printf("%-26s noise %.2f mm: %3.0f scans, %6.0f cells, coverage %.3f, chi-square %.3f\n", c.name.c_str(),
                  noise, count.scans, count.cells, count.coverage(), count.chi_square / count.scans);
      EXPECT_NEAR(count.chi_square / count.scans, 1.0, 0.1) << c.name << ", noise " << noise;
      EXPECT_GE(count.coverage(), 0.90) << c.name << ", noise " << noise;
      EXPECT_LE(count.coverage(), 0.985) << c.name << ", noise " << noise;  // very smooth ones: too wide a band
      all.Add(count);
    }
  }
  std::printf("all: %.0f scans, coverage %.4f, chi-square %.3f\n", all.scans, all.coverage(),
              all.chi_square / all.scans);
  EXPECT_GE(all.scans * static_cast<double>(kShare), 200.0);
  EXPECT_GE(all.coverage(), 0.92);
  EXPECT_LE(all.coverage(), 0.97);
}

}  // namespace
}  // namespace annulus
