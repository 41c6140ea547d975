#include "modeling/glasses/lens_form.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/units.h"
#include "modeling/glasses/lens_thickness.h"

namespace annulus {
namespace {

constexpr const char* kAttempt = "design the lens";
constexpr int kMostThicknessSteps = 60;
constexpr int kMostScans = 30;
constexpr double kBoundaryStep = 0.4;    // mm
constexpr double kThicknessDone = 1e-9;  // mm
constexpr int kMostNewtonSteps = 12;
constexpr int kMostRounds = 30;
constexpr double kPowerDone = 1e-9;    // D and cm/m, at a fixed thickness
constexpr double kCompensated = 1e-6;  // D and cm/m, thickness and power together
constexpr double kDifference = 1e-4;   // D and cm/m, for the numeric Jacobian

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

Vector5d Packed(const PowerMatrix& power, const Eigen::Vector2d& prism) {
  Vector5d packed;
  packed << power(0, 0), power(0, 1), power(1, 1), prism.x(), prism.y();
  return packed;
}

LensOrder Unpacked(const Vector5d& packed) {
  LensOrder order;
  order.power << packed[0], packed[1], packed[1], packed[2];
  order.prism = packed.tail<2>();
  return order;
}

/// The angle between the back's normal and the optical axis that makes `prism` (cm/m). The focimeter's ray leaves the
/// back along its normal and meets the front at i with sin i = (1 − t/R1)·sin τ; it is bent there by δ =
/// atan(prism/100) when tan i = sin δ / (n − cos δ).
double PrismTilt(const LensFormSpec& spec, double front_curvature, double thickness, double prism) {
  const double deviation = std::atan(prism / 100.0);
  const double incidence = std::atan2(std::sin(deviation), spec.index - std::cos(deviation));
  return std::asin(std::sin(incidence) / (1.0 - thickness * front_curvature));
}

/// The back's normal: the optical axis leaned by `tilt` towards the base, for where the lens is thicker the back falls
/// away. `base` (unit) is as a focimeter sees it, whose x, y are carried from the lens's by the shortest turn to this
/// very normal: hence the loop (each round leaves a few thousandths of the last error).
Eigen::Vector3d PrismNormal(const Eigen::Vector3d& optical_axis, const Eigen::Vector2d& base, double tilt) {
  constexpr int kRounds = 6;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), optical_axis);
  Eigen::Rotation2Dd correction(0.0);
  Eigen::Vector3d normal = optical_axis;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector2d turned = correction * base;
    const Eigen::Vector3d lean = upright * Eigen::Vector3d(turned.x(), turned.y(), 0.0);
    normal = std::cos(tilt) * optical_axis + std::sin(tilt) * lean;
    const Eigen::Vector3d deflection = std::cos(tilt) * lean - std::sin(tilt) * optical_axis;
    const Eigen::Vector3d seen =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal).conjugate() * deflection;
    const double error = std::atan2(base.x() * seen.y() - base.y() * seen.x(), base.dot(seen.head<2>()));
    correction *= Eigen::Rotation2Dd(-error);
  }
  return normal;
}

/// The back surface of the curvatures (1/mm, x and y of its own upright frame) at `vertex` with the normal `normal`.
LensSurface BackSurface(const Eigen::Matrix2d& curvatures, const Eigen::Vector3d& vertex,
                        const Eigen::Vector3d& normal) {
  // As a power matrix "S" is the algebraically largest curvature, along its axis.
  const SpheroCylinder principal = SpheroCylinderFrom(curvatures);
  const double along = principal.sphere;
  const double across = principal.sphere + principal.cylinder;
  const bool along_is_steeper = std::abs(along) >= std::abs(across);
  const double meridian = along_is_steeper ? principal.axis : principal.axis + kPi / 2.0;
  LensSurface back;
  back.curvature_u = along_is_steeper ? along : across;
  back.curvature_v = along_is_steeper ? across : along;
  back.lens_from_surface.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal).toRotationMatrix();
  if (back.curvature_u != back.curvature_v) {
    back.lens_from_surface.linear() *= Eigen::AngleAxisd(meridian, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  back.lens_from_surface.translation() = vertex;
  return back;
}

/// Points on the outline's sides, at most kBoundaryStep apart: between them the thickness bends by less than a micron
/// or so.
std::vector<Eigen::Vector2d> BoundaryOf(const LensOutline& outline) {
  std::vector<Eigen::Vector2d> boundary;
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    const Eigen::Vector2d& from = outline.points[i];
    const Eigen::Vector2d& to = outline.points[i + 1 == outline.points.size() ? 0 : i + 1];
    const auto parts = static_cast<std::size_t>(std::max(1.0, std::ceil((to - from).norm() / kBoundaryStep)));
    for (std::size_t part = 0; part < parts; ++part) {
      boundary.emplace_back(from + static_cast<double>(part) / static_cast<double>(parts) * (to - from));
    }
  }
  return boundary;
}

/// The edge of a lens: where it is thinnest, and how thick at most.
struct BoundaryScan {
  bool reached = true;  ///< Both surfaces reach everywhere.
  Eigen::Vector2d thinnest = Eigen::Vector2d::Zero();
  double thickest = 0.0;  ///< mm.
};
BoundaryScan Scan(const LensForm& form, const std::vector<Eigen::Vector2d>& boundary) {
  BoundaryScan scan;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& point : boundary) {
    const double thickness = form.Thickness(point.x(), point.y());
    if (!std::isfinite(thickness)) return {false, point, 0.0};
    scan.thickest = std::max(scan.thickest, thickness);
    if (thickness < least) {
      least = thickness;
      scan.thinnest = point;
    }
  }
  return scan;
}

/// From a point inside to the outline, mm.
double DistanceToEdge(const LensOutline& outline, const Eigen::Vector2d& point) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    const Eigen::Vector2d& from = outline.points[i];
    const Eigen::Vector2d side = outline.points[i + 1 == outline.points.size() ? 0 : i + 1] - from;
    const double share = std::clamp((point - from).dot(side) / side.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (from + share * side - point).norm());
  }
  return least;
}

/// How much thicker (mm, negative: thinner) the lens must be for the rule, if its edge is thinnest at `thinnest`.
double MissingThickness(const LensForm& form, const Eigen::Vector2d& thinnest, const LensOutline& outline,
                        const ThicknessRule& rule) {
  const double edge = form.Thickness(thinnest.x(), thinnest.y());
  double missing = std::max(rule.minimum_centre - form.centre_thickness, rule.minimum_edge - edge);
  const std::optional<InnerExtreme> inner = InnerExtremeOf(form, outline);
  if (inner && inner->minimum) {
    missing = std::max(missing, MinimumInside(rule, DistanceToEdge(outline, inner->position)) - inner->thickness);
  }
  return missing;
}

tl::unexpected<Error> TooThick(double thickness, const ThicknessRule& rule) {
  return Fail(kAttempt, fmt::format("it would be {:.1f} mm thick, more than {:.1f} mm", thickness, rule.largest),
              "use a smaller frame, less decentration or a higher index");
}

/// Thickens (or thins) the lens until nothing is missing at one point of the edge.
Result<LensForm> KeepRuleAt(const Eigen::Vector2d& thinnest, const LensForm& start, const LensFormSpec& spec,
                            const LensOrder& order, const LensOutline& outline, const ThicknessRule& rule) {
  LensForm form = start;
  for (int step = 0; step < kMostThicknessSteps; ++step) {
    const double missing = MissingThickness(form, thinnest, outline, rule);
    if (std::abs(missing) < kThicknessDone) return form;
    const double thickness = form.centre_thickness + missing;
    if (!(thickness < 2.0 * rule.largest)) return TooThick(thickness, rule);
    const Result<LensForm> next = BuildLensForm(spec, order, thickness);
    if (!next && thickness > rule.largest) return TooThick(thickness, rule);
    if (!next) return Fail(next);
    form = *next;
  }
  return Fail(kAttempt, "no thickness keeps the minima", "use a smaller frame or a weaker lens");
}

tl::unexpected<Error> DoesNotReach(const LensForm& form, const LensOutline& outline) {
  const double radius = BoxOf(outline).ed / 2.0;
  const double front = std::abs(1.0 / form.front.curvature_u);
  const double back = std::abs(1.0 / form.back.curvature_u);
  return Fail(kAttempt,
              fmt::format("the front (radius {:.1f} mm) and the back (steepest radius {:.1f} mm) do not both reach the "
                          "edge {:.1f} mm from the box centre",
                          front, back, radius),
              "use a smaller frame, a flatter base curve or a higher index");
}

/// What the goal is about, of a lens made to `order`.
Result<Vector5d> WornNumbers(const LensForm& form, const Vector5d& order, const WornGoal& goal) {
  const Result<TracedPower> traced = TraceAsWorn(form, goal.pose);
  if (!traced) return Fail(traced);
  const Eigen::Vector2d ordered = order.tail<2>();
  return Packed(traced->power, goal.prism == PrismGoal::kAsWorn ? traced->prism : ordered);
}
Result<Vector5d> WornNumbers(const LensFormSpec& spec, const Vector5d& order, double thickness, const WornGoal& goal) {
  const Result<LensForm> form = BuildLensForm(spec, Unpacked(order), thickness);
  if (!form) return Fail(form);
  return WornNumbers(*form, order, goal);
}

/// The order needs the thickness and the thickness the order: the thickness t for which the order solved at t needs
/// just t, by the secant rule.
class ThicknessSearch {
 public:
  /// The thickness to try after the last one tried turned out to need `needed`.
  double Next(double needed) {
    const double excess = needed - tried_;
    const double bend = excess - last_excess_;
    double next = needed;
    if (rounds_ >= 2 && std::abs(bend) > 0.0) {
      const double secant = tried_ - excess * (tried_ - last_tried_) / bend;
      // A kink of the rule can throw the secant far off.
      if (std::abs(secant - needed) < kFarthest * std::abs(excess)) next = secant;
    }
    ++rounds_;
    last_tried_ = tried_;
    last_excess_ = excess;
    tried_ = next;
    return next;
  }

 private:
  static constexpr double kFarthest = 3.0;
  int rounds_ = 0;  ///< The first call has tried nothing; the second knows one excess.
  double tried_ = 0.0;
  double last_tried_ = 0.0;
  double last_excess_ = 0.0;
};

/// One Newton search at a fixed thickness.
Result<Vector5d> SolveOrder(const LensFormSpec& spec, const Vector5d& start, double thickness, const WornGoal& goal) {
  const Vector5d wanted = Packed(goal.wanted.power, goal.wanted.prism);
  Vector5d order = start;
  for (int step = 0; step < kMostNewtonSteps; ++step) {
    const Result<Vector5d> worn = WornNumbers(spec, order, thickness, goal);
    if (!worn) return Fail(worn);
    const Vector5d error = *worn - wanted;
    if (error.cwiseAbs().maxCoeff() < kPowerDone) break;
    Matrix5d jacobian;
    for (Eigen::Index i = 0; i < 5; ++i) {
      Vector5d moved = order;
      moved[i] += kDifference;
      const Result<Vector5d> there = WornNumbers(spec, moved, thickness, goal);
      if (!there) return Fail(there);
      jacobian.col(i) = (*there - *worn) / kDifference;
    }
    const Vector5d change = jacobian.partialPivLu().solve(error);
    if (!change.allFinite())
      return Fail(kAttempt, "the compensation has no solution", "use less tilt or a weaker lens");
    order -= change;
  }
  return order;
}

}  // namespace

Result<LensForm> BuildLensForm(const LensFormSpec& spec, const LensOrder& order, double centre_thickness) {
  const double milli = 1000.0 * (spec.index - 1.0);
  LensForm form;
  form.index = spec.index;
  form.centre_thickness = centre_thickness;
  form.reference = spec.reference;
  form.front.curvature_u = form.front.curvature_v = spec.base / milli;
  form.front.lens_from_surface.translation() << spec.box_centre, 0.0;
  const auto front = Meet(form.front, {spec.reference.x(), spec.reference.y(), 0.0}, -Eigen::Vector3d::UnitZ());
  const bool inside = centre_thickness * form.front.curvature_u < 0.9;  // the back vertex before the front's centre
  if (!front || !inside) {
    return Fail(kAttempt, fmt::format("a front of {:.2f} D does not reach the optical centre", spec.base),
                "use a flatter base curve or a centration nearer to the box centre");
  }
  form.front_point = front->point;
  form.optical_axis = front->normal;
  form.back_point = form.front_point - centre_thickness * form.optical_axis;

  Eigen::Vector3d back_normal = form.optical_axis;
  const double prism = order.prism.norm();
  if (prism > 0.0) {
    const double tilt = PrismTilt(spec, form.front.curvature_u, centre_thickness, prism);
    if (!std::isfinite(tilt))
      return Fail(kAttempt, fmt::format("a prism of {:.1f} cm/m cannot be made", prism), "use less prism");
    back_normal = PrismNormal(form.optical_axis, order.prism / prism, tilt);
  }
  Eigen::Matrix2d from_front = spec.base * Eigen::Matrix2d::Identity();
  if (spec.model == PowerModel::kBackVertex) {
    // What arrives at the back: a flat back square to the ray adds nothing, so a focimeter reads exactly that.
    form.back = BackSurface(Eigen::Matrix2d::Zero(), form.back_point, back_normal);
    const Result<TracedPower> arriving = TraceFocimeter(form);
    if (!arriving) return Fail(arriving);
    from_front = arriving->power;
  }
  form.back = BackSurface((from_front - order.power) / milli, form.back_point, back_normal);
  return form;
}

double MinimumInside(const ThicknessRule& rule, double from_edge) {
  constexpr double kBorder = 5.0;  // mm
  const double share = std::clamp(from_edge / kBorder, 0.0, 1.0);
  return rule.minimum_edge + share * (rule.minimum_centre - rule.minimum_edge);
}

Result<LensForm> ThinnestLensForm(const LensFormSpec& spec, const LensOrder& order, const LensOutline& outline,
                                  const ThicknessRule& rule) {
  const std::vector<Eigen::Vector2d> boundary = BoundaryOf(outline);
  Result<LensForm> form = BuildLensForm(spec, order, rule.minimum_centre);
  for (int round = 0; round < kMostScans; ++round) {
    if (!form) return Fail(form);
    const BoundaryScan scan = Scan(*form, boundary);
    if (!scan.reached) return DoesNotReach(*form, outline);
    if (std::abs(MissingThickness(*form, scan.thinnest, outline, rule)) < kThicknessDone) {
      const double thickest = std::max(form->centre_thickness, scan.thickest);
      if (thickest > rule.largest) return TooThick(thickest, rule);
      return form;
    }
    form = KeepRuleAt(scan.thinnest, *form, spec, order, outline, rule);
  }
  return Fail(kAttempt, "no thickness keeps the minima", "use a smaller frame or a weaker lens");
}

Result<CompensatedForm> CompensatedLensForm(const LensFormSpec& spec, const WornGoal& goal, const LensOutline& outline,
                                            const ThicknessRule& rule) {
  const Vector5d target = Packed(goal.wanted.power, goal.wanted.prism);
  Vector5d order = target;
  ThicknessSearch search;
  for (int round = 0; round < kMostRounds; ++round) {
    const Result<LensForm> form = ThinnestLensForm(spec, Unpacked(order), outline, rule);
    if (!form) return Fail(form);
    const Result<Vector5d> worn = WornNumbers(*form, order, goal);
    if (!worn) return Fail(worn);
    const double error = (*worn - target).cwiseAbs().maxCoeff();
    if (error < kCompensated) return CompensatedForm{*form, Unpacked(order), error};
    const Result<Vector5d> solved = SolveOrder(spec, order, search.Next(form->centre_thickness), goal);
    if (!solved) return Fail(solved);
    order = *solved;
  }
  return Fail(kAttempt, "the compensation for tilt and vertex distance does not converge",
              "use less tilt, a weaker lens, or the prescription as it is");
}

std::optional<InnerExtreme> InnerExtremeOf(const LensForm& form, const LensOutline& outline) {
  constexpr double kStep = 1e-3;  // mm, for the Hessian from gradients
  constexpr int kMostSteps = 20;
  const auto gradient = [&form](const Eigen::Vector2d& at) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector3d origin(at.x(), at.y(), 0.0);
    const auto front = Meet(form.front, origin, Eigen::Vector3d::UnitZ());
    const auto back = Meet(form.back, origin, Eigen::Vector3d::UnitZ());
    if (!front || !back) return std::nullopt;
    return Eigen::Vector2d(back->normal.head<2>() / back->normal.z() - front->normal.head<2>() / front->normal.z());
  };
  Eigen::Vector2d at = form.reference;
  Eigen::Matrix2d hessian;
  for (int step = 0; step < kMostSteps; ++step) {
    const auto here = gradient(at);
    if (!here) return std::nullopt;
    for (Eigen::Index i = 0; i < 2; ++i) {
      const auto above = gradient(at + kStep * Eigen::Vector2d::Unit(i));
      const auto below = gradient(at - kStep * Eigen::Vector2d::Unit(i));
      if (!above || !below) return std::nullopt;
      hessian.col(i) = (*above - *below) / (2.0 * kStep);
    }
    if (!(hessian.determinant() > 1e-12)) return std::nullopt;  // a saddle or a trough: the extremes are on the edge
    const Eigen::Vector2d change = hessian.inverse() * *here;
    at -= change;
    if (!Inside(outline, at)) return std::nullopt;
    if (change.norm() < 1e-9) return InnerExtreme{at, form.Thickness(at.x(), at.y()), hessian(0, 0) > 0.0};
  }
  return std::nullopt;
}

}  // namespace annulus
