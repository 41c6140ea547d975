#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/flatten/flat_material.h"

namespace annulus {

/// What a place of a pattern refers to, so that the same pattern lies on every body: landmarks and parts of the height.
struct PatternBody {
  const SurfaceSegment& segment;                     ///< Borrowed.
  std::map<std::string, Eigen::Vector2d> landmarks;  ///< (theta in rad, nan for a level; z in mm), by id.
};

/// A place on any body.
struct PatternPlace {
  std::string theta_of;             ///< Landmark whose theta is meant; "": the station's theta 0.
  double turn = 0.0;                ///< rad, added to that.
  std::string z_of;                 ///< Landmark or level whose height is meant; "": see z_share.
  std::string z_towards;            ///< Another one; z_share of the way from z_of to it. "": none.
  std::optional<double> z_share{};  ///< 0 … 1; without z_of, of the height of the scanned surface from below.
  double up = 0.0;                  ///< mm, added to that.
};

/// (theta in rad, z in mm). Fails, naming it, on a landmark that the body has not.
[[nodiscard]] Result<Eigen::Vector2d> PlaceOn(const PatternBody& body, const PatternPlace& place);

/// A line on the body through places: straight in the (theta, z) plane from one to the next, each time the shorter way
/// around, or smooth through all of them (Catmull, Rom 1974).
struct PatternLine {
  std::string id;
  std::vector<PatternPlace> places;  ///< Two or more.
  enum class Course { kStraight, kSmooth } course = Course::kStraight;
  std::optional<double> allowance_mm{};  ///< The pattern's unless given.
  std::vector<double> notches{};         ///< Parts of its length at which both sides get a notch, in (0, 1).
};

/// A line as a piece uses it.
struct LineUse {
  std::size_t line = 0;
  enum class Way { kForward, kBackward } way = Way::kForward;
};

/// A cut from an outline's line to a tip inside, whose legs are sewn to each other.
struct PatternDart {
  std::size_t line = 0;
  double share = 0.5;  ///< Of the line's length from its first place, in (0, 1).
  PatternPlace tip;
};

/// A seam across a piece, from outline to outline, straight in the (theta, z) plane from one place to the next: the
/// piece becomes two, which are sewn to each other along it.
struct PatternDivision {
  struct End {
    std::size_t line = 0;
    double share = 0.5;  ///< Of the line's length from its first place, in (0, 1).
  };
  std::array<End, 2> ends;
  std::vector<PatternPlace> through;  ///< Places between the ends, in their order.
};

struct PatternPiece {
  std::string id;
  std::string label;
  std::vector<LineUse> outline;                        ///< End to end, closed.
  std::optional<std::array<PatternPlace, 2>> grain{};  ///< From below upwards; unless given, the middle of its height.
  std::vector<PatternDart> darts{};
  std::vector<PatternDivision> divisions{};  ///< They do not cross each other or darts.
};

/// When darts and seams are proposed.
struct DartRule {
  double strain = 0.02;   ///< Over this on more than 2 % of a piece's area, > 0.
  std::size_t most = 0;   ///< Darts per piece at most; 0: none are proposed.
  std::size_t seams = 0;  ///< Divisions per piece at most, where darts are not enough; 0: none are proposed.
};

/// A garment as lines and pieces on a body (docs/formats.md, "Pattern"). A line that two pieces use, or one piece
/// twice, is a seam.
struct Pattern {
  std::string name;
  FlatMaterial material{};
  double element_mm = 10.0;    ///< Largest side of a triangle.
  double allowance_mm = 10.0;  ///< Beyond the seam lines, >= 0.
  DartRule darts{};
  std::vector<PatternLine> lines;
  std::vector<PatternPiece> pieces;
};

}  // namespace annulus
