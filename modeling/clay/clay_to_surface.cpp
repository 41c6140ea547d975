#include "modeling/clay/clay_to_surface.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "modeling/clay/clay_rays.h"
#include "modeling/elastic/surface_change.h"

namespace annulus {
namespace {

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

}  // namespace

Result<SurfaceOfClay> SurfaceFromClay(const SurfaceSegment& segment, const ClayOfSurface& made,
                                      const ClayBody& shaped) {
  const std::size_t walls = made.columns * made.rows;
  if (shaped.mesh().base_count() != made.body.mesh().base_count()) {
    return Fail("make a surface r(theta, z) of a clay body",
                fmt::format("it was made of {} patches, the model makes {}", shaped.mesh().base_count(),
                            made.body.mesh().base_count()),
                "name the model that the clay was made of");
  }
  const auto before = ClayRays::Make(made.body, segment.axis, walls);
  if (!before) return Fail(before);
  const auto after = ClayRays::Make(shaped, segment.axis, walls);
  if (!after) return Fail(after);
  const Heights heights{before->z_min(), before->z_max(), after->z_min(), after->z_max()};
  const auto growth = [&](double theta, double z) -> std::optional<double> {
    const auto was = before->Radius(theta, heights.Old(z));
    const auto is = after->Radius(theta, z);
    if (!was || !is) return std::nullopt;
    return *is - *was;
  };
  const ThetaZBox all{0.0, kTwoPi, heights.from, heights.to};
  auto changed = GrowRadius(Moved(segment, heights), all, growth);
  if (!changed) return Fail(changed);
  SurfaceOfClay result{std::move(changed->segment)};
  result.largest_error_mm = changed->largest_error;
  result.rms_error_mm = changed->rms_error;
  result.largest_growth_mm = changed->largest_growth;
  result.volume_mm3 = SegmentVolume(result.segment);
  result.volume_error = result.volume_mm3 / shaped.volume() - 1.0;
  result.caps_off_mm = after->caps_off();
  return result;
}

}  // namespace annulus
