#include "sim/head_shape.h"

#include <cmath>

#include "base/units.h"

namespace annulus::sim {
namespace {

constexpr double kFront = kPi / 2.0;
constexpr double kFaceRadius = 94.0;  // mm, from the head's centre line to the face: turns mm across into radians
constexpr double kEarRadius = 76.0;   // mm, the same for the sides
constexpr double kEyeHeight = 1584.0;
constexpr double kEyeLateral = 31.0;  // half of a pupillary distance of 62 mm
constexpr double kEarAngle = 0.20;    // rad behind the frontal plane

// A feature of the face in mm: across and up, as it would be pinned on the front of the head.
struct Feature {
  double across;  // to the subject's right; a pair is made of it unless 0
  double z;
  double amplitude;
  double sigma_across;
  double sigma_z;
  int power = 1;
};

void AddFeatures(std::vector<TubeBump>& bumps, const std::vector<Feature>& features, double scale) {
  for (const Feature& f : features) {
    const double angle = std::asin(f.across / kFaceRadius);
    const TubeBump right{kFront - angle,    f.z * scale, f.amplitude * scale, f.sigma_across / kFaceRadius,
                         f.sigma_z * scale, f.power};
    bumps.push_back(right);
    if (f.across == 0.0) continue;
    TubeBump left = right;
    left.theta = kFront + angle;
    bumps.push_back(left);
  }
}

// A feature of both ears: back along the head from the ear's middle, and up.
struct EarFeature {
  double behind;
  double z;
  double amplitude;
  double sigma_along;
  double sigma_z;
  int power = 1;
};

void AddEarFeatures(std::vector<TubeBump>& bumps, const std::vector<EarFeature>& features, double scale) {
  for (const EarFeature& f : features) {
    const double angle = kEarAngle + f.behind / kEarRadius;
    const TubeBump right{-angle, f.z * scale, f.amplitude * scale, f.sigma_along / kEarRadius, f.sigma_z * scale,
                         f.power};
    bumps.push_back(right);
    TubeBump left = right;
    left.theta = kPi + angle;
    bumps.push_back(left);
  }
}

std::vector<EarFeature> EarFeatures() {
  return {{0, 1566, 17.0, 9.0, 21.0, 2},  // shell
          {-6, 1542, 3.0, 7.0, 8.0}};     // lobe
}

// How far the right ear stands out of the head beneath it in its own column, mm.
double EarRelief(double z, double scale) {
  std::vector<TubeBump> bumps;
  AddEarFeatures(bumps, EarFeatures(), scale);
  double relief = 0.0;
  for (std::size_t k = 0; k < bumps.size(); k += 2) {  // right ones; the left ones are between them
    const TubeBump& b = bumps[k];
    const double height = (z - b.z) * (z - b.z) / (2.0 * b.sigma_z * b.sigma_z);
    const double across = (1.0 - std::cos(-kEarAngle - b.theta)) / (b.sigma_theta * b.sigma_theta);
    relief += b.amplitude * std::exp(-std::pow(height + across, b.power));
  }
  return relief;
}

}  // namespace

std::vector<TubeRow> HeadRows(double scale) {
  //  z, half width, front, back, x centre, squareness, egg
  std::vector<TubeRow> rows{{1440, 55.0, 44.0, -68.0, 0, 0.00, -0.01},  {1455, 53.0, 46.0, -66.0, 0, 0.00, -0.01},
                            {1468, 54.0, 57.0, -66.0, 0, 0.00, 0.00},   {1477, 56.0, 79.0, -66.0, 0, 0.01, 0.00},
                            {1486, 58.0, 88.0, -67.0, 0, 0.02, 0.00},   {1500, 61.0, 87.0, -69.0, 0, 0.03, 0.00},
                            {1520, 65.5, 90.0, -74.0, 0, 0.03, -0.01},  {1540, 69.0, 90.0, -82.0, 0, 0.03, -0.02},
                            {1565, 72.0, 92.0, -92.0, 0, 0.03, -0.03},  {1590, 74.0, 93.5, -97.0, 0, 0.03, -0.04},
                            {1615, 76.5, 96.0, -101.0, 0, 0.03, -0.04}, {1640, 77.0, 95.5, -102.0, 0, 0.03, -0.03},
                            {1670, 74.0, 89.0, -97.0, 0, 0.02, -0.02},  {1700, 66.0, 78.0, -88.0, 0, 0.00, 0.00}};
  for (TubeRow& row : rows) {
    row.z *= scale;
    row.half_width *= scale;
    row.front *= scale;
    row.back *= scale;
  }
  return rows;
}

std::vector<TubeBump> FaceBumps(double scale) {
  std::vector<TubeBump> bumps;
  AddFeatures(bumps,
              {{0, 1550, 17.0, 8.5, 7.5},                    // tip of the nose
               {0, 1566, 13.0, 7.5, 13.0},                   // its bridge
               {13, 1547, 7.0, 6.0, 6.5},                    // its wings
               {kEyeLateral, kEyeHeight, -12.0, 13.0, 9.5},  // eye sockets
               {kEyeLateral, kEyeHeight, 5.0, 8.0, 6.0},     // eyeballs
               {20, 1602, 3.5, 15.0, 7.5},                   // brow
               {46, 1560, 5.0, 14.0, 13.0},                  // cheekbones
               {0, 1513, 5.0, 17.0, 7.0},                    // mouth
               {0, 1488, 6.0, 15.0, 9.0}},                   // chin
              scale);
  AddEarFeatures(bumps, EarFeatures(), scale);
  return bumps;
}

std::vector<TubeBump> FineFaceBumps(double scale) {
  std::vector<TubeBump> bumps;
  AddFeatures(bumps,
              {{0, 1517, 1.8, 12.0, 2.6},              // upper lip
               {0, 1508, 2.2, 12.0, 2.8},              // lower lip
               {0, 1512.5, -1.6, 16.0, 1.5},           // between them
               {0, 1526, -1.4, 3.5, 4.5},              // philtrum
               {0, 1498, -2.5, 14.0, 4.5},             // fold above the chin
               {15, 1545, 1.6, 3.5, 4.0},              // nostril wings
               {kEyeLateral, 1591, -1.5, 11.0, 2.5},   // fold of the upper lid
               {kEyeLateral, 1576, -1.0, 10.0, 2.5}},  // below the lower lid
              scale);
  AddEarFeatures(bumps, {{-4, 1562, -5.0, 4.5, 9.0}}, scale);
  return bumps;
}

double CrownStart(double scale) { return 1590.0 * scale; }
double CrownTip(double scale) { return 1700.0 * scale; }

double FindMaximum(const std::function<double(double)>& value, double low, double high) {
  const double golden = (std::sqrt(5.0) - 1.0) / 2.0;
  const double precision = 1e-6 * (high - low);
  double left = high - golden * (high - low);
  double right = low + golden * (high - low);
  double value_left = value(left);
  double value_right = value(right);
  while (high - low > precision) {
    if (value_left >= value_right) {
      high = right;
      right = left;
      value_right = value_left;
      left = high - golden * (high - low);
      value_left = value(left);
    } else {
      low = left;
      left = right;
      value_left = value_right;
      right = low + golden * (high - low);
      value_right = value(right);
    }
  }
  return (low + high) / 2.0;
}

FaceTruth FindFace(const StarTube& tube, double scale) {
  const auto forward = [&tube](double z) { return tube.Point(kFront, z).y(); };
  const double pronasale = FindMaximum(forward, 1538.0 * scale, 1562.0 * scale);
  const double sellion = FindMaximum([&](double z) { return -forward(z); }, 1575.0 * scale, 1598.0 * scale);
  const double glabella = FindMaximum(forward, 1594.0 * scale, 1620.0 * scale);

  // The pupil: where the surface at eye height is half the pupillary distance beside the middle.
  const double eye_z = kEyeHeight * scale;
  const auto eye_miss = [&](double angle) {
    return std::abs(tube.Point(kFront - angle, eye_z).x() - kEyeLateral * scale);
  };
  const double eye = FindMaximum([&](double angle) { return -eye_miss(angle); }, 0.2, 0.5);

  // The ear's upper edge: where its relief over the head beneath has sunk to a fifth.
  const double middle_z = 1566.0 * scale;
  const double fifth = 0.2 * EarRelief(middle_z, scale);
  const double ear =
      FindMaximum([&](double z) { return -std::abs(EarRelief(z, scale) - fifth); }, middle_z, 1615.0 * scale);

  return {tube.Point(kFront - eye, eye_z),  tube.Point(kFront + eye, eye_z), tube.Point(-kEarAngle, ear),
          tube.Point(kPi + kEarAngle, ear), tube.Point(kFront, glabella),    tube.Point(kFront, sellion),
          tube.Point(kFront, pronasale)};
}

std::vector<NamedLevel> HeadLevels(const StarTube& tube, double scale) {
  const auto tape = [&tube](double z) { return tube.Section(z)->tape_mm; };
  return {{"head", FindMaximum(tape, 1605.0 * scale, 1660.0 * scale)},
          {"neck", FindMaximum([&](double z) { return -tape(z); }, 1436.0 * scale, 1470.0 * scale)}};
}

}  // namespace annulus::sim
