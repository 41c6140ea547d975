#pragma once

#include <array>
#include <optional>
#include <vector>

#include "modeling/glasses/fit_sigma.h"
#include "modeling/glasses/frame_mass.h"
#include "modeling/glasses/frame_skin.h"
#include "modeling/glasses/glasses_fit.h"
#include "modeling/glasses/pad_fit.h"
#include "modeling/glasses/seat_front.h"
#include "modeling/glasses/temple_fit.h"

namespace annulus {

/// A frame put on a head, all its parts in place: what the report is made from. Borrows head and options.
struct FittedFrame {
  const WearerHead* head = nullptr;
  const GlassesFitOptions* options = nullptr;
  PoseProblem problem;
  FrontState state;
  FrontShape front;
  SeatedFront seated;
  std::optional<std::array<PadFit, 2>> pads;
  std::array<TempleFit, 2> temples;
  WornFrame worn;
  std::vector<FrameShell> shells;  ///< All parts as they are worn, frame frame.
  std::optional<FrameMass> mass;   ///< Of a full fit.
  /// Bridge gaps with which this form would bear where pupils and lenses may be: lowest and nearest, highest and
  /// farthest, mm.
  double least_gap = 0.0;
  double largest_gap = 0.0;
  std::array<double, 2> temple_extra{0.0, 0.0};  ///< mm that the temples are kept off the head beside a touch.
};

/// The pose in which the frame's skin is measured.
[[nodiscard]] WornPose WornPoseOf(const FittedFrame& fitted);
/// Least distances of a frame in place, mm.
struct SkinReport {
  double penetration = 0.0;                            ///< >= 0
  std::array<double, 2> temple_penetration{0.0, 0.0};  ///< Right, left; >= 0.
  std::string deepest;                                 ///< The part that enters most; empty if none does.
  double front_penetration = 0.0;                      ///< Of what is neither temple nor adjustable pad; >= 0.
  double rims = 0.0;                                   ///< Of rims, end pieces and lenses beside the nose.
  std::array<SkinPlace, 2> nose;                       ///< Of what bears, right and left.
  std::array<SkinPlace, 2> temples;                    ///< About the ears and before them.
  std::vector<Clearance> map;
};
[[nodiscard]] SkinReport MeasureSkin(const FittedFrame& fitted);

/// Contacts and balance.
void AddBalance(const FittedFrame& fitted, const SkinReport& skin, GlassesFit& fit);
/// Every goal.
void AddGoals(const FittedFrame& fitted, const SkinReport& skin, GlassesFit& fit);
/// What to change, wearable and score, once all else is known.
void AddAdvice(const FittedFrame& fitted, const SkinReport& skin, GlassesFit& fit);

}  // namespace annulus
