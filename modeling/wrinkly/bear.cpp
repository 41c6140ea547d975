#include "modeling/wrinkly/bear.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "modeling/wrinkly/control_nets.h"
#include "modeling/wrinkly/tube_tree.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kBodyColumns = 24;
constexpr double kPi = std::numbers::pi;

/// A ring of the body: an ellipse about the z axis.
struct BodyRing {
  double z, half_width, half_depth, forward;
};
/// From the seat over the belly, the neck and the head to its top, mm.
constexpr std::array<BodyRing, 20> kBody{{{24, 12, 10, 0},  {26, 32, 27, 0},  {34, 48, 42, 0},  {48, 58, 50, 1},
                                          {65, 63, 54, 2},  {82, 63, 54, 2},  {99, 60, 52, 2},  {116, 55, 47, 1},
                                          {132, 49, 41, 0}, {147, 41, 35, 0}, {160, 35, 31, 1}, {172, 38, 36, 3},
                                          {185, 47, 45, 5}, {200, 54, 51, 6}, {216, 57, 54, 6}, {232, 56, 52, 6},
                                          {247, 50, 46, 5}, {259, 40, 37, 4}, {267, 26, 24, 4}, {270, 10, 9, 4}}};

/// Column 0 is at the station's 0°; columns run clockwise seen from above.
double AngleOf(double column) { return -2.0 * kPi * column / static_cast<double>(kBodyColumns); }

TubeRings BodyRings() {
  TubeRings rings;
  for (const BodyRing& ring : kBody) {
    std::vector<Vector3d> points;
    for (std::size_t k = 0; k < kBodyColumns; ++k) {
      const double angle = AngleOf(static_cast<double>(k) + 0.5);
      points.emplace_back(ring.half_width * std::cos(angle), ring.forward + ring.half_depth * std::sin(angle), ring.z);
    }
    rings.push_back(std::move(points));
  }
  return rings;
}

/// A limb: it leaves the body through a slit `half` columns wide about a direction of the station, and its middle goes
/// through these places with these radii.
struct Limb {
  double theta;      ///< deg
  std::size_t ring;  ///< Of the body, below the slit.
  std::size_t half;  ///< Points on one side of a ring.
  std::vector<Vector3d> middle;
  std::vector<double> radius;
};

TubeRings LimbRings(const Limb& limb) {
  TubeRings rings;
  for (std::size_t r = 0; r < limb.middle.size(); ++r) {
    const Vector3d before = limb.middle[r == 0 ? 0 : r - 1];
    const Vector3d after = limb.middle[std::min(r + 1, limb.middle.size() - 1)];
    const Vector3d along = (after - before).normalized();
    // Onward along the body's ring, clockwise seen from above: at a limb that points away from the axis its right side.
    const Vector3d right = along.cross(Vector3d::UnitZ()).normalized();
    const Vector3d up = right.cross(along);
    std::vector<Vector3d> ring;
    for (std::size_t k = 0; k < 2 * limb.half; ++k) {
      const double angle = kPi + kPi * (static_cast<double>(k) + 0.5) / static_cast<double>(limb.half);
      ring.push_back(limb.middle[r] + limb.radius[r] * (std::cos(angle) * right + std::sin(angle) * up));
    }
    rings.push_back(std::move(ring));
  }
  return rings;
}

std::size_t FirstColumn(const Limb& limb) {
  const double middle = -limb.theta / 360.0 * static_cast<double>(kBodyColumns);
  const auto first = static_cast<int>(std::lround(middle - static_cast<double>(limb.half) / 2.0));
  const auto columns = static_cast<int>(kBodyColumns);
  return static_cast<std::size_t>((first % columns + columns) % columns);
}

std::vector<Limb> Limbs() {
  std::vector<Limb> limbs;
  for (const double side : {1.0, -1.0}) {
    const double turn = side > 0.0 ? 0.0 : 180.0;
    limbs.push_back({turn,
                     7,
                     4,
                     {{side * 56, 3, 126},
                      {side * 70, 6, 122},
                      {side * 84, 12, 114},
                      {side * 95, 20, 105},
                      {side * 103, 28, 96},
                      {side * 107, 33, 91}},
                     {17, 17, 17, 17, 14, 5}});
    limbs.push_back({side > 0.0 ? 50.0 : 130.0,
                     2,
                     4,
                     {{side * 33, 48, 44},
                      {side * 39, 62, 38},
                      {side * 44, 78, 31},
                      {side * 47, 94, 27},
                      {side * 49, 108, 27},
                      {side * 50, 113, 28}},
                     {20, 21, 21, 21, 17, 6}});
    limbs.push_back({side > 0.0 ? 15.0 : 165.0,
                     15,
                     3,
                     {{side * 48, 8, 246}, {side * 56, 9, 256}, {side * 62, 9, 264}, {side * 65, 9, 268}},
                     {15, 18, 15, 5}});
  }
  limbs.push_back({90.0, 13, 4, {{0, 55, 206}, {0, 64, 204}, {0, 72, 203}, {0, 76, 203}}, {19, 17, 13, 5}});
  return limbs;
}

/// Fur: long on the body, short on muzzle, ears and paws' tips; brown, lighter where it is short.
void Dress(ControlMeshParts& parts, std::size_t body_points, std::uint64_t seed) {
  parts.attributes = {"height", "red", "green", "blue", "opacity"};
  parts.values.resize(static_cast<Eigen::Index>(parts.points.size()), 5);
  for (std::size_t k = 0; k < parts.points.size(); ++k) {
    const auto chance = [&](std::uint64_t kind) { return ScatteredNumber(seed + kind, k); };
    const auto row = static_cast<Eigen::Index>(k);
    const double tone = 0.75 + 0.5 * chance(1);
    const bool on_limb = k >= body_points;
    parts.values(row, 0) = (on_limb ? 5.0 : 7.0) * (0.35 + 1.3 * chance(0));
    parts.values(row, 1) = 0.36 * tone;
    parts.values(row, 2) = 0.19 * tone;
    parts.values(row, 3) = 0.085 * tone;
    parts.values(row, 4) = 0.55 + 0.45 * chance(2);
  }
}

}  // namespace

Bear MakeBear(std::uint64_t seed) {
  TubeTree tree(BodyRings());
  for (const Limb& limb : Limbs()) tree.Add({0, limb.ring, FirstColumn(limb)}, LimbRings(limb));
  Bear bear;
  bear.mesh = tree.Parts();
  Dress(bear.mesh, kBody.size() * kBodyColumns, seed);
  bear.balls = {{{20, 65, 227}, 6.5}, {{-20, 65, 227}, 6.5}, {{0, 84, 207}, 8.0}};
  return bear;
}

}  // namespace annulus
