#include "modeling/measure/estimate.h"

#include <cmath>

namespace annulus {

GradientSum::GradientSum(const SplineSurface& surface)
    : surface_(&surface),
      width_(surface.theta_basis().count()),
      dense_(Eigen::VectorXd::Zero(surface.coefficients().size())),
      touched_(surface.z_basis().count(), 0) {}

void GradientSum::AddRadius(double theta, double z, double weight) {
  if (weight != 0.0) AddRow(surface_->Row(theta, z), weight, 0.0, 0.0);
}

void GradientSum::AddRow(const RadiusRow& row, double by_r, double by_theta, double by_z) {
  for (std::size_t k = 0; k < row.index.size(); ++k) {
    dense_[static_cast<Eigen::Index>(row.index[k])] += by_r * row.value[k] + by_theta * row.theta[k] + by_z * row.z[k];
    touched_[row.index[k] / width_] = 1;
  }
}

void GradientSum::AddSection(const CubicBasis& at_z, const Eigen::VectorXd& by_value, const Eigen::VectorXd& by_slope) {
  const auto width = static_cast<Eigen::Index>(width_);
  for (std::size_t j = 0; j < 4; ++j) {
    dense_.segment(static_cast<Eigen::Index>(at_z.index[j]) * width, width) +=
        at_z.value[j] * by_value + at_z.first[j] * by_slope;
    touched_[at_z.index[j]] = 1;
  }
}

void GradientSum::Add(const Gradient& gradient, double factor) {
  for (Gradient::InnerIterator entry(gradient); entry; ++entry) {
    dense_[entry.index()] += factor * entry.value();
    touched_[static_cast<std::size_t>(entry.index()) / width_] = 1;
  }
}

Gradient GradientSum::Get() const {
  Gradient gradient(dense_.size());
  for (std::size_t j = 0; j < touched_.size(); ++j) {
    if (touched_[j] == 0) continue;
    for (std::size_t i = 0; i < width_; ++i) {
      const auto index = static_cast<Eigen::Index>(j * width_ + i);
      if (dense_[index] != 0.0) gradient.insertBack(index) = dense_[index];
    }
  }
  return gradient;
}

Estimate Combine(double factor_a, const Estimate& a, double factor_b, const Estimate& b) {
  Estimate sum{factor_a * a.value + factor_b * b.value,
               {},
               std::abs(factor_a) * a.unresolved + std::abs(factor_b) * b.unresolved};
  if (a.gradient.size() == 0 && b.gradient.size() == 0) return sum;
  if (a.gradient.size() == 0) {
    sum.gradient = factor_b * b.gradient;
  } else if (b.gradient.size() == 0) {
    sum.gradient = factor_a * a.gradient;
  } else {
    sum.gradient = factor_a * a.gradient + factor_b * b.gradient;
  }
  return sum;
}

}  // namespace annulus
