#include "modeling/glasses/frame_skin.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Places so much farther than the least one may become it when refined, mm.
constexpr double kMayBeLeast = 0.15;
constexpr std::size_t kMostRefined = 4;
constexpr int kNetRounds = 4;

}  // namespace

const HeadDistance& WornPose::Obstacle(const Vector3d& p) const {
  const double ear_y = p.x() > 0.0 ? ear_y_right : ear_y_left;
  return p.y() < ear_y - kBehindEar ? head->skin_without_ears() : head->skin();
}

NearestOnHead WornPose::Nearest(const Vector3d& p) const { return Obstacle(p).Nearest(station_from_frame * p); }

FrameSkin::FrameSkin(const std::vector<FrameShell>& shells) {
  for (const FrameShell& shell : shells) {
    for (const ShellPatch& patch : shell.shell.patches) {
      patches_.push_back({patch.patch, parts_.size(), patch.u, patch.v});
    }
    parts_.push_back({shell.part, shell.role});
  }
}

std::vector<SkinPlace> FrameSkin::Measure(const WornPose& pose, const PointDensity& density,
                                          double exact_within) const {
  std::vector<SkinPlace> places;
  for (std::size_t k = 0; k < patches_.size(); ++k) {
    const Patch& patch = patches_[k];
    const int count_u = StepsOf(patch.detail_u, density);
    const int count_v = StepsOf(patch.detail_v, density);
    for (int i = 0; i < count_u; ++i) {
      for (int j = 0; j < count_v; ++j) {
        SkinPlace place{patch.part, k, static_cast<double>(i) / count_u, static_cast<double>(j) / count_v, {}, 0.0};
        place.position = patch.patch.Point(place.u, place.v);
        const HeadDistance& obstacle = pose.Obstacle(place.position);
        const Vector3d p_in_station = pose.station_from_frame * place.position;
        place.distance = obstacle.FirstOrder(p_in_station).distance;
        if (std::abs(place.distance) < exact_within) place.distance = obstacle.Nearest(p_in_station).distance;
        places.push_back(place);
      }
    }
  }
  return places;
}

SkinPlace FrameSkin::Refined(const WornPose& pose, const PointDensity& density, const SkinPlace& from) const {
  const Patch& patch = patches_[from.patch];
  double step_u = 0.5 / StepsOf(patch.detail_u, density);
  double step_v = 0.5 / StepsOf(patch.detail_v, density);
  SkinPlace best = from;
  best.distance = pose.Nearest(from.position).distance;
  for (int round = 0; round < kNetRounds; ++round) {
    const SkinPlace middle = best;
    const int reach = round == 0 ? 2 : 1;
    for (int i = -reach; i <= reach; ++i) {
      for (int j = -reach; j <= reach; ++j) {
        if (i == 0 && j == 0) continue;
        SkinPlace place = middle;
        place.u = std::clamp(middle.u + i * step_u, 0.0, 1.0);
        place.v = std::clamp(middle.v + j * step_v, 0.0, 1.0);
        place.position = patch.patch.Point(place.u, place.v);
        place.distance = pose.Nearest(place.position).distance;
        if (place.distance < best.distance) best = place;
      }
    }
    step_u *= 0.5;
    step_v *= 0.5;
  }
  return best;
}

SkinPlace FrameSkin::Least(const WornPose& pose, const PointDensity& density, const std::vector<SkinPlace>& measured,
                           const std::function<bool(const SkinPlace&)>& accept) const {
  std::vector<const SkinPlace*> accepted;
  for (const SkinPlace& place : measured) {
    if (accept(place)) accepted.push_back(&place);
  }
  SkinPlace best;
  best.distance = 1e9;
  if (accepted.empty()) return best;
  std::stable_sort(accepted.begin(), accepted.end(),
                   [](const SkinPlace* a, const SkinPlace* b) { return a->distance < b->distance; });
  // One per patch: a net covers what lies about its place.
  std::vector<std::size_t> done;
  for (const SkinPlace* place : accepted) {
    if (place->distance > accepted.front()->distance + kMayBeLeast || done.size() >= kMostRefined) break;
    if (std::find(done.begin(), done.end(), place->patch) != done.end()) continue;
    done.push_back(place->patch);
    const SkinPlace refined = Refined(pose, density, *place);
    if (refined.distance < best.distance) best = refined;
  }
  return best;
}

}  // namespace annulus
