#include "modeling/measure/region_knowledge.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kLinesPerRow = 4.0;

/// Angles at which the boundary crosses horizontal lines at z = base + (k + 1/2)·pitch.
std::vector<std::vector<double>> Crossings(std::span<const SurfacePlace> boundary, double base, double pitch,
                                           std::size_t lines) {
  std::vector<std::vector<double>> crossings(lines);
  for (std::size_t k = 0; k < boundary.size(); ++k) {
    const SurfacePlace& a = boundary[k];
    const SurfacePlace& b = boundary[(k + 1) % boundary.size()];
    const double low = (std::min(a.z, b.z) - base) / pitch - 0.5;
    const double high = (std::max(a.z, b.z) - base) / pitch - 0.5;
    for (double line = std::max(0.0, std::ceil(low)); line < high && line < static_cast<double>(lines); line += 1.0) {
      const double share = (base + (line + 0.5) * pitch - a.z) / (b.z - a.z);
      crossings[static_cast<std::size_t>(line)].push_back(a.theta + share * (b.theta - a.theta));
    }
  }
  for (std::vector<double>& line : crossings) std::sort(line.begin(), line.end());
  return crossings;
}

}  // namespace

PathKnowledge KnowledgeWithin(const MeasuredSurface& body, std::span<const SurfacePlace> boundary) {
  const KnowledgeMap& map = body.segment().knowledge;
  PathKnowledge shares;
  if (map.rows() == 0 || boundary.empty()) return {0.0, 1.0};
  const double pitch = (map.z_max() - map.z_min()) / (kLinesPerRow * static_cast<double>(map.rows()));
  const auto lines = Crossings(boundary, map.z_min(), pitch, map.rows() * static_cast<std::size_t>(kLinesPerRow));
  const double width = kTwoPi / static_cast<double>(map.columns());
  double whole = 0.0;
  std::vector<double> inside(map.columns());
  for (std::size_t row = 0; row < map.rows(); ++row) {
    std::fill(inside.begin(), inside.end(), 0.0);
    for (std::size_t part = 0; part < static_cast<std::size_t>(kLinesPerRow); ++part) {
      const std::vector<double>& line = lines[row * static_cast<std::size_t>(kLinesPerRow) + part];
      for (std::size_t k = 0; k + 1 < line.size(); k += 2) {
        // Column c reaches half a width to either side of c·width.
        for (double c = std::floor(line[k] / width + 0.5); (c - 0.5) * width < line[k + 1]; c += 1.0) {
          const double from = std::max(line[k], (c - 0.5) * width);
          const double to = std::min(line[k + 1], (c + 0.5) * width);
          const auto column = static_cast<std::size_t>(WrapAngle(c * width) / width + 0.5) % map.columns();
          inside[column] += std::max(to - from, 0.0) * pitch;
        }
      }
    }
    const double z = map.z_min() + (static_cast<double>(row) + 0.5) * kLinesPerRow * pitch;
    for (std::size_t column = 0; column < map.columns(); ++column) {
      if (inside[column] == 0.0) continue;
      const RadiusJet jet = body.surface().Jet(static_cast<double>(column) * width, z);
      const double skin =
          inside[column] * std::sqrt(jet.r * jet.r * (1.0 + jet.r_z * jet.r_z) + jet.r_theta * jet.r_theta);
      whole += skin;
      if (map.Cell(column, row) == Knowledge::kMeasured) shares.measured += skin;
      if (map.Cell(column, row) == Knowledge::kUnknown) shares.unknown += skin;
    }
  }
  if (whole > 0.0) shares = {shares.measured / whole, shares.unknown / whole};
  std::size_t measured = 0;
  for (const SurfacePlace& place : boundary) {
    const Knowledge known = body.KnowledgeAt(place.theta, place.z);
    if (known == Knowledge::kUnknown) shares.unknown = std::max(shares.unknown, 1e-6);
    if (known == Knowledge::kMeasured) ++measured;
  }
  // A region between two of the lines is known as its boundary is.
  if (whole == 0.0) shares.measured = static_cast<double>(measured) / static_cast<double>(boundary.size());
  return shares;
}

}  // namespace annulus
