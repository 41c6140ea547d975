#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "sim/section_spline.h"
#include "sim/section_truth.h"

namespace annulus::sim {

/// A smooth hill or hollow on a tube: amplitude · exp(-E^power), E = (z - z0)²/(2 sigma_z²) + (1 - cos(theta - theta0))
/// / sigma_theta². power 1 is a Gaussian, 2 has a flatter top and steeper flanks.
struct TubeBump {
  double theta = 0.0;        ///< rad, about the section's centre.
  double z = 0.0;            ///< mm.
  double amplitude = 0.0;    ///< mm, radial; negative is a hollow.
  double sigma_theta = 0.1;  ///< rad.
  double sigma_z = 10.0;     ///< mm.
  int power = 1;             ///< 1 or 2.
  bool over_balls = false;   ///< Added after the balls, so that it shows on them: eyelids.
};

/// A ball half sunk in a tube: an eye in its socket. The radius becomes the smooth maximum of the tube's and the ball's
/// far side, C2: within `blend` mm of each other they merge. As seen from the centre line the ball's outline must lie
/// deeper than `blend` under the tube, or the surface jumps there.
struct TubeBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Tube coordinates, mm.
  double radius = 12.0;                              ///< mm, > 0.
  double blend = 2.0;                                ///< mm, > 0.
};

/// Where a tube closes. Beyond a start the radius is multiplied by sqrt(1 - s³), s = 0 at the start and 1 at the tip:
/// C2 at the start and round, with a horizontal tangent plane, at the tip.
struct TubeCaps {
  double bottom_tip = 0.0;    ///< Lowest point, mm.
  double bottom_start = 0.0;  ///< mm, > bottom_tip.
  double top_start = 0.0;     ///< mm, >= bottom_start.
  double top_tip = 0.0;       ///< Highest point, mm, > top_start.
};

/// A closed smooth surface, star-shaped in every horizontal section about a centre line (x_c(z), y_c(z)):
/// radius(theta, z) = cap(z) · (section curve + bumps). Known exactly, hence the source of true girths and volumes.
/// Immutable; reentrant.
class StarTube {
 public:
  /// Rows as for SectionSpline; they need not reach the tips (the end rows hold). Radii must come out positive.
  StarTube(const std::vector<TubeRow>& rows, std::vector<TubeBump> bumps, const TubeCaps& caps,
           std::vector<TubeBall> balls = {});

  [[nodiscard]] double z_min() const { return caps_.bottom_tip; }
  [[nodiscard]] double z_max() const { return caps_.top_tip; }

  /// Centre of the section at z, mm.
  [[nodiscard]] Eigen::Vector2d Centre(double z) const;
  /// Radius about the centre, mm; z in [z_min, z_max].
  [[nodiscard]] double Radius(double theta, double z) const;
  /// Point of the surface, mm.
  [[nodiscard]] Eigen::Vector3d Point(double theta, double z) const;

  /// True measures of the loop at z by the trapezoidal rule in theta, which converges geometrically for these analytic
  /// curves (1024 points; the hull from 4096). Empty outside (z_min, z_max). Relative error <= 1e-6.
  [[nodiscard]] std::optional<SectionTruth> Section(double z) const;
  /// Volume between two heights in either order, clipped to the tube, mm³: 8-point Gauss–Legendre between all places
  /// where the construction changes its polynomial, at most 5 mm apart. Relative error <= 1e-6.
  [[nodiscard]] double Volume(double z0, double z1) const;

  struct Hit {
    double distance_mm = 0.0;
    Eigen::Vector3d normal;
  };
  /// First crossing from outside to inside along the ray, at most `max_distance_mm` away, to 1e-6 mm; 0 if the origin
  /// is inside. Steps are F/L (F the signed level function, L a bound of its gradient per height band), not below 0.05
  /// mm: what a ray grazes less deeply than that may be missed.
  [[nodiscard]] std::optional<Hit> Cast(const Ray& ray, double max_distance_mm) const;

 private:
  // Everything of one height that does not depend on theta.
  struct Slice {
    double z = 0.0;
    double x = 0.0, y = 0.0;  // centre
    double a = 0.0, b = 0.0;  // half width, half depth
    double squareness = 0.0, egg = 0.0;
    double closing = 0.0;  // s³ of the caps: the radius is multiplied by sqrt(1 - closing)
    std::size_t bump_count = 0;
    struct Bump {
      const TubeBump* bump;
      double height_term;  // (z - z0)²/(2 sigma_z²)
      double cosine, sine, angle_factor;
    };
    static constexpr std::size_t kMaxBumps = 48;
    std::array<Bump, kMaxBumps> bumps;
    // The circles that the balls are cut in, about the section's centre; balls not met have no circle.
    struct Circle {
      double x, y, squared_radius, blend;
    };
    static constexpr std::size_t kMaxBalls = 4;
    std::size_t circle_count = 0;
    std::array<Circle, kMaxBalls> circles;
  };
  struct RadiusSlope {
    double radius = 0.0;
    double slope = 0.0;  // d radius / d theta
  };
  struct PreparedBump {
    double cosine, sine, angle_factor;
  };
  // Bounds of a band of heights: box and gradient of the level function.
  struct Band {
    double x_min, x_max, y_min, y_max, gradient;
  };
  struct Span {
    double begin, end, gradient;
  };

  [[nodiscard]] Slice SliceAt(double z) const;
  [[nodiscard]] static double BumpHeight(const Slice::Bump& bump, double cosine, double sine);
  [[nodiscard]] static RadiusSlope BumpHeightSlope(const Slice::Bump& bump, double cosine, double sine);
  [[nodiscard]] static RadiusSlope MergeCircle(const Slice::Circle& circle, RadiusSlope tube, double cosine,
                                               double sine);
  [[nodiscard]] static double UncappedRadius(const Slice& slice, double cosine, double sine);
  [[nodiscard]] static RadiusSlope UncappedRadiusSlope(const Slice& slice, double cosine, double sine);
  [[nodiscard]] static double Level(const Slice& slice, const Eigen::Vector3d& p);
  [[nodiscard]] double LevelAt(const Eigen::Vector3d& p) const;
  // The slice at one height and those that a central difference in z needs.
  struct SliceTriple {
    Slice middle, below, above;
  };
  [[nodiscard]] SliceTriple SlicesAbout(double z) const;
  [[nodiscard]] static Eigen::Vector3d LevelGradient(const SliceTriple& slices, const Eigen::Vector3d& p);
  [[nodiscard]] double Area(double z, std::size_t points) const;
  [[nodiscard]] Band MeasureBand(double z0, double z1) const;
  [[nodiscard]] std::optional<Span> ClipToBands(const Ray& ray, double max_distance_mm) const;
  [[nodiscard]] Hit Refine(const Ray& ray, double outside, double inside) const;

  SectionSpline spline_;
  std::vector<TubeBump> bumps_;
  std::vector<PreparedBump> prepared_;
  std::vector<TubeBall> balls_;
  TubeCaps caps_;
  double band_height_ = 0.0;
  std::vector<Band> bands_;
};

}  // namespace annulus::sim
