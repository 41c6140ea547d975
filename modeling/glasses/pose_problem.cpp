#include "modeling/glasses/pose_problem.h"

#include <ceres/cost_function.h>
#include <ceres/jet.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Jet = ceres::Jet<double, FrontState::kPoseSize>;

// What residuals are divided by: a residual of 1 is as bad as one half range beside a goal's best value.
constexpr double kBearingScale = 0.05;   // mm
constexpr double kClearanceScale = 0.3;  // mm
constexpr double kReachScale = 0.2;      // mm
constexpr double kPadPull = 4.0;         // mm
constexpr double kPull = 0.5;            // of a goal towards its best value
constexpr double kHold = 5.0;            // of a goal back into its range
constexpr double kInside = 0.06;         // of the half range: where the hold begins before the range ends
constexpr double kRollScale = RadiansFromDegrees(8.0);  // the eyes' heights say more than the head's lean
constexpr double kYawScale = RadiansFromDegrees(2.0);
constexpr double kSoftness = 0.1;  // mm; of the least of several distances
/// What an optician can bend: tilt of the front against the level, and its roll and yaw.
constexpr double kLeastTilt = RadiansFromDegrees(-2.0);
constexpr double kLargestTilt = RadiansFromDegrees(22.0);
constexpr double kLargestTurn = RadiansFromDegrees(8.0);
constexpr double kSizePull = 0.3;
constexpr double kGapScale = 3.0;         // mm
constexpr double kWidthScale = 0.08;      // share
constexpr double kSizeStep = 1e-3;        // mm or rad, of the differences over the size
constexpr double kHeightTolerance = 1.0;  // mm, of a pupil height that is asked for
constexpr int kGoalRows = 2 * 10 + 2;
constexpr int kSizeRows = 2;

/// The three rotations of FrontPose and the axes about which its angles turn, head frame.
struct Kinematics {
  explicit Kinematics(const FrontPose& pose) : rotation(pose.HeadFromFrame().linear()), shift(pose.shift) {
    const Eigen::Matrix3d yaw = Eigen::AngleAxisd(pose.yaw, Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Matrix3d yaw_roll = yaw * Eigen::AngleAxisd(pose.roll, Vector3d::UnitY()).toRotationMatrix();
    tilt_axis = -yaw_roll.col(0);
    roll_axis = yaw.col(1);
  }
  Eigen::Matrix3d rotation;
  Vector3d shift;
  Vector3d tilt_axis;
  Vector3d roll_axis;

  /// d(distance)/d(pose) of a point `turned` = rotation · p with the head's normal in the head frame.
  [[nodiscard]] Eigen::Matrix<double, 6, 1> PoseGradient(const Vector3d& turned, const Vector3d& normal) const {
    Eigen::Matrix<double, 6, 1> gradient;
    const Vector3d lever = turned.cross(normal);  // normal · (axis × turned) = axis · (turned × normal)
    gradient << normal, tilt_axis.dot(lever), roll_axis.dot(lever), lever.z();
    return gradient;
  }
};

/// The rotation of FrontPose in dual numbers of its six variables.
void DualPose(const FrontPose& pose, Eigen::Matrix<Jet, 3, 3>& rotation, Eigen::Matrix<Jet, 3, 1>& shift) {
  using std::cos;
  using std::sin;
  for (int k = 0; k < 3; ++k) shift[k] = Jet(pose.shift[k], k);
  const Jet tilt(pose.tilt, 3);
  const Jet roll(pose.roll, 4);
  const Jet yaw(pose.yaw, 5);
  const Jet zero(0.0);
  const Jet one(1.0);
  Eigen::Matrix<Jet, 3, 3> about_x;
  Eigen::Matrix<Jet, 3, 3> about_y;
  Eigen::Matrix<Jet, 3, 3> about_z;
  about_x << one, zero, zero, zero, cos(tilt), sin(tilt), zero, -sin(tilt), cos(tilt);
  about_y << cos(roll), zero, sin(roll), zero, one, zero, -sin(roll), zero, cos(roll);
  about_z << cos(yaw), -sin(yaw), zero, sin(yaw), cos(yaw), zero, zero, zero, one;
  rotation = about_z * about_y * about_x;
}

/// How far beyond a range, signed.
template <class T>
T Excess(const T& value, double low, double high) {
  if (value < low) return value - low;
  if (value > high) return value - high;
  return T(0.0);
}

/// The goals' residuals in their order.
template <class T>
std::array<T, kGoalRows> GoalResiduals(const GoalNumbers<T>& numbers, const FitGoals& goals,
                                       const std::array<GoalRange, 2>& pupils) {
  std::array<T, kGoalRows> rows;
  std::size_t row = 0;
  const auto add = [&](const T& value, const GoalRange& range) {
    const double half = std::max(0.5 * (range.high - range.low), 1e-9);
    rows[row++] = range.weight * kPull / half * (value - range.best);
    const double inner = kInside * half;
    rows[row++] = range.weight * kHold / half * Excess(value, range.low + inner, range.high - inner);
  };
  for (std::size_t side = 0; side < 2; ++side) {
    add(numbers.vertex_distance[side], goals.vertex_distance);
    add(numbers.decentration[side], goals.decentration);
    add(numbers.pupil_above_centre[side], pupils[side]);
    add(numbers.temple_splay[side], goals.temple_splay);
  }
  add(numbers.pantoscopic_tilt, goals.pantoscopic_tilt);
  add(numbers.face_form, goals.face_form);
  rows[row++] = numbers.roll / kRollScale;
  rows[row++] = numbers.yaw / kYawScale;
  ENSURE(row == rows.size(), "every goal has its rows");
  return rows;
}

class PoseCost : public ceres::CostFunction {
 public:
  explicit PoseCost(const PoseProblem& problem) : problem_(problem) {
    set_num_residuals(problem.residual_count());
    mutable_parameter_block_sizes()->push_back(FrontState::kSize);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    VectorXd values;
    MatrixXd jacobian;
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    if (!problem_.Evaluate(FrontState::FromVector(parameters[0]), values, wanted ? &jacobian : nullptr)) return false;
    VectorXd::Map(residuals, values.size()) = values;
    if (wanted) {
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, FrontState::kSize, Eigen::RowMajor>;
      Eigen::Map<RowMajor>(jacobians[0], values.size(), FrontState::kSize) = jacobian;
    }
    return true;
  }

 private:
  const PoseProblem& problem_;
};

/// Residuals of one state, filled row by row.
class Rows {
 public:
  Rows(const PoseTask& task, const FrontShape& front, const FrontPose& pose, VectorXd& residuals, MatrixXd* jacobian)
      : task_(task), front_(front), pose_(pose), kinematics_(pose), residuals_(residuals), jacobian_(jacobian) {}

  void AddPoints() {
    gaps_.reserve(front_.points.size());
    for (const FrontPoint& point : front_.points) {
      HeadGap gap = GapOf(point.position);
      gaps_.push_back(gap);
      gap.distance += task_.skin_shift[point.position.x() > 0.0 ? 0 : 1];
      const double entered = std::min(gap.distance - point.clearance, 0.0) / kClearanceScale;
      if (entered < 0.0) SetGradient(point.position, gap.gradient / kClearanceScale);
      residuals_[row_++] = entered;
    }
  }

  void AddBearing() {
    for (std::size_t side = 0; side < 2; ++side) {
      if (front_.bearing == NoseBearing::kAdjust) {
        AddPad(front_.pads[side], task_.bearing_shift[side]);
      } else {
        AddLeast(front_.bearing_points[side], task_.bearing_shift[side]);
      }
    }
  }

  void AddGoals() {
    const std::array<GoalRange, 2> pupils{PupilRange(task_, front_, 0), PupilRange(task_, front_, 1)};
    if (jacobian_ == nullptr) {
      const auto rows = GoalResiduals(NumbersOf(front_, task_.inputs, pose_), task_.goals, pupils);
      for (const double value : rows) residuals_[row_++] = value;
      return;
    }
    Eigen::Matrix<Jet, 3, 3> rotation;
    Eigen::Matrix<Jet, 3, 1> shift;
    DualPose(pose_, rotation, shift);
    for (const Jet& value : GoalResiduals(NumbersOf<Jet>(front_, task_.inputs, rotation, shift), task_.goals, pupils)) {
      jacobian_->row(row_).head<FrontState::kPoseSize>() = value.v.transpose();
      residuals_[row_++] = value.a;
    }
  }

  [[nodiscard]] int row() const { return row_; }

 private:
  [[nodiscard]] HeadGap GapOf(const Vector3d& p) const {
    const Eigen::Isometry3d& station_from_head = task_.head->station_from_head();
    HeadGap gap =
        task_.head->skin().FirstOrder(station_from_head * Vector3d(kinematics_.rotation * p + kinematics_.shift));
    gap.gradient = station_from_head.linear().transpose() * gap.gradient;
    return gap;
  }

  void SetGradient(const Vector3d& p, const Vector3d& gradient) {
    if (jacobian_ == nullptr) return;
    jacobian_->row(row_).head<FrontState::kPoseSize>() +=
        kinematics_.PoseGradient(kinematics_.rotation * p, gradient).transpose();
  }

  /// The least distance, smoothed: -h·log Σ exp(-d/h).
  void AddLeast(const std::vector<std::size_t>& indices, double shift) {
    double least = 1e9;
    for (const std::size_t k : indices) least = std::min(least, gaps_[k].distance);
    double sum = 0.0;
    for (const std::size_t k : indices) sum += std::exp((least - gaps_[k].distance) / kSoftness);
    for (const std::size_t k : indices) {
      const double share = std::exp((least - gaps_[k].distance) / kSoftness) / std::max(sum, 1.0);
      if (share > 1e-6) SetGradient(front_.points[k].position, share / kBearingScale * gaps_[k].gradient);
    }
    const double value = indices.empty() ? 0.0 : least - kSoftness * std::log(sum) + shift;
    residuals_[row_++] = value / kBearingScale;
    residuals_[row_++] = 0.0;
  }

  void AddPad(const Vector3d& pad, double shift) {
    HeadGap gap = GapOf(pad);
    gap.distance += shift;
    const double beyond = Excess(gap.distance, -kPadReach, kPadReach);
    if (beyond != 0.0) SetGradient(pad, gap.gradient / kReachScale);
    residuals_[row_++] = beyond / kReachScale;
    SetGradient(pad, gap.gradient / kPadPull);
    residuals_[row_++] = gap.distance / kPadPull;
  }

  const PoseTask& task_;
  const FrontShape& front_;
  const FrontPose& pose_;
  Kinematics kinematics_;
  VectorXd& residuals_;
  MatrixXd* jacobian_;
  std::vector<HeadGap> gaps_;
  int row_ = 0;
};

int EvaluateFront(const PoseTask& task, const FrontShape& front, const FrontPose& pose, VectorXd& residuals,
                  MatrixXd* jacobian) {
  Rows rows(task, front, pose, residuals, jacobian);
  rows.AddPoints();
  rows.AddBearing();
  rows.AddGoals();
  return rows.row();
}

}  // namespace

GoalRange PupilRange(const PoseTask& task, const FrontShape& front, std::size_t side) {
  GoalRange range = task.goals.pupil_above_centre;
  if (!task.pupil_height[side]) return range;
  range.best = *task.pupil_height[side] - 0.5 * front.lenses[side].b;
  range.low = range.best - kHeightTolerance;
  range.high = range.best + kHeightTolerance;
  return range;
}

Eigen::Matrix<double, FrontState::kSize, 1> FrontState::Vector() const {
  Eigen::Matrix<double, kSize, 1> values;
  values << pose.shift, pose.tilt, pose.roll, pose.yaw, width, gap, face_form;
  return values;
}

FrontState FrontState::FromVector(const double* values) {
  return {
      {Vector3d(values[0], values[1], values[2]), values[3], values[4], values[5]}, values[6], values[7], values[8]};
}

Result<PoseProblem> PoseProblem::Make(const PoseTask& task) {
  PoseProblem problem(task);
  const auto front = MakeFrontShape(task.design, task.goals, task.inputs.lens_back, task.density);
  RETURN_IF_ERROR(front);
  problem.front_ = std::make_shared<const FrontShape>(*front);
  return problem;
}

PoseProblem PoseProblem::With(PoseTask task) const {
  PoseProblem problem(std::move(task));
  problem.front_ = front_;
  return problem;
}

FrameDesign PoseProblem::DesignOf(const FrontState& state) const {
  FrameDesign design = ScaledToWidth(task_.design, state.width);
  design.details.bridge_gap = state.gap;
  design.details.face_form = state.face_form;
  return design;
}

Result<FrontShape> PoseProblem::Front(const FrontState& state) const {
  if (task_.size == FitSize::kKept) return *front_;
  return MakeFrontShape(DesignOf(state), task_.goals, task_.inputs.lens_back, task_.density);
}

int PoseProblem::residual_count() const { return static_cast<int>(front_->points.size()) + 4 + kGoalRows + kSizeRows; }

bool PoseProblem::IsFree(int k) const { return k < FrontState::kPoseSize || task_.size == FitSize::kMadeToMeasure; }

bool PoseProblem::Evaluate(const FrontState& state, VectorXd& residuals, MatrixXd* jacobian) const {
  const bool is_kept = task_.size == FitSize::kKept;
  Result<FrontShape> made;
  if (!is_kept) {
    made = Front(state);
    if (!made) return false;
  }
  const FrontShape& front = is_kept ? *front_ : *made;
  residuals.setZero(residual_count());
  if (jacobian != nullptr) jacobian->setZero(residual_count(), FrontState::kSize);
  int row = EvaluateFront(task_, front, state.pose, residuals, jacobian);
  const double wider = state.width / task_.design.parameters.width - 1.0;
  if (jacobian != nullptr && !is_kept) {
    for (int k = FrontState::kPoseSize; k < FrontState::kSize; ++k) {
      Eigen::Matrix<double, FrontState::kSize, 1> moved = state.Vector();
      moved[k] += kSizeStep;
      const auto beside = Front(FrontState::FromVector(moved.data()));
      if (!beside || beside->points.size() != front.points.size()) return false;
      VectorXd there = VectorXd::Zero(residual_count());
      EvaluateFront(task_, *beside, state.pose, there, nullptr);
      jacobian->col(k) = (there - residuals) / kSizeStep;
    }
    (*jacobian)(row, 6) = kSizePull / kWidthScale / task_.design.parameters.width;
    (*jacobian)(row + 1, 7) = kSizePull / kGapScale;
  }
  residuals[row++] = kSizePull / kWidthScale * wider;
  residuals[row++] = kSizePull / kGapScale * (state.gap - task_.design.bridge_gap());
  ENSURE(row == residual_count(), "every residual has its row");
  return residuals.allFinite();
}

FrontState PoseProblem::Start() const {
  FrontState state;
  state.width = task_.design.parameters.width;
  state.gap = task_.design.bridge_gap();
  state.face_form = task_.design.details.face_form;
  state.pose.tilt = task_.goals.pantoscopic_tilt.best;
  const Vector3d middle = 0.5 * (task_.inputs.eyes[0] + task_.inputs.eyes[1]);
  const double forward =
      task_.goals.vertex_distance.best + 0.5 * (task_.inputs.lens_back[0] + task_.inputs.lens_back[1]);
  const Vector3d lens = 0.5 * (front_->lenses[0].centre + front_->lenses[1].centre);
  state.pose.shift = middle + Vector3d(0.0, forward, -task_.goals.pupil_above_centre.best) -
                     state.pose.HeadFromFrame().linear() * lens;
  return state;
}

PoseProblem::Summary PoseProblem::Solve(const FrontState& start) const {
  Eigen::Matrix<double, FrontState::kSize, 1> values = start.Vector();
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  PoseCost cost(*this);
  problem.AddResidualBlock(&cost, nullptr, values.data());
  const auto bound = [&](int k, double low, double high) {
    problem.SetParameterLowerBound(values.data(), k, low);
    problem.SetParameterUpperBound(values.data(), k, high);
    values[k] = std::clamp(values[k], low, high);
  };
  bound(3, kLeastTilt, kLargestTilt);
  bound(4, -kLargestTurn, kLargestTurn);
  bound(5, -kLargestTurn, kLargestTurn);
  if (task_.size == FitSize::kKept) {
    problem.SetManifold(values.data(), new ceres::SubsetManifold(FrontState::kSize, {6, 7, 8}));
  } else {
    const FrameDesign& design = task_.design;
    const double width = design.parameters.width;
    bound(6, width * (1.0 - task_.limits.width_share), width * (1.0 + task_.limits.width_share));
    bound(7, std::max(design.bridge_gap() - task_.limits.gap_change, 2.0),
          design.bridge_gap() + task_.limits.gap_change);
    bound(8, std::max(design.details.face_form - task_.limits.face_form_change, 0.0),
          design.details.face_form + task_.limits.face_form_change);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 60;
  options.function_tolerance = 1e-6;
  options.parameter_tolerance = 1e-7;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {FrontState::FromVector(values.data()), summary.final_cost, static_cast<int>(summary.iterations.size())};
}

}  // namespace annulus
