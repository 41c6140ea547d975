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

/// Which of a leaf's cells lie beside what it shares with another.
using CellMarks = std::array<std::array<bool, kCells>, kCells>;

struct CellTriangles {
  AlignedBox3d box;
  std::array<Triangle, 2> triangle;
  bool beside = false;
};

std::vector<CellTriangles> CellsWithin(const ControlNet& net, const AlignedBox3d& box, const CellMarks& beside) {
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
      cell.beside = beside[i][j];
      cells.push_back(cell);
    }
  }
  return cells;
}

/// Whether two leaves cross, other than in cells that both lie beside what they share.
bool Cross(const ControlNet& a, const ControlNet& b, const CellMarks& beside_a, const CellMarks& beside_b) {
  const AlignedBox3d common = BoxOf(a).intersection(BoxOf(b));
  if (common.isEmpty()) return false;
  const std::vector<CellTriangles> of_a = CellsWithin(a, common, beside_a);
  if (of_a.empty()) return false;
  const std::vector<CellTriangles> of_b = CellsWithin(b, common, beside_b);
  for (const CellTriangles& x : of_a) {
    for (const CellTriangles& y : of_b) {
      if ((x.beside && y.beside) || !x.box.intersects(y.box)) continue;
      for (const Triangle& s : x.triangle) {
        for (const Triangle& t : y.triangle) {
          if (Cross(s, t)) return true;
        }
      }
    }
  }
  return false;
}

bool Cross(const ControlNet& a, const ControlNet& b) { return Cross(a, b, CellMarks{}, CellMarks{}); }

/// Cells along edges across which the other lies, and at corners that are also the other's.
CellMarks CellsBeside(const ClayPatch& own, PatchIndex other_index, const ClayPatch& other) {
  CellMarks marks{};
  const auto mark = [&marks](std::size_t edge, std::size_t along) {
    const std::size_t last = kCells - 1;
    switch (edge) {
      case 0:
        marks[along][0] = true;
        break;
      case 1:
        marks[last][along] = true;
        break;
      case 2:
        marks[last - along][last] = true;
        break;
      default:
        marks[0][last - along] = true;
    }
  };
  for (std::size_t e = 0; e < 4; ++e) {
    if (std::find(other.vertex.begin(), other.vertex.end(), own.vertex[e]) != other.vertex.end()) mark(e, 0);
    if (own.join[e].patch[0] != other_index && own.join[e].patch[1] != other_index) continue;
    for (std::size_t along = 0; along < kCells; ++along) mark(e, along);
  }
  return marks;
}

/// How far a leaf's normals go: no farther than `half_angle` from `middle`.
struct NormalCone {
  Vector3d middle = Vector3d::Zero();
  double half_angle = 0.0;
};

/// What the normals of a leaf's 4 × 4 cells say. Cells without area, at poles, do not count.
struct SkinShape {
  bool folds = false;  ///< Somewhere the skin turns by more than a right angle from one cell to the next.
  NormalCone cone;
};

SkinShape ShapeOf(const ControlNet& net) {
  const Grid grid = GridOf(net);
  std::array<std::array<Vector3d, kCells>, kCells> normal;
  SkinShape shape;
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t j = 0; j < kCells; ++j) {
      normal[i][j] = (grid[i + 1][j + 1] - grid[i][j]).cross(grid[i][j + 1] - grid[i + 1][j]);
      shape.cone.middle += normal[i][j];
    }
  }
  shape.cone.middle.stableNormalize();
  double least = 1.0;
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t j = 0; j < kCells; ++j) {
      const double length = normal[i][j].norm();
      if (length > 0.0) least = std::min(least, normal[i][j].dot(shape.cone.middle) / length);
      if (i + 1 < kCells && normal[i][j].dot(normal[i + 1][j]) < 0.0) shape.folds = true;
      if (j + 1 < kCells && normal[i][j].dot(normal[i][j + 1]) < 0.0) shape.folds = true;
    }
  }
  shape.cone.half_angle = std::acos(std::clamp(least, -1.0, 1.0));
  return shape;
}

/// Both leaves are heights over one plane: next to each other they do not cross.
bool FaceOneWay(const NormalCone& a, const NormalCone& b) {
  const double between = std::acos(std::clamp(a.middle.dot(b.middle), -1.0, 1.0));
  return 0.5 * between + std::max(a.half_angle, b.half_angle) < 1.5;
}

bool ShareVertex(const ClayPatch& a, const ClayPatch& b) {
  for (const VertexIndex of_a : a.vertex) {
    for (const VertexIndex of_b : b.vertex) {
      if (of_a == of_b) return true;
    }
  }
  return false;
}

/// Calls `use(a, b)` once for each pair of boxes that overlap: a sweep along the axis of the greatest spread, in strips
/// across the axis of the next, each of which knows the boxes that the sweep has not left yet.
template <class Use>
void ForEachOverlap(const std::vector<AlignedBox3d>& box, Use use) {
  if (box.empty()) return;
  AlignedBox3d all;
  Vector3d sizes = Vector3d::Zero();
  for (const AlignedBox3d& one : box) {
    all.extend(one);
    sizes += one.sizes();
  }
  std::array<Eigen::Index, 3> axis{0, 1, 2};
  std::sort(axis.begin(), axis.end(), [&](Eigen::Index a, Eigen::Index b) { return all.sizes()[a] > all.sizes()[b]; });
  const auto [first, second, third] = axis;
  const double width = 2.0 * sizes[second] / static_cast<double>(box.size());
  constexpr double kMostStrips = 1000.0;
  const double low = all.min()[second];
  const double strips = std::clamp(std::ceil(all.sizes()[second] / width), 1.0, kMostStrips);  // 1 if it is none
  const double scale = strips / std::max(all.sizes()[second], 1e-300);
  const auto strip_of = [&](double x) {
    return static_cast<std::size_t>(std::clamp((x - low) * scale, 0.0, strips - 1.0));
  };
  std::vector<std::uint32_t> order(box.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&, axis = first](std::uint32_t a, std::uint32_t b) { return box[a].min()[axis] < box[b].min()[axis]; });
  std::vector<std::vector<std::uint32_t>> open(static_cast<std::size_t>(strips));
  for (const std::uint32_t own : order) {
    const std::size_t from = strip_of(box[own].min()[second]);
    for (std::size_t strip = from; strip <= strip_of(box[own].max()[second]); ++strip) {
      std::vector<std::uint32_t>& here = open[strip];
      for (std::size_t n = 0; n < here.size();) {
        const std::uint32_t other = here[n];
        if (box[other].max()[first] < box[own].min()[first]) {
          here[n] = here.back();
          here.pop_back();
          continue;
        }
        // Two that share several strips meet in the first.
        const bool meets_here = strip == std::max(from, strip_of(box[other].min()[second]));
        if (meets_here && box[own].intersects(box[other])) use(other, own);
        ++n;
      }
      here.push_back(own);
    }
  }
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

void Embedding::Place(const ClayMesh& mesh, PatchIndex index) {
  const ClayPatch& leaf = mesh.patch(index);
  box_.resize(std::max(box_.size(), mesh.nodes().size()));
  std::uint32_t node = leaf.node;
  box_[node] = InCells(BoxOf(leaf.net));
  while (mesh.nodes()[node].parent != kNoIndex) {
    node = mesh.nodes()[node].parent;
    AlignedBox3d whole;
    for (const std::uint32_t child : mesh.nodes()[node].child) whole.extend(box_[child]);
    if (whole.min() == box_[node].min() && whole.max() == box_[node].max()) return;
    box_[node] = whole;
  }
  PlaceRoot(node);
}

void Embedding::PlaceRoot(std::uint32_t root) {
  if (cells_.size() <= root) cells_.resize(root + 1);
  std::vector<Cell> cells = CellsOf(box_[root]);
  if (cells == cells_[root] && !cells.empty()) return;
  Forget(root);
  cells_[root] = std::move(cells);
  for (const Cell cell : cells_[root]) roots_[cell].push_back(root);
  if (cells_[root].empty()) large_.push_back(root);
}

void Embedding::Forget(std::uint32_t root) {
  const auto drop = [root](std::vector<std::uint32_t>& from) {
    from.erase(std::remove(from.begin(), from.end(), root), from.end());
  };
  for (const Cell cell : cells_[root]) {
    const auto found = roots_.find(cell);
    drop(found->second);
    if (found->second.empty()) roots_.erase(found);
  }
  if (cells_[root].empty()) drop(large_);
}

std::vector<std::uint32_t> Embedding::RootsNear(const ClayMesh& mesh, const AlignedBox3d& box) const {
  std::vector<std::uint32_t> near;
  const std::vector<Cell> cells = CellsOf(box);
  if (cells.empty()) {
    for (std::uint32_t node = 0; node < box_.size(); ++node) {
      if (mesh.nodes()[node].parent == kNoIndex) near.push_back(node);
    }
    return near;
  }
  near = large_;
  for (const Cell cell : cells) {
    const auto found = roots_.find(cell);
    if (found == roots_.end()) continue;
    for (const std::uint32_t root : found->second) {
      if (box_[root].intersects(box)) near.push_back(root);
    }
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  return near;
}

std::vector<PatchIndex> Embedding::Near(const ClayMesh& mesh, const AlignedBox3d& box) const {
  std::vector<PatchIndex> near;
  std::vector<std::uint32_t> open = RootsNear(mesh, box);
  while (!open.empty()) {
    const std::uint32_t node = open.back();
    open.pop_back();
    if (!box_[node].intersects(box)) continue;
    const ClayMesh::Node& here = mesh.nodes()[node];
    if (here.patch != kNoIndex) {
      near.push_back(here.patch);
    } else if (here.child[0] != kNoIndex) {
      open.insert(open.end(), here.child.begin(), here.child.end());
    }
  }
  return near;
}

std::string Embedding::TroubleOf(const ClayMesh& mesh, const std::vector<PatchIndex>& leaves) const {
  for (const PatchIndex leaf : leaves) {
    if (!mesh.alive(leaf)) continue;
    const ClayPatch& own = mesh.patch(leaf);
    for (const PatchIndex other : Near(mesh, InCells(BoxOf(own.net)))) {
      if (other == leaf || ShareVertex(own, mesh.patch(other)) || !Cross(own.net, mesh.patch(other).net)) continue;
      return fmt::format("patches {} and {} would cross", own.base, mesh.patch(other).base);
    }
  }
  return {};
}

std::string Embedding::Trouble(const ClayMesh& mesh, const VisitMarks& marks, const ClayTrial& trial, double k) const {
  const std::vector<PatchIndex>& touched = trial.touched();
  std::vector<ControlNet> net(touched.size());
  std::vector<AlignedBox3d> box(touched.size());  // in the space of the cells
  std::vector<NormalCone> cone(touched.size());
  for (std::size_t n = 0; n < touched.size(); ++n) {
    net[n] = trial.NetAt(n, k);
    box[n] = InCells(BoxOf(net[n]));
    const SkinShape shape = ShapeOf(net[n]);
    cone[n] = shape.cone;
    if (!box[n].min().allFinite() || !box[n].max().allFinite()) return "a control point would not be finite";
    if (shape.folds && !ShapeOf(mesh.patch(touched[n]).net).folds) {
      return fmt::format("the skin would fold over in patch {}", mesh.patch(touched[n]).base);
    }
  }
  // Boxes of where the leaves were: a leaf that came from elsewhere is found among the touched ones.
  const auto crosses = [&](std::size_t n, PatchIndex other, const ControlNet& other_net) {
    const ClayPatch& own = mesh.patch(touched[n]);
    const ClayPatch& theirs = mesh.patch(other);
    if (!ShareVertex(own, theirs)) return Cross(net[n], other_net) && !Cross(own.net, theirs.net);
    if (FaceOneWay(cone[n], marks.Has(other) ? cone[marks.Slot(other)] : ShapeOf(other_net).cone)) return false;
    const CellMarks own_marks = CellsBeside(own, other, theirs);
    const CellMarks their_marks = CellsBeside(theirs, touched[n], own);
    return Cross(net[n], other_net, own_marks, their_marks) && !Cross(own.net, theirs.net, own_marks, their_marks);
  };
  const auto said = [&](std::size_t n, PatchIndex other) {
    return fmt::format("patches {} and {} would cross", mesh.patch(touched[n]).base, mesh.patch(other).base);
  };
  const bool all = touched.size() == mesh.leaf_count();
  for (std::size_t n = 0; n < touched.size() && !all; ++n) {
    for (const PatchIndex other : Near(mesh, box[n])) {
      if (marks.Has(other)) continue;
      if (crosses(n, other, mesh.patch(other).net)) return said(n, other);
    }
  }
  std::string trouble;
  ForEachOverlap(box, [&](std::size_t a, std::size_t b) {
    if (trouble.empty() && crosses(a, touched[b], net[b])) trouble = said(a, touched[b]);
  });
  return trouble;
}

}  // namespace annulus
