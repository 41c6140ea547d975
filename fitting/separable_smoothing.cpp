#include "fitting/separable_smoothing.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr double kNoBend = 1e-10;  // of the largest bend of an axis: a straight line, but for rounding

/// Forms over the even (sign +1) or odd (−1) functions of a mirrored axis.
AxisForms Folded(const AxisForms& forms, double sign) {
  const Eigen::Index n = forms.gram.rows();
  const Eigen::Index count = sign > 0.0 ? (n + 1) / 2 : n / 2;
  // Unit vectors (e_k ± e_{n−1−k})/√2, or the middle e_k alone.
  const auto scale = [&](Eigen::Index k) { return 2 * k == n - 1 ? 0.5 : std::sqrt(0.5); };
  const auto fold = [&](const Eigen::MatrixXd& m) {
    Eigen::MatrixXd folded(count, count);
    for (Eigen::Index b = 0; b < count; ++b) {
      for (Eigen::Index a = 0; a < count; ++a) {
        folded(a, b) =
            scale(a) * scale(b) * (m(a, b) + m(n - 1 - a, n - 1 - b) + sign * (m(a, n - 1 - b) + m(n - 1 - a, b)));
      }
    }
    return folded;
  };
  return {fold(forms.gram), fold(forms.bend)};
}

/// Takes what rounding left of the bends that are zero.
void CleanBends(AxisModes& modes) {
  const double largest = modes.bends.maxCoeff();
  modes.bends = (modes.bends.array() > kNoBend * largest).select(modes.bends, 0.0);
}

AxisModes RawModes(const AxisForms& forms) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(forms.bend, forms.gram);
  ENSURE(solver.info() == Eigen::Success, "the grid determines the basis");
  return {solver.eigenvectors(), solver.eigenvalues()};
}

}  // namespace

AxisModes FindModes(const AxisForms& forms) {
  AxisModes modes = RawModes(forms);
  CleanBends(modes);
  return modes;
}

AxisModes FindMirroredModes(const AxisForms& forms) {
  const Eigen::Index n = forms.gram.rows();
  AxisModes modes{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd(n)};
  Eigen::Index first = 0;
  for (const double sign : {1.0, -1.0}) {
    const AxisModes half = RawModes(Folded(forms, sign));
    const Eigen::Index count = half.bends.size();
    modes.bends.segment(first, count) = half.bends;
    for (Eigen::Index k = 0; k < count; ++k) {
      if (2 * k == n - 1) {
        modes.shapes.row(k).segment(first, count) = half.shapes.row(k);
        continue;
      }
      modes.shapes.row(k).segment(first, count) = std::sqrt(0.5) * half.shapes.row(k);
      modes.shapes.row(n - 1 - k).segment(first, count) = sign * std::sqrt(0.5) * half.shapes.row(k);
    }
    first += count;
  }
  CleanBends(modes);
  return modes;
}

namespace {

/// The score as a function of the logarithms of both weights over their balance.
class CrossValidation {
 public:
  CrossValidation(const AxisModes& theta, const AxisModes& z, const GridData& data)
      : bends_u_(theta.bends.array() / theta.bends.mean()),
        bends_v_(z.bends.array() / z.bends.mean()),
        squares_((theta.shapes.transpose() * data.projected * z.shapes).array().square()),
        unexplained_(std::max(0.0, data.squares - squares_.sum())),
        cells_(data.cells) {}

  struct Sums {
    double squares = 0.0;          ///< RSS, mm²
    double trace = 0.0;            ///< Of H.
    double trace_of_square = 0.0;  ///< Of HHᵀ.
  };
  [[nodiscard]] Sums At(double log_u, double log_v) const {
    Sums sums{unexplained_, 0.0, 0.0};
    const Eigen::ArrayXd u = 1.0 + std::exp(log_u) * bends_u_;
    const double weight_v = std::exp(log_v);
    Eigen::ArrayXd kept(u.size());
    for (Eigen::Index j = 0; j < bends_v_.size(); ++j) {
      kept = 1.0 / (u + weight_v * bends_v_[j]);
      sums.squares += (squares_.col(j) * (1.0 - kept).square()).sum();
      sums.trace += kept.sum();
      sums.trace_of_square += kept.square().sum();
    }
    return sums;
  }
  [[nodiscard]] double Score(double log_u, double log_v) const {
    const Sums sums = At(log_u, log_v);
    const double freedom = cells_ - sums.trace;
    return freedom > 0.0 ? sums.squares / (freedom * freedom) : std::numeric_limits<double>::infinity();
  }

 private:
  Eigen::ArrayXd bends_u_;
  Eigen::ArrayXd bends_v_;
  Eigen::ArrayXXd squares_;
  double unexplained_;
  double cells_;
};

}  // namespace

SmoothingWeights ChooseSeparableSmoothing(const AxisModes& theta, const AxisModes& z, const GridData& data) {
  constexpr double kFirstStep = 2.0;
  constexpr double kLastStep = 0.06;
  const double range = std::log(1e8);
  const CrossValidation validation(theta, z, data);
  double log_u = 0.0;
  double log_v = 0.0;
  double best = validation.Score(log_u, log_v);
  SmoothingWeights weights;
  weights.scores = 1;
  std::array<double, 2> heading{1.0, 0.0};
  for (double step = kFirstStep; step >= kLastStep;) {
    bool moved = false;
    for (int turn = 0; turn < 4 && !moved; ++turn) {
      const double u = std::clamp(log_u + step * heading[0], -range, range);
      const double v = std::clamp(log_v + step * heading[1], -range, range);
      const double score = validation.Score(u, v);
      ++weights.scores;
      moved = score < best;
      if (moved) {
        best = score;
        log_u = u;
        log_v = v;
      } else {
        heading = {-heading[1], heading[0]};
      }
    }
    if (!moved) step *= 0.5;
  }
  const CrossValidation::Sums sums = validation.At(log_u, log_v);
  weights.theta = std::exp(log_u) / theta.bends.mean();
  weights.z = std::exp(log_v) / z.bends.mean();
  weights.effective_parameters = sums.trace;
  weights.residual_parameters = 2.0 * sums.trace - sums.trace_of_square;
  weights.residual_sd = std::sqrt(sums.squares / std::max(1.0, data.cells - weights.residual_parameters));
  return weights;
}

}  // namespace annulus
