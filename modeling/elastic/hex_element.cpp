#include "modeling/elastic/hex_element.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kModes = 12;
using Modes = Eigen::Matrix<double, 6, kModes>;
using Gradients = Eigen::Matrix<double, 3, 8>;
using ModeCoupling = Eigen::Matrix<double, 24, kModes>;
using ModeMatrix = Eigen::Matrix<double, kModes, kModes>;

double Side(int corner, int axis) { return (corner >> axis) % 2 == 1 ? 1.0 : -1.0; }

/// ∂N_a/∂ξ of the trilinear shape functions.
Gradients ParentGradients(const Vector3d& xi) {
  Gradients gradient;
  for (int a = 0; a < 8; ++a) {
    const Vector3d side(Side(a, 0), Side(a, 1), Side(a, 2));
    const Vector3d factor = (1.0 + side.array() * xi.array()).matrix();
    gradient(0, a) = 0.125 * side.x() * factor.y() * factor.z();
    gradient(1, a) = 0.125 * side.y() * factor.x() * factor.z();
    gradient(2, a) = 0.125 * side.z() * factor.x() * factor.y();
  }
  return gradient;
}

/// One Gauss point of the parent cube.
struct GaussPoint {
  Vector3d xi;
  Gradients gradient;
};

const std::array<GaussPoint, 8>& GaussPoints() {
  static const std::array<GaussPoint, 8> points = [] {
    std::array<GaussPoint, 8> made;
    for (int q = 0; q < 8; ++q) {
      GaussPoint& point = made[static_cast<std::size_t>(q)];
      point.xi = Vector3d(Side(q, 0), Side(q, 1), Side(q, 2)) / std::sqrt(3.0);
      point.gradient = ParentGradients(point.xi);
    }
    return made;
  }();
  return points;
}

/// Geometry at the middle, which carries the enhanced strains.
struct Middle {
  Matrix3d inverse;  ///< ∂ξ/∂x
  double determinant = 0.0;
};

Middle MiddleOf(const HexCorners& corners) {
  const Matrix3d jacobian = ParentGradients(Vector3d::Zero()) * corners.transpose();  // (row ξ, column x)
  return {jacobian.inverse(), jacobian.determinant()};
}

/// The tensor sym(a bᵀ) in Voigt's order with engineering shears.
Voigt SymmetricProduct(const Vector3d& a, const Vector3d& b) {
  Voigt v;
  v << a.x() * b.x(), a.y() * b.y(), a.z() * b.z(), a.x() * b.y() + a.y() * b.x(), a.y() * b.z() + a.z() * b.y(),
      a.z() * b.x() + a.x() * b.z();
  return v;
}

/// The twelve strains at a point but for their linear and bilinear factors: those of the parent cube's axes (Simo,
/// Rifai: J0⁻ᵀ E J0⁻¹ j0/j), which integrate to zero over the element.
struct ModeShapes {
  std::array<Voigt, 6> axes;  ///< 11, 22, 33, 12, 23, 31

  explicit ModeShapes(const Middle& middle) {
    const auto axis = [&](int k) -> Vector3d { return middle.inverse.col(k); };
    for (int k = 0; k < 3; ++k) {
      axes[static_cast<std::size_t>(k)] = SymmetricProduct(axis(k), axis(k));
      axes[static_cast<std::size_t>(3 + k)] = SymmetricProduct(axis(k), axis((k + 1) % 3));
    }
  }

  [[nodiscard]] Modes At(const Vector3d& xi, double scale) const {
    Modes modes;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      modes.col(k) = scale * xi[k] * axes[static_cast<std::size_t>(k)];
      modes.col(3 + 2 * k) = scale * xi[k] * axes[static_cast<std::size_t>(3 + k)];
      modes.col(4 + 2 * k) = scale * xi[next] * axes[static_cast<std::size_t>(3 + k)];
      modes.col(9 + k) << Vector3d::Constant(scale * xi[k] * xi[next]), Vector3d::Zero();
    }
    return modes;
  }
};

/// Everything that is summed over the Gauss points.
struct ElementSums {
  std::array<Matrix3d, 36> outer;  ///< ∫ ∇N_a ∇N_bᵀ for a <= b, at b(b + 1)/2 + a.
  ModeCoupling coupling = ModeCoupling::Zero();
  ModeMatrix modes = ModeMatrix::Zero();
};

/// Bᵀ σ for every corner: rows of the coupling.
void AddCoupling(const Gradients& gradient, const Modes& stress, double weight, ModeCoupling& coupling) {
  for (int m = 0; m < kModes; ++m) {
    Matrix3d tensor;
    tensor << stress(0, m), stress(3, m), stress(5, m), stress(3, m), stress(1, m), stress(4, m), stress(5, m),
        stress(4, m), stress(2, m);
    Eigen::Map<Gradients>(coupling.col(m).data()).noalias() += (weight * tensor) * gradient;
  }
}

/// D·M, column by column.
Modes StressesOf(const Modes& strain, const ElasticMaterial& material) {
  Modes stress;
  const double lambda = material.lambda();
  const double mu = material.mu();
  for (int m = 0; m < kModes; ++m) {
    const double pressure = lambda * (strain(0, m) + strain(1, m) + strain(2, m));
    for (int k = 0; k < 3; ++k) {
      stress(k, m) = pressure + 2.0 * mu * strain(k, m);
      stress(3 + k, m) = mu * strain(3 + k, m);
    }
  }
  return stress;
}

std::optional<ElementSums> Sum(const HexCorners& corners, const ElasticMaterial& material) {
  ElementSums sums;
  sums.outer.fill(Matrix3d::Zero());
  const Middle middle = MiddleOf(corners);
  if (!(middle.determinant > 0.0)) return std::nullopt;
  const ModeShapes shapes(middle);
  for (const GaussPoint& point : GaussPoints()) {
    const Matrix3d jacobian = point.gradient * corners.transpose();
    const double determinant = jacobian.determinant();
    if (!(determinant > 0.0)) return std::nullopt;
    const Gradients gradient = jacobian.inverse() * point.gradient;
    for (int b = 0, pair = 0; b < 8; ++b) {
      const Vector3d weighted = determinant * gradient.col(b);
      for (int a = 0; a <= b; ++a, ++pair) {
        sums.outer[static_cast<std::size_t>(pair)].noalias() += gradient.col(a) * weighted.transpose();
      }
    }
    const Modes strain = shapes.At(point.xi, middle.determinant / determinant);
    const Modes stress = StressesOf(strain, material);
    AddCoupling(gradient, stress, determinant, sums.coupling);
    sums.modes.noalias() += determinant * strain.transpose() * stress;
  }
  return sums;
}

}  // namespace

std::optional<HexMatrix> HexStiffness(const HexCorners& corners, const ElasticMaterial& material) {
  const std::optional<ElementSums> sums = Sum(corners, material);
  if (!sums) return std::nullopt;
  const Eigen::LLT<ModeMatrix> modes(sums->modes);
  // K = K_uu − K_uα K_αα⁻¹ K_αu with K_uα K_αα⁻¹ K_αu = HᵀH, H = L⁻¹ K_αu.
  const Eigen::Matrix<double, kModes, 24> half = modes.matrixL().solve(sums->coupling.transpose());
  HexMatrix stiffness;
  for (int b = 0; b < 8; ++b) {  // upper blocks
    stiffness.block(0, 3 * b, 3 * b + 3, 3) =
        -half.leftCols(3 * b + 3).transpose().lazyProduct(half.middleCols<3>(3 * b));
  }
  const double lambda = material.lambda();
  const double mu = material.mu();
  for (int b = 0, pair = 0; b < 8; ++b) {
    for (int a = 0; a <= b; ++a, ++pair) {
      const Matrix3d& outer = sums->outer[static_cast<std::size_t>(pair)];
      Matrix3d block = lambda * outer + mu * outer.transpose();
      block.diagonal().array() += mu * outer.trace();
      stiffness.block<3, 3>(3 * a, 3 * b) += block;
      if (a != b) stiffness.block<3, 3>(3 * b, 3 * a) = stiffness.block<3, 3>(3 * a, 3 * b).transpose();
    }
  }
  return stiffness;
}

std::array<Voigt, 8> HexStrains(const HexCorners& corners, const ElasticMaterial& material,
                                const HexCorners& displacement) {
  const std::optional<ElementSums> sums = Sum(corners, material);
  ENSURE(sums, "the element was right side out");
  const Eigen::Map<const Eigen::Matrix<double, 24, 1>> u(displacement.data());
  const Eigen::Matrix<double, kModes, 1> amplitude = -sums->modes.llt().solve(sums->coupling.transpose() * u);
  const Middle middle = MiddleOf(corners);
  const ModeShapes shapes(middle);
  std::array<Voigt, 8> strains;
  for (std::size_t q = 0; q < 8; ++q) {
    const GaussPoint& point = GaussPoints()[q];
    const Matrix3d jacobian = point.gradient * corners.transpose();
    const Gradients gradient = jacobian.inverse() * point.gradient;
    const Matrix3d slope = displacement * gradient.transpose();  // (component, axis)
    strains[q] << slope(0, 0), slope(1, 1), slope(2, 2), slope(0, 1) + slope(1, 0), slope(1, 2) + slope(2, 1),
        slope(2, 0) + slope(0, 2);
    strains[q].noalias() += shapes.At(point.xi, middle.determinant / jacobian.determinant()) * amplitude;
  }
  return strains;
}

Voigt StressOf(const Voigt& strain, const ElasticMaterial& material) {
  Voigt stress = material.mu() * strain;
  stress.head<3>() *= 2.0;
  stress.head<3>().array() += material.lambda() * strain.head<3>().sum();
  return stress;
}

std::array<Voigt, 8> AtCorners(const std::array<Voigt, 8>& at_gauss) {
  std::array<Voigt, 8> corners;
  for (int a = 0; a < 8; ++a) {
    Voigt sum = Voigt::Zero();
    for (int q = 0; q < 8; ++q) {
      double weight = 0.125;
      for (int axis = 0; axis < 3; ++axis) weight *= 1.0 + std::sqrt(3.0) * Side(a, axis) * Side(q, axis);
      sum += weight * at_gauss[static_cast<std::size_t>(q)];
    }
    corners[static_cast<std::size_t>(a)] = sum;
  }
  return corners;
}

}  // namespace annulus
