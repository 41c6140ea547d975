#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>

#include "acquisition/scan_plan.h"
#include "sim/clothed_subject.h"
#include "sim/moving_subject.h"
#include "sim/person.h"
#include "tests/sim/simulated_scan.h"

namespace annulus {

/// A customer like no other: stature, build, where they stand, how they sway and breathe, all from the seed.
struct Customer {
  std::unique_ptr<sim::MovingSubject> subject;
  ScanPlan plan;
};

enum class Dress { kBare, kFolds };

inline Customer MakeCustomer(std::uint64_t seed, Dress dress = Dress::kBare) {
  std::mt19937_64 random(sim::MixSeed(seed, 11));
  std::normal_distribution<double> gaussian;
  std::uniform_real_distribution<double> uniform;
  sim::PersonOptions person;
  person.height_mm = std::clamp(1700.0 + 90.0 * gaussian(random), 1450.0, 1950.0);
  person.build = 0.88 + 0.24 * uniform(random);
  person.placement = {15.0 * gaussian(random), 15.0 * gaussian(random), 0.08 * gaussian(random)};
  std::unique_ptr<sim::Subject> body = std::make_unique<sim::ParametricBody>(sim::MakePerson(person));
  if (dress == Dress::kFolds) {
    sim::LooseClothing shirt;
    shirt.ease_mm = 3.0;
    shirt.fold_mm = 6.0;
    shirt.fold_width_mm = 30.0;
    body = std::make_unique<sim::ClothedSubject>(std::move(body), std::nullopt, shirt);
  }
  sim::MotionOptions motion;
  motion.sway_scale = 1.0;
  motion.yaw_sd_rad = 0.01;
  motion.breathing_share = 0.01;
  motion.seed = seed;
  Customer customer;
  customer.subject = std::make_unique<sim::MovingSubject>(std::move(body), motion);
  customer.plan = *BuiltInPlan("body", Millimetres(person.height_mm));
  return customer;
}

/// A customer's scan by the body profile: four sweeps, noise, dropouts, outliers; the spot is a mathematical ray (a
/// fifth of the time). `ring` is both true and known.
inline Scan CustomerScan(std::uint64_t seed, const RingCalibration& ring = RingCalibration::Ideal(600.0),
                         Dress dress = Dress::kBare) {
  const Customer customer = MakeCustomer(seed, dress);
  sim::BeamOptions beam;
  beam.spot_rays = 0;
  Scan scan = sim::SimulateScan(*customer.subject, customer.plan, beam, seed, ring);
  scan.header.wall_start_ns = static_cast<std::int64_t>(seed) * 600'000'000'000;
  return scan;
}

/// A ring as it is built, known as after a calibration: offsets 1 mm, scale 0.2 %, aim 0.5 degrees, places 0.5 mm.
inline RingCalibration CrookedRing(std::uint64_t seed) {
  RingCalibration ring = RingCalibration::Ideal(600.0);
  std::mt19937_64 random(sim::MixSeed(seed, 12));
  std::normal_distribution<double> gaussian;
  for (SensorCalibration& sensor : ring.sensors) {
    sensor.range_offset_mm = gaussian(random);
    sensor.range_scale = 1.0 + 0.002 * gaussian(random);
    sensor.aim_lateral = RadiansFromDegrees(0.5 * gaussian(random));
    sensor.aim_vertical = RadiansFromDegrees(0.5 * gaussian(random));
    sensor.height_mm = 0.5 * gaussian(random);
    sensor.radius_mm += 0.5 * gaussian(random);
    sensor.theta += 0.5 / 600.0 * gaussian(random);
  }
  return ring;
}

/// From `start_s` on a sensor reads longer: at once by `offset_mm`, and by `speed_mm_s` more with every second.
struct Drift {
  std::size_t sensor = 0;
  double offset_mm = 0.0;
  double speed_mm_s = 0.0;
  double start_s = 0.0;
};
inline Scan WithDrift(Scan scan, const Drift& drift) {
  for (ScanLevel& level : scan.levels) {
    const double time_s = std::chrono::duration<double>(level.time - scan.levels.front().time).count() - drift.start_s;
    if (time_s >= 0.0) level.readings[drift.sensor].range_mm += drift.offset_mm + drift.speed_mm_s * time_s;
  }
  return scan;
}

}  // namespace annulus
