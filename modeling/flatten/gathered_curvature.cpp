#include "modeling/flatten/gathered_curvature.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace annulus {
namespace {

/// Of the square root of a piece's area.
constexpr double kGather = 0.1;     ///< How far curvature counts.
constexpr double kKeepAway = 0.08;  ///< Of a dart's tip from rim and tips.
constexpr double kKeepClear = 0.15;

}  // namespace

std::optional<std::uint32_t> MostCurved(const FlatPiece& piece, Curved curved) {
  SheetTopology topology;
  topology.rims = {piece.rim};
  const std::vector<double> defects = AngleDefects(piece.body.sheet, topology);
  const auto& places = piece.body.sheet.places;
  const double scale = std::sqrt(piece.body_area_mm2);
  std::vector<Eigen::Vector3d> avoid;
  for (const std::uint32_t v : piece.rim) avoid.push_back(places[v]);
  for (const PieceDart& dart : piece.body.darts) avoid.push_back(places[dart.legs[1].back()[1]]);
  const double clear = (curved == Curved::kDomes ? kKeepAway : kKeepClear) * scale;
  double best = 0.0;
  std::optional<std::uint32_t> found;
  for (std::uint32_t v = 0; v < places.size(); ++v) {
    const bool near = std::any_of(avoid.begin(), avoid.end(),
                                  [&](const Eigen::Vector3d& p) { return (p - places[v]).norm() < clear; });
    if (near) continue;
    double gathered = 0.0;
    for (std::size_t w = 0; w < places.size(); ++w) {
      const double near_share = 1.0 - (places[w] - places[v]).norm() / (kGather * scale);
      if (near_share > 0.0) gathered += near_share * defects[w];
    }
    if (curved == Curved::kDomesAndSaddles) gathered = std::abs(gathered);
    if (gathered <= best) continue;
    best = gathered;
    found = v;
  }
  return found;
}

}  // namespace annulus
