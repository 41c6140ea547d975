#include "fitting/segment_axis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>
#include <vector>

#include "base/frames.h"

namespace annulus {
namespace {

/// Samples of one level after the other, on a level by theta from the middle of the piece.
std::vector<std::size_t> LevelOrder(std::span<const SurfaceSample> samples) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const SurfaceSample& sample : samples) middle += sample.Point().head<2>();
  const double theta = std::atan2(middle.y(), middle.x());
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const SurfaceSample& p = samples[a];
    const SurfaceSample& q = samples[b];
    if (p.sweep != q.sweep) return p.sweep < q.sweep;
    if (p.level != q.level) return p.level < q.level;
    return AngleDifference(p.theta, theta) < AngleDifference(q.theta, theta);
  });
  return order;
}

bool SameLevel(const SurfaceSample& a, const SurfaceSample& b) { return a.sweep == b.sweep && a.level == b.level; }

double AngleAbout(const SurfaceSample& sample, const SegmentAxis& axis) {
  const Eigen::Vector2d d = sample.Point().head<2>() - axis.At(sample.z);
  return std::atan2(d.y(), d.x());
}

/// The middle of what was seen of a limb on one level.
struct LevelCentre {
  double z = 0.0;  ///< mm
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
};

/// Middles of the levels, by height. The arc seen on a level has a chord of half length h and a height s over it; a
/// circle has its centre (h² + s²)/(2 s) behind the top of the arc. Where little was seen that is a guess at what is
/// hidden, and it is not followed further than 2 s. (The middle of the chord, s, would see the ends of the arc at a
/// grazing angle.)
std::vector<LevelCentre> CentresOfLevels(std::span<const SurfaceSample> samples) {
  constexpr double kShortestChord = 5.0;  // mm, half; also the flattest arc
  constexpr double kDeepest = 2.0;        // times the height of the arc
  const std::vector<std::size_t> order = LevelOrder(samples);
  std::vector<LevelCentre> centres;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && SameLevel(samples[order[begin]], samples[order[end]])) ++end;
    const Eigen::Vector2d first = samples[order[begin]].Point().head<2>();
    const Eigen::Vector2d last = samples[order[end - 1]].Point().head<2>();
    const double half = 0.5 * (last - first).norm();
    if (half >= kShortestChord) {
      const Eigen::Vector2d along = (last - first) / (2.0 * half);
      const Eigen::Vector2d outward(along.y(), -along.x());  // the arc runs counter-clockwise around the ring's axis
      double height = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        height = std::max(height, outward.dot(samples[order[k]].Point().head<2>() - first));
      }
      const double depth =
          std::min(kDeepest * height, (half * half + height * height) / (2.0 * std::max(height, kShortestChord)));
      centres.push_back({samples[order[begin]].z, 0.5 * (first + last) + (height - depth) * outward});
    }
    begin = end;
  }
  std::stable_sort(centres.begin(), centres.end(),
                   [](const LevelCentre& a, const LevelCentre& b) { return a.z < b.z; });
  return centres;
}

/// The parabola through the centres with the smallest sum of distances, squared up to 10 mm and linear beyond (Huber),
/// by reweighting: a foot or a wild return does not bend it.
SegmentAxis ParabolaThrough(const std::vector<LevelCentre>& centres) {
  constexpr double kHuber = 10.0;  // mm
  constexpr int kRounds = 20;
  const double middle = 0.5 * (centres.front().z + centres.back().z);
  const double half = std::max(1e-9, 0.5 * (centres.back().z - centres.front().z));
  std::vector<double> weights(centres.size(), 1.0);
  const auto powers = [&](double z) {
    const double t = (z - middle) / half;
    return Eigen::Vector3d(1.0, t, t * t);
  };
  Eigen::Matrix<double, 3, 2> curve = Eigen::Matrix<double, 3, 2>::Zero();  // columns: x, y
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> sums = Eigen::Matrix<double, 3, 2>::Zero();
    for (std::size_t k = 0; k < centres.size(); ++k) {
      const Eigen::Vector3d basis = powers(centres[k].z);
      moments += weights[k] * basis * basis.transpose();
      sums += weights[k] * basis * centres[k].centre.transpose();
    }
    curve = moments.ldlt().solve(sums);
    for (std::size_t k = 0; k < centres.size(); ++k) {
      const double distance = (centres[k].centre - curve.transpose() * powers(centres[k].z)).norm();
      weights[k] = distance <= kHuber ? 1.0 : kHuber / distance;
    }
  }
  return {middle, curve.row(0).transpose(), curve.row(1).transpose() / half, curve.row(2).transpose() / (half * half)};
}

}  // namespace

Result<SegmentAxis> FindSegmentAxis(std::span<const SurfaceSample> samples) {
  constexpr std::size_t kFewest = 8;
  const std::vector<LevelCentre> centres = CentresOfLevels(samples);
  const std::string attempted = "find the axis of a limb";
  if (centres.size() < kFewest || !(centres.back().z - centres.front().z >= 1.0)) {
    return Fail(attempted, "only " + std::to_string(centres.size()) + " levels show enough of it",
                "scan with more levels");
  }
  return ParabolaThrough(centres);
}

std::vector<SurfaceSample> SamplesAboutAxis(std::span<const SurfaceSample> samples, const SegmentAxis& axis) {
  constexpr double kFinest = kTwoPi / 720.0;
  constexpr double kCoarsest = kTwoPi / 24.0;
  std::vector<double> steps;
  const std::vector<std::size_t> order = LevelOrder(samples);
  for (std::size_t k = 1; k < order.size(); ++k) {
    const SurfaceSample& before = samples[order[k - 1]];
    const SurfaceSample& here = samples[order[k]];
    if (!SameLevel(before, here)) continue;
    const double step = AngleDifference(AngleAbout(here, axis), AngleAbout(before, axis));
    if (step > 0.0) steps.push_back(step);
  }
  double step = kCoarsest;
  if (!steps.empty()) {
    const auto quarter = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4);
    std::nth_element(steps.begin(), quarter, steps.end());
    step = std::clamp(*quarter, kFinest, kCoarsest);
  }
  const double directions = std::round(kTwoPi / step);
  std::vector<SurfaceSample> turned(samples.begin(), samples.end());
  for (SurfaceSample& sample : turned) {
    const double theta = WrapAngle(AngleAbout(sample, axis));
    sample.radius = (sample.Point().head<2>() - axis.At(sample.z)).norm();
    sample.theta = theta;
    sample.sensor = static_cast<std::uint16_t>(std::min(directions - 1.0, theta / kTwoPi * directions));
  }
  return turned;
}

std::vector<char> StarShapedLevels(std::span<const SurfaceSample> samples, const SegmentAxis& axis) {
  constexpr std::size_t kNoise = 1;    // steps of a level; at an edge, noise alone may turn one back
  constexpr double kNoiseShare = 0.1;  // a few wild returns
  std::vector<char> fits(samples.size(), 1);
  const std::vector<std::size_t> order = LevelOrder(samples);
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    std::size_t backward = 0;
    for (; end < order.size() && SameLevel(samples[order[begin]], samples[order[end]]); ++end) {
      const double before = AngleAbout(samples[order[end - 1]], axis);
      if (AngleDifference(AngleAbout(samples[order[end]], axis), before) < 0.0) ++backward;
    }
    const auto allowed = std::max(kNoise, static_cast<std::size_t>(kNoiseShare * static_cast<double>(end - begin)));
    if (backward > allowed) {
      for (std::size_t k = begin; k < end; ++k) fits[order[k]] = 0;
    }
    begin = end;
  }
  return fits;
}

}  // namespace annulus
