#include "modeling/glasses/lens_bevel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace annulus {
namespace {

constexpr double kBevelToolPower = 530.0;  // mm · D: (1.53 − 1) · 1000
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Sag of the bevel's sphere at `radius` mm from the box centre.
double CurveSag(double curve, double radius) {
  const double curvature = curve / kBevelToolPower;
  const double inside = std::max(0.0, 1.0 - curvature * curvature * radius * radius);
  return curvature * radius * radius / (1.0 + std::sqrt(inside));
}

/// The sphere as far forward as leaves half the bevel before it; where the edge is too thin, midway.
std::vector<double> OnCurve(const LensEdge& edge, const Eigen::Vector2d& box_centre, const BevelRule& rule) {
  std::vector<double> sags;
  sags.reserve(edge.points.size());
  double front = kInfinity;  // the foremost vertex that meets no front edge
  double back = -kInfinity;  // the hindmost that meets no back edge
  for (const EdgePoint& point : edge.points) {
    sags.push_back(CurveSag(rule.curve, (point.position - box_centre).norm()));
    front = std::min(front, point.front_z + sags.back());
    back = std::max(back, point.back_z + sags.back());
  }
  const double half = rule.width / 2.0;
  const double vertex = front - back >= 2.0 * half ? front - half : 0.5 * (front + back);
  for (double& sag : sags) sag = vertex - sag;
  return sags;
}

}  // namespace

LensBevel BevelOf(const LensEdge& edge, const Eigen::Vector2d& box_centre, const BevelRule& rule) {
  LensBevel bevel;
  if (rule.mode == BevelMode::kCurve) {
    bevel.apex_z = OnCurve(edge, box_centre, rule);
  } else {
    for (const EdgePoint& point : edge.points) {
      const double behind = rule.mode == BevelMode::kFrontFollow ? rule.front_distance : rule.ratio * point.thickness();
      bevel.apex_z.push_back(point.front_z - behind);
    }
  }
  bevel.smallest_front = kInfinity;
  bevel.smallest_back = kInfinity;
  for (std::size_t i = 0; i < edge.points.size(); ++i) {
    bevel.mean_z += bevel.apex_z[i] / static_cast<double>(edge.points.size());
    bevel.smallest_front = std::min(bevel.smallest_front, edge.points[i].front_z - bevel.apex_z[i]);
    bevel.smallest_back = std::min(bevel.smallest_back, bevel.apex_z[i] - edge.points[i].back_z);
  }
  for (const double z : bevel.apex_z) bevel.unevenness = std::max(bevel.unevenness, std::abs(z - bevel.mean_z));
  return bevel;
}

}  // namespace annulus
