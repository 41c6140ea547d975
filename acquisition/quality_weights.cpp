#include "acquisition/quality_weights.h"

#include <algorithm>
#include <cmath>

#include "acquisition/quality_notices.h"

namespace annulus {
namespace {

/// Weights of a grid's readings, by column; all 1 until something is amiss.
class WeightTable {
 public:
  explicit WeightTable(const QualityGrid& grid) : grid_(grid) {}
  void Lower(std::size_t level, std::size_t column, float weight) {
    if (weights_.empty()) weights_.assign(grid_.levels().size() * grid_.columns(), 1.0F);
    float& at = weights_[level * grid_.columns() + grid_.SensorOf(column)];
    at = std::min(at, weight);
  }
  [[nodiscard]] std::vector<float> Take() { return std::move(weights_); }

 private:
  const QualityGrid& grid_;
  std::vector<float> weights_;
};

/// Where a sweep differs from the first one, that of the two which came nearer to the sensors is in the way.
void LeaveOutChanged(const QualityGrid& grid, const std::vector<ComparedLevel>& compared, WeightTable& weights) {
  constexpr float kOtherwise = 30.0F;  // mm
  const std::vector<ChangedParts> changed = FindChangedParts(grid, compared);
  for (const ComparedLevel& level : compared) {
    const QualityGrid::Level& at = grid.levels()[level.level];
    for (const ChangedParts& parts : changed) {
      if (parts.sweep != at.sweep) continue;
      for (const QualityRegion& region : parts.regions) {
        if (at.z < region.z_min || at.z > region.z_max) continue;
        for (std::size_t c = 0; c < grid.columns(); ++c) {
          const double inside = WrapAngle(grid.Theta(c) - region.theta_from);
          if (inside > region.theta_to - region.theta_from || !grid.Seen(level.level, c)) continue;
          if (level.residual[c] > kOtherwise) weights.Lower(level.level, c, 0.0F);
        }
      }
    }
  }
  // What the first sweep has before all the others.
  for (const ChangedParts& parts : changed) {
    for (const QualityRegion& region : parts.regions) {
      for (std::size_t k = 0; k < grid.levels().size(); ++k) {
        const QualityGrid::Level& at = grid.levels()[k];
        if (at.sweep != grid.levels().front().sweep || at.z < region.z_min || at.z > region.z_max) continue;
        const auto near = std::min_element(compared.begin(), compared.end(), [&](const auto& a, const auto& b) {
          const auto cost = [&](const ComparedLevel& other) {
            const QualityGrid::Level& there = grid.levels()[other.level];
            return std::abs(there.z - at.z) + (there.sweep == parts.sweep ? 0.0 : 1e9);
          };
          return cost(a) < cost(b);
        });
        if (near == compared.end()) continue;
        for (std::size_t c = 0; c < grid.columns(); ++c) {
          const double inside = WrapAngle(grid.Theta(c) - region.theta_from);
          if (inside > region.theta_to - region.theta_from || !grid.Seen(k, c)) continue;
          if (near->residual[c] < -kOtherwise) weights.Lower(k, c, 0.0F);
        }
      }
    }
  }
}

/// A person who stands elsewhere than before: where most of the scan was taken is the truth, and the rest counts
/// little.
void LowerMoved(const QualityGrid& grid, const std::vector<ComparedLevel>& compared, WeightTable& weights) {
  const auto moved = FindMoved(grid, compared);
  if (!moved) return;
  constexpr float kElsewhere = 0.05F;
  const bool first_is_odd = 2 * moved->levels > compared.size();
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    const QualityGrid::Level& at = grid.levels()[k];
    const bool first = at.sweep == grid.levels().front().sweep;
    if (first != first_is_odd || at.z < moved->z_min || at.z > moved->z_max) continue;
    if (!first) {
      const auto level = std::find_if(compared.begin(), compared.end(), [k](const auto& c) { return c.level == k; });
      if (level == compared.end() || ShiftOf(*level) < 0.5 * moved->shift_mm) continue;
    }
    for (std::size_t c = 0; c < grid.columns(); ++c) weights.Lower(k, c, kElsewhere);
  }
}

/// Cloth that flutters has the scatter of its sweeps, not that of the sensors.
void LowerFluttering(const QualityGrid& grid, const std::vector<ComparedLevel>& compared, double noise_sigma_mm,
                     WeightTable& weights) {
  const Flutter flutter = MeasureFlutter(grid, compared, noise_sigma_mm);
  if (flutter.share < kMuchFlutter || !(noise_sigma_mm > 0.0)) return;
  const double ratio = noise_sigma_mm / flutter.sigma_mm;
  const auto weight = static_cast<float>(std::clamp(ratio * ratio, 0.02, 1.0));
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    const double z = grid.levels()[k].z;
    if (z < flutter.z_min || z > flutter.z_max) continue;
    for (std::size_t c = 0; c < grid.columns(); ++c) weights.Lower(k, c, weight);
  }
}

}  // namespace

std::vector<float> WeightsOf(const QualityGrid& grid, const SensorWatch& watch, double noise_sigma_mm) {
  WeightTable weights(grid);
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    for (const auto& [from, to] : watch.StuckSpans(c)) {
      for (std::size_t k = from; k < to; ++k) weights.Lower(k, c, 0.0F);
    }
  }
  const std::vector<ComparedLevel> compared = CompareSweeps(grid);
  if (!compared.empty() && !FindLeft(grid)) {
    LeaveOutChanged(grid, compared, weights);
    LowerMoved(grid, compared, weights);
    LowerFluttering(grid, compared, noise_sigma_mm, weights);
  }
  return weights.Take();
}

}  // namespace annulus
