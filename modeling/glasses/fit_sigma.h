#pragma once

#include <Eigen/Core>
#include <array>

#include "modeling/glasses/pose_problem.h"

namespace annulus {

/// The goals' numbers in the order of the report: what has a sigma.
enum class GoalValue {
  kPd,  ///< Between the pupils, mm.
  kPdRight,
  kPdLeft,  ///< From the frame's middle to the pupil in the lens' plane, mm.
  kHeightRight,
  kHeightLeft,  ///< Of the pupil over the box's lower edge, mm.
  kVertexRight,
  kVertexLeft,       ///< mm
  kPantoscopicTilt,  ///< rad
  kFaceForm,         ///< rad
  kSplayRight,
  kSplayLeft,  ///< rad
  kTempleRight,
  kTempleLeft,  ///< Hinge to ear point, mm.
  kDbl,         ///< Between the lenses, mm; certain of a kept size.
  kCount
};
using GoalVector = Eigen::Matrix<double, static_cast<int>(GoalValue::kCount), 1>;

/// All numbers of a front in a pose.
[[nodiscard]] GoalVector ValuesOf(const FrontShape& front, const GoalInputs& inputs, const FrontPose& pose);

/// Their sds, from eyes, ears, level and the skin where the front bears, each independent of the others: a kept size is
/// solved again with each of them moved by 1 sd to either side, a made-to-measure one followed to first order (implicit
/// differentiation of the least-squares solution). `bearing`: where on the head, station frame.
/// NaN where the surface carries no covariance.
[[nodiscard]] GoalVector SigmasOf(const PoseProblem& problem, const FrontState& state,
                                  const std::array<Eigen::Vector3d, 2>& bearing);

}  // namespace annulus
