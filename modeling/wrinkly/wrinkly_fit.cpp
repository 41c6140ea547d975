#include "modeling/wrinkly/wrinkly_fit.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

constexpr const char* kAttempt = "fit a wrinkly surface";
constexpr std::size_t kReportEvery = 8192;
/// Of the mean diagonal of the normal equations: holds points that are hardly seen near the mean.
constexpr double kRidge = 1e-10;
constexpr int kMostRounds = 400;
constexpr double kMiddleTolerance = 1e-9;

std::array<double, 3> Quadratic(double t) { return {(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t}; }

/// Rows of the fit: how much each control point counts at a place.
class RowMaker {
 public:
  RowMaker(const WrinklySurface& surface, int iterations)
      : surface_(surface), iterations_(iterations), shares_(surface.mesh().size()) {
    const ControlMesh& mesh = surface.mesh();
    for (std::size_t k = 0; k < mesh.size(); ++k) {
      if (mesh.HasPatch(static_cast<PointIndex>(k))) shares_[k] = ValueNetOf(mesh, static_cast<PointIndex>(k));
    }
  }

  [[nodiscard]] PointShares Row(const WrinklyTarget& target) const {
    const MeshShuffle& shuffle = surface_.level(iterations_);
    MeshPlace place{target.patch};
    PlaceOn(target.u, shuffle.u().parts(), place.u_code, place.u_rest);
    PlaceOn(target.v, shuffle.v().parts(), place.v_code, place.v_rest);
    PointShares row;
    Add(shuffle.Source(place, ShuffleOrder::kUThenV), surface_.u_then_v(), row);
    Add(shuffle.Source(place, ShuffleOrder::kVThenU), 1.0 - surface_.u_then_v(), row);
    return Merged(std::move(row));
  }

 private:
  static void PlaceOn(double at, std::uint32_t parts, std::uint32_t& code, double& rest) {
    code = std::min(static_cast<std::uint32_t>(at * parts), parts - 1);
    rest = at * parts - code;
  }

  void Add(const MeshPlace& place, double weight, PointShares& row) const {
    if (weight == 0.0) return;
    const MeshShuffle& shuffle = surface_.level(iterations_);
    const auto a = Quadratic((place.u_code + place.u_rest) / shuffle.u().parts());
    const auto b = Quadratic((place.v_code + place.v_rest) / shuffle.v().parts());
    const PatchNet& net = shares_[ControlMesh::Index(place.patch)];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (const PointShare& share : net[i][j]) row.push_back({share.point, share.weight * weight * a[i] * b[j]});
      }
    }
  }

  const WrinklySurface& surface_;
  int iterations_;
  std::vector<PatchNet> shares_;
};

Status Check(const WrinklySurface& surface, int iterations, std::span<const WrinklyTarget> targets) {
  if (iterations < 0 || iterations > surface.most_iterations()) {
    return Fail(kAttempt, fmt::format("{} iterations are asked for", iterations),
                fmt::format("use 0 to {}", surface.most_iterations()));
  }
  if (targets.empty()) return Fail(kAttempt, "there is nothing to fit", "give values");
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const WrinklyTarget& target = targets[k];
    const bool known = target.patch >= 0 && ControlMesh::Index(target.patch) < surface.mesh().size() &&
                       surface.mesh().HasPatch(target.patch);
    if (!known || !(target.u >= 0.0 && target.u <= 1.0 && target.v >= 0.0 && target.v <= 1.0) ||
        !std::isfinite(target.value) || !(target.weight > 0.0)) {
      return Fail(kAttempt, fmt::format("target {} is not on a patch, or not finite", k), "mend it");
    }
  }
  return {};
}

double MeanOf(std::span<const WrinklyTarget> targets) {
  double sum = 0.0;
  double weight = 0.0;
  for (const WrinklyTarget& target : targets) {
    sum += target.weight * target.value;
    weight += target.weight;
  }
  return sum / weight;
}

}  // namespace

Result<WrinklyFit> FitWrinklyValues(const WrinklySurface& surface, int iterations,
                                    std::span<const WrinklyTarget> targets, const TaskContext& task) {
  RETURN_IF_ERROR(Check(surface, iterations, targets));
  const RowMaker maker(surface, iterations);
  const auto count = static_cast<Eigen::Index>(surface.mesh().size());
  const auto rows = static_cast<Eigen::Index>(targets.size());
  const double mean = MeanOf(targets);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd wanted(rows);
  WrinklyFit fit;
  fit.is_seen.assign(surface.mesh().size(), 0);
  for (std::size_t k = 0; k < targets.size(); ++k) {
    if (k % kReportEvery == 0) {
      task.Report("read targets", static_cast<double>(k), static_cast<double>(targets.size()));
      if (task.stop.stop_requested()) return Fail(kAttempt, "it was stopped", "start it again");
    }
    const double root = std::sqrt(targets[k].weight);
    for (const PointShare& share : maker.Row(targets[k])) {
      entries.emplace_back(static_cast<int>(k), share.point, root * share.weight);
      fit.is_seen[ControlMesh::Index(share.point)] = 1;
    }
    wanted[static_cast<Eigen::Index>(k)] = root * (targets[k].value - mean);
  }
  Eigen::SparseMatrix<double> design(rows, count);
  design.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseMatrix<double> normal = design.transpose() * design;
  const double ridge = kRidge * normal.diagonal().sum() / static_cast<double>(count);
  for (Eigen::Index k = 0; k < count; ++k) normal.coeffRef(k, k) += ridge;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
  if (solver.info() != Eigen::Success) return Fail(kAttempt, "its equations are singular", "give more values");
  const Eigen::VectorXd found = solver.solve(design.transpose() * wanted);
  double weights = 0.0;
  for (const WrinklyTarget& target : targets) weights += target.weight;
  fit.rms = std::sqrt((wanted - design * found).squaredNorm() / weights);
  fit.rms_before = std::sqrt(wanted.squaredNorm() / weights);
  fit.values = found.array() + mean;
  for (std::size_t k = 0; k < fit.is_seen.size(); ++k) {
    if (fit.is_seen[k] == 0 && surface.mesh().HasPatch(static_cast<PointIndex>(k))) ++fit.points_without;
  }
  return fit;
}

Result<ControlMeshParts> ThroughMiddles(ControlMeshParts parts, std::span<const Eigen::Vector3d> middles) {
  auto made = ControlMesh::Make(std::move(parts), FamilyRule::kCut);
  if (!made) return Fail(made);
  std::vector<PointShares> middle_of(made->size());
  for (std::size_t k = 0; k < made->size(); ++k) {
    if (!made->HasPatch(static_cast<PointIndex>(k))) continue;
    const PatchNet net = NetOf(*made, static_cast<PointIndex>(k));
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (const PointShare& share : net[i][j]) {
          middle_of[k].push_back({share.point, share.weight * Quadratic(0.5)[i] * Quadratic(0.5)[j]});
        }
      }
    }
    middle_of[k] = Merged(std::move(middle_of[k]));
  }
  parts = made->parts();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& middle : middles) box.extend(middle);
  std::vector<Eigen::Vector3d> error(made->size(), Eigen::Vector3d::Zero());
  // Each point takes its own middle's error: the shares of the others are smaller in sum, so it converges.
  for (int round = 0; round < kMostRounds; ++round) {
    double largest = 0.0;
    for (std::size_t k = 0; k < middle_of.size(); ++k) {
      if (middle_of[k].empty()) continue;
      error[k] = middles[k];
      for (const PointShare& share : middle_of[k]) {
        error[k] -= share.weight * parts.points[ControlMesh::Index(share.point)].position;
      }
      largest = std::max(largest, error[k].norm());
    }
    if (largest <= kMiddleTolerance * box.diagonal().norm()) break;
    for (std::size_t k = 0; k < error.size(); ++k) parts.points[k].position += error[k];
  }
  return parts;
}

}  // namespace annulus
