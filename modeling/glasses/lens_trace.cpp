#include "modeling/glasses/lens_trace.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <optional>

namespace annulus {
namespace {

tl::unexpected<Error> Refuse(const char* seen) {
  return Fail("trace a ray through the lens", seen, "use a flatter lens, less tilt or a smaller angle of gaze");
}

/// Vergence (1/mm, positive converging) as a symmetric 3 × 3 matrix on the plane across the ray; multiplied by the
/// index of its medium. Equating the phases n(k·r − ½ rᵀVr) of both sides on the surface r = t − ½(tᵀKt)N gives, for
/// all tangents t, n'tᵀV't = n·tᵀVt + (n k·N − n' k'·N) tᵀKt; each e across k' belongs to the tangent that lies behind
/// it along k'. This is the generalised Coddington equation without its rotations.
Eigen::Matrix3d RefractedVergence(const Eigen::Matrix3d& reduced, const SurfaceHit& hit, const Eigen::Vector3d& before,
                                  double index_before, const Eigen::Vector3d& behind, double index_behind) {
  const double gain = index_before * before.dot(hit.normal) - index_behind * behind.dot(hit.normal);
  const Eigen::Matrix3d on_surface = reduced + gain * hit.curvature;
  const Eigen::Matrix3d lift = Eigen::Matrix3d::Identity() - behind * hit.normal.transpose() / behind.dot(hit.normal);
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - behind * behind.transpose();
  const Eigen::Matrix3d lifted = lift * across;
  return lifted.transpose() * on_surface * lifted;
}

/// V·(I − d·V)⁻¹ for the reduced vergence n·V after `distance` mm in a medium of `index`.
Eigen::Matrix3d Transferred(const Eigen::Matrix3d& reduced, double distance, double index) {
  const Eigen::Matrix3d step = Eigen::Matrix3d::Identity() - (distance / index) * reduced;
  return reduced * step.inverse();
}

/// A ray as seen from the eye's side: where it leaves the back surface and along what it looks.
struct ChiefRay {
  SurfaceHit back;
  Eigen::Vector3d in_eye;  ///< Unit, forward, between lens and eye.
};

/// The wavefront behind the lens for a distant object, and the prism, along a chief ray. `axes` are two unit vectors
/// across the ray in the eye's space.
Result<TracedPower> TraceChief(const LensForm& form, const ChiefRay& chief, const Eigen::Matrix<double, 3, 2>& axes,
                               double behind_back) {
  const auto in_glass = RefractedDirection(chief.in_eye, chief.back.normal, 1.0 / form.index);
  if (!in_glass) return Refuse("the ray does not enter the back surface");
  const auto front = Meet(form.front, chief.back.point, *in_glass);
  if (!front) return Refuse("the ray misses the front surface");
  const auto outside = RefractedDirection(*in_glass, front->normal, form.index);
  if (!outside) return Refuse("the ray is totally reflected at the front surface");
  // Light runs the other way.
  const double path = (front->point - chief.back.point).norm();
  const Eigen::Matrix3d behind_front =
      RefractedVergence(Eigen::Matrix3d::Zero(), *front, -*outside, 1.0, -*in_glass, form.index);
  const Eigen::Matrix3d before_back = Transferred(behind_front, path, form.index);
  const Eigen::Matrix3d behind_lens =
      RefractedVergence(before_back, chief.back, -*in_glass, form.index, -chief.in_eye, 1.0);
  TracedPower traced;
  traced.power = 1000.0 * (axes.transpose() * Transferred(behind_lens, behind_back, 1.0) * axes);
  traced.prism = 100.0 * (axes.transpose() * *outside) / outside->dot(chief.in_eye);
  traced.front_point = front->point;
  traced.back_point = chief.back.point;
  if (!traced.power.allFinite() || !traced.prism.allFinite()) return Refuse("the light comes to a focus in the lens");
  return traced;
}

}  // namespace

std::optional<Eigen::Vector3d> RefractedDirection(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                                                  double ratio) {
  const double cosine = direction.dot(normal);
  const double inside = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
  if (!(inside >= 0.0)) return std::nullopt;
  return ratio * direction + (std::copysign(std::sqrt(inside), cosine) - ratio * cosine) * normal;
}

Eigen::Vector3d DirectionOf(const Gaze& gaze) {
  return {std::sin(gaze.left) * std::cos(gaze.up), std::sin(gaze.up), std::cos(gaze.left) * std::cos(gaze.up)};
}

Gaze GazeAlong(const Eigen::Vector3d& direction) {
  return {std::atan2(direction.x(), direction.z()),
          std::atan2(direction.y(), std::hypot(direction.x(), direction.z()))};
}

Eigen::Matrix3d ViewFromTurned(const Gaze& gaze) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), DirectionOf(gaze)).toRotationMatrix();
}

LensPose PoseOf(double pantoscopic, double face_form, double vertex_distance, Eye eye) {
  const double outward = eye == Eye::kRight ? -face_form : face_form;
  LensPose pose;
  pose.view_from_lens = Eigen::AngleAxisd(pantoscopic, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                        Eigen::AngleAxisd(outward, Eigen::Vector3d::UnitY()).toRotationMatrix();
  pose.vertex_distance = vertex_distance;
  return pose;
}

Result<TracedPower> TraceAsWorn(const LensForm& form, const LensPose& pose, const Gaze& gaze) {
  const Eigen::Matrix3d lens_from_view = pose.view_from_lens.transpose();
  const double to_centre = pose.vertex_distance + kRotationCentreBehindCornea;
  const Eigen::Vector3d rotation_centre = form.back_point - to_centre * lens_from_view.col(2);
  const Eigen::Matrix3d turned = lens_from_view * ViewFromTurned(gaze);
  const auto back = Meet(form.back, rotation_centre, turned.col(2));
  if (!back) return Refuse("the line of sight misses the back surface");
  const double behind_back = (back->point - rotation_centre).norm() - to_centre;
  return TraceChief(form, {*back, turned.col(2)}, turned.leftCols<2>(), behind_back);
}

Result<TracedPower> TraceFocimeter(const LensForm& form) {
  const auto back = Meet(form.back, form.back_point, form.optical_axis);
  if (!back) return Refuse("the optical axis misses the back surface");
  const Eigen::Matrix3d lens_from_focimeter =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), back->normal).toRotationMatrix();
  return TraceChief(form, {*back, back->normal}, lens_from_focimeter.leftCols<2>(), 0.0);
}

}  // namespace annulus
