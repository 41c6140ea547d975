#include "sim/star_tube.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/ensure.h"
#include "modeling/mesh/convex_hull_2d.h"

namespace annulus::sim {
namespace {

constexpr double kLargestExponent = 30.0;  // exp(-30) of the largest bump is 3e-12 mm: nothing is cut off visibly
constexpr double kDifference = 1e-4;       // mm, of central differences: error about its square times third derivatives
constexpr double kBandHeight = 10.0;       // mm
constexpr double kGradientSafety = 1.25;   // on the largest sampled gradient
constexpr double kEggPeak = 2.598076211353316;  // 1 / max(sin t cos² t) = 3 sqrt(3) / 2

// Nodes and weights of the 8-point Gauss–Legendre rule on [-1, 1] (Abramowitz and Stegun, table 25.4); symmetric.
constexpr std::array<double, 4> kGaussNode{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                           0.9602898564975363};
constexpr std::array<double, 4> kGaussWeight{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                             0.1012285362903763};

double Cubed(double x) { return x * x * x; }

}  // namespace

StarTube::StarTube(const std::vector<TubeRow>& rows, std::vector<TubeBump> bumps, const TubeCaps& caps,
                   std::vector<TubeBall> balls)
    : spline_(rows), bumps_(std::move(bumps)), balls_(std::move(balls)), caps_(caps) {
  ENSURE(
      caps_.bottom_tip < caps_.bottom_start && caps_.bottom_start <= caps_.top_start && caps_.top_start < caps_.top_tip,
      "caps go upwards");
  ENSURE(bumps_.size() <= Slice::kMaxBumps, "too many bumps");
  ENSURE(balls_.size() <= Slice::kMaxBalls, "too many balls");
  // What is added after the balls comes last.
  std::stable_partition(bumps_.begin(), bumps_.end(), [](const TubeBump& bump) { return !bump.over_balls; });
  for (const TubeBump& bump : bumps_) {
    prepared_.push_back({std::cos(bump.theta), std::sin(bump.theta), 1.0 / (bump.sigma_theta * bump.sigma_theta)});
  }
  const double height = z_max() - z_min();
  const auto count = static_cast<std::size_t>(std::ceil(height / kBandHeight));
  band_height_ = height / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double z0 = z_min() + band_height_ * static_cast<double>(i);
    bands_.push_back(MeasureBand(z0, z0 + band_height_));
  }
}

StarTube::Slice StarTube::SliceAt(double z) const {
  Slice slice;
  const SectionSpline::Values values = spline_.At(z);
  slice.z = z;
  slice.a = values[SectionSpline::kHalfWidth];
  slice.b = values[SectionSpline::kHalfDepth];
  slice.x = values[SectionSpline::kXCentre];
  slice.y = values[SectionSpline::kYCentre];
  slice.squareness = values[SectionSpline::kSquareness];
  slice.egg = values[SectionSpline::kEgg];
  if (z < caps_.bottom_start) {
    slice.closing = Cubed((caps_.bottom_start - z) / (caps_.bottom_start - caps_.bottom_tip));
  } else if (z > caps_.top_start) {
    slice.closing = Cubed((z - caps_.top_start) / (caps_.top_tip - caps_.top_start));
  }
  for (std::size_t i = 0; i < bumps_.size(); ++i) {
    const TubeBump& bump = bumps_[i];
    const double u = (z - bump.z) / bump.sigma_z;
    const double height_term = 0.5 * u * u;
    if ((bump.power == 2 ? height_term * height_term : height_term) > kLargestExponent) continue;
    slice.bumps[slice.bump_count++] = {&bump, height_term, prepared_[i].cosine, prepared_[i].sine,
                                       prepared_[i].angle_factor};
  }
  for (const TubeBall& ball : balls_) {
    const double above = z - ball.centre.z();
    const double squared = ball.radius * ball.radius - above * above;
    if (squared <= 0.0) continue;
    slice.circles[slice.circle_count++] = {ball.centre.x() - slice.x, ball.centre.y() - slice.y, squared, ball.blend};
  }
  return slice;
}

double StarTube::BumpHeight(const Slice::Bump& bump, double cosine, double sine) {
  double exponent = bump.height_term + (1.0 - cosine * bump.cosine - sine * bump.sine) * bump.angle_factor;
  if (bump.bump->power == 2) exponent *= exponent;
  return exponent < kLargestExponent ? bump.bump->amplitude * std::exp(-exponent) : 0.0;
}

StarTube::RadiusSlope StarTube::BumpHeightSlope(const Slice::Bump& bump, double cosine, double sine) {
  const double exponent = bump.height_term + (1.0 - cosine * bump.cosine - sine * bump.sine) * bump.angle_factor;
  const double exponent_slope = (sine * bump.cosine - cosine * bump.sine) * bump.angle_factor;
  const bool flat = bump.bump->power == 2;
  const double value = bump.bump->amplitude * std::exp(flat ? -exponent * exponent : -exponent);
  return {value, -value * exponent_slope * (flat ? 2.0 * exponent : 1.0)};
}

// The far crossing t of the direction with the circle: t = m + sqrt(R² - q²), with m and q the centre's places along
// and across the direction. Smooth maximum: max(a, b) + k/6 (1 - |a - b|/k)³ where a and b are within k.
StarTube::RadiusSlope StarTube::MergeCircle(const Slice::Circle& circle, RadiusSlope tube, double cosine, double sine) {
  const double along = cosine * circle.x + sine * circle.y;
  const double across = cosine * circle.y - sine * circle.x;  // d(along)/d(theta)
  const double squared = circle.squared_radius - across * across;
  if (squared <= 0.0 || along <= 0.0) return tube;
  const double root = std::sqrt(squared);
  const RadiusSlope ball{along + root, across + across * along / root};
  const double over = (ball.radius - tube.radius) / circle.blend;
  if (over >= 1.0) return ball;
  if (over <= -1.0) return tube;
  const double rest = 1.0 - std::abs(over);
  const double lesser = 0.5 * rest * rest;  // weight of the lower one of the two
  const double weight = over > 0.0 ? 1.0 - lesser : lesser;
  return {std::max(tube.radius, ball.radius) + circle.blend * rest * rest * rest / 6.0,
          (1.0 - weight) * tube.slope + weight * ball.slope};
}

double StarTube::UncappedRadius(const Slice& slice, double cosine, double sine) {
  const double c = slice.b * cosine;
  const double s = slice.a * sine;
  const double inverse = 1.0 / (c * c + s * s);
  const double root = std::sqrt(inverse);
  const double cos2 = c * c * inverse;  // of the ellipse's own angle t
  const double sin2 = s * s * inverse;
  const double shape = 1.0 + 4.0 * slice.squareness * cos2 * sin2 + kEggPeak * slice.egg * s * root * cos2;
  double radius = slice.a * slice.b * root * shape;
  std::size_t i = 0;
  for (; i < slice.bump_count && !slice.bumps[i].bump->over_balls; ++i)
    radius += BumpHeight(slice.bumps[i], cosine, sine);
  for (std::size_t k = 0; k < slice.circle_count; ++k) {
    radius = MergeCircle(slice.circles[k], {radius, 0.0}, cosine, sine).radius;
  }
  for (; i < slice.bump_count; ++i) radius += BumpHeight(slice.bumps[i], cosine, sine);
  return radius;
}

StarTube::RadiusSlope StarTube::UncappedRadiusSlope(const Slice& slice, double cosine, double sine) {
  // With C = (b cos)², S = (a sin)², D = C + S: cos²t = C/D, sin²t = S/D.
  const double a = slice.a;
  const double b = slice.b;
  const double big_c = b * b * cosine * cosine;
  const double big_s = a * a * sine * sine;
  const double d = big_c + big_s;
  const double c_slope = -2.0 * b * b * cosine * sine;
  const double s_slope = 2.0 * a * a * cosine * sine;
  const double d_slope = c_slope + s_slope;
  const double root = std::sqrt(d);
  const double square = 4.0 * slice.squareness;
  const double egg = kEggPeak * slice.egg * a;
  const double shape = 1.0 + square * big_c * big_s / (d * d) + egg * sine * big_c / (d * root);
  const double shape_slope =
      square * ((c_slope * big_s + big_c * s_slope) / (d * d) - 2.0 * big_c * big_s * d_slope / (d * d * d)) +
      egg * ((cosine * big_c + sine * c_slope) / (d * root) - 1.5 * sine * big_c * d_slope / (d * d * root));
  const double ellipse = a * b / root;
  RadiusSlope result{ellipse * shape, ellipse * (shape_slope - shape * d_slope / (2.0 * d))};
  const auto add = [&](const Slice::Bump& bump) {
    const RadiusSlope height = BumpHeightSlope(bump, cosine, sine);
    result.radius += height.radius;
    result.slope += height.slope;
  };
  std::size_t i = 0;
  for (; i < slice.bump_count && !slice.bumps[i].bump->over_balls; ++i) add(slice.bumps[i]);
  for (std::size_t k = 0; k < slice.circle_count; ++k) result = MergeCircle(slice.circles[k], result, cosine, sine);
  for (; i < slice.bump_count; ++i) add(slice.bumps[i]);
  return result;
}

Eigen::Vector2d StarTube::Centre(double z) const {
  const SectionSpline::Values values = spline_.At(z);
  return {values[SectionSpline::kXCentre], values[SectionSpline::kYCentre]};
}

double StarTube::Radius(double theta, double z) const {
  ENSURE(z >= z_min() && z <= z_max(), "height outside the tube");
  const Slice slice = SliceAt(z);
  return std::sqrt(std::max(0.0, 1.0 - slice.closing)) * UncappedRadius(slice, std::cos(theta), std::sin(theta));
}

Eigen::Vector3d StarTube::Point(double theta, double z) const {
  const double radius = Radius(theta, z);
  const Eigen::Vector2d centre = Centre(z);
  return {centre.x() + radius * std::cos(theta), centre.y() + radius * std::sin(theta), z};
}

std::optional<SectionTruth> StarTube::Section(double z) const {
  if (!(z > z_min() && z < z_max())) return std::nullopt;
  constexpr std::size_t kCurvePoints = 1024;
  constexpr std::size_t kHullPoints = 4096;
  const Slice slice = SliceAt(z);
  const double cap = std::sqrt(1.0 - slice.closing);
  SectionTruth truth;
  truth.z_mm = z;
  const double step = kTwoPi / static_cast<double>(kCurvePoints);
  for (std::size_t i = 0; i < kCurvePoints; ++i) {
    const double theta = step * static_cast<double>(i);
    const RadiusSlope at = UncappedRadiusSlope(slice, std::cos(theta), std::sin(theta));
    truth.perimeter_mm += cap * step * std::hypot(at.radius, at.slope);
    truth.area_mm2 += 0.5 * cap * cap * step * at.radius * at.radius;
  }
  std::vector<Eigen::Vector2d> points;
  points.reserve(kHullPoints);
  for (std::size_t i = 0; i < kHullPoints; ++i) {
    const double theta = kTwoPi * static_cast<double>(i) / static_cast<double>(kHullPoints);
    const Eigen::Vector2d direction(std::cos(theta), std::sin(theta));
    points.emplace_back(cap * UncappedRadius(slice, direction.x(), direction.y()) * direction);
  }
  truth.tape_mm = ConvexHullPerimeter(points);
  return truth;
}

double StarTube::Area(double z, std::size_t points) const {
  const Slice slice = SliceAt(z);
  double sum = 0.0;
  for (std::size_t i = 0; i < points; ++i) {
    const double theta = kTwoPi * static_cast<double>(i) / static_cast<double>(points);
    const double radius = UncappedRadius(slice, std::cos(theta), std::sin(theta));
    sum += radius * radius;
  }
  return (1.0 - slice.closing) * sum * kPi / static_cast<double>(points);
}

double StarTube::Volume(double z0, double z1) const {
  const double low = std::clamp(std::min(z0, z1), z_min(), z_max());
  const double high = std::clamp(std::max(z0, z1), z_min(), z_max());
  std::vector<double> breaks = spline_.knots();
  breaks.insert(breaks.end(), {caps_.bottom_start, caps_.top_start, low, high});
  std::sort(breaks.begin(), breaks.end());
  constexpr double kLongest = 5.0;
  constexpr std::size_t kAnglePoints = 512;
  double volume = 0.0;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double from = std::clamp(breaks[i], low, high);
    const double to = std::clamp(breaks[i + 1], low, high);
    if (to <= from) continue;
    const auto pieces = static_cast<std::size_t>(std::ceil((to - from) / kLongest));
    const double half = (to - from) / (2.0 * static_cast<double>(pieces));
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      const double middle = from + half * static_cast<double>(2 * piece + 1);
      for (std::size_t k = 0; k < kGaussNode.size(); ++k) {
        const double offset = half * kGaussNode[k];
        volume += half * kGaussWeight[k] * (Area(middle - offset, kAnglePoints) + Area(middle + offset, kAnglePoints));
      }
    }
  }
  return volume;
}

// F = R · (sqrt((rho/R)² + s³) - 1) with R the uncapped radius: rho - R where nothing closes, smooth through the tips,
// negative inside, gradient bounded.
double StarTube::Level(const Slice& slice, const Eigen::Vector3d& p) {
  const double x = p.x() - slice.x;
  const double y = p.y() - slice.y;
  const double rho = std::hypot(x, y);
  const double radius = rho > 0.0 ? UncappedRadius(slice, x / rho, y / rho) : UncappedRadius(slice, 1.0, 0.0);
  const double ratio = rho / radius;
  return radius * (std::sqrt(ratio * ratio + slice.closing) - 1.0);
}

double StarTube::LevelAt(const Eigen::Vector3d& p) const { return Level(SliceAt(p.z()), p); }

StarTube::SliceTriple StarTube::SlicesAbout(double z) const {
  return {SliceAt(z), SliceAt(z - kDifference), SliceAt(z + kDifference)};
}

Eigen::Vector3d StarTube::LevelGradient(const SliceTriple& slices, const Eigen::Vector3d& p) {
  const auto across = [&](const Eigen::Vector3d& offset) {
    return (Level(slices.middle, p + offset) - Level(slices.middle, p - offset)) / (2.0 * kDifference);
  };
  return {across({kDifference, 0.0, 0.0}), across({0.0, kDifference, 0.0}),
          (Level(slices.above, p) - Level(slices.below, p)) / (2.0 * kDifference)};
}

StarTube::Band StarTube::MeasureBand(double z0, double z1) const {
  constexpr int kHeights = 6;
  constexpr int kAngles = 180;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Band band{kInfinity, -kInfinity, kInfinity, -kInfinity, 1.0};
  for (int i = 0; i <= kHeights; ++i) {
    const double z = z0 + (z1 - z0) * static_cast<double>(i) / static_cast<double>(kHeights);
    const SliceTriple slices = SlicesAbout(z);
    const Slice& slice = slices.middle;
    const double cap = std::sqrt(std::max(0.0, 1.0 - slice.closing));
    for (int j = 0; j < kAngles; ++j) {
      const double theta = kTwoPi * static_cast<double>(j) / static_cast<double>(kAngles);
      const Eigen::Vector3d direction(std::cos(theta), std::sin(theta), 0.0);
      const double radius = UncappedRadius(slice, direction.x(), direction.y());
      const Eigen::Vector3d centre(slice.x, slice.y, z);
      // The gradient is largest on the surface, or (inside a cap's cylinder) at the uncapped radius.
      const double on_surface = LevelGradient(slices, centre + direction * (cap * radius)).norm();
      const double on_cylinder = slice.closing > 0.0 ? LevelGradient(slices, centre + direction * radius).norm() : 0.0;
      band.gradient = std::max({band.gradient, on_surface, on_cylinder});
      const Eigen::Vector3d p = centre + direction * (cap * radius);
      band.x_min = std::min(band.x_min, p.x());
      band.x_max = std::max(band.x_max, p.x());
      band.y_min = std::min(band.y_min, p.y());
      band.y_max = std::max(band.y_max, p.y());
    }
  }
  constexpr double kMargin = 2.0;  // mm, for what lies between the samples
  band.x_min -= kMargin;
  band.x_max += kMargin;
  band.y_min -= kMargin;
  band.y_max += kMargin;
  band.gradient *= kGradientSafety;
  return band;
}

}  // namespace annulus::sim
