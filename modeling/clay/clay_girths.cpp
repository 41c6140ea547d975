#include "modeling/clay/clay_girths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kCells = 6;
constexpr int kNewton = 8;

/// A place of a patch in its parameters.
using Place = Vector2d;

Vector3d PointAt(const BezierPatch& patch, const Place& place) { return patch.Point(place.x(), place.y()); }

/// Where z crosses the level between two places of a grid line: by regula falsi with halving (Illinois).
Place Crossing(const BezierPatch& patch, double level, Place a, Place b) {
  double at_a = PointAt(patch, a).z() - level;
  double at_b = PointAt(patch, b).z() - level;
  for (int step = 0; step < 40 && (b - a).norm() > 1e-14; ++step) {
    const Place between = a + (b - a) * (at_a / (at_a - at_b));
    const double at = PointAt(patch, between).z() - level;
    if (at == 0.0 || std::abs(at) < 1e-13 * std::max(1.0, std::abs(level))) return between;
    if ((at > 0.0) == (at_b > 0.0)) {
      at_a *= 0.5;
    } else {
      a = b;
      at_a = at_b;
    }
    b = between;
    at_b = at;
  }
  return b;
}

/// The place of the level next to the middle of two of its places, across them: Newton.
Place OntoLevel(const BezierPatch& patch, double level, Place place, const Vector2d& chord) {
  const Vector2d across(-chord.y(), chord.x());
  for (int step = 0; step < kNewton; ++step) {
    const double off = PointAt(patch, place).z() - level;
    const double slope = patch.DerivativeU(place.x(), place.y()).z() * across.x() +
                         patch.DerivativeV(place.x(), place.y()).z() * across.y();
    if (std::abs(off) < 1e-12 || slope == 0.0) break;
    const double move = std::clamp(-off / slope, -0.5, 0.5);
    place += move * across;
  }
  return place;
}

SectionPiece PieceBetween(const BezierPatch& patch, double level, const Place& a, const Place& b) {
  const Vector3d from = PointAt(patch, a);
  const Vector3d to = PointAt(patch, b);
  const Vector3d middle = PointAt(patch, OntoLevel(patch, level, 0.5 * (a + b), b - a));
  const double once = (to - from).norm();
  const double twice = (middle - from).norm() + (to - middle).norm();
  // Chords fall short by the square of their length: Richardson. Not where the middle has gone elsewhere.
  const double length = twice < 1.2 * once ? (4.0 * twice - once) / 3.0 : once;
  return {from, to, length};
}

}  // namespace

std::vector<SectionPiece> SectionOf(const BezierPatch::ControlNet& net, double level) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const auto& row : net) {
    for (const Vector3d& point : row) {
      low = std::min(low, point.z());
      high = std::max(high, point.z());
    }
  }
  std::vector<SectionPiece> pieces;
  if (level < low || level > high || low == high) return pieces;
  const BezierPatch patch(net);
  std::array<std::array<double, kCells + 1>, kCells + 1> above{};
  const auto place = [](std::size_t i, std::size_t j) {
    return Place(static_cast<double>(i) / kCells, static_cast<double>(j) / kCells);
  };
  for (std::size_t i = 0; i <= kCells; ++i) {
    for (std::size_t j = 0; j <= kCells; ++j) above[i][j] = PointAt(patch, place(i, j)).z() - level;
  }
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t j = 0; j < kCells; ++j) {
      const std::array<std::array<std::size_t, 2>, 4> corner{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
      std::vector<Place> crossings;
      for (std::size_t e = 0; e < 4; ++e) {
        const auto& a = corner[e];
        const auto& b = corner[(e + 1) % 4];
        // A corner on the plane counts as above it, whoever asks.
        if ((above[a[0]][a[1]] >= 0.0) == (above[b[0]][b[1]] >= 0.0)) continue;
        crossings.push_back(Crossing(patch, level, place(a[0], a[1]), place(b[0], b[1])));
      }
      for (std::size_t n = 0; n + 1 < crossings.size(); n += 2) {
        pieces.push_back(PieceBetween(patch, level, crossings[n], crossings[n + 1]));
      }
    }
  }
  return pieces;
}

ClayGirths::ClayGirths(const ClayBody& body, std::vector<double> levels)
    : levels_(std::move(levels)), sections_(levels_.size()) {
  seen_ = body.change_count();
  for (PatchIndex leaf = 0; leaf < body.mesh().patches().size(); ++leaf) Renew(body, leaf);
  Measure();
}

void ClayGirths::Renew(const ClayBody& body, PatchIndex leaf) {
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    Section& section = sections_[level];
    std::vector<SectionPiece> pieces;
    if (body.mesh().alive(leaf)) pieces = SectionOf(body.mesh().patch(leaf).net, levels_[level]);
    if (!pieces.empty()) {
      section.pieces[leaf] = std::move(pieces);
      section.changed = true;
    } else if (section.pieces.erase(leaf) > 0) {
      section.changed = true;
    }
  }
}

void ClayGirths::Follow(const ClayBody& body) {
  auto changed = body.LeavesSince(seen_);
  seen_ = body.change_count();
  if (!changed) {
    for (PatchIndex leaf = 0; leaf < body.mesh().patches().size(); ++leaf) Renew(body, leaf);
  } else {
    std::sort(changed->begin(), changed->end());
    changed->erase(std::unique(changed->begin(), changed->end()), changed->end());
    for (const PatchIndex leaf : *changed) Renew(body, leaf);
  }
  Measure();
}

void ClayGirths::Measure() {
  for (Section& section : sections_) {
    if (!section.changed) continue;
    section.changed = false;
    section.perimeter = 0.0;
    std::vector<Vector2d> points;
    for (const auto& [leaf, pieces] : section.pieces) {
      for (const SectionPiece& piece : pieces) {
        section.perimeter += piece.length_mm;
        points.push_back(piece.from.head<2>());
        points.push_back(piece.to.head<2>());
      }
    }
    section.tape = points.empty() ? 0.0 : ConvexHullPerimeter(points);
  }
}

}  // namespace annulus
