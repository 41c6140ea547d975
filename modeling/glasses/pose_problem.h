#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>

#include "base/result.h"
#include "modeling/glasses/front_pose.h"
#include "modeling/glasses/wearer_head.h"

namespace annulus {

/// What PoseProblem solves for: the pose, and of made-to-measure frames the size.
struct FrontState {
  FrontPose pose;
  double width = 0.0;      ///< l1, mm.
  double gap = 0.0;        ///< l0, mm.
  double face_form = 0.0;  ///< rad

  static constexpr int kPoseSize = 6;
  static constexpr int kSize = 9;
  /// Shift, tilt, roll, yaw, width, gap, face form.
  [[nodiscard]] Eigen::Matrix<double, kSize, 1> Vector() const;
  static FrontState FromVector(const double* values);
};

/// What is asked of the front on a head.
struct PoseTask {
  const WearerHead* head = nullptr;
  FrameDesign design;
  FitGoals goals;
  GoalInputs inputs;
  FitSize size = FitSize::kKept;
  SizeLimits limits;
  /// Heights of the pupils over the box's lower edge that are wanted instead of a place over its centre, mm.
  std::array<std::optional<double>, 2> pupil_height;
  PointDensity density{6, 3};
  /// Added to the distances from the head on the right and the left side, mm: of what bears, and of all points (0, but
  /// for sigmas).
  std::array<double, 2> bearing_shift{0.0, 0.0};
  std::array<double, 2> skin_shift{0.0, 0.0};
};

/// The range of pupil_above_centre of one side: the goals', or about the height that is wanted.
[[nodiscard]] GoalRange PupilRange(const PoseTask& task, const FrontShape& front, std::size_t side);

/// The least-squares problem of a front: bearing on both flanks, clear of the skin, goals near their best values.
class PoseProblem {
 public:
  /// Fails if the design cannot be built.
  static Result<PoseProblem> Make(const PoseTask& task);

  [[nodiscard]] const PoseTask& task() const { return task_; }
  /// The same front with other inputs, shifts or goals. `task` must have this one's design, density and lens backs.
  [[nodiscard]] PoseProblem With(PoseTask task) const;
  /// The front of a state; of a kept size always the same.
  [[nodiscard]] Result<FrontShape> Front(const FrontState& state) const;
  /// The residuals at a state, and their Jacobian (rows by FrontState::kSize) if `jacobian` is not null: distances by
  /// the head's normal and rigid kinematics, goals by dual numbers, the size by differences of the frame. False if the
  /// frame cannot be built so.
  [[nodiscard]] bool Evaluate(const FrontState& state, Eigen::VectorXd& residuals, Eigen::MatrixXd* jacobian) const;
  [[nodiscard]] int residual_count() const;
  /// Where the search begins: pupils where they are wanted, usual vertex distance and tilt, level, design's size.
  [[nodiscard]] FrontState Start() const;

  struct Summary {
    FrontState state;
    double cost = 0.0;
    int iterations = 0;
  };
  /// Levenberg–Marquardt (Ceres) from `start`.
  [[nodiscard]] Summary Solve(const FrontState& start) const;
  /// Whether variable k of FrontState::Vector is solved for.
  [[nodiscard]] bool IsFree(int k) const;

 private:
  explicit PoseProblem(PoseTask task) : task_(std::move(task)) {}
  [[nodiscard]] FrameDesign DesignOf(const FrontState& state) const;

  PoseTask task_;
  std::shared_ptr<const FrontShape> front_;  ///< Of the design as it is; shared by copies.
};

}  // namespace annulus
