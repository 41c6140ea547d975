#include "modeling/measure/section.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/frames.h"
#include "base/units.h"
#include "modeling/measure/gauss.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/section_sampler.h"
#include "modeling/measure/surface_path.h"
#include "modeling/measure/unresolved_length.h"

namespace annulus {
namespace {

constexpr std::size_t kTapePoints = 1440;

/// Breaks of the theta pieces over one turn.
std::vector<double> ThetaBreaks(const SplineSurface& surface) {
  std::vector<double> breaks;
  for (std::size_t i = 0; i <= surface.theta_basis().count(); ++i) {
    breaks.push_back(static_cast<double>(i) * surface.theta_basis().spacing());
  }
  return breaks;
}

/// r, r_theta, r_z from the row and the coefficients.
struct Slopes {
  double r = 0.0;
  double theta = 0.0;
  double z = 0.0;
};

Slopes Apply(const RadiusRow& row, const Eigen::VectorXd& c) {
  Slopes s;
  for (std::size_t k = 0; k < row.index.size(); ++k) {
    const double coefficient = c[static_cast<Eigen::Index>(row.index[k])];
    s.r += row.value[k] * coefficient;
    s.theta += row.theta[k] * coefficient;
    s.z += row.z[k] * coefficient;
  }
  return s;
}

/// What a ring sees of the outline of a section.
struct Outline {
  std::vector<double> directions;  ///< In which the tape may touch, rad.
  std::vector<char> beside_step;   ///< Per direction.
  std::size_t steps = 0;           ///< Places where the outline runs along the rays.
  double spacing = 0.0;            ///< Of the sensors' directions, rad.
};

/// Number of runs of true values on a circle.
std::size_t CircularRuns(const std::vector<char>& flags) {
  std::size_t runs = 0;
  for (std::size_t k = 0; k < flags.size(); ++k) {
    if (flags[k] != 0 && flags[(k + 1) % flags.size()] == 0) ++runs;
  }
  return runs;
}

/// Between two sensor directions the surface is dense, but not beside a step (slope over 45 degrees: the edge of an
/// ear, an arm before the body), where a smooth curve swings over the edge that no sensor saw: there only the sensors'
/// own directions count.
Outline OutlineAt(const MeasuredSurface& body, double z) {
  const std::size_t columns = std::max<std::size_t>(8, body.segment().knowledge.columns());
  Outline outline;
  outline.spacing = kTwoPi / static_cast<double>(columns);
  const std::size_t between = std::max<std::size_t>(1, (kTapePoints + columns - 1) / columns);
  std::vector<double> radius(columns);
  for (std::size_t k = 0; k < columns; ++k) {
    radius[k] = body.surface().Radius(static_cast<double>(k) * outline.spacing, z);
  }
  std::vector<char> steep(columns);  // from column k to the next
  for (std::size_t k = 0; k < columns; ++k) {
    const double next = radius[(k + 1) % columns];
    steep[k] = std::abs(next - radius[k]) > 0.5 * (next + radius[k]) * outline.spacing ? 1 : 0;
  }
  for (std::size_t k = 0; k < columns; ++k) {
    const bool beside = steep[(k + columns - 1) % columns] != 0 || steep[k] != 0 || steep[(k + 1) % columns] != 0;
    for (std::size_t j = 0; j < (beside ? 1 : between); ++j) {
      const double share = static_cast<double>(j) / static_cast<double>(between);
      outline.directions.push_back((static_cast<double>(k) + share) * outline.spacing);
      outline.beside_step.push_back(beside ? 1 : 0);
    }
  }
  outline.steps = CircularRuns(steep);
  return outline;
}

/// sd of a length that turns at `edges` edges, each anywhere between two directions `spacing` apart: a uniform error.
double EdgeSigma(std::size_t edges, double spacing) { return spacing * std::sqrt(static_cast<double>(edges) / 12.0); }

/// How much longer the skin is than the hull's chords from one direction to the next, mm: a curve that turns by phi is
/// longer than its chord by its phi²/24th part. Edges of the hull that span a hollow, and steps, have no such share.
double BulgeOverChords(const SplineSurface& surface, const Outline& outline, const std::vector<PathPoint>& curve,
                       const std::vector<std::size_t>& hull) {
  const auto along = [&](std::size_t k) {
    const SurfacePlace& place = curve[k].place;
    const RadiusJet jet = surface.Jet(place.theta, place.z);
    const Eigen::Vector2d outward = curve[k].by_radius.head<2>();
    return Eigen::Vector2d(jet.r_theta * outward + jet.r * Eigen::Vector2d(-outward.y(), outward.x()));
  };
  double bulge = 0.0;
  for (std::size_t corner = 0; corner < hull.size(); ++corner) {
    const std::size_t k = hull[corner];
    const std::size_t next = hull[(corner + 1) % hull.size()];
    if (next != (k + 1) % curve.size() || outline.beside_step[k] != 0 || outline.beside_step[next] != 0) continue;
    const Eigen::Vector2d from = along(k);
    const Eigen::Vector2d to = along(next);
    const double turn = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
    if (turn > 0.0) bulge += (curve[next].position - curve[k].position).norm() * turn * turn / 24.0;
  }
  return bulge;
}

Estimate TapeOfSection(const MeasuredSurface& body, const Outline& outline, double z) {
  const SplineSurface& surface = body.surface();
  const SectionSampler sampler(surface, outline.directions);
  const std::vector<Eigen::Vector2d> flat = sampler.Points(z);
  std::vector<PathPoint> curve;
  for (const double theta : outline.directions) curve.push_back(RadialPoint(surface, {theta, z}));
  std::vector<PathPoint> corners;
  std::vector<char> at_step;
  double reach = 0.0;
  const std::vector<std::size_t> hull = HullOfSection(flat);
  for (const std::size_t k : hull) {
    corners.push_back(curve[k]);
    at_step.push_back(outline.beside_step[k]);
    if (at_step.back() != 0) reach = std::max(reach, flat[k].norm());
  }
  Estimate tape =
      WithUnresolved(PolygonLength(surface, corners, PathEnds::kClosed), UnresolvedHullLength(body, sampler, z));
  tape.value += BulgeOverChords(surface, outline, curve, hull);
  tape.unresolved = std::hypot(tape.unresolved, EdgeSigma(CircularRuns(at_step), reach * outline.spacing));
  return tape;
}

double UnresolvedPerimeter(const MeasuredSurface& body, double z) {
  constexpr std::size_t kPoints = 720;
  std::vector<PathPoint> curve;
  for (std::size_t k = 0; k < kPoints; ++k) {
    curve.push_back(RadialPoint(body.surface(), {kTwoPi * static_cast<double>(k) / kPoints, z}));
  }
  return UnresolvedLength(body, curve, PathEnds::kClosed);
}

/// The meridian as a chain.
std::vector<PathPoint> MeridianChain(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  const auto steps = static_cast<std::size_t>(std::clamp((z_max - z_min) / 0.25, 16.0, 8192.0));
  std::vector<PathPoint> chain;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double z = z_min + (z_max - z_min) * static_cast<double>(k) / static_cast<double>(steps);
    chain.push_back(RadialPoint(body.surface(), {theta, z}));
  }
  return chain;
}

Status CheckMeridian(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  const std::string attempted =
      "measure along the surface at theta = " + NumberText(DegreesFromRadians(theta)) + " deg";
  RETURN_IF_ERROR(CheckInRange(body, z_min, attempted));
  RETURN_IF_ERROR(CheckInRange(body, z_max, attempted));
  if (!(z_min < z_max)) return Fail(attempted, "the ends are not one above the other", "give z_min below z_max");
  for (const PathPoint& point : MeridianChain(body, theta, z_min, z_max)) {
    if (body.KnowledgeAt(theta, point.place.z) == Knowledge::kUnknown) {
      return Fail(attempted, "the surface at z = " + NumberText(point.place.z) + " mm was not seen",
                  "choose another line");
    }
  }
  return {};
}

}  // namespace

Result<SectionEstimates> SectionAt(const MeasuredSurface& body, double z) {
  const std::string attempted = "measure the section at z = " + NumberText(z) + " mm";
  RETURN_IF_ERROR(CheckInRange(body, z, attempted));
  const PathKnowledge shares = KnowledgeOfLevel(body, z);
  RETURN_IF_ERROR(CheckKnown(shares, attempted));

  const SplineSurface& surface = body.surface();
  GradientSum perimeter_gradient(surface);
  GradientSum area_gradient(surface);
  double perimeter = 0.0;
  double area = 0.0;
  for (const QuadratureNode& node : PiecewiseGauss(ThetaBreaks(surface))) {
    const RadiusRow row = surface.Row(node.x, z);
    const Slopes s = Apply(row, surface.coefficients());
    const double speed = std::hypot(s.r, s.theta);
    perimeter += node.weight * speed;
    area += node.weight * 0.5 * s.r * s.r;
    if (speed > 0.0) {
      perimeter_gradient.AddRow(row, node.weight * s.r / speed, node.weight * s.theta / speed, 0.0);
    }
    area_gradient.AddRow(row, node.weight * s.r, 0.0, 0.0);
  }
  const Outline outline = OutlineAt(body, z);
  Estimate skin = WithUnresolved({perimeter, perimeter_gradient.Get()}, UnresolvedPerimeter(body, z));
  const double mean_radius = std::sqrt(area / kPi);
  skin.unresolved = std::hypot(skin.unresolved, EdgeSigma(outline.steps, mean_radius * outline.spacing));
  return SectionEstimates{
      z, skin, TapeOfSection(body, outline, z), {area, area_gradient.Get()}, shares.measured, outline.steps};
}

Result<SectionMeasures> MeasureSection(const MeasuredSurface& body, double z) {
  const auto section = SectionAt(body, z);
  if (!section) return Fail(section);
  const std::vector<Uncertain> numbers = body.WithSigmas({section->perimeter, section->tape, section->area});
  return SectionMeasures{z, numbers[0], numbers[1], numbers[2], section->measured_share, section->steps};
}

Result<std::vector<Eigen::Vector2d>> SectionCurve(const MeasuredSurface& body, double z, std::size_t points) {
  const std::string attempted = "draw the section at z = " + NumberText(z) + " mm";
  RETURN_IF_ERROR(CheckInRange(body, z, attempted));
  RETURN_IF_ERROR(CheckKnown(KnowledgeOfLevel(body, z), attempted));
  std::vector<Eigen::Vector2d> curve;
  for (std::size_t k = 0; k < points; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(points);
    curve.emplace_back(body.surface().Point(theta, z).head<2>());
  }
  return curve;
}

Result<Estimate> MeridianLength(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  RETURN_IF_ERROR(CheckMeridian(body, theta, z_min, z_max));
  return PolygonLength(body.surface(), MeridianChain(body, theta, z_min, z_max), PathEnds::kOpen);
}

Result<Estimate> MeridianTape(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  RETURN_IF_ERROR(CheckMeridian(body, theta, z_min, z_max));
  // The taut chain: from the lower end to the upper, turning only where the surface bulges outward (upper hull of r
  // over z, by the monotone chain).
  std::vector<PathPoint> taut;
  const auto flat = [&](const PathPoint& p) {
    return Eigen::Vector2d(p.position.head<2>().dot(p.by_radius.head<2>()), p.position.z());
  };
  for (const PathPoint& point : MeridianChain(body, theta, z_min, z_max)) {
    while (taut.size() >= 2) {
      const Eigen::Vector2d last = flat(taut.back()) - flat(taut[taut.size() - 2]);
      const Eigen::Vector2d next = flat(point) - flat(taut.back());
      if (last.x() * next.y() - last.y() * next.x() > 0.0) break;  // bulges towards larger r
      taut.pop_back();
    }
    taut.push_back(point);
  }
  return PolygonLength(body.surface(), taut, PathEnds::kOpen);
}

}  // namespace annulus
