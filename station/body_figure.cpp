#include "station/body_figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "base/ensure.h"
#include "modeling/mesh/tessellate.h"

namespace annulus {
namespace {

constexpr double kNothing = std::numeric_limits<double>::lowest();
constexpr double kHiddenBy = 8.0;  // mm of body before a point that hide it; tapes lie on the skin
constexpr double kMargin = 2.0;    // pixels of air around the body
/// The lamp above the viewer's left shoulder, in the viewer's axes (right, up, towards), unit length.
const Eigen::Vector3d kLamp = Eigen::Vector3d(-0.35, 0.45, 1.0).normalized();

using Loop = std::vector<Eigen::Vector2d>;

/// An edge of the grid that a level curve crosses: from the grid point (column, row) to the right or upwards.
struct CrossedEdge {
  long column;
  long row;
  bool upwards;
  auto operator<=>(const CrossedEdge&) const = default;
};

/// Values of a field whose outside is lowest.
struct PaddedField {
  const FigureGrid& grid;
  double outside;

  [[nodiscard]] double At(long column, long row) const {
    const bool inside =
        column >= 0 && row >= 0 && column < static_cast<long>(grid.columns) && row < static_cast<long>(grid.rows);
    return inside ? grid.At(static_cast<std::size_t>(column), static_cast<std::size_t>(row)) : outside;
  }

  [[nodiscard]] Eigen::Vector2d Crossing(const CrossedEdge& edge, double level) const {
    const double from = At(edge.column, edge.row);
    const double to = edge.upwards ? At(edge.column, edge.row + 1) : At(edge.column + 1, edge.row);
    const double share = std::clamp((level - from) / (to - from), 0.0, 1.0);
    const Eigen::Vector2d at(static_cast<double>(edge.column), static_cast<double>(edge.row));
    return at + share * (edge.upwards ? Eigen::Vector2d::UnitY() : Eigen::Vector2d::UnitX());
  }
};

/// Steps of level curves through the cell whose lower left point is (column, row): marching squares, the higher side to
/// the left. In a saddle the higher corners are kept apart.
void StepThroughCell(const PaddedField& field, double level, long column, long row,
                     std::map<CrossedEdge, CrossedEdge>& next) {
  const std::array<bool, 4> high{field.At(column, row) > level, field.At(column + 1, row) > level,
                                 field.At(column + 1, row + 1) > level, field.At(column, row + 1) > level};
  // Edge k joins corner k and corner k + 1, counter-clockwise from the lower left.
  const std::array<CrossedEdge, 4> edges{
      {{column, row, false}, {column + 1, row, true}, {column, row + 1, false}, {column, row, true}}};
  for (std::size_t k = 0; k < 4; ++k) {
    // A curve enters through an edge that leads from high to low, and leaves by the one before it from low to high.
    if (!high[k] || high[(k + 1) % 4]) continue;
    std::size_t back = k;
    while (high[back]) back = (back + 3) % 4;
    next[edges[k]] = edges[back];
  }
}

}  // namespace

std::vector<Loop> LevelLoops(const FigureGrid& field, double level) {
  const PaddedField padded{field, kNothing / 4.0};
  std::map<CrossedEdge, CrossedEdge> next;
  for (long row = -1; row < static_cast<long>(field.rows); ++row) {
    for (long column = -1; column < static_cast<long>(field.columns); ++column) {
      StepThroughCell(padded, level, column, row, next);
    }
  }
  std::vector<Loop> loops;
  while (!next.empty()) {
    Loop loop;
    for (auto at = next.begin(); at != next.end();) {
      loop.push_back(padded.Crossing(at->first, level));
      const CrossedEdge following = at->second;
      next.erase(at);
      at = next.find(following);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<Eigen::Vector2d> Simplified(const std::vector<Eigen::Vector2d>& curve, double tolerance) {
  if (curve.size() < 3) return curve;
  std::vector<char> kept(curve.size(), 0);
  kept.front() = kept.back() = 1;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, curve.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    const Eigen::Vector2d chord = curve[last] - curve[first];
    const double length = chord.norm();
    double worst = tolerance;
    std::size_t at = first;
    for (std::size_t k = first + 1; k < last; ++k) {
      const Eigen::Vector2d d = curve[k] - curve[first];
      const double distance = length > 0.0 ? std::abs(chord.x() * d.y() - chord.y() * d.x()) / length : d.norm();
      if (distance > worst) {
        worst = distance;
        at = k;
      }
    }
    if (at == first) continue;
    kept[at] = 1;
    open.emplace_back(first, at);
    open.emplace_back(at, last);
  }
  std::vector<Eigen::Vector2d> simple;
  for (std::size_t k = 0; k < curve.size(); ++k) {
    if (kept[k] != 0) simple.push_back(curve[k]);
  }
  return simple;
}

struct BodyFigure::Corner {
  Eigen::Vector2d at;  // pixels
  double depth = 0.0;
  double light = 0.0;
};

BodyFigure::BodyFigure(const TriangleMesh& mesh, double azimuth, double pixel_mm)
    : right_(-std::sin(azimuth), std::cos(azimuth), 0.0),
      toward_(std::cos(azimuth), std::sin(azimuth), 0.0),
      pixel_mm_(pixel_mm),
      low_(Eigen::Vector2d::Constant(std::numeric_limits<double>::max())),
      high_(-low_) {
  ENSURE(!mesh.faces.empty() && pixel_mm > 0.0, "a figure shows something");
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    low_ = low_.cwiseMin(Project(vertex));
    high_ = high_.cwiseMax(Project(vertex));
  }
  low_.array() -= kMargin * pixel_mm;
  high_.array() += kMargin * pixel_mm;
  depth_.columns = static_cast<std::size_t>((high_.x() - low_.x()) / pixel_mm) + 1;
  depth_.rows = static_cast<std::size_t>((high_.y() - low_.y()) / pixel_mm) + 1;
  depth_.values.assign(depth_.columns * depth_.rows, kNothing);
  light_ = {depth_.columns, depth_.rows, std::vector<double>(depth_.values.size(), 0.0)};
  const std::vector<Eigen::Vector3d> normals = VertexNormals(mesh);
  std::vector<Corner> corners(mesh.vertices.size());
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector3d seen(normals[k].dot(right_), normals[k].z(), normals[k].dot(toward_));
    corners[k] = {(Project(mesh.vertices[k]) - low_) / pixel_mm, mesh.vertices[k].dot(toward_),
                  std::max(0.0, seen.dot(kLamp))};
  }
  for (const auto& face : mesh.faces) DrawTriangle(corners[face[0]], corners[face[1]], corners[face[2]]);
}

void BodyFigure::DrawTriangle(const Corner& a, const Corner& b, const Corner& c) {
  const auto cross = [](const Eigen::Vector2d& u, const Eigen::Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); };
  const double area = cross(b.at - a.at, c.at - a.at);
  if (std::abs(area) < 1e-12) return;
  const auto first = [](double x, double y, double z) { return std::ceil(std::min({x, y, z}) - 1e-9); };
  const auto last = [](double x, double y, double z) { return std::floor(std::max({x, y, z}) + 1e-9); };
  for (double y = first(a.at.y(), b.at.y(), c.at.y()); y <= last(a.at.y(), b.at.y(), c.at.y()); ++y) {
    for (double x = first(a.at.x(), b.at.x(), c.at.x()); x <= last(a.at.x(), b.at.x(), c.at.x()); ++x) {
      const Eigen::Vector2d p(x, y);
      const double in_b = cross(p - a.at, c.at - a.at) / area;
      const double in_c = cross(b.at - a.at, p - a.at) / area;
      const double in_a = 1.0 - in_b - in_c;
      if (std::min({in_a, in_b, in_c}) < -1e-9) continue;
      const std::size_t at = static_cast<std::size_t>(y) * depth_.columns + static_cast<std::size_t>(x);
      const double depth = in_a * a.depth + in_b * b.depth + in_c * c.depth;
      if (depth <= depth_.values[at]) continue;
      depth_.values[at] = depth;
      light_.values[at] = in_a * a.light + in_b * b.light + in_c * c.light;
    }
  }
}

Eigen::Vector2d BodyFigure::Project(const Eigen::Vector3d& point) const { return {point.dot(right_), point.z()}; }

std::vector<Loop> BodyFigure::Loops(const FigureGrid& field, double level) const {
  constexpr double kTolerance = 0.2;     // pixels
  constexpr std::size_t kSmallest = 24;  // steps; smaller specks are no form
  std::vector<Loop> loops;
  for (Loop& loop : LevelLoops(field, level)) {
    if (loop.size() < kSmallest) continue;
    for (Eigen::Vector2d& point : loop) point = low_ + pixel_mm_ * point;
    loops.push_back(Simplified(loop, kTolerance * pixel_mm_));
  }
  return loops;
}

std::vector<Loop> BodyFigure::Outline() const {
  FigureGrid covered = depth_;
  for (double& value : covered.values) value = value > kNothing ? 1.0 : 0.0;
  return Loops(covered, 0.5);
}

std::vector<Loop> BodyFigure::Lit(double light) const { return Loops(light_, light); }

bool BodyFigure::Hides(const Eigen::Vector3d& point) const {
  const Eigen::Vector2d at = (Project(point) - low_) / pixel_mm_;
  const auto column = std::lround(at.x());
  const auto row = std::lround(at.y());
  if (column < 0 || row < 0 || column >= static_cast<long>(depth_.columns) || row >= static_cast<long>(depth_.rows)) {
    return false;
  }
  return depth_.At(static_cast<std::size_t>(column), static_cast<std::size_t>(row)) > point.dot(toward_) + kHiddenBy;
}

std::vector<FigureRun> BodyFigure::Runs(const std::vector<Eigen::Vector3d>& path) const {
  constexpr double kStep = 4.0;  // mm between the places looked at
  std::vector<FigureRun> runs;
  const auto add = [&](const Eigen::Vector3d& point) {
    const bool visible = !Hides(point);
    const Eigen::Vector2d at = Project(point);
    if (runs.empty()) {
      runs.push_back({{at}, visible});
    } else if (runs.back().visible == visible) {
      runs.back().points.push_back(at);
    } else {
      runs.push_back({{runs.back().points.back(), at}, visible});
    }
  };
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const int steps = std::max(1, static_cast<int>((path[k + 1] - path[k]).norm() / kStep));
    for (int step = 0; step < steps; ++step) add(path[k] + (path[k + 1] - path[k]) * (double(step) / steps));
  }
  if (!path.empty()) add(path.back());
  return runs;
}

TriangleMesh FigureMesh(const SurfaceModel& model, double from_z) {
  TriangleMesh mesh;
  for (const SurfaceSegment& segment : model.segments) {
    if (segment.name.find("arm") != std::string::npos) continue;
    TessellationOptions options;
    options.theta_count = 240;
    options.max_z_spacing_mm = std::clamp((segment.surface.z_max() - segment.surface.z_min()) / 300.0, 1.0, 4.0);
    Append(mesh, TessellateSurface(segment, options));
  }
  TriangleMesh shown;
  std::vector<std::uint32_t> number(mesh.vertices.size(), 0);  // in `shown`, counted from 1
  for (auto face : mesh.faces) {
    const auto below = [&](std::uint32_t k) { return mesh.vertices[k].z() < from_z; };
    if (std::any_of(face.begin(), face.end(), below)) continue;
    for (std::uint32_t& k : face) {
      if (number[k] == 0) {
        shown.vertices.push_back(mesh.vertices[k]);
        number[k] = static_cast<std::uint32_t>(shown.vertices.size());
      }
      k = number[k] - 1;
    }
    shown.faces.push_back(face);
  }
  return shown;
}

}  // namespace annulus
