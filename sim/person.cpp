#include "sim/person.h"

#include <cmath>

#include "base/ensure.h"
#include "sim/head_shape.h"

namespace annulus::sim {
namespace {

constexpr double kCrotch = 742.0;

// Cross dimensions by `wide`, heights by `scale`.
std::vector<TubeRow> Scaled(std::vector<TubeRow> rows, double scale, double wide) {
  for (TubeRow& row : rows) {
    row.z *= scale;
    row.half_width *= wide;
    row.front *= wide;
    row.back *= wide;
    row.x_centre *= wide;
  }
  return rows;
}

StarTube MakeTorso(double scale, double wide) {
  //  z, half width, front, back, x centre, squareness, egg
  std::vector<TubeRow> rows = Scaled({{740, 168, 84, -96, 0, 0.03, 0},
                                      {800, 172, 92, -108, 0, 0.04, 0},
                                      {870, 174, 101, -114, 0, 0.05, 0},
                                      {930, 165, 103, -106, 0, 0.05, 0},
                                      {985, 146, 99, -94, 0, 0.05, 0},
                                      {1060, 126, 93, -84, 0, 0.05, 0},
                                      {1120, 129, 96, -87, 0, 0.05, 0},
                                      {1180, 138, 101, -94, 0, 0.05, 0},
                                      {1250, 147, 101, -100, 0, 0.05, 0},
                                      {1310, 152, 92, -104, 0, 0.06, 0},
                                      {1355, 163, 76, -103, 0, 0.07, 0},
                                      {1385, 162, 62, -98, 0, 0.07, 0},
                                      {1405, 136, 54, -91, 0, 0.04, 0},
                                      {1421, 98, 49, -82, 0, 0.00, 0}},
                                     scale, wide);
  for (const TubeRow& row : HeadRows(scale)) rows.push_back(row);
  std::vector<TubeBump> bumps = FaceBumps(scale);
  const double front = kPi / 2.0;
  const std::vector<TubeBump> below{{front - 0.62, 1245, 24, 0.30, 34}, {front + 0.62, 1245, 24, 0.30, 34},
                                    {-front - 0.55, 862, 22, 0.34, 46}, {-front + 0.55, 862, 22, 0.34, 46},
                                    {-front - 0.65, 1300, 9, 0.25, 40}, {-front + 0.65, 1300, 9, 0.25, 40},
                                    {-front, 1180, -7, 0.14, 110},      {front, 960, 6, 0.5, 60}};
  for (TubeBump bump : below) {
    bump.z *= scale;
    bump.sigma_z *= scale;
    bump.amplitude *= wide;
    bumps.push_back(bump);
  }
  return StarTube(rows, bumps, {kCrotch * scale, 800 * scale, CrownStart(scale), CrownTip(scale)});
}

// `side` +1 is the subject's right.
StarTube MakeLeg(double scale, double wide, double side) {
  const std::vector<TubeRow> rows = Scaled({{0, 44, 165, -62, side * 118, 0, 0},
                                            {25, 44, 150, -64, side * 118, 0, 0},
                                            {50, 39, 100, -60, side * 117, 0, 0},
                                            {80, 35, 42, -52, side * 116, 0, 0},
                                            {120, 35, 26, -49, side * 115, 0, 0},
                                            {220, 45, 34, -60, side * 112, 0, 0},
                                            {320, 55, 42, -72, side * 109, 0, 0},
                                            {410, 52, 46, -58, side * 106, 0, 0},
                                            {470, 55, 53, -52, side * 104, 0, 0},
                                            {560, 66, 66, -60, side * 100, 0, 0},
                                            {680, 76, 80, -80, side * 93, 0, 0},
                                            {770, 80, 86, -92, side * 88, 0, 0},
                                            {850, 74, 80, -86, side * 86, 0, 0}},
                                           scale, wide);
  return StarTube(rows, {}, {0, 22 * scale, 800 * scale, 858 * scale});
}

StarTube MakeArm(double scale, double wide, double side) {
  const std::vector<TubeRow> rows = Scaled({{800, 13, 22, -22, side * 505, 0, 0},
                                            {850, 17, 40, -40, side * 483, 0, 0},
                                            {890, 20, 44, -44, side * 464, 0, 0},
                                            {930, 24, 38, -36, side * 443, 0, 0},
                                            {965, 28, 31, -29, side * 422, 0, 0},
                                            {1030, 39, 37, -36, side * 381, 0, 0},
                                            {1100, 46, 43, -42, side * 336, 0, 0},
                                            {1160, 46, 42, -43, side * 297, 0, 0},
                                            {1240, 52, 47, -49, side * 245, 0, 0},
                                            {1310, 60, 51, -57, side * 202, 0, 0},
                                            {1370, 60, 46, -64, side * 166, 0, 0},
                                            {1420, 56, 36, -66, side * 140, 0, 0}},
                                           scale, wide);
  return StarTube(rows, {}, {806 * scale, 850 * scale, 1325 * scale, 1412 * scale});
}

// Lowest level at which arm and torso overlap: their outlines meet where the arm's inner edge reaches the torso's side.
double FindArmpit(const StarTube& torso, const StarTube& arm) {
  double low = 0.5 * (arm.z_min() + arm.z_max());  // air between them
  double high = arm.z_max() - 0.12 * (arm.z_max() - arm.z_min());
  const auto gap = [&](double z) {
    double smallest = 1e9;
    for (int i = 0; i < 360; ++i) {
      const Eigen::Vector3d p = arm.Point(RadiansFromDegrees(i), z);
      const Eigen::Vector2d from_centre = p.head<2>() - torso.Centre(z);
      smallest = std::min(smallest, from_centre.norm() - torso.Radius(std::atan2(from_centre.y(), from_centre.x()), z));
    }
    return smallest;
  };
  ENSURE(gap(low) > 0.0 && gap(high) < 0.0, "the arm leaves the torso once");
  while (high - low > 1e-3) {
    const double middle = 0.5 * (low + high);
    (gap(middle) > 0.0 ? low : high) = middle;
  }
  return high;
}

}  // namespace

ParametricBody MakePerson(const PersonOptions& options) {
  ENSURE(options.height_mm >= 1400.0 && options.height_mm <= 2000.0, "stature out of range");
  ENSURE(options.build >= 0.85 && options.build <= 1.15, "build out of range");
  const double scale = options.height_mm / 1700.0;
  const double wide = scale * options.build;
  const StarTube torso = MakeTorso(scale, wide);
  ParametricBody::Description description;
  description.name = "body";
  description.parts = {{BodyPart::kTorso, torso},
                       {BodyPart::kRightLeg, MakeLeg(scale, wide, 1.0)},
                       {BodyPart::kLeftLeg, MakeLeg(scale, wide, -1.0)},
                       {BodyPart::kRightArm, MakeArm(scale, wide, 1.0)},
                       {BodyPart::kLeftArm, MakeArm(scale, wide, -1.0)}};
  const auto tape = [&torso](double z) { return torso.Section(z)->tape_mm; };
  description.levels = HeadLevels(torso, scale);
  description.levels.push_back({"chest", FindMaximum(tape, 1215 * scale, 1280 * scale)});
  description.levels.push_back({"waist", FindMaximum([&](double z) { return -tape(z); }, 1000 * scale, 1150 * scale)});
  description.levels.push_back({"hip", FindMaximum(tape, 830 * scale, 930 * scale)});
  description.heights = {CrownTip(scale), FindArmpit(torso, description.parts[3].tube), kCrotch * scale};
  description.face = FindFace(torso, scale);
  description.placement = options.placement;
  return ParametricBody(description);
}

}  // namespace annulus::sim
