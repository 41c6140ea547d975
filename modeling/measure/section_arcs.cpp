#include "modeling/measure/section_arcs.h"

#include <algorithm>
#include <cmath>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kWidestSpan = kTwoPi / 16.0;
constexpr double kNarrowestSpan = kTwoPi / 16384.0;

/// A point of the section and its derivative by theta.
struct Tangent {
  Eigen::Vector2d point;
  Eigen::Vector2d by_theta;
};

Tangent TangentAt(const SplineSurface& surface, double z, double theta) {
  const RadiusJet jet = surface.Jet(theta, z);
  const Eigen::Vector2d e_r(std::cos(theta), std::sin(theta));
  const Eigen::Vector2d e_t(-e_r.y(), e_r.x());
  return {jet.r * e_r, jet.r_theta * e_r + jet.r * e_t};
}

/// The cubic with the section's points and derivatives at both ends (Hermite): off by O(span⁴).
SectionArc HermiteArc(const SplineSurface& surface, double z, double from, double to) {
  const Tangent a = TangentAt(surface, z, from);
  const Tangent b = TangentAt(surface, z, to);
  const double third = (to - from) / 3.0;
  return {a.point, a.point + third * a.by_theta, b.point - third * b.by_theta, b.point};
}

/// The largest distance of the arc from the section's point at the same parameter: at least that from the section.
double LargestDistance(const SplineSurface& surface, double z, double from, double to) {
  const SectionArc arc = HermiteArc(surface, z, from, to);
  const double intervals = std::ceil((to - from) / surface.theta_basis().spacing());
  const double steps = std::max(8.0, 4.0 * intervals);
  double largest = 0.0;
  for (double k = 1.0; k < steps; k += 1.0) {
    const double t = k / steps;
    const double s = 1.0 - t;
    const Eigen::Vector2d point =
        s * s * s * arc[0] + 3.0 * s * s * t * arc[1] + 3.0 * s * t * t * arc[2] + t * t * t * arc[3];
    const Eigen::Vector2d truth = surface.Point(from + t * (to - from), z).head<2>();
    largest = std::max(largest, (point - truth).norm());
  }
  return largest;
}

}  // namespace

std::vector<SectionArc> FitSectionArcs(const SplineSurface& surface, double z, double theta_from, double theta_to,
                                       double tolerance) {
  const double spans = std::max(1.0, std::ceil((theta_to - theta_from) / kWidestSpan - 1e-9));
  std::vector<double> ends;  // of the spans still to be drawn, the next one last
  for (double k = spans; k >= 1.0; k -= 1.0) ends.push_back(theta_from + (theta_to - theta_from) * k / spans);
  std::vector<SectionArc> arcs;
  double from = theta_from;
  while (!ends.empty()) {
    const double to = ends.back();
    if (to - from > kNarrowestSpan && LargestDistance(surface, z, from, to) > tolerance) {
      ends.push_back(0.5 * (from + to));
      continue;
    }
    arcs.push_back(HermiteArc(surface, z, from, to));
    from = to;
    ends.pop_back();
  }
  return arcs;
}

}  // namespace annulus
