#include "modeling/glasses/fit_sigma.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace annulus {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

double& At(GoalVector& values, GoalValue value) { return values[static_cast<int>(value)]; }

/// One independent cause: how it changes the task at +1 sd, and its step in sds.
using Cause = std::function<void(PoseTask&, double)>;

/// sd of the distance of a point at the skin, mm: of the radius, by the slope.
double DistanceSigma(const WearerHead& head, const Vector3d& p_in_station) {
  const double theta = std::atan2(p_in_station.y(), p_in_station.x());
  const Vector3d normal = head.measured().surface().Normal(theta, p_in_station.z());
  const double along = std::abs(normal.x() * std::cos(theta) + normal.y() * std::sin(theta));
  return along * head.measured().RadiusSigma(theta, p_in_station.z());
}

/// Three independent displacements of 1 sd that together make a covariance.
std::array<Vector3d, 3> DisplacementsOf(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  std::array<Vector3d, 3> displacements;
  for (int k = 0; k < 3; ++k) {
    displacements[static_cast<std::size_t>(k)] =
        std::sqrt(std::max(solver.eigenvalues()[k], 0.0)) * solver.eigenvectors().col(k);
  }
  return displacements;
}

std::vector<Cause> CausesOf(const PoseTask& task, const std::array<Vector3d, 2>& bearing) {
  const WearerHead& head = *task.head;
  const Eigen::Matrix3d head_from_station = head.station_from_head().linear().transpose();
  std::vector<Cause> causes;
  for (std::size_t side = 0; side < 2; ++side) {
    const Eye eye = side == 0 ? Eye::kRight : Eye::kLeft;
    const auto in_head = [&](const FacePoint& point) -> Eigen::Matrix3d {
      return head_from_station * point.covariance * head_from_station.transpose();
    };
    const double bears = DistanceSigma(head, bearing[side]);
    for (const Vector3d& moved : DisplacementsOf(in_head(head.EyePoint(eye)))) {
      causes.emplace_back([=](PoseTask& t, double sd) { t.inputs.eyes[side] += sd * moved; });
    }
    for (const Vector3d& moved : DisplacementsOf(in_head(head.EarPoint(eye)))) {
      causes.emplace_back([=](PoseTask& t, double sd) { t.inputs.ears[side] += sd * moved; });
    }
    causes.emplace_back([=](PoseTask& t, double sd) {
      // The nose's side as a whole: what bears on it and what must keep clear of it.
      t.bearing_shift[side] -= sd * bears;
      t.skin_shift[side] -= sd * bears;
    });
  }
  const double level = head.level_sigma();
  causes.emplace_back([=](PoseTask& t, double sd) {
    t.inputs.level = Eigen::AngleAxisd(sd * level, Vector3d::UnitX()).toRotationMatrix() * t.inputs.level;
  });
  return causes;
}

}  // namespace

GoalVector ValuesOf(const FrontShape& front, const GoalInputs& inputs, const FrontPose& pose) {
  const GoalNumbers<double> n = NumbersOf(front, inputs, pose);
  const Eigen::Isometry3d head_from_frame = pose.HeadFromFrame();
  GoalVector values;
  At(values, GoalValue::kPd) = (inputs.eyes[0] - inputs.eyes[1]).dot(inputs.level.col(0));
  for (std::size_t side = 0; side < 2; ++side) {
    const auto of = [&](GoalValue right) {
      return static_cast<GoalValue>(static_cast<int>(right) + (side == 0 ? 0 : 1));
    };
    const LensPlane& lens = front.lenses[side];
    At(values, of(GoalValue::kPdRight)) = std::abs(lens.centre.x()) - n.decentration[side] * lens.right.x();
    At(values, of(GoalValue::kHeightRight)) = 0.5 * lens.b + n.pupil_above_centre[side];
    At(values, of(GoalValue::kVertexRight)) = n.vertex_distance[side];
    At(values, of(GoalValue::kSplayRight)) = n.temple_splay[side];
    At(values, of(GoalValue::kTempleRight)) = (head_from_frame * front.hinges[side] - inputs.ears[side]).norm();
  }
  At(values, GoalValue::kDbl) =
      front.lenses[0].centre.x() - front.lenses[1].centre.x() - 0.5 * (front.lenses[0].a + front.lenses[1].a);
  At(values, GoalValue::kPantoscopicTilt) = n.pantoscopic_tilt;
  At(values, GoalValue::kFaceForm) = n.face_form;
  return values;
}

namespace {

/// A kept size is solved again at +1 and -1 sd of every cause: a target at the end of its range gives way to one side.
GoalVector VarianceBySolving(const PoseProblem& problem, const FrontState& state, const std::vector<Cause>& causes) {
  GoalVector variance = GoalVector::Zero();
  const auto front = problem.Front(state);
  for (const Cause& cause : causes) {
    std::array<GoalVector, 2> values;
    for (std::size_t k = 0; k < 2; ++k) {
      PoseTask task = problem.task();
      cause(task, k == 0 ? 1.0 : -1.0);
      const PoseProblem::Summary solved = problem.With(task).Solve(state);
      values[k] = ValuesOf(*front, task.inputs, solved.state.pose);
    }
    variance += (0.5 * (values[0] - values[1])).array().square().matrix();
  }
  return variance;
}

/// Made to measure, to first order: implicit differentiation of the least-squares solution.
GoalVector VarianceToFirstOrder(const PoseProblem& problem, const FrontState& state, const std::vector<Cause>& causes) {
  constexpr double kStep = 1e-3;  // of every variable; of every cause in sds
  const GoalVector unknown = GoalVector::Constant(std::nan(""));
  VectorXd residuals;
  MatrixXd jacobian;
  const auto front = problem.Front(state);
  if (!front || !problem.Evaluate(state, residuals, &jacobian)) return unknown;
  const GoalVector values = ValuesOf(*front, problem.task().inputs, state.pose);
  MatrixXd goals_by_state(static_cast<int>(GoalValue::kCount), FrontState::kSize);
  for (int k = 0; k < FrontState::kSize; ++k) {
    Eigen::Matrix<double, FrontState::kSize, 1> moved = state.Vector();
    moved[k] += kStep;
    const FrontState there = FrontState::FromVector(moved.data());
    const auto beside = problem.Front(there);
    if (!beside) return unknown;
    goals_by_state.col(k) = (ValuesOf(*beside, problem.task().inputs, there.pose) - values) / kStep;
  }
  MatrixXd normal = jacobian.transpose() * jacobian;
  normal.diagonal().array() += 1e-9;
  const Eigen::LDLT<MatrixXd> solver(normal);
  GoalVector variance = GoalVector::Zero();
  for (const Cause& cause : causes) {
    PoseTask task = problem.task();
    cause(task, kStep);
    VectorXd changed;
    if (!problem.With(task).Evaluate(state, changed, nullptr)) return unknown;
    const VectorXd motion = -solver.solve(jacobian.transpose() * ((changed - residuals) / kStep));
    const GoalVector direct = (ValuesOf(*front, task.inputs, state.pose) - values) / kStep;
    variance += (direct + goals_by_state * motion).array().square().matrix();
  }
  return variance;
}

}  // namespace

GoalVector SigmasOf(const PoseProblem& problem, const FrontState& state, const std::array<Vector3d, 2>& bearing) {
  for (const Vector3d& place : bearing) {
    // Without a covariance of the surface there is nothing to go on.
    if (!std::isfinite(DistanceSigma(*problem.task().head, place))) return GoalVector::Constant(std::nan(""));
  }
  const std::vector<Cause> causes = CausesOf(problem.task(), bearing);
  const GoalVector variance = problem.task().size == FitSize::kKept ? VarianceBySolving(problem, state, causes)
                                                                    : VarianceToFirstOrder(problem, state, causes);
  return variance.array().sqrt();
}

}  // namespace annulus
