#include "modeling/landmarks/face_from_landmarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

namespace annulus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A landmark of the face point.
struct Entry {
  std::string_view id;
  FacePoint FacePoints::*member;
};
constexpr std::array<Entry, 6> kEntries{{{"eye_right", &FacePoints::eye_right},
                                         {"eye_left", &FacePoints::eye_left},
                                         {"otobasion_superius_right", &FacePoints::ear_right},
                                         {"otobasion_superius_left", &FacePoints::ear_left},
                                         {"sellion", &FacePoints::sellion},
                                         {"pronasale", &FacePoints::pronasale}}};

double SquareOr0(double sigma) { return std::isfinite(sigma) ? sigma * sigma : 0.0; }

/// The place moves along the surface as its theta and z do, and with the surface's own radius there.
Matrix3d CovarianceOf(const Landmark& landmark, const MeasuredSurface& head) {
  const double theta = landmark.theta.value;
  const double z = landmark.z.value;
  const RadiusJet jet = head.surface().Jet(theta, z);
  const Vector3d radial(std::cos(theta), std::sin(theta), 0.0);
  const Vector3d around(-std::sin(theta), std::cos(theta), 0.0);
  const Vector3d by_theta = jet.r_theta * radial + jet.r * around;
  const Vector3d by_z = jet.r_z * radial + Vector3d::UnitZ();
  const std::vector<Uncertain> place = head.WithSigmas({landmark.theta, landmark.z});
  const double across = landmark.placing_across / std::max(by_theta.norm(), 1.0);  // rad
  const double up = landmark.placing_up / by_z.norm();
  return (SquareOr0(place[0].sigma) + across * across) * by_theta * by_theta.transpose() +
         (SquareOr0(place[1].sigma) + up * up) * by_z * by_z.transpose() +
         SquareOr0(head.RadiusSigma(theta, z)) * radial * radial.transpose();
}

}  // namespace

Result<FacePoints> FaceFromLandmarks(const Landmarks& landmarks, const MeasuredSurface& head) {
  FacePoints face;
  for (const Entry& entry : kEntries) {
    const Landmark* const landmark = landmarks.Find(entry.id);
    if (landmark == nullptr) {
      return Fail("take the face points from the landmarks", fmt::format("there is no {}", entry.id),
                  "check that the model shows a head that faces +y, or set the landmark by hand");
    }
    face.*entry.member = {landmark->position, landmark->source, CovarianceOf(*landmark, head)};
  }
  face.forehead = ForeheadAbove(head.surface(), face.sellion);
  return face;
}

}  // namespace annulus
