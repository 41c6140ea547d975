#include "acquisition/swapped_channels.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "acquisition/drift_watch.h"
#include "acquisition/neighbour_prediction.h"
#include "acquisition/quality_grid.h"
#include "acquisition/ring_profile.h"
#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::size_t kBoardSensors = 15;
constexpr std::size_t kMostSwaps = 8;
constexpr double kCap = 8.0;  // cost of one comparison at most: 4 sd
constexpr double kNormal = 1.4826;

/// By how much an exchange explains the readings better.
struct Evidence {
  double gain = 0.0;    ///< In log-likelihood.
  double sigma = 0.0;   ///< sd of the gain of an exchange that changes nothing.
  double least = 15.0;  ///< From here on it is believed.
  [[nodiscard]] bool Clear() const {
    constexpr double kLeastSigmas = 4.0;
    return gain > least && gain > kLeastSigmas * sigma;
  }
};

/// Two blocks of sensors that may be exchanged.
struct Candidate {
  std::size_t a = 0, b = 0, count = 1;
};

std::vector<RecordedBoard> BoardsOf(std::size_t sensors, const std::vector<RecordedBoard>& known) {
  if (!known.empty() || sensors % kBoardSensors != 0) return known;
  std::vector<RecordedBoard> boards;
  for (std::size_t first = 0; first < sensors; first += kBoardSensors) {
    RecordedBoard board;
    board.first_sensor = static_cast<std::uint16_t>(first);
    board.sensor_count = static_cast<std::uint16_t>(kBoardSensors);
    boards.push_back(board);
  }
  return boards;
}

std::vector<Candidate> CandidatesOf(std::size_t sensors, const std::vector<RecordedBoard>& boards) {
  std::vector<Candidate> candidates;
  const auto fits = [&](const RecordedBoard& board) {
    return std::size_t{board.first_sensor} + board.sensor_count <= sensors;
  };
  for (const RecordedBoard& board : boards) {
    if (!fits(board)) continue;
    const std::size_t end = std::size_t{board.first_sensor} + board.sensor_count;
    for (std::size_t a = board.first_sensor; a < end; ++a) {
      for (std::size_t b = a + 1; b < end; ++b) candidates.push_back({a, b, 1});
    }
  }
  for (std::size_t k = 0; k < boards.size(); ++k) {
    for (std::size_t other = 0; other < boards.size(); ++other) {
      const bool pair = boards[k].first_sensor < boards[other].first_sensor && fits(boards[other]);
      if (!pair || boards[k].sensor_count != boards[other].sensor_count || boards[k].sensor_count < 2) continue;
      candidates.push_back({boards[k].first_sensor, boards[other].first_sensor, boards[k].sensor_count});
    }
  }
  return candidates;
}

std::string NameOf(const RecordedBoard& board, std::size_t number) {
  return board.serial != 0 ? std::to_string(board.serial) : "number " + std::to_string(number);
}

ChannelSwap Describe(const Candidate& found, double evidence, const std::vector<RecordedBoard>& boards) {
  ChannelSwap swap{found.a, found.b, found.count, evidence, ""};
  const auto board_of = [&](std::size_t sensor) {
    std::size_t k = 0;
    while (k < boards.size() && !(sensor >= boards[k].first_sensor &&
                                  sensor < std::size_t{boards[k].first_sensor} + boards[k].sensor_count)) {
      ++k;
    }
    return k;
  };
  const std::size_t a = board_of(found.a);
  const std::size_t b = board_of(found.b);
  if (a >= boards.size() || b >= boards.size()) return swap;
  if (found.count == 1) {
    swap.text = "board " + NameOf(boards[a], a) + ": channels " + std::to_string(found.a - boards[a].first_sensor) +
                " and " + std::to_string(found.b - boards[a].first_sensor) + " are exchanged (sensors " +
                std::to_string(found.a) + " and " + std::to_string(found.b) + ")";
  } else {
    swap.text = "boards " + NameOf(boards[a], a) + " and " + NameOf(boards[b], b) + " are exchanged (sensors " +
                std::to_string(found.a) + " to " + std::to_string(found.a + found.count - 1) + " and " +
                std::to_string(found.b) + " to " + std::to_string(found.b + found.count - 1) + ")";
  }
  return swap;
}

/// The search in some levels of one scan. `channel_` says whose readings are taken for each sensor: found exchanges are
/// put right, and the search goes on.
class LevelSearch {
 public:
  LevelSearch(const Scan& scan, std::size_t stride, double offset_sigma)
      : profile_(scan, stride), offset_sigma_(offset_sigma) {
    const std::size_t n = profile_.columns();
    channel_.resize(n);
    std::iota(channel_.begin(), channel_.end(), std::size_t{0});
    for (std::size_t column = 0; column < n; ++column) columns_.push_back(profile_.Column(column));
    Compare();
  }

  [[nodiscard]] Evidence Try(const Candidate& candidate) const {
    Moved moved;
    for (std::size_t k = 0; k < candidate.count; ++k) {
      const std::size_t a = candidate.a + k;
      const std::size_t b = candidate.b + k;
      moved[profile_.ColumnOf(a)] = profile_.Placed(channel_[b], a);
      moved[profile_.ColumnOf(b)] = profile_.Placed(channel_[a], b);
    }
    // Where the two themselves do not fit better, their neighbours do not make that good again.
    constexpr double kHopeless = -100.0;
    std::vector<std::size_t> columns = ColumnsAround(candidate);
    std::stable_partition(columns.begin(), columns.end(), [&](std::size_t column) { return moved.contains(column); });
    std::vector<double> gains(profile_.levels().size(), 0.0);
    Evidence evidence;
    for (const std::size_t column : columns) {
      if (candidate.count > 1 || evidence.gain > kHopeless) evidence.gain += Gain(column, moved, gains);
    }
    for (const double gain : gains) evidence.sigma += gain * gain;
    evidence.sigma = std::sqrt(evidence.sigma);
    return evidence;
  }
  void Exchange(const Candidate& candidate) {
    for (std::size_t k = 0; k < candidate.count; ++k) {
      std::swap(channel_[candidate.a + k], channel_[candidate.b + k]);
      for (const std::size_t sensor : {candidate.a + k, candidate.b + k}) {
        columns_[profile_.ColumnOf(sensor)] = profile_.Placed(channel_[sensor], sensor);
      }
    }
    Compare();
  }

 private:
  static constexpr std::size_t kAround = 3;  ///< Columns whose prediction hangs noticeably on another.
  using Moved = std::map<std::size_t, ProfileColumn>;

  [[nodiscard]] std::vector<std::size_t> ColumnsAround(const Candidate& candidate) const {
    const std::size_t n = columns_.size();
    std::vector<std::size_t> around;
    for (const std::size_t first : {candidate.a, candidate.b}) {
      const std::size_t from = profile_.ColumnOf(first);
      for (std::size_t step = 0; step < candidate.count + 2 * kAround; ++step) {
        // Within a block all have moved together, and it is as smooth as it was.
        const bool inside = step >= 2 * kAround && step < candidate.count;
        if (!inside) around.push_back((from + n - kAround + step) % n);
      }
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
  }

  [[nodiscard]] ColumnWindow WindowOf(std::size_t column, const Moved& moved) const {
    const std::size_t n = columns_.size();
    const double step = kTwoPi / static_cast<double>(n);
    std::array<ColumnWindow::Entry, kNeighbours + 1> entries;
    for (std::size_t k = 0; k < entries.size(); ++k) {
      const std::size_t other = (column + n + k - kNeighbourReach) % n;
      const auto found = moved.find(other);
      entries[k] = {found == moved.end() ? &columns_[other] : &found->second,
                    AngleDifference(profile_.Direction(other), profile_.Direction(column)) / step};
    }
    return {entries, step};
  }

  [[nodiscard]] std::vector<float> Residuals(std::size_t column, const Moved& moved) const {
    const ColumnWindow window = WindowOf(column, moved);
    std::vector<float> residuals(profile_.levels().size(), std::numeric_limits<float>::quiet_NaN());
    for (std::size_t level = 0; level < residuals.size(); ++level) {
      const auto residual = window.At(level);
      if (residual) residuals[level] = static_cast<float>(residual->value);
    }
    return residuals;
  }
  /// All columns as they are now.
  void Compare() {
    residuals_.clear();
    std::vector<float> magnitudes;
    for (std::size_t column = 0; column < columns_.size(); ++column) {
      residuals_.push_back(Residuals(column, {}));
      for (const float value : residuals_.back()) {
        if (!std::isnan(value)) magnitudes.push_back(std::abs(value));
      }
    }
    if (!magnitudes.empty()) sigma_ = std::max(0.05, kNormal * MedianOf(magnitudes));
  }

  /// What one column's comparisons cost less with the exchange; level by level added to `gains`.
  double Gain(std::size_t column, const Moved& moved, std::vector<double>& gains) const {
    const std::vector<float>& before = residuals_[column];
    const std::vector<float> after = Residuals(column, moved);
    const double old_offset = OffsetOf(before, after);
    const double new_offset = OffsetOf(after, before);
    double whole = OffsetCost(old_offset) - OffsetCost(new_offset);
    for (std::size_t level = 0; level < after.size(); ++level) {
      if (std::isnan(before[level]) || std::isnan(after[level])) continue;
      const double gain = Cost(before[level] - old_offset) - Cost(after[level] - new_offset);
      gains[level] += gain;
      whole += gain;
    }
    return whole;
  }
  /// The median of those values for which there is one of the others, too.
  [[nodiscard]] static double OffsetOf(const std::vector<float>& values, const std::vector<float>& others) {
    std::vector<float> both;
    for (std::size_t level = 0; level < values.size(); ++level) {
      if (!std::isnan(values[level]) && !std::isnan(others[level])) both.push_back(values[level]);
    }
    return both.empty() ? 0.0 : MedianOf(both);
  }
  [[nodiscard]] double OffsetCost(double offset) const {
    return std::min(0.5 * offset * offset / (offset_sigma_ * offset_sigma_), kCap);
  }
  [[nodiscard]] double Cost(double off) const { return std::min(0.5 * off * off / (sigma_ * sigma_), kCap); }

  RingProfile profile_;
  double offset_sigma_;
  std::vector<std::size_t> channel_;           ///< By sensor.
  std::vector<ProfileColumn> columns_;         ///< By column.
  std::vector<std::vector<float>> residuals_;  ///< By column and level, mm.
  double sigma_ = 1.0;                         ///< sd of one comparison, mm.
};

/// The search in one scan: some levels tell nearly all pairs, all levels the others.
class ScanSearch {
 public:
  ScanSearch(const Scan& scan, double offset_sigma)
      : some_(scan, std::max<std::size_t>(1, scan.levels.size() / kLevels), offset_sigma),
        all_(scan, 1, offset_sigma) {}

  [[nodiscard]] Evidence Try(const Candidate& candidate) const {
    constexpr double kClear = -100.0;
    const Evidence evidence = some_.Try(candidate);
    return evidence.gain < kClear ? evidence : all_.Try(candidate);
  }
  void Exchange(const Candidate& candidate) {
    some_.Exchange(candidate);
    all_.Exchange(candidate);
  }

 private:
  static constexpr std::size_t kLevels = 240;

  LevelSearch some_;
  LevelSearch all_;
};

/// The best exchange, then the best of what is left …
template <class Search>
std::vector<ChannelSwap> FindAll(Search& search, std::size_t sensors, const std::vector<RecordedBoard>& boards) {
  const std::vector<Candidate> candidates = CandidatesOf(sensors, boards);
  std::vector<ChannelSwap> swaps;
  while (swaps.size() < kMostSwaps) {
    double most = 0.0;
    std::optional<Candidate> best;
    for (const Candidate& candidate : candidates) {
      const Evidence evidence = search.Try(candidate);
      if (!evidence.Clear() || evidence.gain <= most) continue;
      most = evidence.gain;
      best = candidate;
    }
    if (!best) break;
    search.Exchange(*best);
    swaps.push_back(Describe(*best, most, boards));
  }
  return swaps;
}

/// The search in placements: what a channel reads against what is expected at a place.
class PlacementSearch {
 public:
  PlacementSearch(const std::vector<PlacementReadings>& placements, double offset_sigma,
                  const PlacementTolerance& tolerance)
      : placements_(placements) {
    channel_.resize(placements.front().seen_mm.size());
    std::iota(channel_.begin(), channel_.end(), std::size_t{0});
    const auto count = static_cast<Eigen::Index>(placements.size());
    for (std::size_t place = 0; place < channel_.size(); ++place) {
      Eigen::MatrixXd covariance = Square(tolerance.reading_sigma_mm) * Eigen::MatrixXd::Identity(count, count);
      const auto add = [&](double sigma, const std::function<double(const PlacementReadings&)>& slope) {
        Eigen::VectorXd column(count);
        for (Eigen::Index k = 0; k < count; ++k) {
          const double value = slope(placements[static_cast<std::size_t>(k)]);
          column(k) = std::isfinite(value) ? value : 0.0;
        }
        covariance += sigma * sigma * column * column.transpose();
      };
      add(offset_sigma, [](const PlacementReadings&) { return 1.0; });
      add(tolerance.scale_sigma, [&](const PlacementReadings& readings) { return readings.expected_mm[place]; });
      add(tolerance.aim_sigma, [&](const PlacementReadings& r) { return SlopeAt(r.lateral_slope_mm, place); });
      add(tolerance.aim_sigma, [&](const PlacementReadings& r) { return SlopeAt(r.vertical_slope_mm, place); });
      precision_.push_back(covariance.llt().solve(Eigen::MatrixXd::Identity(count, count)));
    }
  }

  [[nodiscard]] Evidence Try(const Candidate& candidate) const {
    Evidence evidence;
    constexpr double kLeastOfMany = 8.0;  // several placements that all fit are no chance
    if (placements_.size() >= 4) evidence.least = kLeastOfMany;
    double left = 0.0;
    double fits = 0.0;
    for (std::size_t k = 0; k < candidate.count; ++k) {
      const std::size_t a = candidate.a + k;
      const std::size_t b = candidate.b + k;
      const Eigen::VectorXd aa = Residuals(channel_[a], a);
      const Eigen::VectorXd bb = Residuals(channel_[b], b);
      const Eigen::VectorXd ab = Residuals(channel_[a], b);
      const Eigen::VectorXd ba = Residuals(channel_[b], a);
      // What one of the four lacks is left out of all, so that none is cheaper for having seen less.
      const Eigen::ArrayXd all = aa.array() + bb.array() + ab.array() + ba.array();
      const Eigen::ArrayXd kept = all.isFinite().cast<double>();
      const double after = Cost(ba, a, kept) + Cost(ab, b, kept);
      evidence.gain += Cost(aa, a, kept) + Cost(bb, b, kept) - after;
      left += after;
      fits += kept.sum() + std::max(kMostLeft, kLeftEach * kept.sum());
    }
    // Two sensors that are wrong may fit better in each other's place without fitting there.
    return left <= fits ? evidence : Evidence{};
  }
  void Exchange(const Candidate& candidate) {
    for (std::size_t k = 0; k < candidate.count; ++k) std::swap(channel_[candidate.a + k], channel_[candidate.b + k]);
  }

 private:
  static constexpr double kMostLeft = 8.0;  ///< Of two costs of 4 sd, beyond the mean of chi-square …
  static constexpr double kLeftEach = 4.0;  ///< … or so much per placement: large aims are not linear.

  static double Square(double number) { return number * number; }
  static double SlopeAt(const std::vector<double>& slopes, std::size_t place) {
    return slopes.empty() ? 0.0 : slopes[place];
  }
  [[nodiscard]] Eigen::VectorXd Residuals(std::size_t channel, std::size_t place) const {
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(placements_.size()));
    for (std::size_t k = 0; k < placements_.size(); ++k) {
      residuals(static_cast<Eigen::Index>(k)) = placements_[k].seen_mm[channel] - placements_[k].expected_mm[place];
    }
    return residuals;
  }
  /// −log likelihood at a place whose offset, scale and aims have the tolerance's priors. A placement that is left out
  /// counts as one that fits.
  [[nodiscard]] double Cost(const Eigen::VectorXd& residuals, std::size_t place, const Eigen::ArrayXd& kept) const {
    const Eigen::VectorXd off = (kept > 0.0).select(residuals.array(), 0.0).matrix();
    return 0.5 * off.dot(precision_[place] * off);
  }

  const std::vector<PlacementReadings>& placements_;
  std::vector<std::size_t> channel_;        ///< By place.
  std::vector<Eigen::MatrixXd> precision_;  ///< By place: of the residuals over the placements, 1/mm².
};

}  // namespace

std::vector<ChannelSwap> FindSwappedChannels(const Scan& scan, SwapOptions options) {
  ENSURE(options.offset_sigma_mm > 0.0, "sensors are never perfect");
  const std::size_t sensors = scan.header.calibration.sensors.size();
  if (sensors < kFewestComparedSensors || scan.levels.empty()) return {};
  if (options.boards.empty()) options.boards = scan.header.machine.boards;
  ScanSearch search(scan, options.offset_sigma_mm);
  return FindAll(search, sensors, BoardsOf(sensors, options.boards));
}

std::vector<ChannelSwap> FindSwappedChannels(const std::vector<PlacementReadings>& placements,
                                             const SwapOptions& options, const PlacementTolerance& tolerance) {
  ENSURE(options.offset_sigma_mm > 0.0 && tolerance.reading_sigma_mm > 0.0, "sensors are never perfect");
  if (placements.empty()) return {};
  const std::size_t sensors = placements.front().seen_mm.size();
  for (const PlacementReadings& placement : placements) {
    const auto fits = [&](const std::vector<double>& slopes) { return slopes.empty() || slopes.size() == sensors; };
    ENSURE(placement.seen_mm.size() == sensors && placement.expected_mm.size() == sensors, "one entry per sensor");
    ENSURE(fits(placement.lateral_slope_mm) && fits(placement.vertical_slope_mm), "one slope per sensor, or none");
  }
  PlacementSearch search(placements, options.offset_sigma_mm, tolerance);
  return FindAll(search, sensors, BoardsOf(sensors, options.boards));
}

}  // namespace annulus
