#include "modeling/clay/cubic.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace annulus {
namespace {

constexpr int kBisections = 200;
constexpr int kNewtonSteps = 4;

/// Where the slope vanishes, ascending.
std::vector<double> TurningPoints(const Cubic& f) {
  const double a = 3.0 * f.c[3];
  const double b = f.c[2];  // half of the linear coefficient
  const double c = f.c[1];
  if (a == 0.0) return b == 0.0 ? std::vector<double>{} : std::vector<double>{-c / (2.0 * b)};
  const double discriminant = b * b - a * c;
  if (discriminant <= 0.0) return {};
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  std::vector<double> turns{q / a};
  if (q != 0.0) turns.push_back(c / q);
  std::sort(turns.begin(), turns.end());
  return turns;
}

/// All roots are nearer to 0 than this (Cauchy).
double RootBound(const Cubic& f) {
  for (std::size_t degree = 3; degree > 0; --degree) {
    if (f.c[degree] == 0.0) continue;
    double largest = 0.0;
    for (std::size_t i = 0; i < degree; ++i) largest = std::max(largest, std::abs(f.c[i] / f.c[degree]));
    if (std::isfinite(largest)) return 1.0 + largest;
  }
  return 0.0;
}

/// The root between two places where the signs differ and between which the polynomial is monotone.
double RootBetween(const Cubic& f, double low, double high) {
  const bool rises = f.At(high) > 0.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    ((f.At(middle) > 0.0) == rises ? high : low) = middle;
  }
  double root = 0.5 * (low + high);
  for (int i = 0; i < kNewtonSteps; ++i) {
    const double slope = f.Slope(root);
    const double next = slope == 0.0 ? root : root - f.At(root) / slope;
    if (!(std::abs(f.At(next)) < std::abs(f.At(root)))) break;
    root = next;
  }
  return root;
}

}  // namespace

Cubic& Cubic::operator+=(const Cubic& other) {
  for (std::size_t i = 0; i < c.size(); ++i) c[i] += other.c[i];
  return *this;
}

std::vector<double> RealRoots(const Cubic& cubic) {
  const double bound = RootBound(cubic);
  if (bound == 0.0) return {};
  std::vector<double> ends{-bound};
  for (const double turn : TurningPoints(cubic)) {
    if (std::abs(turn) < bound) ends.push_back(turn);
  }
  ends.push_back(bound);
  std::vector<double> roots;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double low = cubic.At(ends[i]);
    const double high = cubic.At(ends[i + 1]);
    if (low == 0.0) {
      if (roots.empty() || roots.back() != ends[i]) roots.push_back(ends[i]);
    } else if (high != 0.0 && (low > 0.0) != (high > 0.0)) {
      roots.push_back(RootBetween(cubic, ends[i], ends[i + 1]));
    } else if (high == 0.0) {
      roots.push_back(ends[i + 1]);
    }
  }
  std::sort(roots.begin(), roots.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  return roots;
}

}  // namespace annulus
