#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "base/units.h"
#include "modeling/glasses/lens_power.h"
#include "modeling/glasses/lens_sight.h"

namespace annulus {

/// What an eye is to get from its lens in every direction of gaze.
struct FieldGoal {
  PowerMatrix power = PowerMatrix::Zero();          ///< D, on the vertex sphere (TracedPower), axes of the turned view.
  Eigen::Vector2d prism = Eigen::Vector2d::Zero();  ///< cm/m, base direction in the view.
  double abbe = 58.0;                               ///< Abbe number of the lens.
};

/// What the wearer has in one direction of gaze. An error is what the lens gives less the goal. NaN where the line of
/// sight does not pass through the lens.
struct FieldPoint {
  Gaze gaze;
  SightPath path{};
  double mean_error = 0.0;   ///< D: half the trace of the error's power matrix. Positive: too much plus.
  double astigmatism = 0.0;  ///< D, >= 0: difference of the error's principal powers (its cylinder without sign).
  double axis = 0.0;         ///< rad, (0, π]: of the error as a minus cylinder, in the turned view.
  double worst_error = 0.0;  ///< D, >= 0: in the worst meridian.
  Eigen::Vector2d prism = Eigen::Vector2d::Zero();  ///< cm/m, all of it; base direction in the turned view.
  double chromatic = 0.0;                           ///< cm/m between the lines F and C: |prism| / Abbe number.
  double thickness = 0.0;                           ///< mm of glass along the line of sight.
  Gaze object;                                      ///< Where the thing really is that is seen at `gaze`.
  double magnification = 0.0;  ///< Linear, of a small thing there for the eye that turns: sqrt(area seen / area).
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< On the back surface, lens x, y, mm.
};

/// One direction of gaze. Requires goal.abbe > 0.
[[nodiscard]] FieldPoint FieldPointAt(const LensSight& sight, const FieldGoal& goal, const Gaze& gaze);

/// Directions of gaze on a grid; rad.
struct FieldGrid {
  double most_left = RadiansFromDegrees(50.0);
  double most_right = RadiansFromDegrees(50.0);  ///< > -most_left.
  double most_up = RadiansFromDegrees(45.0);
  double most_down = RadiansFromDegrees(45.0);
  double step = RadiansFromDegrees(1.0);  ///< > 0.

  /// From the wearer's left to the right, first and last included.
  [[nodiscard]] int columns() const;
  [[nodiscard]] int rows() const;  ///< From above downwards.
  [[nodiscard]] Gaze At(int column, int row) const;
};

/// The field over a grid, row-major, as the wearer sees it: the first is up left.
struct LensField {
  FieldGrid grid;
  std::vector<FieldPoint> points;

  [[nodiscard]] const FieldPoint& At(int column, int row) const {
    return points[static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns()) +
                  static_cast<std::size_t>(column)];
  }
};
[[nodiscard]] LensField LensFieldOf(const LensSight& sight, const FieldGoal& goal, const FieldGrid& grid);

/// Where the lens ends in one direction from straight ahead, angles from straight ahead, rad.
struct FieldEdge {
  double gaze = 0.0;    ///< The eye's turn to the last line of sight through the lens.
  double object = 0.0;  ///< Where the thing really is that is seen there.
  double beside = 0.0;  ///< The first free direction past lens and frame; NaN: none up to 85°.
  /// What no turn of the eye shows (a scotoma) if positive; what is seen twice, through the lens and past it, if
  /// negative; NaN without `beside`.
  [[nodiscard]] double gap() const { return beside - object; }
};
/// How far the wearer sees through the lens with a turning eye.
struct FieldLimits {
  FieldEdge left, right, up, down;       ///< The wearer's.
  double gaze_solid_angle = 0.0;         ///< sr: of the eye's turns that pass through the lens.
  double object_solid_angle = 0.0;       ///< sr: of the world that is seen so.
  std::vector<Eigen::Vector3d> outline;  ///< Last lines of sight, unit, view; from the left by way of up, even angles.
};
/// Requires that straight ahead passes through the lens and that the field is star-shaped about it; a ray that is not
/// through ends it. All zero if straight ahead is not through. `directions` >= 8, a multiple of 4.
[[nodiscard]] FieldLimits FieldLimitsOf(const LensSight& sight, int directions = 360);

/// Shares of the lens, by solid angle of gaze, whose worst error is at most 0.25, 0.5 and 1 D; 0 without a lens.
struct FieldShares {
  double quarter = 0.0;
  double half = 0.0;
  double one = 0.0;
};
[[nodiscard]] FieldShares SharesOf(const LensField& field);

}  // namespace annulus
