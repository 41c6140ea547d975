#include "fitting/ring_exchange.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr double kBin = 60.0;           // mm of height
constexpr double kFloor = 0.03;         // mm; what bins have in common beside noise
constexpr double kCap = 25.0;           // a bin counts no more than this many variances
constexpr double kMisfit = 1.6;         // mean of the capped squares from which a sensor does not fit its place
constexpr double kConvincing = 25.0;    // variances by which an exchange must be better
constexpr std::size_t kNeighbours = 2;  // so near, an exchange looks like turned beams: tried for all
constexpr std::size_t kFewestBins = 12;

/// Readings of one sensor in one placement and a few cm of height.
struct Slice {
  std::size_t placement = 0;
  std::vector<const TargetReading*> readings;
};

/// By sensor, without readings that are far from the rest of their slice.
std::vector<std::vector<Slice>> SlicesOf(const CalibrationSetup& setup) {
  constexpr double kWild = 8.0;  // mm: a slice of a tilted column is no thicker
  std::vector<std::vector<Slice>> slices(setup.start.sensors.size());
  for (std::size_t p = 0; p < setup.scans.size(); ++p) {
    if (setup.targets[setup.scans[p].target].kind != Kind::kCylinder) continue;
    std::map<std::pair<std::uint16_t, int>, std::vector<const TargetReading*>> by_height;
    for (const TargetReading& reading : setup.scans[p].readings) {
      const bool inside =
          reading.z_mm > setup.placements[p].z_low + kBin && reading.z_mm < setup.placements[p].z_high - kBin;
      if (reading.sensor >= slices.size() || !inside) continue;
      by_height[{reading.sensor, static_cast<int>(std::floor(reading.z_mm / kBin))}].push_back(&reading);
    }
    for (auto& [key, readings] : by_height) {
      if (readings.size() < 4) continue;
      const auto middle = readings.begin() + static_cast<std::ptrdiff_t>(readings.size() / 2);
      std::nth_element(readings.begin(), middle, readings.end(),
                       [](const TargetReading* a, const TargetReading* b) { return a->range_mm < b->range_mm; });
      const double range = (*middle)->range_mm;
      std::erase_if(readings, [&](const TargetReading* one) { return std::abs(one->range_mm - range) > kWild; });
      slices[key.first].push_back({p, readings});
    }
  }
  return slices;
}

/// Tries readings of one sensor in the place of another.
class PlaceTrial {
 public:
  PlaceTrial(const CalibrationSetup& setup, const CalibrationState& state, const PriorSigmas& priors)
      : setup_(setup), state_(state), priors_(priors), slices_(SlicesOf(setup)) {}

  /// Sum of capped squares of the residuals of `readings_of`'s bins at `place`, with the seven unknowns at their best.
  double Cost(std::size_t place, std::size_t readings_of) const {
    SensorUnknowns unknowns = place == readings_of ? state_.ring.sensors[place] : SensorUnknowns::Zero();
    const std::vector<Bin> bins = BinsAt(place, readings_of, unknowns);
    constexpr int kRounds = 5;
    double scale = 40.0;  // robust: residuals, in sds, beyond which bins count less; narrowed
    double cost = 0.0;
    BinRow row;
    for (int round = 0; round < kRounds; ++round) {
      Matrix7 normal = priors_.sensor.array().square().inverse().matrix().asDiagonal();
      SensorUnknowns right = -(normal * unknowns);
      cost = (unknowns.array() / priors_.sensor.array()).square().sum() +
             kCap * static_cast<double>(slices_[readings_of].size() - bins.size());
      for (const Bin& bin : bins) {
        if (!Evaluate(bin, unknowns, row)) {
          cost += kCap;
          continue;
        }
        const double square = row.residual * row.residual;
        cost += std::min(square, kCap);
        const double weight = 1.0 / (1.0 + square / (scale * scale));
        normal += weight * row.by_sensor.transpose() * row.by_sensor;
        right -= weight * row.residual * row.by_sensor.transpose();
      }
      const SensorUnknowns change = normal.ldlt().solve(right);
      unknowns += change;
      scale = std::max(4.0, 0.4 * scale);
    }
    return cost;
  }

  [[nodiscard]] std::size_t Bins(std::size_t sensor) const { return slices_[sensor].size(); }

 private:
  struct Bin {
    std::size_t placement;
    TargetBin bin;
  };

  bool Evaluate(const Bin& bin, const SensorUnknowns& unknowns, BinRow& row) const {
    const std::size_t knot = KnotAt(state_.ring.knots_z_mm, setup_.start.carriage.position_scale * bin.bin.z_mm).first;
    const BinUnknowns blocks{unknowns.data(),
                             state_.ring.ring.data(),
                             state_.poses[bin.placement].data(),
                             state_.forms[setup_.scans[bin.placement].target].data(),
                             state_.ring.path[knot].data(),
                             state_.ring.path[knot + 1].data()};
    return EvaluateBin(setup_, bin.placement, bin.bin, state_.ring.knots_z_mm, blocks, row);
  }

  /// The slices as bins at a place: what the target's curve does within a slice is taken out with that place's beam.
  std::vector<Bin> BinsAt(std::size_t place, std::size_t readings_of, const SensorUnknowns& unknowns) const {
    RingUnknowns corrections;
    corrections.sensors.assign(1, unknowns);
    corrections.ring = state_.ring.ring;
    RingCalibration alone = setup_.start;
    alone.sensors = {setup_.start.sensors[place]};
    alone = Corrected(alone, corrections);
    std::vector<Bin> bins;
    for (const Slice& slice : slices_[readings_of]) {
      const TargetForm form = FormOf(state_.forms[setup_.scans[slice.placement].target]);
      const TargetPose pose = PoseOf(state_.poses[slice.placement]);
      const CalibrationTarget& target = setup_.targets[setup_.scans[slice.placement].target];
      double weight = 0.0;
      double residual = 0.0;
      double height = 0.0;
      for (const TargetReading* reading : slice.readings) {
        const auto hit = MeetTarget(target, form, pose, alone.RayOf(0, reading->z_mm));
        if (!hit) continue;
        weight += reading->weight;
        residual += reading->weight * (alone.sensors[0].Distance(reading->range_mm) - hit->distance);
        height += reading->weight * reading->z_mm;
      }
      if (!(weight > 0.0)) continue;
      Bin bin;
      bin.placement = slice.placement;
      bin.bin.sensor = static_cast<std::uint16_t>(place);
      bin.bin.z_mm = height / weight;
      const auto hit = MeetTarget(target, form, pose, alone.RayOf(0, bin.bin.z_mm));
      if (!hit) continue;
      bin.bin.range_mm = alone.sensors[0].ReadingOf(hit->distance + residual / weight);
      const double variance = setup_.noise_mm * setup_.noise_mm / weight + kFloor * kFloor;
      bin.bin.weight = setup_.noise_mm * setup_.noise_mm / variance;
      if (std::isfinite(bin.bin.range_mm)) bins.push_back(bin);
    }
    return bins;
  }

  const CalibrationSetup& setup_;
  const CalibrationState& state_;
  const PriorSigmas& priors_;
  std::vector<std::vector<Slice>> slices_;
};

/// Costs of all sensors where they are, and which of them do not fit there.
struct OwnPlaces {
  std::vector<double> cost;
  std::set<std::size_t> misfits;
};

OwnPlaces TryOwnPlaces(const PlaceTrial& trial, std::size_t sensors) {
  OwnPlaces own;
  for (std::size_t i = 0; i < sensors; ++i) {
    own.cost.push_back(trial.Bins(i) < kFewestBins ? 0.0 : trial.Cost(i, i));
    if (own.cost[i] > kMisfit * static_cast<double>(trial.Bins(i))) own.misfits.insert(i);
  }
  return own;
}

/// Boards most of whose sensors are misfits, each against each.
void FindBoards(const PlaceTrial& trial, std::size_t board_size, OwnPlaces& own, std::vector<SensorExchange>& found) {
  std::map<std::size_t, std::size_t> by_board;
  for (const std::size_t sensor : own.misfits) ++by_board[sensor / board_size];
  for (auto a = by_board.begin(); a != by_board.end(); ++a) {
    for (auto b = std::next(a); b != by_board.end(); ++b) {
      if (2 * a->second < board_size || 2 * b->second < board_size) continue;
      double better = 0.0;
      for (std::size_t k = 0; k < board_size; ++k) {
        const std::size_t i = a->first * board_size + k;
        const std::size_t j = b->first * board_size + k;
        better += own.cost[i] + own.cost[j] - trial.Cost(i, j) - trial.Cost(j, i);
      }
      if (better < kConvincing * static_cast<double>(board_size)) continue;
      found.push_back({a->first * board_size, b->first * board_size, board_size, better});
      for (std::size_t k = 0; k < board_size; ++k) {
        for (const std::size_t board : {a->first, b->first}) {
          own.misfits.erase(board * board_size + k);
          own.cost[board * board_size + k] = 0.0;  // explained: no exchange makes it better
        }
      }
      a->second = b->second = 0;
    }
  }
}

}  // namespace

std::vector<SensorExchange> FindExchanges(const CalibrationSetup& setup, const CalibrationState& state,
                                          const PriorSigmas& priors, std::size_t board_size) {
  std::vector<SensorExchange> found;
  const std::size_t sensors = setup.start.sensors.size();
  const PlaceTrial trial(setup, state, priors);
  OwnPlaces own = TryOwnPlaces(trial, sensors);
  if (board_size > 1) FindBoards(trial, board_size, own, found);
  std::set<std::pair<std::size_t, std::size_t>> pairs;
  for (const std::size_t a : own.misfits) {
    for (const std::size_t b : own.misfits) {
      if (a < b) pairs.insert({a, b});
    }
  }
  for (std::size_t a = 0; a < sensors; ++a) {
    for (std::size_t step = 1; step <= kNeighbours; ++step) {
      const std::size_t b = a + step;
      if (b < sensors && (board_size < 2 || a / board_size == b / board_size)) pairs.insert({a, b});
    }
  }
  std::vector<SensorExchange> better;
  for (const auto& [a, b] : pairs) {
    if (own.cost[a] == 0.0 || own.cost[b] == 0.0) continue;
    const double evidence = own.cost[a] + own.cost[b] - trial.Cost(a, b) - trial.Cost(b, a);
    if (evidence > kConvincing) better.push_back({a, b, 1, evidence});
  }
  std::sort(better.begin(), better.end(),
            [](const SensorExchange& x, const SensorExchange& y) { return x.evidence > y.evidence; });
  std::vector<bool> named(sensors, false);
  for (const SensorExchange& pair : better) {
    if (named[pair.a] || named[pair.b]) continue;
    named[pair.a] = named[pair.b] = true;
    found.push_back(pair);
  }
  return found;
}

}  // namespace annulus
