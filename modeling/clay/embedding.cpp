#include "modeling/clay/embedding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace annulus {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

namespace {

constexpr std::size_t kCells = 4;  ///< Of a leaf, each way, when two are held against each other.
using Grid = std::array<std::array<Vector3d, kCells + 1>, kCells + 1>;

AlignedBox3d BoxOf(const ControlNet& net) {
  AlignedBox3d box;
  for (const auto& row : net) {
    for (const Vector3d& point : row) box.extend(point);
  }
  return box;
}

const std::array<std::array<double, 4>, kCells + 1>& GridWeights() {
  static const auto weights = [] {
    std::array<std::array<double, 4>, kCells + 1> made;
    for (std::size_t i = 0; i <= kCells; ++i) {
      made[i] = CubicBernstein(static_cast<double>(i) / static_cast<double>(kCells));
    }
    return made;
  }();
  return weights;
}

Grid GridOf(const ControlNet& net) {
  const auto& weight = GridWeights();
  Grid grid;
  for (std::size_t i = 0; i <= kCells; ++i) {
    std::array<Vector3d, 4> curve;
    for (std::size_t j = 0; j < 4; ++j) {
      curve[j] =
          weight[i][0] * net[0][j] + weight[i][1] * net[1][j] + weight[i][2] * net[2][j] + weight[i][3] * net[3][j];
    }
    for (std::size_t j = 0; j <= kCells; ++j) {
      grid[i][j] =
          weight[j][0] * curve[0] + weight[j][1] * curve[1] + weight[j][2] * curve[2] + weight[j][3] * curve[3];
    }
  }
  return grid;
}

using Triangle = std::array<Vector3d, 3>;

/// Möller and Trumbore (1997); touching at an end counts as no crossing.
bool SegmentMeets(const Vector3d& from, const Vector3d& to, const Triangle& triangle) {
  const Vector3d direction = to - from;
  const Vector3d edge1 = triangle[1] - triangle[0];
  const Vector3d edge2 = triangle[2] - triangle[0];
  const Vector3d p = direction.cross(edge2);
  const double determinant = edge1.dot(p);
  if (std::abs(determinant) < 1e-300) return false;
  const Vector3d s = from - triangle[0];
  const double u = s.dot(p) / determinant;
  if (u < 0.0 || u > 1.0) return false;
  const Vector3d q = s.cross(edge1);
  const double v = direction.dot(q) / determinant;
  if (v < 0.0 || u + v > 1.0) return false;
  const double t = edge2.dot(q) / determinant;
  return t > 0.0 && t < 1.0;
}

bool Cross(const Triangle& a, const Triangle& b) {
  for (std::size_t e = 0; e < 3; ++e) {
    if (SegmentMeets(a[e], a[(e + 1) % 3], b) || SegmentMeets(b[e], b[(e + 1) % 3], a)) return true;
  }
  return false;
}

struct CellTriangles {
  AlignedBox3d box;
  std::array<Triangle, 2> triangle;
};

std::vector<CellTriangles> CellsWithin(const ControlNet& net, const AlignedBox3d& box) {
  const Grid grid = GridOf(net);
  std::vector<CellTriangles> cells;
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t j = 0; j < kCells; ++j) {
      CellTriangles cell;
      for (const Vector3d& corner : {grid[i][j], grid[i + 1][j], grid[i][j + 1], grid[i + 1][j + 1]}) {
        cell.box.extend(corner);
      }
      if (!cell.box.intersects(box)) continue;
      cell.triangle[0] = {grid[i][j], grid[i + 1][j], grid[i + 1][j + 1]};
      cell.triangle[1] = {grid[i][j], grid[i + 1][j + 1], grid[i][j + 1]};
      cells.push_back(cell);
    }
  }
  return cells;
}

bool Cross(const ControlNet& a, const ControlNet& b) {
  const AlignedBox3d common = BoxOf(a).intersection(BoxOf(b));
  if (common.isEmpty()) return false;
  const std::vector<CellTriangles> of_a = CellsWithin(a, common);
  if (of_a.empty()) return false;
  const std::vector<CellTriangles> of_b = CellsWithin(b, common);
  for (const CellTriangles& x : of_a) {
    for (const CellTriangles& y : of_b) {
      if (!x.box.intersects(y.box)) continue;
      for (const Triangle& s : x.triangle) {
        for (const Triangle& t : y.triangle) {
          if (Cross(s, t)) return true;
        }
      }
    }
  }
  return false;
}

/// Somewhere the skin turns by more than a right angle from one of 4 × 4 cells to the next. Cells without area, at
/// poles, do not count.
bool FoldsOver(const ControlNet& net) {
  const Grid grid = GridOf(net);
  std::array<std::array<Vector3d, kCells>, kCells> normal;
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t j = 0; j < kCells; ++j) {
      normal[i][j] = (grid[i + 1][j + 1] - grid[i][j]).cross(grid[i][j + 1] - grid[i + 1][j]);
    }
  }
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t j = 0; j < kCells; ++j) {
      if (i + 1 < kCells && normal[i][j].dot(normal[i + 1][j]) < 0.0) return true;
      if (j + 1 < kCells && normal[i][j].dot(normal[i][j + 1]) < 0.0) return true;
    }
  }
  return false;
}

bool ShareVertex(const ClayPatch& a, const ClayPatch& b) {
  for (const VertexIndex of_a : a.vertex) {
    for (const VertexIndex of_b : b.vertex) {
      if (of_a == of_b) return true;
    }
  }
  return false;
}

/// Pairs of boxes that overlap, by a sweep along the axis of the greatest spread.
std::vector<std::pair<std::size_t, std::size_t>> OverlappingPairs(const std::vector<AlignedBox3d>& box) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  AlignedBox3d all;
  for (const AlignedBox3d& one : box) all.extend(one);
  if (box.empty()) return pairs;
  Eigen::Index axis = 0;
  all.sizes().maxCoeff(&axis);
  std::vector<std::size_t> order(box.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return box[a].min()[axis] < box[b].min()[axis]; });
  for (std::size_t a = 0; a < order.size(); ++a) {
    const AlignedBox3d& own = box[order[a]];
    for (std::size_t b = a + 1; b < order.size() && box[order[b]].min()[axis] <= own.max()[axis]; ++b) {
      if (own.intersects(box[order[b]])) pairs.emplace_back(order[a], order[b]);
    }
  }
  return pairs;
}

std::uint64_t KeyOf(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t key = 0xcbf29ce484222325U;
  for (const std::int64_t c : {x, y, z}) {
    key = (key ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15U;
    key ^= key >> 29U;
  }
  return key;
}

}  // namespace

std::vector<Embedding::Cell> Embedding::CellsOf(const AlignedBox3d& box) const {
  std::array<std::int64_t, 3> low{};
  std::array<std::int64_t, 3> high{};
  double count = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double first = std::floor(box.min()[axis] / cell_);
    const double last = std::floor(box.max()[axis] / cell_);
    count *= last - first + 1.0;
    if (!(count <= static_cast<double>(kMostCells))) return {};  // nor if it is none
    low[a] = std::llround(first);
    high[a] = std::llround(last);
  }
  std::vector<Cell> cells;
  for (std::int64_t x = low[0]; x <= high[0]; ++x) {
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      for (std::int64_t z = low[2]; z <= high[2]; ++z) cells.push_back(KeyOf(x, y, z));
    }
  }
  return cells;
}

AlignedBox3d Embedding::InCells(const AlignedBox3d& box) const {
  return {(box.min() - shift_) / scale_, (box.max() - shift_) / scale_};
}

void Embedding::Move(double scale, const Vector3d& shift) {
  scale_ *= scale;
  shift_ = scale * shift_ + shift;
}

void Embedding::Place(PatchIndex index, const ControlNet& net) {
  if (cells_.size() <= index) {
    cells_.resize(index + 1);
    box_.resize(index + 1);
    is_large_.resize(index + 1, false);
  }
  box_[index] = InCells(BoxOf(net));
  std::vector<Cell> cells = CellsOf(box_[index]);
  if (cells == cells_[index] && !cells.empty()) return;
  Forget(index);
  cells_[index] = std::move(cells);
  for (const Cell cell : cells_[index]) leaves_[cell].push_back(index);
  if (!cells_[index].empty()) return;
  large_.push_back(index);
  is_large_[index] = true;
}

void Embedding::Remove(PatchIndex index) {
  Forget(index);
  box_[index].setEmpty();
}

void Embedding::Forget(PatchIndex index) {
  const auto drop = [index](std::vector<PatchIndex>& from) {
    from.erase(std::remove(from.begin(), from.end(), index), from.end());
  };
  for (const Cell cell : cells_[index]) {
    const auto found = leaves_.find(cell);
    drop(found->second);
    if (found->second.empty()) leaves_.erase(found);
  }
  cells_[index].clear();
  if (is_large_[index]) drop(large_);
  is_large_[index] = false;
}

std::vector<PatchIndex> Embedding::Near(const AlignedBox3d& box) const {
  std::vector<PatchIndex> near;
  const std::vector<Cell> cells = CellsOf(box);
  if (cells.empty()) {
    for (PatchIndex index = 0; index < box_.size(); ++index) near.push_back(index);
  } else {
    near = large_;
    for (const Cell cell : cells) {
      const auto found = leaves_.find(cell);
      if (found != leaves_.end()) near.insert(near.end(), found->second.begin(), found->second.end());
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
  }
  return near;
}

std::string Embedding::Trouble(const ClayMesh& mesh, const VisitMarks& marks, const ClayTrial& trial, double k) const {
  const std::vector<PatchIndex>& touched = trial.touched();
  std::vector<ControlNet> net(touched.size());
  std::vector<AlignedBox3d> box(touched.size());  // in the space of the cells
  for (std::size_t n = 0; n < touched.size(); ++n) {
    net[n] = trial.NetAt(n, k);
    box[n] = InCells(BoxOf(net[n]));
    if (!box[n].min().allFinite() || !box[n].max().allFinite()) return "a control point would not be finite";
    if (FoldsOver(net[n]) && !FoldsOver(mesh.patch(touched[n]).net)) {
      return fmt::format("the skin would fold over in patch {}", mesh.patch(touched[n]).base);
    }
  }
  // Boxes of where the leaves were: a leaf that came from elsewhere is found among the touched ones.
  const auto crosses = [&](std::size_t n, PatchIndex other, const ControlNet& other_net) {
    const ClayPatch& own = mesh.patch(touched[n]);
    return !ShareVertex(own, mesh.patch(other)) && Cross(net[n], other_net) && !Cross(own.net, mesh.patch(other).net);
  };
  const auto said = [&](std::size_t n, PatchIndex other) {
    return fmt::format("patches {} and {} would cross", mesh.patch(touched[n]).base, mesh.patch(other).base);
  };
  for (std::size_t n = 0; n < touched.size(); ++n) {
    for (const PatchIndex other : Near(box[n])) {
      if (marks.Has(other) || !box_[other].intersects(box[n])) continue;
      if (crosses(n, other, mesh.patch(other).net)) return said(n, other);
    }
  }
  for (const auto& [a, b] : OverlappingPairs(box)) {
    if (crosses(a, touched[b], net[b])) return said(a, touched[b]);
  }
  return {};
}

}  // namespace annulus
