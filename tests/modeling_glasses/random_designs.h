#pragma once

#include <random>

#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_adjust.h"

namespace annulus {

inline double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

/// A value of an enum with `count` values.
template <typename Enum>
Enum AnyOf(std::mt19937_64& random, unsigned count) {
  return static_cast<Enum>(random() % count);
}

/// Numbers and forms drawn over everything that somebody might ask for, and beyond; most of them cannot be built.
inline FrameDesign WildDesign(std::mt19937_64& random) {
  FrameDesign d;
  FrameParameters& p = d.parameters;
  p.width = Uniform(random, 30, 70);
  p.height = Uniform(random, 0.25, 1.3) * p.width;
  for (double FrameParameters::*corner : {&FrameParameters::upper_outer, &FrameParameters::upper_inner,
                                          &FrameParameters::lower_outer, &FrameParameters::lower_inner}) {
    p.*corner = Uniform(random, 0.0, 0.4) * p.width;
  }
  p.upper_thickness = Uniform(random, 0.005, 0.3) * p.width;
  p.lower_thickness = Uniform(random, 0.005, 0.3) * p.width;
  p.bridge_height = Uniform(random, 0.0, 1.1) * p.height;
  FrameDetails& details = d.details;
  details.rim = AnyOf<RimForm>(random, 3);
  details.bridge = AnyOf<BridgeForm>(random, 3);
  details.pads = AnyOf<PadForm>(random, 3);
  details.temple = AnyOf<TempleForm>(random, 3);
  details.hinge = AnyOf<HingeForm>(random, 2);
  const auto maybe = [&random](double low, double high) -> std::optional<double> {
    if (random() % 3 == 0) return std::nullopt;
    return Uniform(random, low, high);
  };
  details.bridge_gap = maybe(2, 30);
  details.depth = maybe(0.5, 8);
  details.arm_height = maybe(0, 1.1 * p.height);
  details.arm_width = maybe(0.5, 18);
  details.bridge_forward = maybe(-4, 13);
  details.bridge_rise = maybe(-4, 13);
  details.lens_edge = Uniform(random, 0.5, 8);
  if (random() % 3 != 0) {
    details.groove_depth = Uniform(random, 0, 2);
    details.groove_width = Uniform(random, 0, 3);
  }
  if (random() % 2 != 0) details.frame_curve = Uniform(random, 0, 11);
  if (random() % 2 != 0) details.face_form = Uniform(random, 0, 0.5);
  details.end_piece = Uniform(random, 0, 15);
  details.tip_length = Uniform(random, 10, 90);
  details.tip_drop = Uniform(random, 0, 1.5);
  details.pad_length = Uniform(random, 5, 20);
  details.pad_width = Uniform(random, 3, 12);
  return d;
}

/// What somebody may bend on it: ears, bows, tips and pads of both sides drawn one by one.
inline FrameAdjustment WildAdjustment(std::mt19937_64& random, const FrameDesign& design) {
  FrameAdjustment adjustment = StandardAdjustment(design);
  for (TempleShape* temple : {&adjustment.temple_right, &adjustment.temple_left}) {
    const double side = temple->ear.x() > 0.0 ? 1.0 : -1.0;
    const double l1 = design.parameters.width;
    temple->ear +=
        l1 * Eigen::Vector3d(side * Uniform(random, -0.3, 0.2), Uniform(random, -0.4, 0.4), Uniform(random, -0.4, 0.3));
    temple->bow = Uniform(random, -0.2, 0.2);
    temple->tip_in = Uniform(random, -0.2, 0.5);
  }
  for (PadPose* pad : {&adjustment.pad_right, &adjustment.pad_left}) {
    pad->centre += Eigen::Vector3d(Uniform(random, -1, 1), Uniform(random, -4, 2), Uniform(random, -3, 3));
    const Eigen::AngleAxisd turn(Uniform(random, -0.3, 0.3),
                                 Eigen::Vector3d(Uniform(random, -1, 1), Uniform(random, -1, 1), 0.5).normalized());
    pad->normal = turn * pad->normal;
    pad->up = turn * pad->up;
  }
  return adjustment;
}

}  // namespace annulus
