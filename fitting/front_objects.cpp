#include "fitting/front_objects.h"

#include <algorithm>
#include <cstdint>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kStep = 25.0;            // mm; half of a wrist, the thinnest part that is seen as one
constexpr double kWidest = kPi / 2.0;     // rad; a wider run is a part of the main surface
constexpr double kWidestGap = 0.15;       // rad; across a wider gap a step says nothing
constexpr double kShortestObject = 20.0;  // mm
constexpr std::size_t kFewestRows = 3;
constexpr std::size_t kFewestCells = 12;
constexpr double kLostHeight = 30.0;  // mm; over which an object may be lost to view and go on
constexpr std::ptrdiff_t kReach = 2;  // cells; an object's cells are at most this far apart

enum : std::uint8_t { kMain = 0, kFront = 1, kTaken = 2 };

/// Marks the runs of one row that stand before both their sides.
void MarkRow(const RingImage& image, std::size_t row, std::vector<std::uint8_t>& marks) {
  const std::vector<std::size_t> columns = image.SeenColumns(row);
  const std::size_t n = columns.size();
  if (n < 8) return;
  // Step from the (k-1)-th to the k-th seen column; none over a gap.
  const auto step = [&](std::size_t k) {
    const std::size_t before = columns[(k + n - 1) % n];
    const std::size_t after = columns[k % n];
    return image.AngleFrom(before, after) > kWidestGap ? 0.0 : image.Radius(row, after) - image.Radius(row, before);
  };
  // Whether the lower surface that begins at the k-th seen column goes on in a direction (1 or n - 1) for a while.
  const auto goes_on = [&](std::size_t k, std::size_t direction) {
    constexpr std::size_t kWhile = 3;
    for (std::size_t i = 1; i < kWhile; ++i, k += direction) {
      const std::size_t a = columns[k % n];
      const std::size_t b = columns[(k + direction) % n];
      const double angle = direction == 1 ? image.AngleFrom(a, b) : image.AngleFrom(b, a);
      if (angle > kWidestGap || std::abs(image.Radius(row, b) - image.Radius(row, a)) > kStep) return false;
    }
    return true;
  };
  for (std::size_t first = 0; first < n; ++first) {
    if (step(first) < kStep) continue;
    for (std::size_t length = 1; length < n / 2; ++length) {
      if (image.AngleFrom(columns[first], columns[(first + length - 1) % n]) > kWidest) break;
      const double after = step(first + length);
      if (after > kStep) break;  // a higher run begins here
      if (after > -kStep) continue;
      // A leg's own silhouette is a step too, but nothing goes on behind it.
      if (!goes_on(first + n - 1, n - 1) && !goes_on(first + length, 1)) break;
      for (std::size_t k = first; k < first + length; ++k) marks[image.Index(row, columns[k % n])] = kFront;
      break;
    }
  }
}

/// Calls `visit` with the cells within (rows, columns) of a cell.
template <class Visit>
void Around(const RingImage& image, std::size_t cell, std::ptrdiff_t rows, std::ptrdiff_t columns, Visit visit) {
  const auto row = static_cast<std::ptrdiff_t>(cell / image.columns());
  const auto width = static_cast<std::ptrdiff_t>(image.columns());
  const auto column = static_cast<std::ptrdiff_t>(cell % image.columns());
  const auto last = std::min(static_cast<std::ptrdiff_t>(image.rows()) - 1, row + rows);
  for (std::ptrdiff_t r = std::max<std::ptrdiff_t>(0, row - rows); r <= last; ++r) {
    for (std::ptrdiff_t c = column - columns; c <= column + columns; ++c) {
      visit(static_cast<std::size_t>(r * width + ((c % width) + width) % width));
    }
  }
}

/// The marked cells that hang together with `seed`; they are marked as taken.
std::vector<std::size_t> Collect(const RingImage& image, std::size_t seed, std::vector<std::uint8_t>& marks) {
  const double pitch =
      (image.z(image.rows() - 1) - image.z(0)) / std::max(1.0, static_cast<double>(image.rows()) - 1.0);
  const double lost = pitch > 0.0 ? std::min(30.0, kLostHeight / pitch) : 0.0;
  const std::ptrdiff_t rows = std::max(kReach, static_cast<std::ptrdiff_t>(std::lround(lost)));
  std::vector<std::size_t> cells{seed};
  marks[seed] = kTaken;
  for (std::size_t next = 0; next < cells.size(); ++next) {
    Around(image, cells[next], rows, kReach, [&](std::size_t k) {
      if (marks[k] != kFront) return;
      marks[k] = kTaken;
      cells.push_back(k);
    });
  }
  return cells;
}

/// Adds the returns beside the object that are as far out as it is: finger tips, edges beside a gap.
void Claim(const RingImage& image, std::vector<std::size_t>& cells, std::vector<std::uint8_t>& marks) {
  for (std::size_t next = 0; next < cells.size(); ++next) {
    const std::size_t column = cells[next] % image.columns();
    const double radius = image.RawRadius(cells[next] / image.columns(), column);
    Around(image, cells[next], kReach, kReach, [&](std::size_t k) {
      const double other = image.RawRadius(k / image.columns(), k % image.columns());
      if (marks[k] != kMain || !(std::abs(other - radius) < kStep)) return;
      // Only what stands before the main surface on this level: next to it there is a step, or nothing.
      const std::size_t row = k / image.columns();
      const auto open = [&](std::ptrdiff_t side) {
        const std::size_t beside = row * image.columns() + image.grid().Column(k % image.columns(), side);
        const double there = image.RawRadius(row, beside % image.columns());
        return marks[beside] == kTaken || std::isnan(there) || other - there > kStep;
      };
      if (!open(-1) || !open(1)) return;
      marks[k] = kTaken;
      cells.push_back(k);
    });
  }
  std::sort(cells.begin(), cells.end());
}

/// Whether the next thing seen counter-clockwise of a cell of an object is the main surface, or nothing is near.
bool EndsArc(const RingImage& image, const std::vector<std::uint8_t>& marks, std::size_t cell) {
  constexpr std::ptrdiff_t kLost = 4;  // columns; so many returns may be lost or wild within an arc
  const std::size_t row = cell / image.columns();
  for (std::ptrdiff_t ahead = 1; ahead <= kLost; ++ahead) {
    const std::size_t column = image.grid().Column(cell % image.columns(), ahead);
    if (marks[image.Index(row, column)] == kTaken) return false;
    if (image.IsSeen(row, column)) return true;
  }
  return true;
}

/// Where the object is several arcs with the main surface between them.
void FindFingers(const RingImage& image, const std::vector<std::uint8_t>& marks, FrontObject& object) {
  std::vector<std::pair<double, std::size_t>> parted;  // height and arcs of the rows that have several
  for (std::size_t k = 0; k < object.cells.size();) {
    const std::size_t row = object.cells[k] / image.columns();
    std::size_t arcs = 0;
    for (; k < object.cells.size() && object.cells[k] / image.columns() == row; ++k) {
      if (EndsArc(image, marks, object.cells[k])) ++arcs;
    }
    if (arcs > 1) parted.emplace_back(image.z(row), arcs);
  }
  // The lowest run of such rows (rows ascend) that is more than a chance.
  constexpr double kSameHand = 20.0;  // mm
  for (std::size_t k = 0; k < parted.size();) {
    std::size_t end = k + 1;
    while (end < parted.size() && parted[end].first - parted[end - 1].first <= kSameHand) ++end;
    if (end - k >= kFewestRows && parted[end - 1].first - parted[k].first >= kSameHand) {
      object.fingers_z_min = parted[k].first;
      object.fingers_z_max = parted[end - 1].first;
      for (std::size_t n = k; n < end; ++n) object.fingers = std::max(object.fingers, parted[n].second);
      break;
    }
    k = end;
  }
  constexpr double kTip = 30.0;  // mm; what is left beyond the fingers belongs to them
  if (!object.HasFingers()) return;
  if (object.fingers_z_min - object.z_min <= kTip) object.fingers_z_min = object.z_min;
  if (object.z_max - object.fingers_z_max <= kTip) object.fingers_z_max = object.z_max;
}

FrontObject Describe(const RingImage& image, std::vector<std::size_t> cells) {
  FrontObject object;
  object.cells = std::move(cells);
  object.z_min = image.z(object.cells.front() / image.columns());
  object.z_max = image.z(object.cells.back() / image.columns());
  for (const std::size_t k : object.cells) {
    const std::size_t column = k % image.columns();
    const Eigen::Vector3d p =
        PointFromCylindrical(image.theta(column), image.RawRadius(k / image.columns(), column), 0.0);
    object.x += p.x() / static_cast<double>(object.cells.size());
    object.y += p.y() / static_cast<double>(object.cells.size());
  }
  const double middle = std::atan2(object.y, object.x);
  const auto offset = [&](std::size_t k) { return AngleDifference(image.theta(k % image.columns()), middle); };
  const auto [from, to] = std::minmax_element(object.cells.begin(), object.cells.end(),
                                              [&](std::size_t a, std::size_t b) { return offset(a) < offset(b); });
  object.column_from = *from % image.columns();
  object.column_to = *to % image.columns();
  return object;
}

}  // namespace

std::vector<FrontObject> FindFrontObjects(const RingImage& image) {
  std::vector<std::uint8_t> marks(image.cells(), kMain);
  for (std::size_t row = 0; row < image.rows(); ++row) MarkRow(image, row, marks);
  std::vector<FrontObject> objects;
  for (std::size_t seed = 0; seed < marks.size(); ++seed) {
    if (marks[seed] != kFront) continue;
    std::vector<std::size_t> cells = Collect(image, seed, marks);
    const auto [low, high] = std::minmax_element(cells.begin(), cells.end());
    const std::size_t rows = *high / image.columns() - *low / image.columns() + 1;
    const double height = image.z(*high / image.columns()) - image.z(*low / image.columns());
    if (rows < kFewestRows || height < kShortestObject || cells.size() < kFewestCells) {
      for (const std::size_t k : cells) marks[k] = kMain;
      continue;
    }
    Claim(image, cells, marks);
    objects.push_back(Describe(image, std::move(cells)));
    FindFingers(image, marks, objects.back());
  }
  return objects;
}

}  // namespace annulus
