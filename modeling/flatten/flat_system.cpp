#include "modeling/flatten/flat_system.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

constexpr int kHeld = -1;
/// A seam pulls as ten strips of cloth of its own width would.
constexpr double kSeamRate = 10.0;
constexpr double kKeptFromFlip = 0.9;

double SideLength(const std::array<std::uint32_t, 2>& side, const FlatSystem::Points& flat) {
  return (flat[side[1]] - flat[side[0]]).norm();
}

double Cross(const Eigen::Vector2d& u, const Eigen::Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }

}  // namespace

FlatSystem::FlatSystem(const CurvedSheet& sheet, const FlattenOptions& options, const std::vector<GrainPair>& grain)
    : sheet_(sheet),
      elements_(ElementsOf(sheet)),
      stiffness_(Stiffness(options.material)),
      sewn_(options.sewn),
      multiplier_(options.sewn.size(), 0.0),
      seam_rate_(kSeamRate * std::max(stiffness_(0, 0), stiffness_(1, 1))),
      unknown_(2 * sheet.places.size(), 0) {
  for (const GrainPair& pair : grain) {
    unknown_[2 * pair[0]] = unknown_[2 * pair[0] + 1] = unknown_[2 * pair[1]] = kHeld;
  }
  for (int& u : unknown_) {
    if (u != kHeld) u = count_++;
  }
}

FlatElement::Corners FlatSystem::CornersOf(std::size_t face, const Points& flat) const {
  FlatElement::Corners corners;
  for (std::size_t k = 0; k < 3; ++k) corners.col(static_cast<Eigen::Index>(k)) = flat[sheet_.faces[face][k]];
  return corners;
}

double FlatSystem::Difference(std::size_t seam, const Points& flat) const {
  return SideLength(sewn_[seam].one, flat) - SideLength(sewn_[seam].other, flat);
}

double FlatSystem::Elastic(const Points& flat) const {
  double energy = 0.0;
  for (std::size_t f = 0; f < elements_.size(); ++f) energy += elements_[f].Energy(CornersOf(f, flat), stiffness_);
  return energy;
}

double FlatSystem::Total(const Points& flat) const {
  double energy = Elastic(flat);
  for (std::size_t s = 0; s < sewn_.size(); ++s) {
    const double c = Difference(s, flat);
    energy += (multiplier_[s] + 0.5 * seam_rate_ * c) * c;
  }
  return energy;
}

double FlatSystem::SeamGap(const Points& flat) const {
  double gap = 0.0;
  for (std::size_t s = 0; s < sewn_.size(); ++s) gap = std::max(gap, std::abs(Difference(s, flat)));
  return gap;
}

void FlatSystem::UpdateMultipliers(const Points& flat) {
  for (std::size_t s = 0; s < sewn_.size(); ++s) multiplier_[s] += seam_rate_ * Difference(s, flat);
}

void FlatSystem::AddSeam(std::size_t seam, const Points& flat, Curvature curvature) {
  const double c = Difference(seam, flat);
  const double force = multiplier_[seam] + seam_rate_ * c;
  Eigen::Matrix<double, 8, 1> by_points;
  Eigen::Matrix<double, 8, 8> second = Eigen::Matrix<double, 8, 8>::Zero();
  std::array<std::uint32_t, 4> vertex{sewn_[seam].one[0], sewn_[seam].one[1], sewn_[seam].other[0],
                                      sewn_[seam].other[1]};
  for (int side = 0; side < 2; ++side) {
    const Eigen::Vector2d along =
        flat[vertex[static_cast<std::size_t>(2 * side + 1)]] - flat[vertex[static_cast<std::size_t>(2 * side)]];
    const double length = along.norm();
    const Eigen::Vector2d unit = along / length;
    const double sign = side == 0 ? 1.0 : -1.0;
    by_points.segment<2>(4 * side) = -sign * unit;
    by_points.segment<2>(4 * side + 2) = sign * unit;
    // A side under tension gets stiffer across itself, one under pressure softer.
    if (curvature == Curvature::kConvex && sign * force < 0.0) continue;
    const Eigen::Matrix2d across = sign * force / length * (Eigen::Matrix2d::Identity() - unit * unit.transpose());
    second.block<2, 2>(4 * side, 4 * side) += across;
    second.block<2, 2>(4 * side + 2, 4 * side + 2) += across;
    second.block<2, 2>(4 * side, 4 * side + 2) -= across;
    second.block<2, 2>(4 * side + 2, 4 * side) -= across;
  }
  second += seam_rate_ * by_points * by_points.transpose();
  for (int a = 0; a < 8; ++a) {
    const int row = unknown_[2 * vertex[static_cast<std::size_t>(a / 2)] + static_cast<std::size_t>(a % 2)];
    if (row == kHeld) continue;
    gradient_[row] += force * by_points[a];
    for (int b = 0; b < 8; ++b) {
      const int column = unknown_[2 * vertex[static_cast<std::size_t>(b / 2)] + static_cast<std::size_t>(b % 2)];
      if (column != kHeld && row >= column) entries_.emplace_back(row, column, second(a, b));
    }
  }
}

void FlatSystem::AssembleSeams(const Points& flat, Curvature curvature) {
  for (std::size_t s = 0; s < sewn_.size(); ++s) AddSeam(s, flat, curvature);
}

void FlatSystem::Assemble(const Points& flat, Curvature curvature) {
  entries_.clear();
  gradient_ = Eigen::VectorXd::Zero(count_);
  for (std::size_t f = 0; f < elements_.size(); ++f) {
    const FlatElement::Expansion e = elements_[f].Expand(CornersOf(f, flat), stiffness_, curvature);
    std::array<int, 6> at{};
    for (std::size_t k = 0; k < 6; ++k) at[k] = unknown_[2 * sheet_.faces[f][k / 2] + k % 2];
    for (std::size_t a = 0; a < 6; ++a) {
      if (at[a] == kHeld) continue;
      gradient_[at[a]] += e.gradient[static_cast<Eigen::Index>(a)];
      for (std::size_t b = 0; b < 6; ++b) {
        if (at[b] == kHeld || at[a] < at[b]) continue;
        entries_.emplace_back(at[a], at[b], e.hessian(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
      }
    }
  }
  AssembleSeams(flat, curvature);
  matrix_.resize(count_, count_);
  matrix_.setFromTriplets(entries_.begin(), entries_.end());
}

std::optional<FlatSystem::Step> FlatSystem::Newton(const Points& flat) {
  for (const Curvature curvature : {Curvature::kExact, Curvature::kConvex}) {
    Assemble(flat, curvature);
    if (curvature == Curvature::kConvex) {
      for (int k = 0; k < count_; ++k) matrix_.coeffRef(k, k) += 1e-9 * stiffness_(1, 1);
    }
    if (!analysed_) factor_.analyzePattern(matrix_);
    analysed_ = true;
    factor_.factorize(matrix_);
    if (factor_.info() != Eigen::Success) continue;
    const Eigen::VectorXd solved = factor_.solve(gradient_);
    Step step{Points(flat.size(), Eigen::Vector2d::Zero()), -gradient_.dot(solved)};
    if (!solved.allFinite() || step.slope > 0.0) continue;
    for (std::size_t u = 0; u < unknown_.size(); ++u) {
      if (unknown_[u] != kHeld) step.move[u / 2][static_cast<Eigen::Index>(u % 2)] = -solved[unknown_[u]];
    }
    return step;
  }
  return {};
}

double FlatSystem::LargestPart(const Points& flat, const Points& move) const {
  double part = 1.0;
  for (const auto& face : sheet_.faces) {
    // Twice the area along the way is c + b t + a t²; its first root is where the triangle would collapse.
    const Eigen::Vector2d u = flat[face[1]] - flat[face[0]];
    const Eigen::Vector2d v = flat[face[2]] - flat[face[0]];
    const Eigen::Vector2d du = move[face[1]] - move[face[0]];
    const Eigen::Vector2d dv = move[face[2]] - move[face[0]];
    const double a = Cross(du, dv);
    const double b = Cross(u, dv) + Cross(du, v);
    const double c = Cross(u, v);
    const double root = b * b - 4.0 * a * c;
    if (root < 0.0) continue;
    const double q = -0.5 * (b + std::copysign(std::sqrt(root), b));
    for (const double t : {q / a, c / q}) {
      if (t > 0.0) part = std::min(part, kKeptFromFlip * t);
    }
  }
  return part;
}

}  // namespace annulus
