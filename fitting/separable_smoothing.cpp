#include "fitting/separable_smoothing.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr double kNoBend = 1e-10;        // of the largest bend of an axis: a straight line, but for rounding
constexpr double kSmallestNoise = 1e-3;  // mm

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

SmoothingWeights ChooseSeparableSmoothing(const AxisModes& theta, const AxisModes& z, const GridData& data) {
  constexpr int kMaxIterations = 200;
  constexpr double kSettled = 0.005;  // of log weight
  constexpr double kRange = 1e8;
  const Eigen::ArrayXXd squares = (theta.shapes.transpose() * data.projected * z.shapes).array().square();
  const Eigen::Index height = z.bends.size();
  const Eigen::ArrayXd bend_u = theta.bends.array();
  const double unexplained = std::max(0.0, data.squares - squares.sum());
  const auto free_u = static_cast<double>((theta.bends.array() == 0.0).count());
  const auto free_v = static_cast<double>((z.bends.array() == 0.0).count());
  const double freedom = data.cells - free_u * free_v;

  SmoothingWeights weights;
  const double balanced_u = 1.0 / theta.bends.mean();
  const double balanced_v = 1.0 / z.bends.mean();
  weights.theta = balanced_u;
  weights.z = balanced_v;
  double last_step = 1.0;
  for (weights.iterations = 1; weights.iterations <= kMaxIterations; ++weights.iterations) {
    double bend_left_u = 0.0;  // Σ u/(p(1 + p)): how much the prior lets it bend beyond what the data fix
    double bend_left_v = 0.0;
    double bent_u = 0.0;  // Σ d²u/(1 + p)²: how much it bends
    double bent_v = 0.0;
    double misfit = unexplained;
    for (Eigen::Index j = 0; j < height; ++j) {
      const double v = weights.z * z.bends[j];
      const Eigen::ArrayXd u = weights.theta * bend_u;
      const Eigen::ArrayXd p = u + v;
      const Eigen::ArrayXd shrink = 1.0 / (1.0 + p);
      const Eigen::ArrayXd share = (p > 0.0).select(shrink / p.max(1e-300), 0.0);
      const Eigen::ArrayXd kept = squares.col(j) * shrink;
      bend_left_u += (u * share).sum();
      bend_left_v += v * share.sum();
      bent_u += (u * kept * shrink).sum();
      bent_v += v * (kept * shrink).sum();
      misfit += (kept * p).sum();
    }
    const double variance = std::max(misfit / freedom, kSmallestNoise * kSmallestNoise);
    const auto next = [&](double weight, double balanced, double allowed, double bent) {
      const double factor = bent > 0.0 ? variance * allowed / bent : kRange;
      return std::clamp(weight * factor, balanced / kRange, balanced * kRange);
    };
    const double theta_next = next(weights.theta, balanced_u, bend_left_u, bent_u);
    const double z_next = next(weights.z, balanced_v, bend_left_v, bent_v);
    const double step =
        std::max(std::abs(std::log(theta_next / weights.theta)), std::abs(std::log(z_next / weights.z)));
    weights.theta = theta_next;
    weights.z = z_next;
    // Steps shrink by a constant ratio: what is left of them is a geometric series.
    const double ratio = std::min(step / last_step, 0.95);
    last_step = step;
    if (step / (1.0 - ratio) < kSettled) break;
  }
  double effective = 0.0;
  double squares_left = unexplained;
  for (Eigen::Index j = 0; j < height; ++j) {
    const Eigen::ArrayXd shrink = 1.0 / (1.0 + weights.theta * bend_u + weights.z * z.bends[j]);
    effective += shrink.sum();
    squares_left += (squares.col(j) * (1.0 - shrink).square()).sum();
  }
  weights.effective_parameters = effective;
  weights.residual_sd = std::sqrt(squares_left / std::max(1.0, data.cells - effective));
  return weights;
}

}  // namespace annulus
