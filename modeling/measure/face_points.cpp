#include "modeling/measure/face_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/units.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr const char* kAttempt = "find the face points";
constexpr const char* kAdvice =
    "check that the model shows a head that faces +y (theta 90 degrees), or enter the points";

// Heights below the top of the head in which an adult's or child's nose tip lies, hair included, mm.
constexpr double kNoseHighest = 85.0;
constexpr double kNoseLowest = 210.0;
constexpr double kNeckLowest = 330.0;
constexpr double kLeastHead = 150.0;
/// How far a nose stands out between points 15 degrees to either side, mm; less is no nose.
constexpr double kLeastNose = 4.0;

constexpr int kFullCircle = 360;

/// r(theta, z) of the head sampled at whole degrees and millimetres below its top: what the searches run on.
class HeadGrid {
 public:
  HeadGrid(const SplineSurface& head, double depth)
      : top_(head.z_max()), rows_(static_cast<int>(std::floor(std::min(depth, head.z_max() - head.z_min()))) + 1) {
    radius_.reserve(static_cast<std::size_t>(rows_) * kFullCircle);
    for (int row = 0; row < rows_; ++row) {
      for (int degree = 0; degree < kFullCircle; ++degree) {
        radius_.push_back(std::max(head.Radius(RadiansFromDegrees(degree), z(row)), 0.0));
      }
    }
  }

  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] double z(int row) const { return top_ - row; }
  /// The row nearest to z, within the grid.
  [[nodiscard]] int RowAt(double z) const { return std::clamp(static_cast<int>(std::lround(top_ - z)), 0, rows_ - 1); }
  /// Radius at any whole degree; rows beyond the grid repeat its border.
  [[nodiscard]] double r(int degree, int row) const {
    const int column = ((degree % kFullCircle) + kFullCircle) % kFullCircle;
    return radius_[static_cast<std::size_t>(std::clamp(row, 0, rows_ - 1) * kFullCircle + column)];
  }
  [[nodiscard]] Vector3d Point(int degree, int row) const {
    return PointFromCylindrical(RadiansFromDegrees(degree), r(degree, row), z(row));
  }
  [[nodiscard]] double MeanRadius(int row) const {
    double sum = 0.0;
    for (int degree = 0; degree < kFullCircle; ++degree) sum += r(degree, row);
    return sum / kFullCircle;
  }

 private:
  double top_;
  int rows_;
  std::vector<double> radius_;
};

/// The row of the smallest mean girth below the face.
int NeckRow(const HeadGrid& grid) {
  int neck = std::min(grid.rows() - 1, static_cast<int>(kLeastHead));
  for (int row = neck; row < grid.rows(); ++row) {
    if (grid.MeanRadius(row) < grid.MeanRadius(neck)) neck = row;
  }
  return neck;
}

struct GridPlace {
  int degree;
  int row;
};

/// The nose's tip: forward, and standing out from what is 15 degrees to either side. Forehead and chin are too broad.
std::optional<GridPlace> FindNose(const HeadGrid& grid, int neck) {
  const auto prominence = [&grid](int degree, int row) {
    return grid.r(degree, row) - 0.5 * (grid.r(degree - 15, row) + grid.r(degree + 15, row));
  };
  GridPlace best{90, 0};
  double best_score = 0.0;
  for (int row = static_cast<int>(kNoseHighest); row <= std::min(neck, static_cast<int>(kNoseLowest)); ++row) {
    for (int degree = 55; degree <= 125; ++degree) {
      const double score = grid.Point(degree, row).y() + prominence(degree, row);
      if (score > best_score) {
        best = {degree, row};
        best_score = score;
      }
    }
  }
  if (best_score == 0.0 || prominence(best.degree, best.row) < kLeastNose) return std::nullopt;
  return best;
}

/// The tip on the surface: most forward near the grid's maximum, halfway between the flanks 3 mm behind it.
FacePoint RefinePronasale(const SplineSurface& head, const HeadGrid& grid, const GridPlace& nose) {
  constexpr double kStep = 0.25;
  const double theta = RadiansFromDegrees(nose.degree);
  double z = grid.z(nose.row);
  for (double dz = -6.0; dz <= 6.0; dz += kStep) {
    const double moved = std::clamp(grid.z(nose.row) + dz, head.z_min(), head.z_max());
    if (head.Point(theta, moved).y() > head.Point(theta, z).y()) z = moved;
  }
  const double flank = head.Radius(theta, z) - 3.0;
  const auto reach = [&](double sign) {
    double angle = 0.0;
    while (angle < RadiansFromDegrees(20.0) && head.Radius(theta + sign * angle, z) > flank) angle += 0.001;
    return angle;
  };
  return {head.Point(theta + 0.5 * (reach(1.0) - reach(-1.0)), z), LandmarkSource::kDetected};
}

/// The hollow of the mid profile above the nose: its first minimum, else where it lies deepest under the chord from the
/// tip to the forehead, else by proportion.
FacePoint FindSellion(const SplineSurface& head, const Vector3d& tip) {
  constexpr double kStep = 0.25;
  constexpr double kChord = 70.0;
  constexpr double kUsual = 33.0;
  const double theta = std::atan2(tip.y(), tip.x());
  const double tip_z = tip.z();
  const auto radius = [&](double above) { return head.Radius(theta, std::min(tip_z + above, head.z_max())); };
  double deepest = 0.0;
  double chord_place = kUsual;
  for (double above = 10.0; above <= 62.0; above += kStep) {
    const bool is_minimum = radius(above) <= radius(above - kStep) && radius(above) < radius(above + kStep);
    // Noise makes shallow minima: a real one has a forehead that comes forward again.
    if (is_minimum && radius(above + 8.0) > radius(above) + 0.3 && radius(above - 8.0) > radius(above) + 0.3) {
      return {head.Point(theta, tip_z + above), LandmarkSource::kDetected};
    }
    const double chord = radius(0.0) + (radius(kChord) - radius(0.0)) * above / kChord;
    if (chord - radius(above) > deepest) {
      deepest = chord - radius(above);
      chord_place = above;
    }
  }
  if (deepest >= 1.0) return {head.Point(theta, tip_z + chord_place), LandmarkSource::kDetected};
  return {head.Point(theta, std::min(tip_z + kUsual, head.z_max())), LandmarkSource::kProportion};
}

enum class BodySide { kRight, kLeft };

/// Sums of a centroid.
struct Centroid {
  double weight = 0.0;
  double sum = 0.0;
  void Add(double w, double value) {
    weight += w;
    sum += w * value;
  }
  [[nodiscard]] double value() const { return sum / weight; }
};

/// Where, on one side, the surface meets x at height z: theta by bisection; x falls with theta on the front.
Vector3d SurfaceAtX(const SplineSurface& head, double x, double z) {
  double low = RadiansFromDegrees(20.0);
  double high = RadiansFromDegrees(160.0);
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (low + high);
    (head.Point(middle, z).x() > x ? low : high) = middle;
  }
  return head.Point(0.5 * (low + high), z);
}

/// The eye's centre from the hollow of its socket: how far the surface lies behind a vertical chord of 40 mm. The
/// hollow is deepest at the nose, so x is the centre of its extent (weights cut off) and z that of its depth.
FacePoint FindEye(const SplineSurface& head, const HeadGrid& grid, const Vector3d& sellion, BodySide side) {
  constexpr int kHalfChord = 20;
  constexpr double kInnermost = 14.5;
  constexpr double kOutermost = 55.0;
  constexpr double kUsualLateral = 31.5;
  constexpr double kUsualBelow = 7.0;
  const double sign = side == BodySide::kRight ? 1.0 : -1.0;
  Centroid across;
  Centroid height;
  for (int row = grid.RowAt(sellion.z() + 8.0); row <= grid.RowAt(sellion.z() - 27.0); ++row) {
    for (int degree = 30; degree <= 150; ++degree) {
      const double lateral = sign * (grid.Point(degree, row).x() - sellion.x());
      if (lateral < kInnermost || lateral > kOutermost) continue;
      const double hollow =
          0.5 * (grid.r(degree, row - kHalfChord) + grid.r(degree, row + kHalfChord)) - grid.r(degree, row);
      across.Add(std::clamp(hollow - 1.5, 0.0, 4.0), lateral);
      const double deep = std::max(hollow - 3.0, 0.0);
      height.Add(deep * deep, grid.z(row));
    }
  }
  const bool found = across.weight > 300.0 && height.weight > 300.0 && across.value() > 22.0 && across.value() < 42.0;
  const double lateral = found ? across.value() : kUsualLateral;
  const double z = found ? height.value() : sellion.z() - kUsualBelow;
  return {SurfaceAtX(head, sellion.x() + sign * lateral, z),
          found ? LandmarkSource::kDetected : LandmarkSource::kProportion};
}

/// How far the ear stands out of the head: the surface less its morphological opening around (features narrower than
/// 45° removed), on a window of degrees counted from the side's middle, forward positive.
class EarRelief {
 public:
  static constexpr int kBack = -56;
  static constexpr int kFront = 35;

  EarRelief(const HeadGrid& grid, BodySide side) : grid_(grid), side_(side) {}

  [[nodiscard]] int Degree(int forward) const { return side_ == BodySide::kRight ? forward : 180 - forward; }
  /// The head without the ear, mm from the axis, one value per degree from kBack to kFront.
  [[nodiscard]] std::vector<double> Base(int row) const {
    constexpr int kHalf = 22;
    const auto lowest = [&](int forward) {
      double low = grid_.r(Degree(forward - kHalf), row);
      for (int k = -kHalf + 1; k <= kHalf; ++k) low = std::min(low, grid_.r(Degree(forward + k), row));
      return low;
    };
    std::vector<double> eroded;
    for (int forward = kBack - kHalf; forward <= kFront + kHalf; ++forward) eroded.push_back(lowest(forward));
    std::vector<double> opened;
    for (auto start = eroded.begin(); start + 2 * kHalf < eroded.end(); ++start) {
      opened.push_back(*std::max_element(start, start + 2 * kHalf + 1));
    }
    return opened;
  }
  [[nodiscard]] std::vector<double> Height(int row) const {
    std::vector<double> height = Base(row);
    for (std::size_t k = 0; k < height.size(); ++k) {
      height[k] = grid_.r(Degree(kBack + static_cast<int>(k)), row) - height[k];
    }
    return height;
  }

 private:
  const HeadGrid& grid_;
  BodySide side_;
};

/// The ear's relief, row by row downwards, only near the column in which it stands out most: the cheek's hollows far in
/// front of the ear also make some relief.
std::vector<std::vector<double>> EarOnly(const EarRelief& relief, int first, int last) {
  constexpr std::size_t kReach = 20;
  std::vector<std::vector<double>> heights;
  for (int row = first; row <= last; ++row) heights.push_back(relief.Height(row));
  std::vector<double> columns(heights.front().size(), 0.0);
  for (const std::vector<double>& row : heights) {
    for (std::size_t k = 0; k < row.size(); ++k) columns[k] += row[k];
  }
  const auto ear = static_cast<std::size_t>(std::max_element(columns.begin(), columns.end()) - columns.begin());
  for (std::vector<double>& row : heights) {
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (k + kReach < ear || k > ear + kReach) row[k] = 0.0;
    }
  }
  return heights;
}

/// The rows that the ear takes, counted from the first row searched.
struct EarRows {
  std::size_t upper;
  std::size_t lower;
  double edge;  ///< mm; the relief at which it ends.
};

/// From the row where the ear is largest up and down until it stands out by a fifth of its height only. Empty if that
/// is nothing like an ear.
std::optional<EarRows> FindEarRows(const std::vector<std::vector<double>>& heights) {
  constexpr double kLeastEar = 4.0;
  constexpr double kLeastEdge = 2.0;
  constexpr std::size_t kShortest = 20;
  constexpr std::size_t kLongest = 100;
  std::vector<double> peaks;
  std::vector<double> sums;
  for (const std::vector<double>& row : heights) {
    peaks.push_back(*std::max_element(row.begin(), row.end()));
    sums.push_back(std::accumulate(row.begin(), row.end(), 0.0));
  }
  const double peak = *std::max_element(peaks.begin(), peaks.end());
  const auto middle = static_cast<std::size_t>(std::max_element(sums.begin(), sums.end()) - sums.begin());
  EarRows rows{middle, middle, std::max(0.2 * peak, kLeastEdge)};
  while (rows.upper > 0 && peaks[rows.upper - 1] >= rows.edge) --rows.upper;
  while (rows.lower + 1 < peaks.size() && peaks[rows.lower + 1] >= rows.edge) ++rows.lower;
  const std::size_t length = rows.lower - rows.upper;
  if (peak < kLeastEar || length < kShortest || length > kLongest || rows.upper == 0) return std::nullopt;
  return rows;
}

/// The top of the ear, where the temple lies between ear and head; by proportion if there is no ear.
FacePoint FindEar(const SplineSurface& head, const HeadGrid& grid, const Vector3d& sellion, BodySide side) {
  constexpr int kUsualForward = -4;
  constexpr double kUsualBelow = 2.0;
  const EarRelief relief(grid, side);
  const int first = grid.RowAt(sellion.z() + 25.0);
  const std::vector<std::vector<double>> heights = EarOnly(relief, first, grid.RowAt(sellion.z() - 75.0));
  const std::optional<EarRows> rows = FindEarRows(heights);
  if (!rows) {
    return {head.Point(RadiansFromDegrees(relief.Degree(kUsualForward)), sellion.z() - kUsualBelow),
            LandmarkSource::kProportion};
  }
  Centroid forward;
  const std::vector<double>& top = heights[rows->upper];
  for (std::size_t k = 0; k < top.size(); ++k) {
    forward.Add(std::max(top[k] - 0.5 * rows->edge, 0.0), EarRelief::kBack + static_cast<double>(k));
  }
  const int row = first + static_cast<int>(rows->upper);
  const auto degree = static_cast<int>(std::lround(forward.value()));
  const double base = relief.Base(row)[static_cast<std::size_t>(degree - EarRelief::kBack)];
  const double radius = std::min(grid.r(relief.Degree(degree), row), base + rows->edge);
  return {PointFromCylindrical(RadiansFromDegrees(relief.Degree(degree)), radius, grid.z(row)),
          LandmarkSource::kDetected};
}

/// "Slightly before" the middle of the forehead (paper 000, §5, (5)).
FacePoint FindForehead(const SplineSurface& head, const Vector3d& sellion) {
  constexpr double kAboveSellion = 30.0;
  constexpr double kSlightlyBefore = 2.0;
  const double z = std::min(sellion.z() + kAboveSellion, head.z_max());
  const Vector3d on_skin = head.Point(std::atan2(sellion.y(), sellion.x()), z);
  return {on_skin + Vector3d(0.0, kSlightlyBefore, 0.0), LandmarkSource::kDetected};
}

}  // namespace

const std::vector<NamedFacePoint>& FacePointNames() {
  static const std::vector<NamedFacePoint> names{
      {"eye_right", &FacePoints::eye_right}, {"eye_left", &FacePoints::eye_left}, {"ear_right", &FacePoints::ear_right},
      {"ear_left", &FacePoints::ear_left},   {"forehead", &FacePoints::forehead}, {"sellion", &FacePoints::sellion},
      {"pronasale", &FacePoints::pronasale}};
  return names;
}

Result<FacePoints> FindFacePoints(const SplineSurface& head) {
  if (head.z_max() - head.z_min() < kLeastHead) {
    return Fail(kAttempt, fmt::format("the surface is only {:.0f} mm high", head.z_max() - head.z_min()), kAdvice);
  }
  const HeadGrid grid(head, kNeckLowest);
  const std::optional<GridPlace> nose = FindNose(grid, NeckRow(grid));
  if (!nose) {
    return Fail(kAttempt,
                fmt::format("nothing like a nose at the front between z = {:.0f} and {:.0f} mm",
                            head.z_max() - kNoseLowest, head.z_max() - kNoseHighest),
                kAdvice);
  }
  FacePoints face;
  face.pronasale = RefinePronasale(head, grid, *nose);
  face.sellion = FindSellion(head, face.pronasale.position);
  const Vector3d& sellion = face.sellion.position;
  face.eye_right = FindEye(head, grid, sellion, BodySide::kRight);
  face.eye_left = FindEye(head, grid, sellion, BodySide::kLeft);
  face.ear_right = FindEar(head, grid, sellion, BodySide::kRight);
  face.ear_left = FindEar(head, grid, sellion, BodySide::kLeft);
  face.forehead = FindForehead(head, sellion);
  return face;
}

}  // namespace annulus
