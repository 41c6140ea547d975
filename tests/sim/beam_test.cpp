#include "sim/beam.h"

#include <gtest/gtest.h>

#include <cmath>

namespace annulus::sim {
namespace {

// The half space y <= 0, whose surface may be tilted by having another normal.
class Wall final : public Subject {
 public:
  explicit Wall(double incidence, double reflectance = 1.0)
      : normal_(std::sin(incidence), std::cos(incidence), 0.0), reflectance_(reflectance) {}
  std::optional<SubjectHit> Cast(const Ray& ray, double, double max_distance_mm) const override {
    const double slope = -ray.direction.dot(normal_);
    if (slope <= 0.0) return std::nullopt;
    const double distance = ray.origin.dot(normal_) / slope;
    if (distance < 0.0 || distance > max_distance_mm) return std::nullopt;
    return SubjectHit{distance, normal_, reflectance_};
  }
  double top_mm() const override { return 1e6; }
  double bottom_mm() const override { return -1e6; }
  std::string name() const override { return "wall"; }

 private:
  Eigen::Vector3d normal_;
  double reflectance_;
};

const Ray kRay{{0, 400, 0}, {0, -1, 0}};

struct Statistics {
  double mean = 0.0, sd = 0.0, missing = 0.0, wrong = 0.0;
};

// Of 100,000 readings: those within 15 mm of the truth, the share that is missing, the share that is elsewhere.
Statistics Sample(const Subject& subject, const BeamOptions& options) {
  constexpr int kCount = 100000;
  const BeamModel beam(options);
  std::mt19937_64 random(11);
  Statistics result;
  double sum = 0.0;
  double squares = 0.0;
  int good = 0;
  for (int i = 0; i < kCount; ++i) {
    const BeamReading reading = beam.Measure(subject, kRay, 0.0, 1200.0, random);
    if (std::isnan(reading.range_mm)) {
      result.missing += 1.0 / kCount;
    } else if (std::abs(reading.range_mm - 400.0) > 15.0) {
      result.wrong += 1.0 / kCount;
      EXPECT_LE(std::abs(reading.range_mm - 400.0), 200.0 + 1e-9);
      EXPECT_GE(std::abs(reading.range_mm - 400.0), 20.0 - 1e-9);
    } else {
      ++good;
      sum += reading.range_mm - 400.0;
      squares += (reading.range_mm - 400.0) * (reading.range_mm - 400.0);
    }
  }
  result.mean = 400.0 + sum / good;
  result.sd = std::sqrt(squares / good - (sum / good) * (sum / good));
  return result;
}

TEST(BeamModel, HasTheStatedNoiseDropoutsAndOutliers) {
  BeamOptions options;
  options.dropout_rate = 0.03;
  options.outlier_rate = 0.01;
  const Statistics statistics = Sample(Wall(0.0), options);
  EXPECT_NEAR(statistics.mean, 400.0, 0.01);      // 0.5 / sqrt(1e5) = 0.0016 times six
  EXPECT_NEAR(statistics.sd, 0.5, 0.007);         // 0.5 / sqrt(2e5) = 0.0011 times six
  EXPECT_NEAR(statistics.missing, 0.03, 0.0033);  // sqrt(p (1 - p) / n) times six
  EXPECT_NEAR(statistics.wrong, 0.97 * 0.01, 0.0019);
}

TEST(BeamModel, IsNoisierOnSlantingAndDarkSurfaces) {
  // At 60 degrees and on half reflectance the signal is 1/2: sqrt(2) of the noise.
  EXPECT_NEAR(Sample(Wall(std::acos(0.5)), {}).sd, 0.5 * std::sqrt(2.0), 0.01);
  EXPECT_NEAR(Sample(Wall(0.0, 0.5), {}).sd, 0.5 * std::sqrt(2.0), 0.01);
}

TEST(BeamModel, LosesWeakReturns) {
  // Signal 0.05 of 0.15: dropout_rate + (1 - dropout_rate) (2/3)².
  EXPECT_NEAR(Sample(Wall(0.0, 0.05), {}).missing, 0.01 + 0.99 * 4.0 / 9.0, 0.01);
}

TEST(BeamModel, RepeatsItselfWithTheSameSeed) {
  const BeamModel beam{BeamOptions{}};
  std::mt19937_64 one(3);
  std::mt19937_64 two(3);
  for (int i = 0; i < 100; ++i) {
    const double a = beam.Measure(Wall(0.3), kRay, 0.0, 1200.0, one).range_mm;
    const double b = beam.Measure(Wall(0.3), kRay, 0.0, 1200.0, two).range_mm;
    EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
  }
}

TEST(BeamModel, TakesEquallyManyDrawsWhetherItHitsOrNot) {
  const BeamModel beam{BeamOptions{}};
  std::mt19937_64 hit(5);
  std::mt19937_64 missed(5);
  (void)beam.Measure(Wall(0.0), kRay, 0.0, 1200.0, hit);
  (void)beam.Measure(Wall(0.0), {kRay.origin, -kRay.direction}, 0.0, 1200.0, missed);
  EXPECT_EQ(hit(), missed());
}

TEST(BeamModel, AveragesOverItsSpot) {
  // A ball: at distance d from the axis its surface lies d²/(2 R) deeper, on average over four rays at d² = spot²/8 and
  // the central one, whose lights are about equal.
  class Ball final : public Subject {
   public:
    std::optional<SubjectHit> Cast(const Ray& ray, double, double max_distance_mm) const override {
      const double along = -ray.origin.dot(ray.direction);
      const double under_root = 100.0 - (ray.origin + along * ray.direction).squaredNorm();
      if (under_root < 0.0) return std::nullopt;
      const double distance = along - std::sqrt(under_root);
      if (distance < 0.0 || distance > max_distance_mm) return std::nullopt;
      return SubjectHit{distance, (ray.origin + distance * ray.direction) / 10.0, 1.0};
    }
    double top_mm() const override { return 10.0; }
    double bottom_mm() const override { return -10.0; }
    std::string name() const override { return "ball"; }
  };
  BeamOptions options;
  options.noise_sigma_mm = options.dropout_rate = options.outlier_rate = 0.0;
  std::mt19937_64 random(1);
  EXPECT_NEAR(BeamModel(options).Measure(Ball(), kRay, 0.0, 1200.0, random).range_mm, 390.0 + 0.8 * 0.5 / 20.0, 2e-3);
  options.spot_diameter_mm = 0.0;
  EXPECT_NEAR(BeamModel(options).Measure(Ball(), kRay, 0.0, 1200.0, random).range_mm, 390.0, 1e-12);
}

TEST(BeamModel, GivesNoReturnWhereNothingIsInRange) {
  const BeamModel beam{BeamOptions{}};
  std::mt19937_64 random(1);
  const BeamReading reading = beam.Measure(Wall(0.0), kRay, 0.0, 300.0, random);
  EXPECT_TRUE(std::isnan(reading.range_mm));
  EXPECT_EQ(reading.quality, 0);
}

}  // namespace
}  // namespace annulus::sim
