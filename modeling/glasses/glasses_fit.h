#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/fit_goals.h"
#include "modeling/glasses/placement.h"
#include "modeling/glasses/wearer_head.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// One of the fitter's targets on the finished fit.
struct FitGoal {
  std::string id;      ///< Stable: "vertex_distance_right", "pantoscopic_tilt", "pupil_height_left", …
  std::string term;    ///< The field's English term.
  std::string unit;    ///< "mm" or "deg".
  double value = 0.0;  ///< In `unit`.
  double sigma = 0.0;  ///< sd of the value from scan, face points and what is left of the fit; NaN if unknown.
  double low = 0.0;    ///< The usual range.
  double high = 0.0;
  bool met = false;    ///< low <= value <= high.
  std::string advice;  ///< What to change; empty if met.
};

/// Where a part of the frame touches the head.
struct FrameContact {
  std::string part;                                    ///< "pad_right", "temple_left", …
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< On the head, station frame, mm.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();   ///< Outward of the head there, unit.
  double distance = 0.0;                               ///< mm, negative where the part enters the head.
  double load_share = 0.0;                             ///< Share of the spectacles' weight that rests here, 0 … 1.
  double pressure_kpa = 0.0;                           ///< Mean over the contact's area; 0 where none is known.
};

/// Distance of one point of the frame or lens from the head.
struct Clearance {
  std::string part;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Of the frame, station frame, mm.
  double distance = 0.0;                               ///< Signed distance to the head, mm; negative inside.
};

/// How the weight is carried.
struct WeightBalance {
  double frame_g = 0.0;
  double lenses_g = 0.0;                                        ///< 0 without a prescription.
  Eigen::Vector3d centre_of_gravity = Eigen::Vector3d::Zero();  ///< Station frame, mm.
  double nose_share = 0.0;                                      ///< 0 … 1; the rest is on the ears.
  double right_share = 0.0;                                     ///< Of the nose's load, on the right flank.
};

/// A frame fitted on a head.
struct GlassesFit {
  WornFrame worn;
  std::vector<FitGoal> goals;
  std::vector<FrameContact> contacts;
  std::vector<Clearance> clearance;  ///< The clearance map: all parts, evenly spread.
  WeightBalance balance;
  double penetration = 0.0;         ///< mm; deepest place of any part in the head, 0 if none enters.
  bool wearable = false;            ///< Contacts hold, nothing enters, every goal is met.
  std::vector<std::string> advice;  ///< What to change, most important first; empty if wearable.
};

}  // namespace annulus
