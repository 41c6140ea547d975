// Volumes and skin areas of the parts of the body between levels.

#include <array>
#include <cmath>
#include <string>

#include "base/units.h"
#include "modeling/measure/slab.h"
#include "modeling/table/measurement_groups.h"

namespace annulus {
namespace {

struct SegmentRow {
  const char* upper;
  const char* lower;
  const char* id;
  const char* term;
};
constexpr std::array<SegmentRow, 5> kSegments{{{"vertex", "level.neck", "head", "Head above the neck level"},
                                               {"level.axilla", "level.chest", "upper_chest", "Axilla to chest"},
                                               {"level.chest", "level.waist", "chest_to_waist", "Chest to waist"},
                                               {"level.waist", "level.hip", "waist_to_hip", "Waist to hip"},
                                               {"level.hip", "level.crotch", "hip_to_crotch", "Hip to crotch"}}};

/// d(volume)/dz and d(skin)/dz at a height: the section's area, and ∮ |P_theta × P_z| dtheta.
struct Rates {
  double area = 0.0;
  double skin = 0.0;
};
Rates RatesAt(const SplineSurface& surface, double z) {
  constexpr int kDirections = 720;
  Rates rates;
  for (int k = 0; k < kDirections; ++k) {
    const RadiusJet jet = surface.Jet(kTwoPi * k / kDirections, z);
    rates.area += 0.5 * jet.r * jet.r * kTwoPi / kDirections;
    rates.skin +=
        std::sqrt(jet.r * jet.r * (1.0 + jet.r_z * jet.r_z) + jet.r_theta * jet.r_theta) * kTwoPi / kDirections;
  }
  return rates;
}

/// What lies above a scan's highest level up to the crown: a paraboloid of revolution on the highest section, by which
/// the crown's height was found too.
struct Crown {
  Estimate volume;
  Estimate skin;
  Rates by_height;  ///< What both grow by if the crown rises.
};

/// Lateral area of a paraboloid over a circle: π r/(6h²)·((r² + 4h²)^(3/2) − r³), h > 0.
double ParaboloidSkin(double circle, double height) {
  const double radius = std::sqrt(circle / kPi);
  return kPi * radius / (6.0 * height * height) *
         (std::pow(radius * radius + 4.0 * height * height, 1.5) - std::pow(radius, 3.0));
}

Crown CrownOver(const SplineSurface& surface, double top, double height) {
  constexpr int kDirections = 720;
  constexpr double kStep = 1e-3;  // of the variable, for differences
  GradientSum circle_gradient(surface);
  double circle = 0.0;
  for (int k = 0; k < kDirections; ++k) {
    const double theta = kTwoPi * k / kDirections;
    const double r = surface.Radius(theta, top);
    circle += 0.5 * r * r * kTwoPi / kDirections;
    circle_gradient.AddRadius(theta, top, r * kTwoPi / kDirections);
  }
  const auto difference = [&](double by_circle, double by_height) {
    return ParaboloidSkin(circle * (1.0 + by_circle), height * (1.0 + by_height)) -
           ParaboloidSkin(circle * (1.0 - by_circle), height * (1.0 - by_height));
  };
  const Gradient gradient = circle_gradient.Get();
  return {{0.5 * height * circle, 0.5 * height * gradient},
          {ParaboloidSkin(circle, height), difference(kStep, 0.0) / (2.0 * kStep * circle) * gradient},
          {0.5 * circle, difference(0.0, kStep) / (2.0 * kStep * height)}};
}

/// A volume or an area with what both have in common.
RawMeasurement Part(const Estimate& estimate, const SlabEstimates& slab, const Landmark& upper, const Landmark& lower) {
  RawMeasurement raw;
  raw.estimate = estimate;
  raw.measured_share = slab.measured_share;
  raw.landmarks = {upper.id, lower.id};
  raw.height_share = estimate.value;
  return raw;
}

}  // namespace

void AddSegments(MeasurementList& list) {
  const SplineSurface& surface = list.body().surface();
  for (const SegmentRow& row : kSegments) {
    const Landmark* upper = list.Find(row.upper);
    const Landmark* lower = list.Find(row.lower);
    if (upper == nullptr || lower == nullptr) continue;
    const double top = std::min(upper->z.value, surface.z_max());  // the crown may lie above the scan
    const std::string between = " between " + upper->term + " and " + lower->term + ".";
    const MeasurementSpec volume{std::string(row.id) + "_volume",
                                 std::string(row.term) + ", volume",
                                 "Volume of the body" + between,
                                 "volume",
                                 "mm3",
                                 0.0};
    const MeasurementSpec skin{std::string(row.id) + "_area",
                               std::string(row.term) + ", skin area",
                               "Area of the skin" + between,
                               "skin area",
                               "mm2",
                               0.0};
    auto slab = SlabBetween(list.body(), lower->z.value, top);
    if (!slab) {
      list.Omit(volume.term, slab.error().seen);
      continue;
    }
    Rates above = RatesAt(surface, top);
    const Rates below = RatesAt(surface, lower->z.value);
    if (upper->z.value > top) {
      const Crown crown = CrownOver(surface, top, upper->z.value - top);
      slab->measured_share *= slab->volume.value / (slab->volume.value + crown.volume.value);
      slab->volume = Combine(1.0, slab->volume, 1.0, crown.volume);
      slab->area = Combine(1.0, slab->area, 1.0, crown.skin);
      above = crown.by_height;
    }
    for (const auto& [spec, estimate, at_top, at_bottom] : {std::tuple{&volume, &slab->volume, above.area, below.area},
                                                            std::tuple{&skin, &slab->area, above.skin, below.skin}}) {
      RawMeasurement raw = Part(*estimate, *slab, *upper, *lower);
      Follow(raw, upper->z, at_top, upper->placing_up);
      Follow(raw, lower->z, -at_bottom, lower->placing_up);
      list.Add(*spec, std::move(raw));
    }
  }
}

}  // namespace annulus
