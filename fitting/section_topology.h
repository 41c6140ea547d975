#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/sample_grid.h"

namespace annulus {

/// How the ring sees one level of a body.
enum class LevelView : std::uint8_t {
  kEmpty,         ///< Hardly any return.
  kOneLoop,       ///< One loop around the axis; what hides the axis is the loop itself.
  kBehind,        ///< One loop around the axis, with something standing before a part of it.
  kSeveralLoops,  ///< Loops with air between them, and air at the axis (legs).
  kAxisOutside,   ///< The axis is in the air beside the body.
};

/// Why a region is not simply a part of the one star-shaped loop.
enum class RegionKind : std::uint8_t {
  kSeveralLoops,  ///< Several loops beside each other: legs, fingers.
  kAxisOutside,   ///< The section does not hold the ring's axis.
  kInFront,       ///< Stands before the main surface and hides it: an arm.
  kOverhang,      ///< The surface turns back under itself; what is beneath is not seen. The fit goes on over it.
  kUnseen,        ///< No returns where there should be a surface: dead sensors, black hair. The fit leaves a hole.
};

/// A part of the scan that is not seen as one star-shaped loop, in plain words.
struct SectionRegion {
  RegionKind kind = RegionKind::kUnseen;
  std::string name;          ///< "legs", "left arm" (the subject's left), "right hand", "overhang", …
  double z_min = 0.0;        ///< mm, lowest level concerned
  double z_max = 0.0;        ///< mm, highest level concerned
  double theta_from = 0.0;   ///< rad, [0, 2 pi); from here counter-clockwise …
  double theta_to = 0.0;     ///< … to here. All around: 0 and 2 pi.
  std::size_t samples = 0;   ///< Returns in it.
  double share = 0.0;        ///< Of the scan's usable returns, 0 … 1.
  std::size_t left_out = 0;  ///< Returns in it that no segment was fitted to.
  std::string why;           ///< What was seen.
  std::string outcome;       ///< What the fit did with it; see FitBody. Empty before a fit.

  /// One line: name, where, why, outcome.
  [[nodiscard]] std::string BriefReport() const;
};

/// A piece that is to be fitted about an axis of its own.
struct SectionPart {
  std::string name;                  ///< "left leg", "right arm", …
  std::size_t region = 0;            ///< Index of the region that it belongs to.
  std::vector<std::size_t> samples;  ///< Indices, ascending.
  /// Of the one loop, on the level next above: where the piece goes on into it. Given to both fits, so that they meet.
  std::vector<std::size_t> seam;
};

/// What a ring's scan looks like, level by level.
struct SectionTopology {
  std::vector<LevelView> levels;       ///< One per row of the grid.
  std::vector<SectionRegion> regions;  ///< From the top down.
  std::vector<SectionPart> parts;      ///< Pieces with a loop of their own, in the order of the regions.
  std::vector<char> main;              ///< One per sample: 1 if it may belong to the one loop around the axis.

  /// Whether all samples may belong to the one loop.
  [[nodiscard]] bool IsOneLoop() const;
};

/// Finds where the section is not one star-shaped loop around the axis, from sizes on a body and what persists over
/// levels, not from a noise scale. Single wild returns have no influence, so `samples` need no screening. What is
/// looked for, per level, then followed over levels:
///   - gaps of returns whose ends fall off towards the axis as the silhouettes of legs do (several loops, or the axis
///   in
///     the air), and gaps whose ends do not (unseen);
///   - runs of returns that stand a step before both their sides (arms);
///   - sudden loss of radius from one level to that below (overhangs).
[[nodiscard]] SectionTopology FindSectionTopology(std::span<const SurfaceSample> samples, const SampleGrid& grid);

}  // namespace annulus
