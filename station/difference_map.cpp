#include "station/difference_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "modeling/measure/systematic.h"
#include "station/compare.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kColumns = 36;

/// One of the two sides.
struct Side {
  const SurfaceModel& model;
  const MeasuredSurface& body;

  [[nodiscard]] Knowledge At(double theta, double z) const {
    if (z < body.surface().z_min() || z > body.surface().z_max()) return Knowledge::kUnknown;
    return body.KnowledgeAt(theta, z);
  }
  /// Variance of the radius at a place.
  [[nodiscard]] double Variance(double theta, double z, RingErrors ring) const {
    const double own = body.RadiusSigma(theta, z);
    double variance = own * own;
    if (body.systematic() == nullptr) return variance;
    GradientSum gradient(body.surface());
    gradient.AddRadius(theta, z, 1.0);
    const SystematicSigmas more = SigmasFrom(*body.systematic(), body, {0.0, gradient.Get()});
    variance += more.sway * more.sway;
    if (ring == RingErrors::kIndependent) variance += more.calibration * more.calibration;
    return variance;
  }
};

/// sds of the difference at the middles of cells, and how large |difference| / sd must be.
struct Significance {
  double z_min = 0.0;
  double height = 10.0;   ///< Of a cell, mm.
  Eigen::MatrixXd sigma;  ///< Row by row from the bottom; nan where not known. Empty: nothing is tested.
  double limit = std::numeric_limits<double>::infinity();
  std::size_t tested = 0;
  std::size_t significant = 0;

  /// Linear between the middles; that of the nearest where a neighbour is not known.
  [[nodiscard]] double SigmaAt(double theta, double z) const {
    const double across = theta / kTwoPi * static_cast<double>(kColumns);
    const double up = std::clamp((z - z_min) / height - 0.5, 0.0, static_cast<double>(sigma.rows() - 1));
    const auto column = static_cast<Eigen::Index>(std::floor(across)) % kColumns;
    const auto row = std::min<Eigen::Index>(static_cast<Eigen::Index>(up), std::max<Eigen::Index>(0, sigma.rows() - 2));
    const Eigen::Index next = (column + 1) % kColumns;
    const Eigen::Index above = std::min<Eigen::Index>(row + 1, sigma.rows() - 1);
    const double right = across - std::floor(across);
    const double rise = up - static_cast<double>(row);
    const double linear = (1.0 - rise) * ((1.0 - right) * sigma(row, column) + right * sigma(row, next)) +
                          rise * ((1.0 - right) * sigma(above, column) + right * sigma(above, next));
    return std::isnan(linear) ? sigma(rise < 0.5 ? row : above, right < 0.5 ? column : next) : linear;
  }
};

Significance TestCells(const Side& before, const Side& after) {
  Significance test;
  if (before.body.segment().normal_matrix.nonZeros() == 0 || after.body.segment().normal_matrix.nonZeros() == 0) {
    return test;
  }
  const RingErrors ring = RingErrorsOf(before.model.provenance, after.model.provenance);
  test.z_min = before.body.surface().z_min();
  const double tall = before.body.surface().z_max() - test.z_min;
  test.height = tall > 600.0 ? 20.0 : 10.0;
  const auto rows = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::ceil(tall / test.height)));
  test.sigma = Eigen::MatrixXd::Constant(rows, kColumns, kNan);
  std::vector<double> p_values;
  std::vector<double> ratios;
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double z = test.z_min + (static_cast<double>(row) + 0.5) * test.height;
    for (Eigen::Index column = 0; column < kColumns; ++column) {
      const double theta = kTwoPi * static_cast<double>(column) / static_cast<double>(kColumns);
      if (before.At(theta, z) == Knowledge::kUnknown || after.At(theta, z) == Knowledge::kUnknown) continue;
      const double sigma = std::sqrt(before.Variance(theta, z, ring) + after.Variance(theta, z, ring));
      if (!std::isfinite(sigma)) continue;
      test.sigma(row, column) = sigma;
      const double apart = std::abs(after.body.surface().Radius(theta, z) - before.body.surface().Radius(theta, z));
      ratios.push_back(apart == 0.0 ? 0.0 : apart / sigma);
      p_values.push_back(std::erfc(ratios.back() / std::sqrt(2.0)));
    }
  }
  const std::vector<double> corrected = HolmCorrected(p_values);
  test.tested = p_values.size();
  for (std::size_t k = 0; k < corrected.size(); ++k) {
    if (!(corrected[k] < kComparisonLevel)) continue;
    ++test.significant;
    test.limit = std::min(test.limit, ratios[k]);
  }
  return test;
}

}  // namespace

BodyField DifferenceField(const SurfaceModel& model_before, const MeasuredSurface& before,
                          const SurfaceModel& model_after, const MeasuredSurface& after) {
  const Side a{model_before, before};
  const Side b{model_after, after};
  const auto test = std::make_shared<const Significance>(TestCells(a, b));
  BodyField field;
  field.title = "Difference of two models";
  field.unit = "mm";
  field.definition =
      "Distance from the first model to the second along the normal, by the radii at equal theta and height; positive: "
      "the second lies outside. The models are not aligned to each other.";
  field.hatch_label = "inferred in one of them";
  if (test->tested > 0) {
    field.definition += fmt::format(
        " {} of {} cells of 10° × {:.0f} mm differ significantly (5 % over all, Holm; ring's errors {}).",
        test->significant, test->tested, test->height,
        RingErrorsOf(model_before.provenance, model_after.provenance) == RingErrors::kCommon ? "common: they cancel"
                                                                                             : "counted for both");
    field.hatch_label = "not significant";
  }
  field.value = [&before, &after, a, b](const BodyPlace& place) {
    if (place.segment != 0 || a.At(place.theta, place.z) == Knowledge::kUnknown ||
        b.At(place.theta, place.z) == Knowledge::kUnknown) {
      return kNan;
    }
    const RadiusJet jet = before.surface().Jet(place.theta, place.z);
    const double slope = jet.r > 1e-9 ? jet.r_theta / jet.r : 0.0;
    const double cosine = 1.0 / std::sqrt(1.0 + slope * slope + jet.r_z * jet.r_z);
    return cosine * (after.surface().Radius(place.theta, place.z) - jet.r);
  };
  field.hatched = [&before, &after, a, b, test](const BodyPlace& place) {
    if (place.segment != 0) return false;
    if (test->tested == 0) {
      return a.At(place.theta, place.z) == Knowledge::kInferred || b.At(place.theta, place.z) == Knowledge::kInferred;
    }
    const double apart =
        std::abs(after.surface().Radius(place.theta, place.z) - before.surface().Radius(place.theta, place.z));
    constexpr double kRounding = 1.0 - 1e-9;
    return !(apart / test->SigmaAt(WrapAngle(place.theta), place.z) >= kRounding * test->limit);
  };
  return field;
}

}  // namespace annulus
