#include "fitting/sample_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "base/ensure.h"
#include "base/frames.h"

namespace annulus {
namespace {

constexpr auto kEmpty = static_cast<std::uint32_t>(SampleGrid::kNone);

/// Mean position of the samples of one row or column.
struct Group {
  std::uint64_t key = 0;
  double first = 0.0;  ///< Position of the first member; the others are averaged relative to it.
  double sum = 0.0;
  std::size_t count = 0;

  void Add(double offset) {
    sum += offset;
    ++count;
  }
  [[nodiscard]] double mean() const { return first + sum / static_cast<double>(count); }
};

/// Indices of the groups by ascending position; equal positions by key.
std::vector<std::uint32_t> Order(const std::vector<Group>& groups) {
  std::vector<std::uint32_t> order(groups.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double pa = groups[a].mean();
    const double pb = groups[b].mean();
    return pa != pb ? pa < pb : groups[a].key < groups[b].key;
  });
  return order;
}

std::vector<double> Positions(const std::vector<Group>& groups, const std::vector<std::uint32_t>& order) {
  std::vector<double> positions;
  positions.reserve(order.size());
  for (const std::uint32_t group : order) positions.push_back(groups[group].mean());
  return positions;
}

/// Where a sample's beam comes from, rad; its own theta if that is not known.
double HeadingOf(const SurfaceSample& sample) {
  constexpr double kSame = 1e-5;  // rad; the rounding of ray_direction
  const double x = -static_cast<double>(sample.ray_direction.x());
  const double y = -static_cast<double>(sample.ray_direction.y());
  if (x == 0.0 && y == 0.0) return sample.theta;
  const double heading = std::atan2(y, x);
  return std::abs(AngleDifference(heading, sample.theta)) < kSame ? sample.theta : WrapAngle(heading);
}

/// Whether thetas are about the axis that the beams aim at, if not quite: the ring's own, not that of a limb.
bool AboutRing(std::span<const SurfaceSample> samples) {
  constexpr double kCrooked = 0.2;  // rad; 4 mm beside the axis at a radius of 20 mm
  std::size_t usable = 0;
  std::size_t near = 0;
  for (const SurfaceSample& sample : samples) {
    if (!IsUsable(sample)) continue;
    ++usable;
    near += std::abs(AngleDifference(HeadingOf(sample), sample.theta)) < kCrooked ? 1 : 0;
  }
  return 10 * near >= 9 * usable;
}

/// The sensors that gave usable samples, in order of appearance.
struct SensorGroups {
  std::vector<Group> groups;
  std::vector<std::uint32_t> of_sensor;  ///< kEmpty for a sensor without samples.
  std::size_t usable = 0;                ///< Samples.

  explicit SensorGroups(std::span<const SurfaceSample> samples) {
    // A column stands where its sensor does. Where beams do not aim at the axis quite, points near it lie columns apart
    // from their sensor, and would change places with those of its neighbours.
    const bool by_heading = AboutRing(samples);
    for (const SurfaceSample& s : samples) {
      if (!IsUsable(s)) continue;
      ++usable;
      const double direction = by_heading ? HeadingOf(s) : s.theta;
      if (s.sensor >= of_sensor.size()) of_sensor.resize(std::size_t{s.sensor} + 1, kEmpty);
      std::uint32_t& group = of_sensor[s.sensor];
      if (group == kEmpty) {
        group = static_cast<std::uint32_t>(groups.size());
        groups.push_back({s.sensor, direction, 0.0, 0});
      }
      const double first = groups[group].first;
      groups[group].Add((first + AngleDifference(direction, first)) - first);  // a sensor may straddle 0
    }
  }
};

/// Rows in order of appearance, with their cells (one per sensor group).
class RowGroups {
 public:
  RowGroups(std::size_t columns, std::size_t usable)
      : columns_(columns), max_cells_(kCellsPerSample * usable + kFreeCells) {}

  /// Puts a sample in the first row of its sweep and level in which its cell is free, if there is one. False when the
  /// rows would take more cells than a scan of so many samples can need.
  bool Put(const SurfaceSample& s, std::uint32_t index, std::uint32_t column) {
    constexpr std::uint64_t kMaxShared = 16;
    const std::uint64_t key = (std::uint64_t{s.sweep} << 48U) | (std::uint64_t{s.level} << 16U);
    for (std::uint64_t repeat = 0; repeat < kMaxShared; ++repeat) {
      const std::uint32_t row = Row(key | repeat, s.z);
      if (cells_.size() > max_cells_) return false;
      std::uint32_t& cell = cells_[row * columns_ + column];
      if (cell != kEmpty) continue;
      cell = index;
      groups_[row].Add(s.z - groups_[row].first);
      ++held_;
      return true;
    }
    return true;
  }

  [[nodiscard]] std::size_t held() const { return held_; }
  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }
  [[nodiscard]] const std::uint32_t* Cells(std::uint32_t row) const { return cells_.data() + row * columns_; }

 private:
  static constexpr std::size_t kCellsPerSample = 100;
  static constexpr std::size_t kFreeCells = std::size_t{1} << 16U;

  std::uint32_t Row(std::uint64_t key, double z) {
    if (last_ < groups_.size() && groups_[last_].key == key) return last_;  // samples mostly come level by level
    const auto [entry, is_new] = row_of_key_.try_emplace(key, static_cast<std::uint32_t>(groups_.size()));
    last_ = entry->second;
    if (is_new) {
      groups_.push_back({key, z, 0.0, 0});
      cells_.resize(cells_.size() + columns_, kEmpty);
    }
    return last_;
  }

  std::size_t columns_;
  std::size_t max_cells_;
  std::unordered_map<std::uint64_t, std::uint32_t> row_of_key_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> cells_;
  std::uint32_t last_ = 0;
  std::size_t held_ = 0;
};

}  // namespace

bool IsUsable(const SurfaceSample& sample) {
  constexpr double kLargestRadius = 1e4;  // mm
  constexpr double kLargestHeight = 1e5;  // mm
  constexpr double kLargestAngle = 1e3;   // rad
  constexpr float kLargestWeight = 1e6F;  // and its inverse the smallest: beyond them the equations lose their digits
  return std::abs(sample.theta) <= kLargestAngle && sample.radius > 0.0 && sample.radius <= kLargestRadius &&
         std::abs(sample.z) <= kLargestHeight && sample.weight >= 1.0F / kLargestWeight &&
         sample.weight <= kLargestWeight;
}

SampleGrid::SampleGrid(std::span<const SurfaceSample> samples) {
  ENSURE(samples.size() < kNone, "samples are counted in 32 bits");
  const SensorGroups sensors(samples);
  RowGroups levels(sensors.groups.size(), sensors.usable);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (!IsUsable(samples[k])) continue;
    if (!levels.Put(samples[k], static_cast<std::uint32_t>(k), sensors.of_sensor[samples[k].sensor])) return;
  }
  if (levels.held() < sensors.usable / 2) return;
  const std::vector<std::uint32_t> row_order = Order(levels.groups());
  const std::vector<std::uint32_t> column_order = Order(sensors.groups);
  row_z_ = Positions(levels.groups(), row_order);
  column_theta_ = Positions(sensors.groups, column_order);
  cells_.resize(rows() * columns());
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::uint32_t* from = levels.Cells(row_order[row]);
    for (std::size_t column = 0; column < columns(); ++column) {
      cells_[row * columns() + column] = from[column_order[column]];
    }
  }
}

std::size_t SampleGrid::RingSize() const {
  const std::size_t n = columns();
  if (n < 2) return n;
  std::vector<double> gaps(n);
  for (std::size_t k = 0; k + 1 < n; ++k) gaps[k] = column_theta_[k + 1] - column_theta_[k];
  gaps[n - 1] = kTwoPi - (column_theta_[n - 1] - column_theta_[0]);
  std::vector<double> sorted = gaps;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2), sorted.end());
  const double usual = sorted[n / 2];
  if (!(usual > kTwoPi / (16.0 * static_cast<double>(n)))) return n;  // no ring: most stand on one spot
  double directions = 0.0;
  for (const double gap : gaps) directions += std::max(1.0, std::round(gap / usual));
  return static_cast<std::size_t>(directions);
}

}  // namespace annulus
