#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/fit_goals.h"
#include "modeling/glasses/placement.h"
#include "modeling/glasses/wearer_head.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// What a fit finds out.
enum class FitDetail {
  kFull,
  kRanking,  ///< No sigmas, no clearance map, no hinges' small parts: for comparing many frames.
};

/// What is asked of a fit.
struct GlassesFitOptions {
  FitSize size = FitSize::kKept;
  FitGoals goals;
  SizeLimits limits;
  FaceOverrides face;
  /// Right, left: height of the pupil over the box's lower edge that is wanted, mm (B/2 ± 15).
  std::array<std::optional<double>, 2> pupil_height;
  /// Right, left: how far the lens' back vertex lies behind the plane of its rim, mm. Absent: kLensBackBehindRim.
  std::array<std::optional<double>, 2> lens_back;
  std::array<double, 2> lens_mass_g{0.0, 0.0};  ///< Right, left; 0: not known.
  double frame_density = 1.3;                   ///< g/cm³; acetate 1.3, titanium 4.5.
  /// Overall length of the temples from hinge to tip, mm, where they are not made for the wearer: what is not needed to
  /// the ear becomes tip. Absent: the tip is as long as the design says.
  std::optional<double> temple_length;
  FitDetail detail = FitDetail::kFull;
};

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
  double score = 0.0;               ///< 0 … 100, how well it fits: docs say how (ScoreOf).
};

/// Fits a frame on a head. The cornea's apex is the eye's centre on the scanned surface, lids as they were scanned. The
/// vertex distance ends at the lens' back, without a lens kLensBackBehindRim behind the rim's plane. What of a temple
/// lies behind its ear is kept off the head without its ears, as a ring does not see between ear and head. Fails if
/// there is no head, an override is impossible, the design is invalid or a temple cannot reach its ear; a frame that
/// cannot be worn is no failure: see `wearable` and `advice`.
[[nodiscard]] Result<GlassesFit> FitGlasses(const MeasuredSurface& head, const FrameDesign& design,
                                            const GlassesFitOptions& options);
/// The same on a head that was looked at before (options.face is not looked at).
[[nodiscard]] Result<GlassesFit> FitGlasses(const WearerHead& head, const FrameDesign& design,
                                            const GlassesFitOptions& options);

}  // namespace annulus
