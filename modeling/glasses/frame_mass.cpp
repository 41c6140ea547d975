#include "modeling/glasses/frame_mass.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace annulus {
namespace {

using Eigen::AlignedBox2d;
using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Columns along each side of a region, and steps of the patches that they meet.
constexpr int kColumns = 32;
constexpr std::size_t kAlongSteps = 6;
constexpr std::size_t kAroundSteps = 5;

AlignedBox3d BoxOf(const BezierPatch& patch) {
  AlignedBox3d box;
  for (const auto& row : patch.control_net()) {
    for (const Vector3d& point : row) box.extend(point);
  }
  return box;
}

AlignedBox3d BoxOf(const PatchShell& shell) {
  AlignedBox3d box;
  for (const ShellPatch& piece : shell.patches) box.extend(BoxOf(piece.patch));
  return box;
}

/// The x, z rectangle of a box.
AlignedBox2d Plan(const AlignedBox3d& box) {
  return {Vector2d(box.min().x(), box.min().z()), Vector2d(box.max().x(), box.max().z())};
}

/// Rectangles that together hold every place where two shells may overlap; they do not meet each other.
std::vector<AlignedBox2d> OverlapRegions(const std::vector<AlignedBox3d>& boxes) {
  std::vector<AlignedBox2d> regions;
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    for (std::size_t b = a + 1; b < boxes.size(); ++b) {
      const AlignedBox3d shared = boxes[a].intersection(boxes[b]);
      if (!shared.isEmpty()) regions.push_back(Plan(shared));
    }
  }
  for (std::size_t k = 0; k < regions.size();) {
    const auto other = std::find_if(regions.begin() + static_cast<std::ptrdiff_t>(k) + 1, regions.end(),
                                    [&](const AlignedBox2d& r) { return r.intersects(regions[k]); });
    if (other == regions.end()) {
      ++k;
      continue;
    }
    regions[k].extend(*other);
    regions.erase(other);
    k = 0;  // what was clear before may meet the larger one
  }
  return regions;
}

/// A surface crossed by a column: +1 into a shell, -1 out of it.
struct Crossing {
  int column;
  int change;
  double y;
};

/// Columns along y on a grid over a region.
class Columns {
 public:
  explicit Columns(const AlignedBox2d& region) : region_(region), step_(region.sizes() / kColumns) {
    crossings_.reserve(std::size_t{8} * kColumns * kColumns);
  }

  void Add(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const double twice_area = (b.x() - a.x()) * (c.z() - a.z()) - (b.z() - a.z()) * (c.x() - a.x());
    if (twice_area == 0.0) return;
    const auto [x_first, x_last] = Range({a.x(), b.x(), c.x()}, 0);
    const auto [z_first, z_last] = Range({a.z(), b.z(), c.z()}, 1);
    for (int i = x_first; i <= x_last; ++i) {
      for (int j = z_first; j <= z_last; ++j) {
        const Vector2d p = At(i, j);
        const double wb = ((p.x() - a.x()) * (c.z() - a.z()) - (p.y() - a.z()) * (c.x() - a.x())) / twice_area;
        const double wc = ((b.x() - a.x()) * (p.y() - a.z()) - (b.z() - a.z()) * (p.x() - a.x())) / twice_area;
        if (wb < 0.0 || wc < 0.0 || wb + wc > 1.0) continue;
        // Seen along +y a positive turn in x, z faces backwards (x × z = -y): the column enters there.
        crossings_.push_back(
            {i * kColumns + j, twice_area > 0.0 ? 1 : -1, a.y() + wb * (b.y() - a.y()) + wc * (c.y() - a.y())});
      }
    }
  }

  /// What is counted more than once.
  ShellMoments Excess() {
    std::sort(crossings_.begin(), crossings_.end(), [](const Crossing& a, const Crossing& b) {
      return a.column != b.column ? a.column < b.column : a.y < b.y;
    });
    ShellMoments excess;
    int inside = 0;
    for (std::size_t k = 0; k + 1 < crossings_.size(); ++k) {
      const Crossing& from = crossings_[k];
      const Crossing& to = crossings_[k + 1];
      inside = to.column == from.column ? inside + from.change : 0;
      if (inside < 2) continue;
      const Vector2d place = At(from.column / kColumns, from.column % kColumns);
      const double volume = (inside - 1) * (to.y - from.y) * step_.prod();
      excess.volume += volume;
      excess.first += volume * Vector3d(place.x(), 0.5 * (from.y + to.y), place.y());
    }
    return excess;
  }

 private:
  [[nodiscard]] Vector2d At(int i, int j) const {
    return region_.min() + Vector2d((i + 0.5) * step_.x(), (j + 0.5) * step_.y());
  }

  [[nodiscard]] std::pair<int, int> Range(std::initializer_list<double> values, int axis) const {
    const auto cell = [&](double value) {
      return std::clamp((value - region_.min()[axis]) / step_[axis] - 0.5, -1.0, kColumns + 0.0);
    };
    return {std::max(0, static_cast<int>(std::ceil(cell(std::min(values))))),
            std::min(kColumns - 1, static_cast<int>(std::floor(cell(std::max(values)))))};
  }

  AlignedBox2d region_;
  Vector2d step_;
  std::vector<Crossing> crossings_;
};

std::size_t Steps(PatchDetail detail) {
  if (detail == PatchDetail::kStraight) return 1;
  return detail == PatchDetail::kAlong ? kAlongSteps : kAroundSteps;
}

ShellMoments ExcessOf(const FrameBody& body) {
  std::vector<AlignedBox3d> boxes;
  boxes.reserve(body.shells.size());
  for (const PatchShell& shell : body.shells) boxes.push_back(BoxOf(shell));
  ShellMoments excess;
  for (const AlignedBox2d& region : OverlapRegions(boxes)) {
    Columns columns(region);
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      if (!Plan(boxes[k]).intersects(region)) continue;
      for (const ShellPatch& piece : body.shells[k].patches) {
        if (!Plan(BoxOf(piece.patch)).intersects(region)) continue;
        const TriangleMesh sheet = Tessellate(piece.patch, Steps(piece.u), Steps(piece.v));
        for (const auto& face : sheet.faces) {
          columns.Add(sheet.vertices[face[0]], sheet.vertices[face[1]], sheet.vertices[face[2]]);
        }
      }
    }
    const ShellMoments here = columns.Excess();
    excess.volume += here.volume;
    excess.first += here.first;
  }
  return excess;
}

}  // namespace

FrameMass MassOf(const Frame& frame, double density) {
  FrameMass whole;
  Vector3d first = Vector3d::Zero();
  for (const FrameBody& body : FrameBodies(frame)) {
    ShellMoments moments = ExcessOf(body);
    moments.volume = -moments.volume;
    moments.first = -moments.first;
    for (const PatchShell& shell : body.shells) {
      const ShellMoments exact = MomentsOf(shell);
      moments.volume += exact.volume;
      moments.first += exact.first;
    }
    // g/cm³ = 1e-3 g/mm³.
    whole.bodies.push_back(
        {body.name, moments.volume, 1e-3 * density * moments.volume, moments.first / moments.volume});
    whole.volume += moments.volume;
    first += moments.first;
  }
  whole.mass = 1e-3 * density * whole.volume;
  whole.centre_of_gravity = first / whole.volume;
  return whole;
}

}  // namespace annulus
