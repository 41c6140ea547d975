#include "modeling/glasses/front_pose.h"

#include <algorithm>
#include <cmath>

namespace annulus {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Eigen::Isometry3d FrontPose::HeadFromFrame() const {
  Eigen::Isometry3d head_from_frame = Eigen::Isometry3d::Identity();
  head_from_frame.linear() =
      (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(roll, Vector3d::UnitY()) * AngleAxisd(-tilt, Vector3d::UnitX()))
          .toRotationMatrix();
  head_from_frame.translation() = shift;
  return head_from_frame;
}

FrontPose PoseFrom(const Eigen::Isometry3d& head_from_frame) {
  const Eigen::Matrix3d r = head_from_frame.linear();
  FrontPose pose;
  pose.shift = head_from_frame.translation();
  pose.roll = std::asin(std::clamp(-r(2, 0), -1.0, 1.0));
  pose.tilt = -std::atan2(r(2, 1), r(2, 2));
  pose.yaw = std::atan2(r(1, 0), r(0, 0));
  return pose;
}

GoalNumbers<double> NumbersOf(const FrontShape& front, const GoalInputs& inputs, const FrontPose& pose) {
  const Eigen::Isometry3d head_from_frame = pose.HeadFromFrame();
  return NumbersOf<double>(front, inputs, head_from_frame.linear(), head_from_frame.translation());
}

}  // namespace annulus
