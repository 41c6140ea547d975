#include "modeling/landmarks/eyeball.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/frames.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kUsualRadius = 12.4;  // mm
constexpr double kPointSd = 0.3;       // mm, of a point that follows the ball: weighs the usual radius
// The edges of open lids, which stand out of the ball, lie about so far above and below the pupil.
constexpr double kLid = 5.8;    // mm
constexpr double kLidSd = 1.8;  // mm

/// Which points count. Lids and skin lie outside the ball only: so outwards a point counts less far.
struct Tolerance {
  double inside;     ///< mm; a point deeper than this in the ball counts no more.
  double outside;    ///< mm; nor one farther out.
  double cap;        ///< mm from the ball's foremost point, seen from the front.
  double lid_loss;   ///< Share of its weight that a point at the lids' edges loses.
  double radius_sd;  ///< mm, about the usual radius.
};
constexpr Tolerance kCoarse{1.5, 1.5, 10.0, 0.97, 0.5};  // while searching
constexpr Tolerance kFine{0.6, 0.3, 10.0, 0.97, 0.5};    // at last
// At last, where so little follows the ball that noise or skin must be on it: many points count, and the radius more.
constexpr Tolerance kRough{1.2, 0.84, 12.0, 0.7, 0.25};
constexpr double kFineShare = 0.66;  // less than this is so little

constexpr int kSearchSteps = 8;
constexpr int kRounds = 6;
constexpr int kStepsPerRound = 12;
constexpr double kLessReach = 0.85;  // from step to step
constexpr double kConverged = 1e-4;  // mm
constexpr double kSettled = 0.02;    // mm, of the centre from round to round
constexpr double kLeastShare = 0.35;

/// A point of the surface and how much of it is seen.
struct Seen {
  Vector3d point;
  double theta;
};

/// A ball as it is sought.
struct Ball {
  Vector3d centre;
  double radius;
};

/// One point's part in the fit.
struct Part {
  double residual;   ///< mm, outside positive
  Vector3d outward;  ///< Unit vector from the centre.
  double window;     ///< Weight by the place on the cap.
  double weight;     ///< That, and how well it follows the ball (Tukey's biweight).
};

Part PartOf(const Ball& ball, const Vector3d& point, const Vector3d& forward, const Tolerance& tolerance) {
  const Vector3d from = point - ball.centre;
  const double distance = from.norm();
  Part part{distance - ball.radius, from / std::max(distance, 1e-9), 0.0, 0.0};
  const double ahead = forward.dot(from);
  const double beside = (distance * distance - ahead * ahead) / (tolerance.cap * tolerance.cap);
  if (beside >= 1.0 || ahead <= 0.0) return part;
  const double from_lid = (std::abs(from.z()) - kLid) / kLidSd;
  part.window = (1.0 - beside) * (1.0 - beside) * (1.0 - tolerance.lid_loss * std::exp(-0.5 * from_lid * from_lid));
  const double relative = part.residual / (part.residual > 0.0 ? tolerance.outside : tolerance.inside);
  if (std::abs(relative) < 1.0) part.weight = part.window * std::pow(1.0 - relative * relative, 2);
  return part;
}

/// How well points follow a ball.
struct Score {
  double window = 0.0;
  double weight = 0.0;
  double squares = 0.0;
  [[nodiscard]] double share() const { return window > 0.0 ? weight / window : 0.0; }
  [[nodiscard]] double spread() const { return weight > 0.0 ? std::sqrt(squares / weight) : 1e9; }
};

/// Gauss–Newton with biweights; the last step's length in mm says whether it settled.
struct Fitted {
  Ball ball;
  Score score;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  double step = 1e9;
};

void Improve(Fitted& fit, const std::vector<Seen>& points, const Vector3d& forward, const Tolerance& tolerance) {
  Score score;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Vector4d right = Vector4d::Zero();
  for (const Seen& seen : points) {
    const Part part = PartOf(fit.ball, seen.point, forward, tolerance);
    score.window += part.window;
    if (part.weight == 0.0) continue;
    const Vector4d slope(-part.outward.x(), -part.outward.y(), -part.outward.z(), -1.0);
    normal += part.weight * slope * slope.transpose();
    right -= part.weight * part.residual * slope;
    score.weight += part.weight;
    score.squares += part.weight * part.residual * part.residual;
  }
  // The usual radius, as an observation beside the points.
  const double prior = kPointSd * kPointSd / (tolerance.radius_sd * tolerance.radius_sd);
  normal(3, 3) += prior;
  right[3] -= prior * (fit.ball.radius - kUsualRadius);
  normal.diagonal().array() += 1e-9;
  Vector4d step = normal.ldlt().solve(right);
  const double longest = step.norm();
  if (longest > 2.0) step *= 2.0 / longest;
  fit.ball.centre += step.head<3>();
  fit.ball.radius += step[3];
  fit.score = score;
  fit.normal = normal;
  fit.step = longest;
}

/// The surface on a square of 1 mm cells around the ball's foremost point: moves with the ball, as no grid does.
std::vector<Seen> CapPoints(const SplineSurface& head, const Ball& ball, const Vector3d& forward) {
  const Vector3d front = ball.centre + ball.radius * forward;
  const double theta = std::atan2(front.y(), front.x());
  const double step = 1.0 / std::max(std::hypot(front.x(), front.y()), 20.0);
  constexpr int kHalf = 14;
  std::vector<Seen> points;
  for (int row = -kHalf; row <= kHalf; ++row) {
    const double z = front.z() + row;
    if (z < head.z_min() || z > head.z_max()) continue;
    for (int column = -kHalf; column <= kHalf; ++column) {
      const double at = theta + column * step;
      points.push_back({head.Point(at, z), at});
    }
  }
  return points;
}

/// Where an eye is looked for, mm: beside the root, and above it.
constexpr double kInnermost = 22.0;
constexpr double kOutermost = 44.0;
constexpr double kHighest = 6.0;
constexpr double kLowest = -24.0;

std::vector<Seen> RegionPoints(const HeadGrid& grid, const MidPlane& plane, const Vector3d& sellion, double sign) {
  const double root = plane.Lateral(sellion);
  const auto middle = static_cast<int>(std::lround(DegreesFromRadians(plane.yaw)));
  std::vector<Seen> points;
  for (int row = grid.RowAt(sellion.z() + kHighest + kCoarse.cap);
       row <= grid.RowAt(sellion.z() + kLowest - kCoarse.cap); row += 2) {
    for (int degree = middle - 60; degree <= middle + 60; ++degree) {
      const Vector3d point = grid.Point(degree, row);
      const double lateral = sign * (plane.Lateral(point) - root);
      if (lateral < kInnermost - kCoarse.cap || lateral > kOutermost + kCoarse.cap) continue;
      points.push_back({point, RadiansFromDegrees(degree)});
    }
  }
  return points;
}

/// The height of the surface along `forward` at a place beside the plane, from the nearest point of a list.
double ForwardNear(const std::vector<Seen>& points, const Vector3d& right, const Vector3d& forward, double lateral,
                   double z) {
  double nearest = 1e9;
  double ahead = 0.0;
  for (const Seen& seen : points) {
    const double across = right.dot(seen.point) - lateral;
    const double up = seen.point.z() - z;
    if (across * across + up * up >= nearest) continue;
    nearest = across * across + up * up;
    ahead = forward.dot(seen.point);
  }
  return ahead;
}

/// The best of the balls that start on a lattice over the region.
Fitted SearchBall(const std::vector<Seen>& points, const MidPlane& plane, const Vector3d& sellion, double sign) {
  constexpr double kLattice = 4.0;
  const Vector3d forward = plane.forward();
  const Vector3d right = plane.right();
  const double root = right.dot(sellion);
  Fitted best;
  for (double beside = kInnermost + 2.0; beside <= kOutermost - 2.0; beside += kLattice) {
    for (double up = kHighest - 2.0; up >= kLowest + 2.0; up -= kLattice) {
      const double lateral = root + sign * beside;
      const double z = sellion.z() + up;
      const double ahead = ForwardNear(points, right, forward, lateral, z) - kUsualRadius;
      Fitted fit{{lateral * right + ahead * forward + z * Vector3d::UnitZ(), kUsualRadius}, {}};
      for (int k = 0; k < kSearchSteps; ++k) Improve(fit, points, forward, kCoarse);
      const double moved = std::hypot(right.dot(fit.ball.centre) - lateral, fit.ball.centre.z() - z);
      if (fit.score.weight > best.score.weight && moved < 2.0 * kLattice) best = fit;
    }
  }
  return best;
}

/// The ball at last: on the surface itself, with ever less tolerance.
Fitted SettleBall(const SplineSurface& head, Fitted fit, const Vector3d& forward, const Tolerance& least) {
  Tolerance tolerance = kCoarse;
  double inside = kCoarse.inside;
  double outside = kCoarse.outside;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Seen> points = CapPoints(head, fit.ball, forward);
    const Vector3d before = fit.ball.centre;
    for (int k = 0; k < kStepsPerRound; ++k) {
      tolerance = least;
      tolerance.inside = std::max(least.inside, inside *= kLessReach);
      tolerance.outside = std::max(least.outside, outside *= kLessReach);
      Improve(fit, points, forward, tolerance);
      if (tolerance.outside == least.outside && fit.step < kConverged) break;
    }
    if (tolerance.outside == least.outside && (fit.ball.centre - before).norm() < kSettled) break;
  }
  return fit;
}

/// A lid's edge may hold the fit off to one side: of three starts, the ball that most of the surface follows.
Fitted SettleBest(const SplineSurface& head, const Fitted& found, const Vector3d& forward, const Tolerance& least) {
  Fitted best;
  for (const double shift : {0.0, 1.2, -1.2}) {
    Fitted start = found;
    start.ball.centre.z() += shift;
    const Fitted settled = SettleBall(head, start, forward, least);
    if (settled.score.weight > best.score.weight) best = settled;
  }
  return best;
}

/// The ball that a search or its mirror image leads to; empty where the surface does not follow it.
std::optional<Eyeball> EyeballFrom(const SplineSurface& head, const Fitted& start, const MidPlane& plane,
                                   const Vector3d& sellion, double sign) {
  const Vector3d forward = plane.forward();
  Fitted fit = SettleBest(head, start, forward, kFine);
  const bool is_rough = fit.score.share() < kFineShare;
  if (is_rough) fit = SettleBest(head, start, forward, kRough);
  const double beside = sign * (plane.Lateral(fit.ball.centre) - plane.Lateral(sellion));
  const double above = fit.ball.centre.z() - sellion.z();
  const bool is_there = beside > kInnermost && beside < kOutermost && above < kHighest && above > kLowest;
  if (!is_there || fit.score.share() < kLeastShare) return std::nullopt;
  return Eyeball{fit.ball.centre, fit.ball.radius, fit.score.spread(), fit.score.share(), is_rough};
}

/// Where the other side's ball would be if the head were its own mirror image.
Fitted Mirrored(const Eyeball& ball, const MidPlane& plane) {
  const Vector3d centre = ball.centre - 2.0 * plane.Lateral(ball.centre) * plane.right();
  Fitted fit;
  fit.ball = {centre, ball.radius};
  return fit;
}

bool ArePair(const Eyeballs& eyes, const MidPlane& plane) {
  constexpr double kMostUneven = 4.0;  // mm: faces are less uneven
  const double uneven = plane.Lateral(eyes.right->centre) + plane.Lateral(eyes.left->centre);
  return std::abs(eyes.right->centre.z() - eyes.left->centre.z()) < kMostUneven && std::abs(uneven) < 2.0 * kMostUneven;
}

}  // namespace

Eyeballs FindEyeballs(const SplineSurface& head, const HeadGrid& grid, const MidPlane& plane, const Vector3d& sellion) {
  const auto search = [&](double sign) -> std::optional<Eyeball> {
    const Fitted found = SearchBall(RegionPoints(grid, plane, sellion, sign), plane, sellion, sign);
    if (found.score.weight == 0.0) return std::nullopt;
    return EyeballFrom(head, found, plane, sellion, sign);
  };
  Eyeballs eyes{search(1.0), search(-1.0)};
  if (eyes.right && eyes.left && ArePair(eyes, plane)) return eyes;
  // One of them, or both, is something else: the pair that the surface follows best.
  Eyeballs best;
  const auto share = [](const Eyeballs& pair) {
    return pair.right && pair.left ? pair.right->share + pair.left->share : 0.0;
  };
  if (eyes.right) {
    const Eyeballs pair{eyes.right, EyeballFrom(head, Mirrored(*eyes.right, plane), plane, sellion, -1.0)};
    if (share(pair) > share(best) && ArePair(pair, plane)) best = pair;
  }
  if (eyes.left) {
    const Eyeballs pair{EyeballFrom(head, Mirrored(*eyes.left, plane), plane, sellion, 1.0), eyes.left};
    if (share(pair) > share(best) && ArePair(pair, plane)) best = pair;
  }
  return best;
}

EyeballEstimates EstimateEyeball(const SplineSurface& head, const MidPlane& plane, const Eyeball& ball) {
  const Vector3d forward = plane.forward();
  const std::vector<Seen> points = CapPoints(head, {ball.centre, ball.radius}, forward);
  Fitted fit{{ball.centre, ball.radius}, {}};
  const Tolerance& tolerance = ball.is_rough ? kRough : kFine;
  Improve(fit, points, forward, tolerance);
  const Eigen::Matrix4d inverse = fit.normal.inverse();
  GradientSum lateral(head);
  GradientSum up(head);
  for (const Seen& seen : points) {
    const Part part = PartOf({ball.centre, ball.radius}, seen.point, forward, tolerance);
    if (part.weight == 0.0) continue;
    const Vector4d slope(-part.outward.x(), -part.outward.y(), -part.outward.z(), -1.0);
    // The residual grows with the radius of the surface there by outward · e_r.
    const double by_radius = part.outward.dot(PointFromCylindrical(seen.theta, 1.0, 0.0));
    const Vector4d move = -part.weight * by_radius * (inverse * slope);
    lateral.AddRadius(seen.theta, seen.point.z(), plane.right().dot(move.head<3>()));
    up.AddRadius(seen.theta, seen.point.z(), move[2]);
  }
  return {{plane.right().dot(ball.centre), lateral.Get()}, {ball.centre.z(), up.Get()}};
}

}  // namespace annulus
