#pragma once

#include <Eigen/Geometry>
#include <array>

#include "modeling/glasses/front_shape.h"

namespace annulus {

/// How a front stands in the head frame: head_from_frame = shift after yaw about z after roll about y after -tilt about
/// x. A positive tilt brings the lower edge nearer to the face; a positive yaw turns the front to the wearer's left.
struct FrontPose {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< mm
  double tilt = 0.0;                                ///< rad
  double roll = 0.0;
  double yaw = 0.0;

  [[nodiscard]] Eigen::Isometry3d HeadFromFrame() const;
};

/// The pose whose HeadFromFrame this is; |roll| < 90°.
[[nodiscard]] FrontPose PoseFrom(const Eigen::Isometry3d& head_from_frame);

/// What the goals are measured against, head frame, mm.
struct GoalInputs {
  std::array<Eigen::Vector3d, 2> eyes;  ///< Right, left: the cornea's apex, on the surface.
  std::array<Eigen::Vector3d, 2> ears;
  Eigen::Matrix3d level = Eigen::Matrix3d::Identity();                      ///< Columns: right, line of sight, up.
  std::array<double, 2> lens_back{kLensBackBehindRim, kLensBackBehindRim};  ///< Behind the rim's plane.
};

/// The numbers that goals are about, right and left; mm and rad. T: double, or a dual number.
template <class T>
struct GoalNumbers {
  std::array<T, 2> vertex_distance;
  std::array<T, 2> decentration;        ///< Pupil towards the nose from the box centre.
  std::array<T, 2> pupil_above_centre;  ///< Over the box centre.
  std::array<T, 2> temple_splay;        ///< Outward from hinge to ear.
  T pantoscopic_tilt;
  T face_form;
  T roll;  ///< Of the front against the level.
  T yaw;
};

/// The numbers of a front in a pose. Instantiated for double and for dual numbers of the six pose variables (shift,
/// tilt, roll, yaw) where they are needed.
template <class T>
GoalNumbers<T> NumbersOf(const FrontShape& front, const GoalInputs& inputs, const Eigen::Matrix<T, 3, 3>& rotation,
                         const Eigen::Matrix<T, 3, 1>& shift) {
  using std::atan2;
  using Vector = Eigen::Matrix<T, 3, 1>;
  const Vector sight = inputs.level.col(1).template cast<T>();
  GoalNumbers<T> numbers;
  std::array<T, 2> turned_out;
  std::array<T, 2> tilts;
  for (std::size_t side = 0; side < 2; ++side) {
    const double outward = side == 0 ? 1.0 : -1.0;
    const LensPlane& lens = front.lenses[side];
    const Vector centre = rotation * lens.centre.template cast<T>() + shift;
    const Vector normal = rotation * lens.forward.template cast<T>();
    const Vector eye = inputs.eyes[side].template cast<T>();
    const T slope = sight.dot(normal);
    const T along = (centre - eye).dot(normal) / slope;
    const Vector hit = eye + along * sight - centre;
    numbers.vertex_distance[side] = along - inputs.lens_back[side] / slope;
    numbers.decentration[side] = -outward * hit.dot(rotation * lens.right.template cast<T>());
    numbers.pupil_above_centre[side] = hit.dot(rotation * lens.up.template cast<T>());
    const Vector levelled = inputs.level.transpose().template cast<T>() * normal;
    tilts[side] = atan2(-levelled.z(), levelled.y());
    turned_out[side] = atan2(outward * levelled.x(), levelled.y());
    const Vector hinge = rotation * front.hinges[side].template cast<T>() + shift;
    const Vector to_ear = inputs.ears[side].template cast<T>() - hinge;
    numbers.temple_splay[side] = atan2(outward * to_ear.x(), -to_ear.y());
  }
  numbers.pantoscopic_tilt = 0.5 * (tilts[0] + tilts[1]);
  numbers.face_form = 0.5 * (turned_out[0] + turned_out[1]);
  const Vector across = inputs.level.transpose().template cast<T>() * rotation.col(0);
  numbers.roll = atan2(across.z(), across.x());
  numbers.yaw = 0.5 * (turned_out[1] - turned_out[0]);
  return numbers;
}

/// Of a pose, in double precision.
[[nodiscard]] GoalNumbers<double> NumbersOf(const FrontShape& front, const GoalInputs& inputs, const FrontPose& pose);

}  // namespace annulus
