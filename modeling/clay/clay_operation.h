#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/result.h"
#include "modeling/clay/clay_body.h"

namespace annulus {

/// What the maker holds (paper 004, table 1).
enum class ClayTool { kFinger, kHand, kSpatula, kNippers };

/// Where and how a tool acts: at an address, along its normal unless `direction` (from the tool into the body, any
/// length) says otherwise. A spatula is `length_mm` long (0: three times its radius) and turned by `angle_rad` about
/// its direction from the patch's u.
struct ToolHold {
  ClayTool tool = ClayTool::kFinger;
  ClayAddress at;
  double radius_mm = 8.0;  ///< > 0; √(b/a) of eq. 9; half the width of a spatula.
  double length_mm = 0.0;
  double angle_rad = 0.0;
  std::optional<Eigen::Vector3d> direction;
};

/// 押す, 引く: a dent, or a bump where depth is negative; finger, hand, spatula. Model 1: a rim rises around it, to
/// q = rho (eq. 10); model 2: the whole body swells.
struct PushAct {
  ToolHold hold;
  double depth_mm = 2.0;
  int model = 1;
  double rho = 2.0;  ///< > 1.3: √(f/e) over the radius; a property of the clay.
};

/// 穴をあける・ひろげる・閉じる: finger, spatula. Make: a dent as deep as `depth_mm`, steep and flat at its bottom, in
/// steps of half its radius. Through: to the far side, along the direction, with four straight walls that leave as much
/// room as the tool's circle; the skin has edges there. Its middle is that of the leaf which holds the address. Widen
/// and close: a hole that is there, to `factor` times its radius; one that goes through is held by a place that it has
/// taken out. Fill: such a hole is no more.
struct HoleAct {
  enum class How { kMake, kThrough, kWiden, kClose, kFill };
  ToolHold hold;
  How how = How::kMake;
  double depth_mm = 10.0;
  double factor = 1.5;  ///< > 1; closing divides by it.
};

/// A line in space, from and to: what acts along an axis. Of two addresses, or of two points.
struct ClayAxis {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
};

/// ひねる (hand): what is beyond `to` is turned by an angle against what is before `from`, evenly between.
struct TwistAct {
  ClayAxis axis;
  double angle_rad = 0.5;
};

/// 丸める (hand): a part of the way to a ball.
struct BallAct {
  double amount = 0.5;  ///< 0 … 1
};

/// 広げる (hand): flatter towards the place's tangent plane, and wider.
struct SpreadAct {
  ToolHold hold;
  double amount = 0.3;  ///< 0 … 1: of the height, lost.
};

/// こねる (hand): waves through the whole body.
struct KneadAct {
  double amplitude_mm = 2.0;
  double wavelength_mm = 100.0;
  std::uint64_t seed = 1;
};

/// 線を引く・消す (finger, spatula): a groove along a line over the surface; erasing smooths it away.
struct LineAct {
  enum class How { kDraw, kErase };
  ClayTool tool = ClayTool::kSpatula;
  How how = How::kDraw;
  std::vector<ClayAddress> path;  ///< At least two; between them the way is straight, on the surface.
  double depth_mm = 1.0;
  double radius_mm = 2.0;
  double rho = 2.0;
};

/// 付加 (hand): clay of a given volume is put on and blended in.
struct AddAct {
  ToolHold hold;
  double volume_mm3 = 100.0;  ///< > 0
};

/// 削る (hand): what is higher than a plane `depth_mm` below the place comes off.
struct ShaveAct {
  ToolHold hold;
  double depth_mm = 1.0;
};

/// ちぎる (hand, nippers): the same, leaving a torn face (hand) or a clean one (nippers).
struct TearAct {
  ToolHold hold;
  double depth_mm = 5.0;
  std::uint64_t seed = 1;  ///< Of the torn face.
};

/// ならす (hand, spatula): unevenness goes, the volume stays.
struct SmoothAct {
  ToolHold hold;
  double amount = 0.5;  ///< 0 … 1, of the way to the mean of the neighbours, each time.
  int passes = 3;       ///< 1 … 100
};

/// のばす (hand, spatula): longer between `from` and `to` by a factor, and thinner there.
struct StretchAct {
  ClayAxis axis;
  double factor = 1.2;  ///< > 0
};

using ClayAct = std::variant<PushAct, HoleAct, TwistAct, BallAct, SpreadAct, KneadAct, LineAct, AddAct, ShaveAct,
                             TearAct, SmoothAct, StretchAct>;

/// A place that operations leave as it is, fading over half of its radius.
struct ClayMask {
  ClayAddress at;
  double radius_mm = 10.0;
};

/// How operations are carried out.
struct ClayPractice {
  bool mirrored = false;        ///< Each act that has a place acts at its image beyond x = 0, too.
  std::vector<ClayMask> masks;  ///< Where they were when the practice began is not remembered: they move with the skin.
  double merge_mm = 1e-11;      ///< Patches that differ by less from an undivided one are merged.
};

/// What an operation did, mm and mm³.
struct ClayReport {
  double volume_before_mm3 = 0.0;
  double volume_after_mm3 = 0.0;
  double moved_mm3 = 0.0;   ///< Put on, or (negative) taken away; 0 where the volume is kept.
  double k = 0.0;           ///< Of eq. 8, of the last step.
  std::size_t patches = 0;  ///< Leaves afterwards.
  std::size_t touched = 0;  ///< Leaves that moved.
};

/// Carries out one operation. Fails, with the body as it was, if a parameter is out of its range (named), or no amount
/// of its indirect motion keeps volume and embedding.
Result<ClayReport> Perform(ClayBody& body, const ClayAct& act, const ClayPractice& practice = {});

/// The operation's name in scripts: "push" …
[[nodiscard]] std::string NameOf(const ClayAct& act);

}  // namespace annulus
