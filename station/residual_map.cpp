#include "station/residual_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "station/fit_scan.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kReturnsPerCell = 4.0;
constexpr double kLeastHeight = 2.0;  // mm

/// A return that belongs to a segment.
struct OwnedResidual {
  std::size_t segment = 0;
  double theta = 0.0;
  double z = 0.0;
  double residual = 0.0;
};

/// How large the cells of a segment are.
struct CellSize {
  Eigen::Index columns = 180;
  double height = kLeastHeight;  ///< mm
};

/// Means over the cells of one segment.
class ResidualCells {
 public:
  ResidualCells(const SplineSurface& surface, const CellSize& size)
      : z_min_(surface.z_min()),
        height_(size.height),
        columns_(size.columns),
        rows_(std::max<Eigen::Index>(1, std::lround(std::ceil((surface.z_max() - z_min_) / size.height)))) {
    sum_.setZero(rows_, columns_);
    count_.setZero(rows_, columns_);
  }

  void Add(const OwnedResidual& one) {
    const Eigen::Index column = std::lround(one.theta / kTwoPi * static_cast<double>(columns_)) % columns_;
    const auto row = std::clamp<Eigen::Index>(static_cast<Eigen::Index>((one.z - z_min_) / height_), 0, rows_ - 1);
    sum_(row, column) += one.residual;
    count_(row, column) += 1.0;
  }

  /// Linear between the middles of the cells around that hold returns; nan where less than a quarter of the weight
  /// does.
  [[nodiscard]] double At(double theta, double z) const {
    const double across = theta / kTwoPi * static_cast<double>(columns_);
    const double up = (z - z_min_) / height_ - 0.5;
    const double column = std::floor(across);
    const double row = std::floor(up);
    double sum = 0.0;
    double weight = 0.0;
    for (int v = 0; v < 2; ++v) {
      for (int u = 0; u < 2; ++u) {
        const auto i = (static_cast<Eigen::Index>(column) + u + columns_) % columns_;
        const auto j = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(row) + v, 0, rows_ - 1);
        if (count_(j, i) < 1.0) continue;
        const double share =
            (u == 0 ? 1.0 - (across - column) : across - column) * (v == 0 ? 1.0 - (up - row) : up - row);
        sum += share * sum_(j, i) / count_(j, i);
        weight += share;
      }
    }
    return weight >= 0.25 ? sum / weight : kNan;
  }

 private:
  double z_min_;
  double height_;
  Eigen::Index columns_;
  Eigen::Index rows_;
  Eigen::MatrixXd sum_;
  Eigen::MatrixXd count_;
};

/// The size at which a cell holds kReturnsPerCell in the mean and is as wide as it is tall, or nearly so.
CellSize SizeFor(const std::vector<OwnedResidual>& owned, std::size_t segment, const SplineSurface& surface) {
  double count = 0.0;
  double z_low = surface.z_max();
  double z_high = surface.z_min();
  double radius = 0.0;
  for (const OwnedResidual& one : owned) {
    if (one.segment != segment) continue;
    count += 1.0;
    z_low = std::min(z_low, one.z);
    z_high = std::max(z_high, one.z);
    radius += surface.Radius(one.theta, one.z);
  }
  CellSize best;
  if (count < 1.0) return best;
  radius /= count;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Index columns : {180, 120, 90, 60, 36}) {
    const double per_mm = count / std::max(z_high - z_low, 1.0) / static_cast<double>(columns);
    const double height = std::max(kLeastHeight, std::ceil(kReturnsPerCell / per_mm));
    const double apart = std::abs(std::log(kTwoPi * radius / static_cast<double>(columns) / height));
    if (apart < least) {
      least = apart;
      best = {columns, height};
    }
  }
  return best;
}

/// The returns that lie on a segment.
std::vector<OwnedResidual> Owned(const SurfaceModel& model, const std::vector<SurfaceSample>& samples) {
  std::vector<OwnedResidual> owned;
  for (const SurfaceSample& sample : samples) {
    if (!(sample.weight > 0.0F)) continue;
    OwnedResidual best;
    double nearest = kResidualReach;
    for (std::size_t k = 0; k < model.segments.size(); ++k) {
      const SurfaceSegment& segment = model.segments[k];
      if (sample.z < segment.surface.z_min() || sample.z > segment.surface.z_max()) continue;
      const SampleResidual at = ResidualOf(sample, segment);
      if (segment.knowledge.rows() > 0 && segment.knowledge.At(at.theta, sample.z) == Knowledge::kUnknown) continue;
      if (!(std::abs(at.residual) < nearest)) continue;
      nearest = std::abs(at.residual);
      best = {k, at.theta, sample.z, at.residual};
    }
    if (nearest < kResidualReach) owned.push_back(best);
  }
  return owned;
}

}  // namespace

std::vector<SurfaceSample> FittedSamples(const std::vector<Scan>& scans) {
  std::vector<SurfaceSample> samples;
  for (const Scan& scan : scans) {
    const SwayEstimate sway = SwayOf(scan);
    samples.insert(samples.end(), sway.corrected.begin(), sway.corrected.end());
  }
  return samples;
}

Result<BodyField> ResidualField(const SurfaceModel& model, const std::vector<SurfaceSample>& samples) {
  const std::vector<OwnedResidual> owned = Owned(model, samples);
  if (owned.empty()) {
    return Fail("draw the residuals", "no return of the scan lies on the surface of the model",
                "give the scan that the model was fitted to");
  }
  double squares = 0.0;
  for (const OwnedResidual& one : owned) squares += one.residual * one.residual;
  auto cells = std::make_shared<std::vector<ResidualCells>>();
  for (std::size_t k = 0; k < model.segments.size(); ++k) {
    cells->emplace_back(model.segments[k].surface, SizeFor(owned, k, model.segments[k].surface));
  }
  const CellSize main = SizeFor(owned, 0, model.main().surface);
  for (const OwnedResidual& one : owned) (*cells)[one.segment].Add(one);
  BodyField field;
  field.title = "Residuals: returns minus surface";
  field.unit = "mm";
  field.definition = fmt::format(
      "Means over cells of {}° × {:.0f} mm, linear in between; {} of {} returns, their rms {:.2f} mm. Positive: the "
      "scan "
      "saw the skin farther out than the surface.",
      360 / main.columns, main.height, owned.size(), samples.size(),
      std::sqrt(squares / static_cast<double>(owned.size())));
  field.value = [cells](const BodyPlace& place) { return (*cells)[place.segment].At(WrapAngle(place.theta), place.z); };
  field.hatched = [&model](const BodyPlace& place) {
    return model.segments[place.segment].knowledge.At(place.theta, place.z) == Knowledge::kInferred;
  };
  field.hatch_label = "inferred";
  return field;
}

}  // namespace annulus
