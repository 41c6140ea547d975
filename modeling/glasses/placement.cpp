#include "modeling/glasses/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr const char* kAttempt = "place the frame on the head";

/// Pupillary distances outside this are no face's, mm.
constexpr double kSmallestSpacing = 30.0;
constexpr double kLargestSpacing = 100.0;
/// ClearHead gives up beyond this, mm.
constexpr double kLargestShift = 40.0;
/// Step of ClearHead's search, mm; a thinner ridge of the head would not stop it.
constexpr double kShiftStep = 0.5;
/// Points of the rims and the bridge that ClearHead looks at.
constexpr ShellTessellation kContactPoints{12, 6};

Status CheckFace(const FacePoints& face) {
  for (const NamedFacePoint& point : FacePointNames()) {
    if (!(face.*point.member).position.allFinite()) {
      return Fail(kAttempt, fmt::format("{} is not a number", point.name), "give its x, y and z in mm");
    }
  }
  const double spacing = face.eye_right.position.x() - face.eye_left.position.x();
  if (!(spacing > kSmallestSpacing && spacing < kLargestSpacing)) {
    return Fail(kAttempt, fmt::format("the right eye is {:.1f} mm to the right of the left eye", spacing),
                "check the eye centres: x to the subject's right, 30 … 100 mm apart");
  }
  return {};
}

struct Pose {
  FrameDesign design;
  Eigen::Isometry3d station_from_frame;
};

/// Steps 1 to 3 solved together. Rotations: first the tilt about x, then the roll about y; the rim centres lie on the
/// tilt's axis through the origin, so that step 1 fixes roll, size, x and z, and step 2 then fixes y. A tilt about P3P4
/// differs from one about O0O0' by a translation only.
Pose SolveSteps1To3(const FrameDesign& design, const FacePoints& face, double tilt) {
  const Vector3d right = face.eye_right.position;
  const Vector3d left = face.eye_left.position;
  const double dx = right.x() - left.x();
  const double dz = right.z() - left.z();
  Pose pose;
  pose.design = ScaledToSpacing(design, std::hypot(dx, dz));
  const double roll = std::atan2(-dz, dx);  // About +y: turns +x towards -z.
  const Eigen::Matrix3d rotation =
      (Eigen::AngleAxisd(roll, Vector3d::UnitY()) * Eigen::AngleAxisd(-tilt, Vector3d::UnitX())).toRotationMatrix();
  const double c_forward = (rotation * BridgeCentre(pose.design)).y();
  pose.station_from_frame.setIdentity();
  pose.station_from_frame.linear() = rotation;
  pose.station_from_frame.translation() =
      Vector3d(0.5 * (right.x() + left.x()), face.forehead.position.y() - c_forward, 0.5 * (right.z() + left.z()));
  return pose;
}

double FrontalDistance(const Vector3d& a, const Vector3d& b) { return std::hypot(a.x() - b.x(), a.z() - b.z()); }

/// Step 4 for the current pose, and what is left of all steps on the finished frame.
Result<WornFrame> WithTemples(WornFrame worn) {
  const Eigen::Isometry3d& station_from_frame = worn.station_from_frame;
  const Eigen::Isometry3d frame_from_station = station_from_frame.inverse();
  worn.adjustment.temple_right.ear = frame_from_station * worn.face.ear_right.position;
  worn.adjustment.temple_left.ear = frame_from_station * worn.face.ear_left.position;
  const Result<Frame> frame = BuildWornFrame(worn);
  RETURN_IF_ERROR(frame);
  worn.l6_right = frame->arm_right.l6;
  worn.l6_left = frame->arm_left.l6;
  const Vector3d q30_right = frame->arm_right.ear_point;
  const Vector3d q30_left = frame->arm_left.ear_point;
  worn.residuals.eye_right =
      FrontalDistance(station_from_frame * frame->rim_centre_right(), worn.face.eye_right.position);
  worn.residuals.eye_left = FrontalDistance(station_from_frame * frame->rim_centre_left(), worn.face.eye_left.position);
  worn.residuals.bridge = std::abs((station_from_frame * frame->bridge_centre()).y() -
                                   (worn.face.forehead.position.y() + worn.forward_shift));
  worn.residuals.ear_right = (station_from_frame * q30_right - worn.face.ear_right.position).norm();
  worn.residuals.ear_left = (station_from_frame * q30_left - worn.face.ear_left.position).norm();
  return worn;
}

/// Distance of a point to the head along the normal's first-order estimate, mm; negative inside. Above the head's top
/// and below its cut nothing is in the way.
double Gap(const SplineSurface& head, const Vector3d& p) {
  if (p.z() < head.z_min() || p.z() > head.z_max()) return kLargestShift;
  const RadiusJet jet = head.Jet(std::atan2(p.y(), p.x()), p.z());
  const double slope_theta = jet.r_theta / std::max(jet.r, 1.0);
  return (std::hypot(p.x(), p.y()) - jet.r) / std::sqrt(1.0 + slope_theta * slope_theta + jet.r_z * jet.r_z);
}

double SmallestGap(const SplineSurface& head, const std::vector<Vector3d>& points, double forward) {
  double smallest = kLargestShift;
  for (const Vector3d& point : points) smallest = std::min(smallest, Gap(head, point + Vector3d(0.0, forward, 0.0)));
  return smallest;
}

/// Rims and bridge as points in the station frame.
std::vector<Vector3d> ContactPoints(const Frame& frame, const Eigen::Isometry3d& station_from_frame) {
  std::vector<Vector3d> points;
  for (const FrameMesh& part : TessellateFrameParts(frame, kContactPoints)) {
    if (part.name.rfind("rim", 0) != 0 && part.name != "bridge") continue;
    for (const Vector3d& vertex : part.mesh.vertices) points.push_back(station_from_frame * vertex);
  }
  return points;
}

TriangleMesh Moved(TriangleMesh mesh, const Eigen::Isometry3d& station_from_frame) {
  for (Vector3d& vertex : mesh.vertices) vertex = station_from_frame * vertex;
  return mesh;
}

}  // namespace

Result<WornFrame> PlaceFrame(const FrameDesign& design, const FacePoints& face, double tilt) {
  RETURN_IF_ERROR(Validate(design));
  RETURN_IF_ERROR(CheckFace(face));
  if (!(std::abs(tilt) <= RadiansFromDegrees(30.0))) {
    return Fail(kAttempt, fmt::format("the tilt is {:.1f} degrees", DegreesFromRadians(tilt)),
                "choose -30 to 30 degrees");
  }
  const Pose pose = SolveSteps1To3(design, face, tilt);
  WornFrame worn;
  worn.design = pose.design;
  worn.adjustment = StandardAdjustment(pose.design);
  worn.station_from_frame = pose.station_from_frame;
  worn.face = face;
  worn.tilt = tilt;
  return WithTemples(std::move(worn));
}

Result<WornFrame> ClearHead(const WornFrame& worn, const SplineSurface& head, double clearance) {
  const Result<Frame> frame = BuildWornFrame(worn);
  RETURN_IF_ERROR(frame);
  const std::vector<Vector3d> points = ContactPoints(*frame, worn.station_from_frame);
  double clear = 0.0;
  while (SmallestGap(head, points, clear) < clearance) {
    clear += kShiftStep;
    if (clear > kLargestShift) {
      return Fail("move the frame clear of the head",
                  fmt::format("{:.0f} mm forward still leave it {:.1f} mm from the head", kLargestShift,
                              SmallestGap(head, points, kLargestShift)),
                  "check the face points, or choose a smaller bridge height");
    }
  }
  double blocked = clear - kShiftStep;
  for (int step = 0; step < 20 && clear > 0.0; ++step) {
    const double middle = 0.5 * (blocked + clear);
    (SmallestGap(head, points, middle) < clearance ? blocked : clear) = middle;
  }
  WornFrame moved = worn;
  moved.forward_shift = worn.forward_shift + clear;
  moved.station_from_frame.translation().y() += clear;
  moved.clearance = SmallestGap(head, points, clear);
  return WithTemples(std::move(moved));
}

Result<Frame> BuildWornFrame(const WornFrame& worn) { return BuildFrame(worn.design, worn.adjustment); }

Result<WornMeshes> TessellateWornFrame(const WornFrame& worn, const ShellTessellation& tessellation,
                                       std::size_t lens_steps) {
  const Result<Frame> frame = BuildWornFrame(worn);
  RETURN_IF_ERROR(frame);
  WornMeshes meshes{TessellateFrameParts(*frame, tessellation), TessellateLenses(*frame, lens_steps)};
  for (FrameMesh& part : meshes.parts) part.mesh = Moved(std::move(part.mesh), worn.station_from_frame);
  for (FrameMesh& lens : meshes.lenses) lens.mesh = Moved(std::move(lens.mesh), worn.station_from_frame);
  return meshes;
}

}  // namespace annulus
