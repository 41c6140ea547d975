#include "render/make_up.h"

#include <algorithm>
#include <cmath>

#include "modeling/landmarks/head_grid.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kUsualPupils = 63.0;  // mm, of a face of scale 1
constexpr double kSoftEdge = 2.0;      // mm from nothing to all at an edge of lips or brows
/// No skin is darker: keeps the factors finite.
constexpr float kDarkestSkin = 0.004F;

/// 1 where `inside` (mm within an edge) is large, 0 outside, smooth over the soft edge about 0.
double Edge(double inside) {
  const double t = std::clamp(inside / kSoftEdge + 0.5, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Height of the upper lip's border over its crease, as a share, at `place` from the middle (0) to the corner (1): the
/// bow has its dip in the middle and its peaks at a fifth.
double UpperBorder(double place) {
  constexpr double kPeak = 0.20;
  if (place < kPeak) {
    const double t = place / kPeak;
    return 0.84 + 0.16 * t * t * (3.0 - 2.0 * t);
  }
  const double t = (place - kPeak) / (1.0 - kPeak);
  return std::max(0.0, 1.0 - 0.55 * t - 0.45 * t * t);
}

double LowerBorder(double place) { return std::max(0.0, 1.0 - std::pow(place, 2.4)); }

/// The brow's arc over its height above the eye, mm at scale 1, from its inner end (0) to the tail (1).
double BrowArc(double place) {
  constexpr double kPeak = 0.62;
  const double t = (place - kPeak) / (place < kPeak ? kPeak : 1.0 - kPeak);
  return 1.6 - (place < kPeak ? 3.2 : 6.0) * t * t;
}

/// Half the brow's thickness, mm at scale 1.
double BrowHalf(double place) { return place < 0.15 ? 2.6 + 0.8 * place / 0.15 : 3.4 - 2.6 * (place - 0.15) / 0.85; }

}  // namespace

MakeUpZones MakeUpZones::On(const SplineSurface& head, const FacePoints& face) {
  MakeUpZones zones;
  const HeadGrid grid(head, kHeadDepth);
  zones.plane_ = FindMidPlane(grid, face.pronasale.position);
  const FaceRelief relief(head, zones.plane_);
  zones.mouth_ = FindMouth(relief, face);
  zones.scale_ = std::clamp((face.eye_right.position - face.eye_left.position).norm() / kUsualPupils, 0.8, 1.25);
  const Vector3d forward = zones.plane_.forward();
  const double tip = face.pronasale.position.z();
  for (std::size_t side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    const Vector3d& eye = (side == 0 ? face.eye_right : face.eye_left).position;
    const double lateral = std::clamp(std::abs(zones.plane_.Lateral(eye)), 24.0, 40.0);
    zones.brows_[side] = {lateral, FindBrowHeight(relief, face, sign * lateral, eye.z())};
    zones.eyes_ += 0.5 * eye.z();
    zones.front_ += 0.5 * (eye.dot(forward) - 55.0 * zones.scale_);
    // Over the cheekbone's front, and from there back and up towards the zygion.
    const Vector3d centre = relief.PointAt(sign * 1.38 * lateral, eye.z() - 0.72 * (eye.z() - tip));
    const Vector3d outer = relief.PointAt(sign * 1.85 * lateral, eye.z() - 0.42 * (eye.z() - tip));
    const Vector3d along = (outer - centre).normalized();
    const Vector3d out = (sign * zones.plane_.right() + forward).normalized();
    zones.cheeks_[side] = {centre, along, along.cross(out).normalized()};
  }
  return zones;
}

double MakeUpZones::LipsAt(double lateral, double z) const {
  const std::size_t side = lateral > 0.0 ? 0 : 1;
  const double place = std::abs(lateral) / mouth_.half_breadth[side];
  if (place > 1.15) return 0.0;
  const double held = std::min(place, 1.0);
  const double crease = mouth_.stomion + mouth_.corner_rise[side] * place * place;
  // Distances to the borders measured down and up; a border's slope near the corner makes that an overestimate, which
  // the end of the mouth's breadth corrects.
  const double below_upper = crease + mouth_.upper_height * UpperBorder(held) - z;
  const double above_lower = z - crease + mouth_.lower_height * LowerBorder(held);
  const double before_corner = 0.5 * kSoftEdge + (1.0 - place) * mouth_.half_breadth[side];
  return Edge(below_upper) * Edge(above_lower) * Edge(before_corner);
}

double MakeUpZones::BrowAt(double lateral, double z) const {
  const Brow& brow = brows_[lateral > 0.0 ? 0 : 1];
  const double inner = 0.40 * brow.eye_lateral;
  const double outer = 1.62 * brow.eye_lateral;
  const double place = (std::abs(lateral) - inner) / (outer - inner);
  if (place < -0.1 || place > 1.1) return 0.0;
  const double held = std::clamp(place, 0.0, 1.0);
  const double off = std::abs(z - brow.height - scale_ * BrowArc(held));
  const double end = std::min(place, 1.0 - place) * (outer - inner);
  return Edge(scale_ * BrowHalf(held) - off) * Edge(end + 0.25 * kSoftEdge);
}

double MakeUpZones::CheekAt(const Vector3d& p, std::size_t side) const {
  const Cheek& cheek = cheeks_[side];
  const Vector3d from = p - cheek.centre;
  const double u = from.dot(cheek.along) / (29.0 * scale_);
  const double v = from.dot(cheek.across) / (18.0 * scale_);
  const Vector3d normal = cheek.along.cross(cheek.across);
  const double w = from.dot(normal) / (40.0 * scale_);
  const double inside = std::max(0.0, 1.0 - u * u - v * v - w * w);
  return inside * inside;
}

MakeUpCover MakeUpZones::At(const Vector3d& p_in_station) const {
  const double lateral = plane_.Lateral(p_in_station);
  const double depth = p_in_station.dot(plane_.forward()) - front_;
  if (depth <= 0.0) return {};
  const double z = p_in_station.z();
  // Lips and brows are columns along the line of sight: they end well before the ears.
  const double before = std::clamp(depth / 10.0, 0.0, 1.0);
  return {before * LipsAt(lateral, z), before * CheekAt(p_in_station, lateral > 0.0 ? 0 : 1),
          before * BrowAt(lateral, z)};
}

std::vector<LinearRgb> MakeUpColours(const MakeUpZones& zones, const MakeUp& make_up, const LinearRgb& skin,
                                     const std::vector<Vector3d>& vertices) {
  std::vector<LinearRgb> factors;
  if (make_up.lips.strength <= 0.0 && make_up.cheeks.strength <= 0.0 && make_up.brows.strength <= 0.0) return factors;
  const LinearRgb ground = skin.cwiseMax(kDarkestSkin);
  factors.reserve(vertices.size());
  const auto lay = [&ground](LinearRgb& factor, const MakeUpLayer& layer, double cover) {
    const auto share = static_cast<float>(std::clamp(layer.strength, 0.0, 1.0) * cover);
    if (share > 0.0F) factor += share * (layer.colour.cwiseQuotient(ground) - factor);
  };
  for (const Vector3d& vertex : vertices) {
    LinearRgb factor = LinearRgb::Ones();
    const MakeUpCover cover = zones.At(vertex);
    lay(factor, make_up.cheeks, cover.cheeks);
    lay(factor, make_up.lips, cover.lips);
    lay(factor, make_up.brows, cover.brows);
    factors.push_back(factor);
  }
  return factors;
}

}  // namespace annulus
