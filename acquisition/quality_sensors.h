#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "acquisition/quality_grid.h"
#include "acquisition/scan_quality.h"

namespace annulus {

/// Watches the sensors one by one, level by level.
class SensorWatch {
 public:
  /// Levels of one value that make a sensor stuck, if its neighbours move.
  static constexpr std::uint32_t kStuckAfter = 8;
  /// Levels without a return, though something lay there, that make a sensor dead.
  static constexpr std::uint32_t kDeadAfter = 40;
  /// The same for a sensor that had returns before.
  static constexpr std::uint32_t kDiedAfter = 100;
  /// The same for three and more side by side: then it may as well be something black.
  static constexpr std::uint32_t kManyDeadAfter = 80;

  explicit SensorWatch(std::size_t columns) : states_(columns), quality_(columns) {}

  /// The newest level of the grid.
  void Update(const QualityGrid& grid);

  /// By column; `dead` and `stuck` as they are now.
  [[nodiscard]] const std::vector<SensorQuality>& quality() const { return quality_; }
  /// Levels [from, to) on which a column was stuck.
  [[nodiscard]] const std::vector<std::pair<std::size_t, std::size_t>>& StuckSpans(std::size_t column) const {
    return states_[column].stuck_spans;
  }

 private:
  struct State {
    float value = 0.0F;
    std::uint32_t same = 0;     ///< Levels of this value up to now.
    std::uint32_t missing = 0;  ///< Expected returns in a row that did not come.
    std::uint32_t returns = 0;
    std::vector<std::pair<std::size_t, std::size_t>> stuck_spans;
  };
  void FindStuck(const QualityGrid& grid, std::size_t level);
  void FindDead();

  std::vector<State> states_;
  std::vector<SensorQuality> quality_;
};

}  // namespace annulus
