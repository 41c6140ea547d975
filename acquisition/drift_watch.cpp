#include "acquisition/drift_watch.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "acquisition/neighbour_prediction.h"
#include "acquisition/quality_grid.h"
#include "acquisition/ring_profile.h"

namespace annulus {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kNormal = 1.4826;        // sd of a normal distribution over its median magnitude
constexpr double kMeanOverMedian = 1.18;  // of a normal distribution's magnitudes
constexpr std::size_t kFewestLevels = 20;

/// Predicted less seen radius, of all levels and columns, and how much each is worth.
struct ResidualField {
  std::size_t columns = 0;
  std::vector<float> value;                              ///< Level by level, mm; NaN: not compared.
  std::vector<float> weight;                             ///< 0 … 1.
  double median_mm = 0.0;                                ///< Of the magnitudes.
  std::vector<std::array<double, kNeighbours>> stencil;  ///< By column: mean weights of the neighbours.
};

ResidualField ResidualsOf(const RingProfile& profile) {
  ResidualField field;
  field.columns = profile.columns();
  field.value.assign(profile.levels().size() * field.columns, kNone);
  field.stencil.resize(field.columns);
  std::vector<float> magnitudes;
  for (std::size_t column = 0; column < field.columns; ++column) {
    const ColumnWindow window = WindowAt(profile, column);
    double compared = 0.0;
    for (std::size_t level = 0; level < profile.levels().size(); ++level) {
      const auto residual = window.At(level);
      if (!residual) continue;
      field.value[level * field.columns + column] = static_cast<float>(-residual->value);
      for (std::size_t k = 0; k < kNeighbours; ++k) field.stencil[column][k] += residual->stencil.weight[k];
      ++compared;
      magnitudes.push_back(static_cast<float>(std::abs(residual->value)));
    }
    for (double& weight : field.stencil[column]) weight /= std::max(compared, 1.0);
  }
  field.median_mm = magnitudes.empty() ? 0.0 : MedianOf(magnitudes);
  return field;
}

/// Sums of capped magnitudes over levels from -3 to 3, by level and column; what is missing counts as the cap.
std::vector<float> SumsOverLevels(const ResidualField& field) {
  constexpr float kCap = 9.0F;  // mm
  constexpr std::size_t kHalf = 3;
  const std::size_t n = field.columns;
  const std::size_t levels = field.value.size() / n;
  std::vector<float> sums(field.value.size(), 0.0F);
  for (std::size_t level = 0; level < levels; ++level) {
    const std::size_t from = level > kHalf ? level - kHalf : 0;
    const std::size_t to = std::min(levels, level + kHalf + 1);
    for (std::size_t k = from; k < to; ++k) {
      for (std::size_t c = 0; c < n; ++c) {
        const float value = field.value[k * n + c];
        sums[level * n + c] += std::isnan(value) ? kCap : std::min(std::abs(value), kCap);
      }
    }
    for (std::size_t c = 0; c < n; ++c) sums[level * n + c] /= static_cast<float>(to - from);
  }
  return sums;
}

/// Where the neighbourhood (four columns to either side, three levels up and down; not the column itself, so that a
/// sensor's own error does not count against it) is rougher than twice what is usual, a level counts less.
void WeighByRoughness(ResidualField& field) {
  constexpr std::size_t kSide = 4;
  const std::vector<float> sums = SumsOverLevels(field);
  const double usual = 2.0 * kMeanOverMedian * std::max(field.median_mm, 1e-6);
  const std::size_t n = field.columns;
  field.weight.assign(field.value.size(), 0.0F);
  for (std::size_t at = 0; at < field.value.size(); ++at) {
    if (std::isnan(field.value[at])) continue;
    const std::size_t row = at / n * n;
    double rough = 0.0;
    for (std::size_t k = 1; k <= kSide; ++k) {
      rough += sums[row + (at - row + k) % n] + sums[row + (at - row + n - k) % n];
    }
    const double excess = std::max(1.0, rough / (2.0 * kSide) / usual);
    field.weight[at] = static_cast<float>(std::pow(excess, -4));
  }
}

/// One comparison of a sensor.
struct Compared {
  double value = 0.0;
  double weight = 0.0;
  double z = 0.0;
  double time_s = 0.0;
};

std::vector<Compared> ColumnOf(const ResidualField& field, const RingProfile& profile, std::size_t column) {
  std::vector<Compared> cells;
  for (std::size_t level = 0; level < profile.levels().size(); ++level) {
    const std::size_t at = level * field.columns + column;
    if (std::isnan(field.value[at])) continue;
    const RingProfile::Level& where = profile.levels()[level];
    constexpr float kWeakest = 0.05F;
    const double signal = std::max(profile.Column(column).signal[level], kWeakest);
    cells.push_back({field.value[at], signal * field.weight[at], where.z, where.time_s});
  }
  return cells;
}

/// Tukey's biweight around the median; multiplies the weights by it.
double RobustMean(std::vector<Compared>& cells) {
  constexpr double kCut = 4.685;
  constexpr int kRounds = 20;
  std::vector<double> values;
  for (const Compared& cell : cells) values.push_back(cell.value);
  double mean = MedianOf(values);
  for (double& value : values) value = std::abs(value - mean);
  const double scale = kCut * std::max(kNormal * MedianOf(values), 0.02);
  const auto trust = [&](const Compared& cell) {
    const double share = (cell.value - mean) / scale;
    return std::abs(share) < 1.0 ? cell.weight * (1.0 - share * share) * (1.0 - share * share) : 0.0;
  };
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    double weights = 0.0;
    for (const Compared& cell : cells) {
      sum += trust(cell) * cell.value;
      weights += trust(cell);
    }
    if (!(weights > 0.0)) break;
    mean = sum / weights;
  }
  for (Compared& cell : cells) cell.weight = trust(cell);
  return mean;
}

/// Weighted sums of the comparisons that lie in one range of heights.
struct Bin {
  double weight = 0.0, value = 0.0, time = 0.0, time2 = 0.0, time_value = 0.0;
};
using Bins = std::map<long, Bin>;

Bins BinsOf(const std::vector<Compared>& cells, double height_mm) {
  Bins bins;
  for (const Compared& cell : cells) {
    if (!(cell.weight > 0.0)) continue;
    Bin& bin = bins[std::lround(std::floor(cell.z / height_mm))];
    bin.weight += cell.weight;
    bin.value += cell.weight * cell.value;
    bin.time += cell.weight * cell.time_s;
    bin.time2 += cell.weight * cell.time_s * cell.time_s;
    bin.time_value += cell.weight * cell.time_s * cell.value;
  }
  return bins;
}

/// sd of a weighted mean from the scatter of its means over 50 mm of height, and at least what single levels say.
double SigmaOfMean(const std::vector<Compared>& cells, double mean) {
  constexpr double kDetailMm = 50.0;
  constexpr double kFewestBins = 4.0;
  double weights = 0.0;
  double scatter = 0.0;
  double single = 0.0;
  double weights2 = 0.0;
  for (const auto& [key, bin] : BinsOf(cells, kDetailMm)) {
    const double off = bin.value - mean * bin.weight;
    weights += bin.weight;
    weights2 += bin.weight * bin.weight;
    scatter += off * off;
  }
  for (const Compared& cell : cells) single += std::pow(cell.weight * (cell.value - mean), 2);
  if (!(weights > 0.0)) return std::numeric_limits<double>::infinity();
  const double bins = weights * weights / weights2;  // as many as count
  if (bins < kFewestBins) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(scatter * bins / (bins - 1.0), single)) / weights;
}

/// The slope over time, with a level of its own for every height; and its sd.
void AddTrend(const std::vector<Compared>& cells, double height_mm, SensorDrift& drift) {
  const Bins bins = BinsOf(cells, height_mm);
  double spread = 0.0;
  double together = 0.0;
  for (const auto& [key, bin] : bins) {
    spread += bin.time2 - bin.time * bin.time / bin.weight;
    together += bin.time_value - bin.time * bin.value / bin.weight;
  }
  constexpr double kLeastSpread = 50.0;  // s²; levels of one sweep in one bin are no comparison
  if (!(spread > kLeastSpread)) return;
  const double slope = together / spread;
  std::map<long, double> pulls;
  for (const Compared& cell : cells) {
    if (!(cell.weight > 0.0)) continue;
    const long key = std::lround(std::floor(cell.z / height_mm));
    const Bin& bin = bins.at(key);
    const double time = cell.time_s - bin.time / bin.weight;
    const double rest = cell.value - bin.value / bin.weight - slope * time;
    pulls[key] += cell.weight * time * rest;
  }
  double variance = 0.0;
  for (const auto& [key, pull] : pulls) variance += pull * pull;
  // A level of its own for every height takes degrees of freedom away.
  const double kept =
      1.0 - static_cast<double>(bins.size() + 1) / static_cast<double>(std::max(cells.size(), bins.size() + 2));
  drift.trend_mm_s = slope;
  drift.trend_sigma_mm_s = std::sqrt(variance / kept) / spread;
}

/// The usual distance between levels of a sweep: heights that are compared with each other.
double HeightBin(const RingProfile& profile) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < profile.levels().size(); ++k) {
    if (profile.levels()[k].sweep == profile.levels()[k - 1].sweep) {
      steps.push_back(std::abs(profile.levels()[k].z - profile.levels()[k - 1].z));
    }
  }
  return std::max(1.0, steps.empty() ? 1.0 : MedianOf(steps));
}

}  // namespace

bool SensorDrift::known() const { return std::isfinite(offset_mm) && std::isfinite(sigma_mm); }

DriftEstimate EstimateDrift(const Scan& scan) {
  DriftEstimate estimate;
  estimate.scan_hash = ScanHash(scan);
  estimate.calibration = scan.header.calibration.certificate;
  estimate.ring_serial = scan.header.calibration.ring_serial;
  estimate.wall_start_ns = scan.header.wall_start_ns;
  estimate.sensors.resize(scan.header.calibration.sensors.size());
  if (estimate.sensors.size() < kFewestComparedSensors || scan.levels.empty()) return estimate;
  const RingProfile profile(scan);
  estimate.duration_s = profile.levels().back().time_s;
  ResidualField field = ResidualsOf(profile);
  estimate.residual_mm = field.median_mm;
  WeighByRoughness(field);
  const double height_mm = HeightBin(profile);
  for (std::size_t column = 0; column < profile.columns(); ++column) {
    std::vector<Compared> cells = ColumnOf(field, profile, column);
    SensorDrift& drift = estimate.sensors[profile.SensorOf(column)];
    drift.levels = static_cast<std::uint32_t>(cells.size());
    if (cells.size() < kFewestLevels) continue;
    const double mean = RobustMean(cells);
    const double sigma = SigmaOfMean(cells, mean);
    if (!std::isfinite(sigma)) continue;
    drift.offset_mm = mean;
    drift.sigma_mm = sigma;
    std::transform(field.stencil[column].begin(), field.stencil[column].end(), drift.neighbour_weight.begin(),
                   [](double weight) { return static_cast<float>(weight); });
    AddTrend(cells, height_mm, drift);
  }
  return estimate;
}

}  // namespace annulus
