#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace annulus {

/// A point of a band's thread: at rest on the skin between two nodes over each other, or on skin that stays.
struct FibrePoint {
  static constexpr std::size_t kFixed = static_cast<std::size_t>(-1);
  std::size_t stack = kFixed;                      ///< Of the lower node; the upper one is a row above.
  double upper = 0.0;                              ///< Weight of the upper node, 0 … 1.
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();  ///< Station frame, mm.
};

/// A thread of a band, without friction: its length is that of the convex hull of its points in the band's plane. So
/// it presses and never pulls, and spans hollows. Hull length is convex in the points, hence so is the energy
/// ½ (k/L0)(L − L0)² where L > L0, else 0.
struct BandFibre {
  std::vector<FibrePoint> points;     ///< In order around the body, counter-clockwise from above.
  Eigen::Matrix<double, 2, 3> plane;  ///< Two unit directions in the plane, as rows.
  double length_factor = 1.0;         ///< Length of the real skin's hull over that of the points', at rest.
  double rest_length = 0.0;           ///< L0, mm, > 0.
  double stiffness = 0.0;             ///< k, N per relative elongation, > 0.
  double width = 1.0;                 ///< mm of the band that this thread stands for.
  /// mm: the length that the thread is tightened to, whatever tension it takes; L0 and k are then the solver's.
  std::optional<double> target{};
};

/// A side of the hull, between two points of the thread.
struct HullSide {
  std::size_t from = 0, to = 0;
  Eigen::Vector2d along = Eigen::Vector2d::Zero();  ///< Unit.
  double length = 0.0;                              ///< mm
};

/// A thread over a deformed skin.
struct FibreState {
  std::vector<HullSide> sides;
  double length = 0.0;   ///< L, mm.
  double tension = 0.0;  ///< N
  double energy = 0.0;   ///< N·mm
  /// ∂L/∂point, station frame, by point; 0 where the thread does not touch.
  std::vector<Eigen::Vector3d> gradient;
};

/// The thread when its points are at `positions`, mm.
[[nodiscard]] FibreState Stretch(const BandFibre& fibre, const std::vector<Eigen::Vector3d>& positions);

/// Length of the convex hull of points in the fibre's plane, times its factor, mm.
[[nodiscard]] double HullLength(const BandFibre& fibre, const std::vector<Eigen::Vector3d>& positions);

}  // namespace annulus
