#include "render/overlay.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace annulus {
namespace {

constexpr double kStep = 2.0;  // pixels between the places looked at

/// Labels that touch: they move together.
struct Block {
  double sum = 0.0;  ///< Of the places wanted, each less its offset in the block.
  std::size_t count = 0;

  [[nodiscard]] double mean() const { return sum / static_cast<double>(count); }
};

double LengthOf(const OverlayRun& run) {
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < run.points.size(); ++k) length += (run.points[k + 1] - run.points[k]).norm();
  return length;
}

/// Joins runs that go on where the one before ends, once what is too short counts as its neighbours.
std::vector<OverlayRun> WithoutFlicker(std::vector<OverlayRun> runs, double shortest) {
  const auto goes_on = [&runs](std::size_t k) {
    return k + 1 < runs.size() && runs[k].points.back() == runs[k + 1].points.front();
  };
  for (std::size_t k = 1; k + 1 < runs.size(); ++k) {
    if (goes_on(k - 1) && goes_on(k) && LengthOf(runs[k]) < shortest) runs[k].visible = runs[k - 1].visible;
  }
  std::vector<OverlayRun> joined;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const bool continues = k > 0 && goes_on(k - 1) && joined.back().visible == runs[k].visible;
    if (continues) {
      joined.back().points.insert(joined.back().points.end(), runs[k].points.begin() + 1, runs[k].points.end());
    } else {
      joined.push_back(runs[k]);
    }
  }
  return joined;
}

}  // namespace

Overlay::Overlay(const Camera& camera, const RgbImage& picture, double tolerance)
    : camera_(camera), picture_(picture), tolerance_(tolerance) {}

std::optional<PicturePoint> Overlay::Project(const Eigen::Vector3d& p_in_station) const {
  const Eigen::Vector3d p = camera_.ToCamera(p_in_station);
  if (!p.allFinite() || p.z() < camera_.near_mm) return std::nullopt;
  const double scale = camera_.projection == Projection::kPerspective ? p.z() : 1.0;
  const double pixels = 0.5 * picture_.height / (camera_.half_height * scale);  // per mm
  return PicturePoint{{0.5 * picture_.width + pixels * p.x(), 0.5 * picture_.height - pixels * p.y()}, p.z()};
}

bool Overlay::Hides(const PicturePoint& point) const {
  const auto column = static_cast<long>(std::floor(point.at.x()));
  const auto row = static_cast<long>(std::floor(point.at.y()));
  float farthest = -1.0F;
  for (long y = row - 1; y <= row + 1; ++y) {
    for (long x = column - 1; x <= column + 1; ++x) {
      if (x < 0 || y < 0 || x >= picture_.width || y >= picture_.height) return false;
      farthest = std::max(farthest, picture_.depth[picture_.Index(static_cast<int>(x), static_cast<int>(y))]);
    }
  }
  return point.depth > static_cast<double>(farthest) + tolerance_;
}

std::vector<OverlayRun> Overlay::Runs(const std::vector<Eigen::Vector3d>& line) const {
  std::vector<OverlayRun> runs;
  bool joined = false;
  const auto add = [&](const Eigen::Vector3d& p) {
    const std::optional<PicturePoint> point = Project(p);
    if (!point) {
      joined = false;
      return;
    }
    const bool visible = !Hides(*point);
    if (!joined) {
      runs.push_back({{point->at}, visible});
    } else if (runs.back().visible == visible) {
      runs.back().points.push_back(point->at);
    } else {
      runs.push_back({{runs.back().points.back(), point->at}, visible});
    }
    joined = true;
  };
  for (std::size_t k = 0; k < line.size(); ++k) {
    add(line[k]);
    if (k + 1 == line.size()) break;
    const auto from = Project(line[k]);
    const auto to = Project(line[k + 1]);
    const double length = from && to ? std::min((to->at - from->at).norm(), 1e5) : 0.0;
    const int steps = static_cast<int>(length / kStep);
    for (int step = 1; step <= steps; ++step) {
      add(line[k] + (line[k + 1] - line[k]) * (static_cast<double>(step) / (steps + 1)));
    }
  }
  std::erase_if(runs, [](const OverlayRun& run) { return run.points.size() < 2; });
  return WithoutFlicker(std::move(runs), kShortestRun);
}

std::vector<double> SpreadLabels(const std::vector<double>& wanted, double gap, double from, double to) {
  std::vector<std::size_t> order(wanted.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return wanted[a] < wanted[b]; });
  // Less k times the gap, the places need only not fall.
  const double last = std::max(from, to - gap * (static_cast<double>(wanted.size()) - 1.0));
  std::vector<Block> blocks;
  for (std::size_t k = 0; k < order.size(); ++k) {
    blocks.push_back({wanted[order[k]] - gap * static_cast<double>(k), 1});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].mean() > blocks.back().mean()) {
      const Block upper = blocks.back();
      blocks.pop_back();
      blocks.back().sum += upper.sum;
      blocks.back().count += upper.count;
    }
  }
  std::vector<double> placed(wanted.size());
  std::size_t k = 0;
  for (const Block& block : blocks) {
    for (std::size_t n = 0; n < block.count; ++n, ++k) {
      placed[order[k]] = std::clamp(block.mean(), from, last) + gap * static_cast<double>(k);
    }
  }
  return placed;
}

}  // namespace annulus
