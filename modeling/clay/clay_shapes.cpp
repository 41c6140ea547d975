#include "modeling/clay/clay_shapes.h"

#include <Eigen/Core>
#include <array>
#include <initializer_list>
#include <utility>
#include <vector>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A flat face from `corner` along two sides, in columns × rows patches; its normal is along_u × along_v.
void AppendFace(const Vector3d& corner, const Vector3d& along_u, const Vector3d& along_v, std::size_t columns,
                std::size_t rows, PatchShell& shell) {
  const auto point = [&](std::size_t i, std::size_t j) -> Vector3d {
    return corner + along_u * (static_cast<double>(i) / static_cast<double>(3 * columns)) +
           along_v * (static_cast<double>(j) / static_cast<double>(3 * rows));
  };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      BezierPatch::ControlNet net;
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) net[i][j] = point(3 * column + i, 3 * row + j);
      }
      shell.patches.push_back({BezierPatch(net), PatchDetail::kAlong, PatchDetail::kAlong});
    }
  }
}

/// Quarters of a circle have their control points there (the original's number, not the best one).
constexpr double kQuarter = 0.56;

/// A profile curve's control points, (radius, height), from outside seen upwards or downwards.
using Profile = std::array<std::array<double, 2>, 4>;

/// Turned about z: four patches whose u runs along the profile; the normal is outward if the profile runs down.
void AppendTurned(const Profile& profile, double scale, PatchShell& shell) {
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    const std::array<Vector3d, 4> corner{Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(-1, 0, 0), Vector3d(0, -1, 0)};
    const Vector3d& from = corner[quarter];
    const Vector3d& to = corner[(quarter + 1) % 4];
    const std::array<Vector3d, 4> round{from, from + kQuarter * to, to + kQuarter * from, to};
    BezierPatch::ControlNet net;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        net[i][j] = scale * (profile[i][0] * round[j] + Vector3d(0.0, 0.0, profile[i][1]));
      }
    }
    shell.patches.push_back({BezierPatch(net), PatchDetail::kAlong, PatchDetail::kAround});
  }
}

/// A section of handle or spout: a half on the side of -y, of which the other is the mirror image.
struct PipeSection {
  double first_x, first_z;  ///< Where the half begins, on the plane y = 0 …
  double half_width;        ///< … how far its inner control points stand off …
  double last_x, last_z;    ///< … and where it ends.
};

BezierCurve HalfOf(const PipeSection& section, double side, double scale) {
  const double y = side * section.half_width;
  return {scale * Vector3d(section.first_x, 0.0, section.first_z),
          scale * Vector3d(section.first_x, y, section.first_z), scale * Vector3d(section.last_x, y, section.last_z),
          scale * Vector3d(section.last_x, 0.0, section.last_z)};
}

/// Pieces of four sections each, the last of one being the first of the next, both halves, and caps at both ends.
void AppendPipe(const std::vector<PipeSection>& sections, double scale, PatchShell& shell) {
  PatchShell pipe{"pipe", {}};
  for (const double side : {-1.0, 1.0}) {
    for (std::size_t first = 0; first + 3 < sections.size(); first += 3) {
      BezierPatch::ControlNet net;
      for (std::size_t i = 0; i < 4; ++i) net[i] = HalfOf(sections[first + i], side, scale);
      const BezierPatch patch(net);
      pipe.patches.push_back({side < 0.0 ? patch : patch.Flipped(), PatchDetail::kAlong, PatchDetail::kAround});
    }
  }
  const auto cap = [&](const PipeSection& section) {
    return RuledPatch(HalfOf(section, -1.0, scale), HalfOf(section, 1.0, scale));
  };
  pipe.patches.push_back({cap(sections.front()).Flipped(), PatchDetail::kAround, PatchDetail::kStraight});
  pipe.patches.push_back({cap(sections.back()), PatchDetail::kStraight, PatchDetail::kAround});
  for (ShellPatch& piece : TurnedOutward(std::move(pipe)).patches) shell.patches.push_back(piece);
}

}  // namespace

PatchShell ClayBlock(double size, double height, std::size_t count, std::size_t layers) {
  ENSURE(size > 0.0 && height > 0.0 && count >= 1 && layers >= 1, "a block has a size");
  PatchShell shell{"block", {}};
  const double half = 0.5 * size;
  const Vector3d x(size, 0.0, 0.0);
  const Vector3d y(0.0, size, 0.0);
  const Vector3d up(0.0, 0.0, height);
  AppendFace({-half, -half, 0.0}, x, y, count, count, shell);        // top
  AppendFace({-half, -half, -height}, y, x, count, count, shell);    // bottom
  AppendFace({-half, -half, -height}, x, up, count, layers, shell);  // y = -half
  AppendFace({half, -half, -height}, y, up, count, layers, shell);
  AppendFace({half, half, -height}, -x, up, count, layers, shell);
  AppendFace({-half, half, -height}, -y, up, count, layers, shell);
  return shell;
}

PatchShell UtahTeapot(double scale) {
  ENSURE(scale > 0.0, "a teapot has a size");
  PatchShell shell{"teapot", {}};
  PatchShell pot{"pot", {}};
  for (const Profile& profile : std::initializer_list<Profile>{
           {{{0.0, 3.15}, {0.8, 3.15}, {0.0, 2.7}, {0.2, 2.7}}},              // knob
           {{{0.2, 2.7}, {0.4, 2.55}, {1.3, 2.55}, {1.3, 2.4}}},              // lid
           {{{1.3, 2.4}, {4.0 / 3.0, 2.4}, {4.1 / 3.0, 2.4}, {1.4, 2.4}}},    // the ring that is not in the original
           {{{1.4, 2.4}, {1.3375, 2.53125}, {1.4375, 2.53125}, {1.5, 2.4}}},  // rim
           {{{1.5, 2.4}, {1.75, 1.875}, {2.0, 1.35}, {2.0, 0.9}}},            // body
           {{{2.0, 0.9}, {2.0, 0.45}, {1.5, 0.225}, {1.5, 0.15}}},
           {{{1.5, 0.15}, {1.5, 0.075}, {1.425, 0.0}, {0.0, 0.0}}}}) {  // bottom
    AppendTurned(profile, scale, pot);
  }
  shell.patches = TurnedOutward(std::move(pot)).patches;
  AppendPipe({{-1.6, 2.025, 0.3, -1.5, 2.25},
              {-2.3, 2.025, 0.3, -2.5, 2.25},
              {-2.7, 2.025, 0.3, -3.0, 2.25},
              {-2.7, 1.8, 0.3, -3.0, 1.8},
              {-2.7, 1.575, 0.3, -3.0, 1.35},
              {-2.5, 1.125, 0.3, -2.65, 0.9375},
              {-2.0, 0.9, 0.3, -1.9, 0.6}},
             scale, shell);
  AppendPipe({{1.7, 1.425, 0.66, 1.7, 0.6},
              {2.6, 1.425, 0.66, 3.1, 0.825},
              {2.3, 2.1, 0.25, 2.4, 2.025},
              {2.7, 2.4, 0.25, 3.3, 2.4},
              {2.8, 2.475, 0.25, 3.525, 2.49375},
              {2.9, 2.475, 0.15, 3.45, 2.5125},
              {2.8, 2.4, 0.15, 3.2, 2.4}},
             scale, shell);
  return shell;
}

}  // namespace annulus
