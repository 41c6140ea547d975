#include "modeling/bezier/bezier_tube.h"

#include <cmath>

namespace annulus {
namespace {

/// Fig. 5: each row of a patch is a U from one seam over the depth to the other seam.
BezierPatch MakeHalf(const BezierTube::Sections& sections, double side) {
  BezierPatch::ControlNet net;
  for (std::size_t i = 0; i < 4; ++i) {
    const TubeSection& section = sections[i];
    const Eigen::Vector3d width = side * section.half_width;
    const Eigen::Vector3d depth = side * section.half_depth;
    const Eigen::Vector3d start = section.centre - width;
    const Eigen::Vector3d end = section.centre + width;
    net[i] = {start, start + depth, end + depth, end};
  }
  return BezierPatch(net);
}

}  // namespace

BezierTube::BezierTube(const Sections& sections)
    : sections_(sections), a_(MakeHalf(sections, 1.0)), b_(MakeHalf(sections, -1.0)) {}

Eigen::Vector3d BezierTube::CentreLine(double u) const {
  return CubicBezierPoint({sections_[0].centre, sections_[1].centre, sections_[2].centre, sections_[3].centre}, u);
}

Eigen::Vector3d BezierTube::Point(double u, double around) const {
  return around < 0.5 ? a_.Point(u, 2.0 * around) : b_.Point(u, 2.0 * around - 1.0);
}

BezierTube BezierTube::MirroredX() const {
  const auto mirror = [](const Eigen::Vector3d& p) { return Eigen::Vector3d(-p.x(), p.y(), p.z()); };
  Sections mirrored;
  for (std::size_t i = 0; i < 4; ++i) {
    mirrored[i] = {mirror(sections_[i].centre), mirror(sections_[i].half_width), -mirror(sections_[i].half_depth)};
  }
  return BezierTube(mirrored);
}

}  // namespace annulus
