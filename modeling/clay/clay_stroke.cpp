#include "modeling/clay/clay_stroke.h"

#include <cmath>
#include <unordered_set>

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Detail that may go where leaves are finer than the tool needs them, over the size of leaf that it needs.
constexpr double kDetail = 5e-3;

/// The vertices that the stroke's places hold, each once.
std::vector<VertexIndex> VerticesOf(const ClayBody& body, const std::vector<StrokePlace>& places) {
  if (places.empty()) return WholeBody(body.mesh()).vertices;
  std::vector<VertexIndex> vertices;
  std::unordered_set<VertexIndex> seen;
  for (const StrokePlace& place : places) {
    const PatchIndex start = body.mesh().Locate(place.at).patch;
    for (const VertexIndex vertex : RegionAround(body.mesh(), start, place.centre, place.radius_mm).vertices) {
      if (seen.insert(vertex).second) vertices.push_back(vertex);
    }
  }
  return vertices;
}

Vector3d MiddleOf(const ClayBody& body) {
  Vector3d sum = Vector3d::Zero();
  double count = 0.0;
  for (const ClayPatch& patch : body.mesh().patches()) {
    if (patch.node == kNoIndex) continue;
    for (const auto& [i, j] : {std::pair{0U, 0U}, {3U, 0U}, {3U, 3U}, {0U, 3U}}) sum += patch.net[i][j];
    count += 4.0;
  }
  return sum / count;
}

}  // namespace

MaskWeight::MaskWeight(const ClayBody& body, const std::vector<ClayMask>& masks) {
  for (const ClayMask& mask : masks) spots_.push_back({body.Point(mask.at), mask.radius_mm});
}

PointMotion MaskWeight::Weigh(const Vector3d& place, const PointMotion& motion) const {
  double weight = 1.0;
  Vector3d slope = Vector3d::Zero();
  for (const Spot& spot : spots_) {
    const Vector3d from = place - spot.centre;
    const double distance = from.norm();
    const double t = (distance / spot.radius - 1.0) / 0.5;
    double one = t >= 1.0 ? 1.0 : 0.0;
    Vector3d one_slope = Vector3d::Zero();
    if (t > 0.0 && t < 1.0) {
      one = t * t * (3.0 - 2.0 * t);
      one_slope = 6.0 * t * (1.0 - t) / (0.5 * spot.radius * distance) * from;
    }
    slope = slope * one + weight * one_slope;
    weight *= one;
  }
  return {weight * motion.move, weight * motion.gradient + motion.move * slope.transpose()};
}

std::vector<GroupMotion> MotionsOf(const ClayMesh& mesh, const std::vector<VertexIndex>& vertices,
                                   const ClayField& field, const MaskWeight& mask) {
  std::vector<GroupMotion> motions;
  if (!field) return motions;
  for (const VertexIndex vertex : vertices) {
    const Vector3d& place = mesh.Position(vertex);
    PointMotion motion = field(place);
    if (!mask.empty()) motion = mask.Weigh(place, motion);
    if (motion.move.isZero(0.0) && motion.gradient.isZero(0.0)) continue;
    motions.push_back({vertex, motion.move, motion.gradient});
  }
  return motions;
}

namespace {

Result<ClayChange> Deform(ClayBody& body, const ClayStroke& stroke, const MaskWeight& mask) {
  const std::vector<VertexIndex> vertices = VerticesOf(body, stroke.places);
  ClayDeformation deformation;
  deformation.direct = MotionsOf(body.mesh(), vertices, stroke.direct, mask);
  const bool scales = !stroke.indirect && stroke.rule == VolumeRule::kKept;
  if (!scales) {
    deformation.indirect = MotionsOf(body.mesh(), vertices, stroke.indirect, mask);
    return body.Deform(deformation, stroke.rule);
  }
  if (!mask.empty()) {
    deformation.indirect = MotionsOf(body.mesh(), WholeBody(body.mesh()).vertices, ScaleField(MiddleOf(body)), mask);
    return body.Deform(deformation, VolumeRule::kKept);
  }
  auto change = body.Deform(deformation, VolumeRule::kOwed);
  if (!change) return change;
  change->k = body.ScaleToKept(MiddleOf(body));
  change->volume_after_mm3 = body.volume();
  return change;
}

}  // namespace

std::vector<ClayBody::FormerLeaf> CoarsenAround(ClayBody& body, const StrokePlace& place) {
  if (place.leaf_mm > place.radius_mm) return {};
  const PatchIndex start = body.mesh().Locate(place.at).patch;
  const ClayRegion region = RegionAround(body.mesh(), start, place.centre, place.radius_mm);
  return body.Coarsen(region.patches, place.leaf_mm, kDetail * place.leaf_mm);
}

Result<ClayChange> Carry(ClayBody& body, const ClayStroke& stroke, const MaskWeight& mask) {
  for (const StrokePlace& place : stroke.places) {
    RETURN_IF_ERROR(RefineAround(body, place.at, place.centre, place.radius_mm, place.leaf_mm));
  }
  std::vector<ClayBody::FormerLeaf> former;
  // What only comes off is not to take the clay of a merged leaf with it.
  for (const StrokePlace& place : stroke.places) {
    if (stroke.rule != VolumeRule::kKept) break;
    const auto more = CoarsenAround(body, place);
    former.insert(former.end(), more.begin(), more.end());
  }
  auto change = Deform(body, stroke, mask);
  if (!change) body.Restore(former);
  return change;
}

}  // namespace annulus
