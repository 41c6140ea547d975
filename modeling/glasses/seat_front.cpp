#include "modeling/glasses/seat_front.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace annulus {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr PointDensity kDensity{10, 8};
constexpr double kExactWithin = 1.0;  // mm
constexpr double kTouch = 0.01;       // mm between what bears and the head
constexpr double kFree = 0.03;        // mm that all else keeps at least
constexpr double kGood = 0.008;       // mm
constexpr int kRounds = 25;
constexpr double kLargestMove = 2.0;  // mm per round
/// How dear a motion is: shift right, forward, up (mm), roll, yaw (rad).
constexpr std::array<double, 5> kPrice{1.0, 1.0, 2.0, 40.0, 80.0};

/// A distance that has to change, and how the five motions change it.
struct Demand {
  double change = 0.0;
  Eigen::Matrix<double, 5, 1> gradient;
};

class Seating {
 public:
  Seating(const WearerHead& head, const FrontShape& front, const std::vector<FrameShell>& shells, const FrontPose& pose)
      : head_(head), front_(front), skin_(shells), pose_(pose) {}

  SeatedFront Run() {
    SeatedFront best = Look();
    for (int round = 0; round < kRounds; ++round) {
      if (demands_.empty()) return best;
      Move();
      best = Look();
    }
    // Touching both flanks was not to be had: at least nothing enters.
    for (int round = 0; round < kRounds && Deepest(best) < 0.0; ++round) {
      pose_.shift.y() += kTouch - Deepest(best);
      best = Look();
    }
    return best;
  }

 private:
  static double Deepest(const SeatedFront& seated) {
    return std::min({seated.least, seated.bearing[0].distance, seated.bearing[1].distance});
  }

  /// The least distances now, and what has to change.
  SeatedFront Look() {
    WornPose pose;
    pose.head = &head_;
    pose.station_from_frame = head_.station_from_head() * pose_.HeadFromFrame();
    const std::vector<SkinPlace> places = skin_.Measure(pose, kDensity, kExactWithin);
    demands_.clear();
    SeatedFront seated;
    seated.pose = pose_;
    const auto bears = [&](const SkinPlace& place) {
      return MayBear(front_.design, skin_.parts()[place.part].role, place.position);
    };
    const bool is_rigid = front_.bearing == NoseBearing::kRigid;
    for (std::size_t side = 0; side < 2; ++side) {
      const double outward = side == 0 ? 1.0 : -1.0;
      seated.bearing[side] = skin_.Least(pose, kDensity, places, [&](const SkinPlace& place) {
        return is_rigid && bears(place) && outward * place.position.x() > 0.0;
      });
      if (is_rigid) Want(pose, seated.bearing[side], kTouch, kGood);
    }
    const SkinPlace other = skin_.Least(pose, kDensity, places, [&](const SkinPlace& place) {
      const FrameRole role = skin_.parts()[place.part].role;
      const bool is_bent = !is_rigid && (role == FrameRole::kPad || role == FrameRole::kPadArm);
      return !is_bent && !(is_rigid && bears(place));
    });
    seated.least = other.distance;
    if (other.distance < 0.5 * kFree) Want(pose, other, kFree, 0.0);
    return seated;
  }

  void Want(const WornPose& pose, const SkinPlace& place, double distance, double tolerance) {
    const double change = distance - place.distance;
    if (std::abs(change) <= tolerance || place.distance > 1e6) return;
    const Vector3d p_in_station = pose.station_from_frame * place.position;
    const NearestOnHead foot = head_.skin().Nearest(p_in_station);
    const Vector3d off = p_in_station - foot.position;
    // Nearly touching, the direction to the foot is rounding: the surface's normal is the same.
    const Vector3d normal =
        off.norm() > 0.05 ? Vector3d(off / foot.distance) : head_.skin().surface().Normal(foot.theta, foot.z);
    const Vector3d n = head_.station_from_head().linear().transpose() * normal;
    const Vector3d lever = (pose_.HeadFromFrame().linear() * place.position).cross(n);
    Demand demand;
    demand.change = std::clamp(change, -kLargestMove, kLargestMove);
    demand.gradient << n, lever.y(), lever.z();
    demands_.push_back(demand);
  }

  /// The cheapest motion that makes all changes to first order.
  void Move() {
    const auto count = static_cast<Eigen::Index>(demands_.size());
    MatrixXd gradients(count, 5);
    VectorXd changes(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      gradients.row(k) = demands_[static_cast<std::size_t>(k)].gradient.transpose();
      changes[k] = demands_[static_cast<std::size_t>(k)].change;
    }
    const Eigen::Matrix<double, 5, 1> price = Eigen::Map<const Eigen::Matrix<double, 5, 1>>(kPrice.data());
    const Eigen::Matrix<double, 5, 1> ease = price.array().square().inverse();
    MatrixXd normal = gradients * ease.asDiagonal() * gradients.transpose();
    normal.diagonal().array() += 1e-4;
    const VectorXd motion = ease.asDiagonal() * gradients.transpose() * normal.ldlt().solve(changes);
    pose_.shift += motion.head<3>();
    pose_.roll += motion[3];
    pose_.yaw += motion[4];
  }

  const WearerHead& head_;
  const FrontShape& front_;
  FrameSkin skin_;
  FrontPose pose_;
  std::vector<Demand> demands_;
};

}  // namespace

Result<SeatedFront> SeatFront(const WearerHead& head, const FrontShape& front, const FrontPose& pose) {
  const auto shells = FrontShells(front.design, StandardAdjustment(front.design));
  RETURN_IF_ERROR(shells);
  return Seating(head, front, *shells, pose).Run();
}

}  // namespace annulus
