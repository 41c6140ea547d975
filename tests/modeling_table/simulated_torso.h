#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "base/frames.h"
#include "base/surface_sample.h"
#include "sim/head.h"
#include "sim/person.h"
#include "tests/fitting/synthetic_scan.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus::test {

/// The torso tube (with neck and head) of a simulated subject, without arms and legs: one closed shape that is known
/// exactly, and how a ring scans it.
struct SimulatedTorso {
  sim::ParametricBody body;
  sim::FaceTruth face;  ///< Station frame.
  double z_min = 0.0;   ///< mm; lowest level of a scan.
  double pitch = 5.0;   ///< mm
  std::size_t levels = 0;

  [[nodiscard]] double z_max() const { return z_min + pitch * static_cast<double>(levels - 1); }

  /// Distance from the ring's axis to the skin, mm: what a beam along the radius sees first; 0 past the body.
  [[nodiscard]] double Radius(double theta, double z) const {
    constexpr double kRing = 900.0;  // mm
    const Ray ray{PointFromCylindrical(theta, kRing, z), -PointFromCylindrical(theta, 1.0, 0.0)};
    const auto hit = body.Cast(ray, 0.0, kRing);
    return hit ? kRing - hit->distance_mm : 0.0;
  }
};

inline SimulatedTorso TorsoOf(const sim::ParametricBody& subject, double above_bottom, double pitch) {
  sim::ParametricBody::Description torso;
  torso.name = "torso";
  torso.parts = {subject.parts().front()};
  torso.levels = subject.levels();
  torso.heights = subject.heights();
  torso.placement = subject.placement();
  constexpr double kBelowTop = 6.0;  // mm; higher up a level is a few returns
  const double z_min = subject.torso().z_min() + above_bottom;
  const auto steps = static_cast<std::size_t>((subject.torso().z_max() - kBelowTop - z_min) / pitch);
  return {sim::ParametricBody(std::move(torso)), subject.face(), z_min, pitch, steps + 1};
}

/// A person's trunk and head as the body profile scans it.
inline SimulatedTorso PersonTorso(const sim::PersonOptions& options) {
  return TorsoOf(sim::MakePerson(options), 40.0, 5.0);
}

/// A head on its neck as the head profile scans it.
inline SimulatedTorso HeadTorso(const sim::HeadOptions& options) { return TorsoOf(sim::MakeHead(options), 10.0, 1.0); }

constexpr std::size_t kSimulatedSensors = 180;

/// The radius without noise in every sensor's direction at every level, level by level, mm.
inline std::vector<double> CleanRadii(const SimulatedTorso& torso) {
  std::vector<double> radii;
  for (std::size_t level = 0; level < torso.levels; ++level) {
    for (std::size_t sensor = 0; sensor < kSimulatedSensors; ++sensor) {
      radii.push_back(torso.Radius(kTwoPi * static_cast<double>(sensor) / kSimulatedSensors,
                                   torso.z_min + torso.pitch * static_cast<double>(level)));
    }
  }
  return radii;
}

/// A scan with noise of 0.5 mm (sd) and 1 % of the returns missing.
inline std::vector<SurfaceSample> NoisyScan(const SimulatedTorso& torso, const std::vector<double>& clean,
                                            std::uint64_t seed) {
  constexpr double kNoise = 0.5;
  constexpr double kDropouts = 0.01;
  std::mt19937_64 random(seed);
  std::vector<SurfaceSample> samples;
  for (std::size_t k = 0; k < clean.size(); ++k) {
    const double error = kNoise * Normal(random);
    if (Uniform(random, 0.0, 1.0) < kDropouts || clean[k] <= 0.0) continue;
    const std::size_t level = k / kSimulatedSensors;
    const std::size_t sensor = k % kSimulatedSensors;
    SurfaceSample sample;
    sample.theta = WrapAngle(kTwoPi * static_cast<double>(sensor) / kSimulatedSensors);
    sample.z = torso.z_min + torso.pitch * static_cast<double>(level);
    sample.radius = std::max(1e-3, clean[k] + error);
    sample.ray_direction = -PointFromCylindrical(sample.theta, 1.0, 0.0).cast<float>();
    sample.level = static_cast<std::uint32_t>(level);
    sample.sensor = static_cast<std::uint16_t>(sensor);
    samples.push_back(sample);
  }
  return samples;
}

/// The torso itself as a surface: interpolated three times as densely around as it is scanned, every 2.5 mm of height
/// at the most.
inline SurfaceModel NoiseFreeModel(const SimulatedTorso& torso) {
  constexpr std::size_t kColumns = 540;
  const double step = std::min(2.5, torso.pitch);
  std::vector<double> breaks;
  for (double z = torso.z_min; z < torso.z_max() - 1e-6; z += step) breaks.push_back(z);
  breaks.push_back(torso.z_max());
  return InterpolatedBody([&torso](double theta, double z) { return torso.Radius(theta, z); }, kColumns, breaks);
}

}  // namespace annulus::test
