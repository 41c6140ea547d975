#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "modeling/glasses/frame.h"

namespace annulus {

/// From where a frame is drawn (third angle): from the front (x of the picture to the wearer's left, y up), from above
/// (x as before, y backwards), and from the wearer's right (x forward, y up). Pictures are orthographic, mm.
enum class FrameView { kFront, kTop, kSide };

/// A point of the frame in a picture, mm.
[[nodiscard]] Eigen::Vector2d InView(FrameView view, const Eigen::Vector3d& p);

/// What is seen of a frame, as line segments in the picture.
struct ViewLines {
  using Segment = std::array<Eigen::Vector2d, 2>;
  std::vector<Segment> outlines;  ///< Where the surface turns away.
  std::vector<Segment> creases;   ///< Where it has an edge.
  Eigen::AlignedBox2d box;        ///< Of all of it.
};

/// Lines of the shells' meshes that nothing stands before. From the side only what does not end in "_left".
[[nodiscard]] ViewLines VisibleLines(const std::vector<FrameBody>& bodies, FrameView view);

}  // namespace annulus
