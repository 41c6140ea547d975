#include "modeling/clay/clay_to_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "fitting/spline_transfer.h"
#include "modeling/clay/clay_rays.h"
#include "modeling/elastic/surface_change.h"

namespace annulus {
namespace {

/// Of the tolerance: what is nearly off is split with what is, or that would stay alone with its few new functions.
constexpr double kSplitFrom = 0.25;

constexpr std::size_t kMostRefinements = 8;  ///< As MODEL.json may have.

/// The heights of a segment before and after its ends moved.
struct Heights {
  double old_from, old_to, from, to;

  [[nodiscard]] bool Same() const { return old_from == from && old_to == to; }
  [[nodiscard]] double Old(double z) const {
    return Same() ? z : old_from + (z - from) / (to - from) * (old_to - old_from);
  }
  [[nodiscard]] double New(double old) const {
    return Same() ? old : from + (old - old_from) / (old_to - old_from) * (to - from);
  }
};

std::vector<double> Moved(std::vector<double> breakpoints, const Heights& heights) {
  for (double& z : breakpoints) z = heights.New(z);
  breakpoints.front() = heights.from;
  breakpoints.back() = heights.to;
  return breakpoints;
}

KnowledgeMap Moved(const KnowledgeMap& old, const Heights& heights) {
  KnowledgeMap map(old.columns(), old.rows(), heights.New(old.z_min()), heights.New(old.z_max()));
  for (std::size_t row = 0; row < old.rows(); ++row) {
    for (std::size_t column = 0; column < old.columns(); ++column) map.SetCell(column, row, old.Cell(column, row));
  }
  return map;
}

/// The segment with its ends elsewhere: the same radii at the same shares of its height.
SurfaceSegment Moved(const SurfaceSegment& segment, const Heights& heights) {
  if (heights.Same()) return segment;
  SurfaceSegment moved = segment;
  moved.knowledge = Moved(segment.knowledge, heights);
  if (segment.hierarchy == nullptr) {
    const ClampedCubicBasis basis(Moved(segment.surface.z_basis().breakpoints(), heights));
    moved.surface = SplineSurface(segment.surface.theta_basis(), basis, segment.surface.coefficients());
    return moved;
  }
  const SplineLevel& coarsest = segment.hierarchy->levels().front();
  moved.hierarchy = std::make_shared<const HierarchicalSpline>(
      coarsest.theta.count(), Moved(coarsest.z.breakpoints(), heights), segment.hierarchy->flags());
  moved.surface = moved.hierarchy->Surface(segment.active);
  return moved;
}

/// Of the leaves of a mesh, whether another one has just the same.
std::vector<bool> Untouched(const ClayMesh& mesh, const ClayMesh& other) {
  std::vector<bool> same(mesh.patches().size(), false);
  for (const PatchIndex index : mesh.LeavesInOrder()) {
    const ClayPatch& leaf = mesh.patch(index);
    const PatchIndex there = other.LeafOf({leaf.base, leaf.level, leaf.column, leaf.row});
    same[index] = there != kNoIndex && other.patch(there).net == leaf.net;
  }
  return same;
}

/// Marks the leaf at a place for splitting, unless it is finer already.
void Mark(const HierarchicalSpline& spline, double theta, double z, std::uint8_t level, RefinementFlags& flags) {
  const SplineLeaf& leaf = spline.leaves()[spline.LeafAt(theta, z)];
  if (leaf.level > level) return;
  flags[leaf.level][leaf.z_cell * spline.levels()[leaf.level].theta_cells() + leaf.theta_cell] = 1;
}

/// The spline with all leaves split that are off by more than a part of the tolerance, and those around them: a
/// function of the next level needs four of its cells each way. None beyond the coefficients that there may be; null:
/// none at all.
std::shared_ptr<const HierarchicalSpline> Split(const HierarchicalSpline& spline, const std::vector<double>& error,
                                                const SurfaceOfClayOptions& options) {
  RefinementFlags flags = spline.flags();
  const SplineLevel& finest = spline.finest();
  const bool deeper = 4 * finest.theta.count() * finest.z.count() <= options.most_coefficients &&
                      spline.levels().size() <= kMostRefinements;
  if (deeper) flags.emplace_back(finest.theta_cells() * finest.z_cells(), char{0});
  bool split = false;
  for (std::size_t n = 0; n < error.size(); ++n) {
    const SplineLeaf& leaf = spline.leaves()[n];
    if (!(error[n] > kSplitFrom * options.tolerance_mm) || leaf.level >= flags.size()) continue;
    split = true;
    const SplineLevel& level = spline.levels()[leaf.level];
    const double width = level.theta.spacing();
    const double from = level.z.breakpoints()[leaf.z_cell];
    const double height = level.z.breakpoints()[leaf.z_cell + 1] - from;
    for (int k = 0; k < 9; ++k) {
      const double z = from + (0.5 + (k / 3 - 1)) * height;
      if (!(z > level.z.min() && z < level.z.max())) continue;
      Mark(spline, (leaf.theta_cell + 0.5 + (k % 3 - 1)) * width, z, leaf.level, flags);
    }
  }
  if (!split) return nullptr;
  const std::vector<char>& last = flags.back();
  if (std::none_of(last.begin(), last.end(), [](char flag) { return flag != 0; })) flags.pop_back();
  const SplineLevel& coarsest = spline.levels().front();
  return std::make_shared<const HierarchicalSpline>(coarsest.theta.count(), coarsest.z.breakpoints(), std::move(flags));
}

double Largest(const std::vector<double>& distances) { return *std::max_element(distances.begin(), distances.end()); }

/// Grows the radius, with more knots as long as they are needed and there may be more.
Result<ChangedSegment> Grow(const SurfaceSegment& segment, const RadiusGrowth& growth,
                            const SurfaceOfClayOptions& options) {
  const ThetaZBox all{0.0, kTwoPi, segment.surface.z_min(), segment.surface.z_max()};
  auto changed = GrowRadius(segment, all, growth);
  const ControlledSurface old = ControlledBy(segment);
  std::shared_ptr<const HierarchicalSpline> spline = old.spline;
  while (changed && !(Largest(changed->piece_distance) <= options.tolerance_mm)) {
    auto finer = Split(*spline, changed->piece_distance, options);
    if (finer == nullptr) break;
    spline = std::move(finer);
    changed = GrowRadius(Refined(segment, spline), all, growth);
  }
  if (changed && spline != old.spline && segment.normal_matrix.nonZeros() > 0) {
    changed->segment.normal_matrix = RefinedPrecision(segment.normal_matrix, *old.spline, *spline);
  }
  return changed;
}

}  // namespace

Result<SurfaceOfClay> SurfaceFromClay(const SurfaceSegment& segment, const ClayOfSurface& made, const ClayBody& shaped,
                                      const SurfaceOfClayOptions& options) {
  const std::size_t walls = made.columns * made.rows;
  if (shaped.mesh().base_count() != made.body.mesh().base_count()) {
    return Fail(
        "make a surface r(theta, z) of a clay body",
        fmt::format("it has {} patches, the model makes {}", shaped.mesh().base_count(), made.body.mesh().base_count()),
        "name the model that it was made of; clay with a hole through it has no r(theta, z)");
  }
  const auto before = ClayRays::Make(made.body, segment.axis, walls);
  if (!before) return Fail(before);
  const auto after = ClayRays::Make(shaped, segment.axis, walls);
  if (!after) return Fail(after);
  const Heights heights{before->z_min(), before->z_max(), after->z_min(), after->z_max()};
  const std::vector<bool> untouched = Untouched(made.body.mesh(), shaped.mesh());
  const auto growth = [&](double theta, double z) -> std::optional<double> {
    const auto was = before->Meet(theta, heights.Old(z));
    if (!was) return std::nullopt;
    if (heights.Same() && untouched[was->leaf]) return 0.0;
    const auto is = after->Meet(theta, z);
    if (!is) return std::nullopt;
    return is->radius - was->radius;
  };
  const std::size_t pieces = ControlledBy(segment).spline->leaves().size();
  auto changed = Grow(Moved(segment, heights), growth, options);
  if (!changed) return Fail(changed);
  SurfaceOfClay result{std::move(changed->segment)};
  result.largest_error_mm = Largest(changed->piece_distance);
  result.largest_growth_mm = changed->largest_growth;
  result.volume_mm3 = SegmentVolume(result.segment);
  result.volume_error = result.volume_mm3 / shaped.volume() - 1.0;
  result.caps_off_mm = after->caps_off();
  result.covariance_kept = segment.normal_matrix.nonZeros() == 0 || result.segment.normal_matrix.nonZeros() > 0;
  result.pieces_split = (ControlledBy(result.segment).spline->leaves().size() - pieces) / 3;
  return result;
}

}  // namespace annulus
