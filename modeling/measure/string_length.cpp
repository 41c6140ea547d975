#include "modeling/measure/string_length.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/gauss.h"

namespace annulus {
namespace {

constexpr double kPathDepth = 0.6e-3;  ///< mm
constexpr double kMostParts = 16.0;
constexpr double kKnowledgeStep = 5.0;  ///< mm; spans are looked under at least so often.

/// How far inside the body a point is, along its normal to first order, mm; negative outside.
double DepthOf(const SplineSurface& surface, const Eigen::Vector3d& point) {
  const double theta = std::atan2(point.y(), point.x());
  const double rho = point.head<2>().norm();
  const RadiusJet jet = surface.Jet(theta, point.z());
  return (jet.r - rho) / std::sqrt(1.0 + jet.r_z * jet.r_z + std::pow(jet.r_theta / std::max(rho, 1e-9), 2));
}

/// Hermite's cubic in (theta, z) from 0 to `step`, over t = 0 … 1, with its slopes at both ends.
struct HermitePiece {
  Eigen::Vector2d step, slope_from, slope_to;

  [[nodiscard]] Eigen::Vector2d At(double t) const {
    return t * t * (3.0 - 2.0 * t) * step + t * (1.0 - t) * (1.0 - t) * slope_from - t * t * (1.0 - t) * slope_to;
  }
  [[nodiscard]] Eigen::Vector2d Slope(double t) const {
    return 6.0 * t * (1.0 - t) * step + (1.0 - t) * (1.0 - 3.0 * t) * slope_from + t * (3.0 * t - 2.0) * slope_to;
  }
};

/// A path in (theta, z) over one edge: what it adds to the length.
class CurveSum {
 public:
  explicit CurveSum(const MeasuredSurface& body) : body_(&body), surface_(&body.surface()), gradient_(*surface_) {}

  void AddSurfacePiece(const SurfacePlace& from, const HermitePiece& cubic);
  void AddStraightPiece(const PathPoint& from, const PathPoint& to);
  [[nodiscard]] Estimate Length() const { return {length_, gradient_.Get()}; }
  [[nodiscard]] PathKnowledge Knowledge() const {
    if (!(length_ > 0.0)) return {};
    return {measured_ / length_, unknown_ / length_};
  }

 private:
  void AddSeen(const SurfacePlace& place, double length, bool touching);

  const MeasuredSurface* body_;
  const SplineSurface* surface_;
  GradientSum gradient_;
  double length_ = 0.0;
  double measured_ = 0.0;
  double unknown_ = 0.0;
};

void CurveSum::AddSeen(const SurfacePlace& place, double length, bool touching) {
  const annulus::Knowledge known = body_->KnowledgeAt(place.theta, place.z);
  if (known == annulus::Knowledge::kMeasured) measured_ += length;
  if (known == annulus::Knowledge::kUnknown && touching) unknown_ += length;
}

void CurveSum::AddSurfacePiece(const SurfacePlace& from, const HermitePiece& cubic) {
  double piece = 0.0;
  for (const QuadratureNode& node : PiecewiseGauss(std::array<double, 2>{0.0, 1.0})) {
    const double t = node.x;
    const Eigen::Vector2d at = cubic.At(t);
    const Eigen::Vector2d slope = cubic.Slope(t);
    const RadiusRow row = surface_->Row(from.theta + at.x(), from.z + at.y());
    double r = 0.0;
    double r_slope = 0.0;
    for (std::size_t k = 0; k < row.index.size(); ++k) {
      const double c = surface_->coefficients()[static_cast<Eigen::Index>(row.index[k])];
      r += row.value[k] * c;
      r_slope += (row.theta[k] * slope.x() + row.z[k] * slope.y()) * c;
    }
    const double speed = std::sqrt(r_slope * r_slope + r * r * slope.x() * slope.x() + slope.y() * slope.y());
    piece += node.weight * speed;
    if (speed > 0.0) {
      const double weight = node.weight / speed;
      gradient_.AddRow(row, weight * r * slope.x() * slope.x(), weight * r_slope * slope.x(),
                       weight * r_slope * slope.y());
    }
  }
  length_ += piece;
  AddSeen(from, 0.5 * piece, true);
  AddSeen({from.theta + cubic.step.x(), from.z + cubic.step.y()}, 0.5 * piece, true);
}

void CurveSum::AddStraightPiece(const PathPoint& from, const PathPoint& to) {
  const Eigen::Vector3d edge = to.position - from.position;
  const double piece = edge.norm();
  if (piece == 0.0) return;
  length_ += piece;
  gradient_.AddRadius(to.place.theta, to.place.z, edge.dot(to.by_radius) / piece);
  gradient_.AddRadius(from.place.theta, from.place.z, -edge.dot(from.by_radius) / piece);
  const auto parts = static_cast<std::size_t>(std::ceil(piece / kKnowledgeStep));
  for (std::size_t part = 0; part < parts; ++part) {
    const double t = (static_cast<double>(part) + 0.5) / static_cast<double>(parts);
    const Eigen::Vector3d under = from.position + t * edge;
    AddSeen({std::atan2(under.y(), under.x()), under.z()}, piece / static_cast<double>(parts), false);
  }
}

/// A string cut into edges on the surface and straight ones.
class StringPieces {
 public:
  StringPieces(const SplineSurface& surface, const TautString& string);

  [[nodiscard]] bool OnSurface(std::size_t edge) const { return on_surface_[edge] != 0; }
  [[nodiscard]] const Eigen::Vector2d& Step(std::size_t edge) const { return step_[edge]; }
  /// d(theta, z) over edge `edge` at its start (or end), from the parabola through it and the edge beside it.
  [[nodiscard]] Eigen::Vector2d SlopeAtStart(std::size_t edge) const {
    return SlopeFrom(edge, Before(edge), After(edge));
  }
  [[nodiscard]] Eigen::Vector2d SlopeAtEnd(std::size_t edge) const {
    return SlopeFrom(edge, After(edge), Before(edge));
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  /// The neighbour if the string goes smoothly over the vertex between, else kNone.
  [[nodiscard]] std::size_t Before(std::size_t edge) const;
  [[nodiscard]] std::size_t After(std::size_t edge) const;
  [[nodiscard]] Eigen::Vector2d SlopeFrom(std::size_t edge, std::size_t near, std::size_t far) const;

  const TautString* string_;
  std::vector<char> on_surface_;
  std::vector<Eigen::Vector2d> step_;
  std::vector<double> length_;
};

StringPieces::StringPieces(const SplineSurface& surface, const TautString& string) : string_(&string) {
  const std::vector<StringVertex>& vertices = string.vertices();
  for (std::size_t k = 0; k < string.edge_count(); ++k) {
    const StringVertex& a = vertices[k];
    const StringVertex& b = vertices[(k + 1) % vertices.size()];
    const double length = (b.position - a.position).norm();
    const bool flat = a.touches && b.touches && length > 0.0;
    const bool spans =
        string.rules().side == StringSide::kOutside && flat && DepthOf(surface, 0.5 * (a.position + b.position)) <= 0.0;
    on_surface_.push_back(flat && !spans ? 1 : 0);
    step_.emplace_back(AngleDifference(b.place.theta, a.place.theta), b.place.z - a.place.z);
    length_.push_back(length);
  }
}

std::size_t StringPieces::Before(std::size_t edge) const {
  if (string_->vertices()[edge].hold != VertexHold::kSliding) return kNone;
  const std::size_t before = (edge + string_->edge_count() - 1) % string_->edge_count();
  return OnSurface(before) ? before : kNone;
}

std::size_t StringPieces::After(std::size_t edge) const {
  const std::size_t vertex = (edge + 1) % string_->vertices().size();
  if (string_->vertices()[vertex].hold != VertexHold::kSliding) return kNone;
  const std::size_t after = (edge + 1) % string_->edge_count();
  return OnSurface(after) ? after : kNone;
}

Eigen::Vector2d StringPieces::SlopeFrom(std::size_t edge, std::size_t near, std::size_t far) const {
  const double own = length_[edge];
  const Eigen::Vector2d slope = step_[edge] / own;
  if (near != kNone) {  // between both edges
    return own * (own * step_[near] / length_[near] + length_[near] * slope) / (own + length_[near]);
  }
  if (far != kNone) {  // at the end of a run
    return own * (slope + own / (own + length_[far]) * (slope - step_[far] / length_[far]));
  }
  return step_[edge];
}

}  // namespace

double DepthOfEdge(const SplineSurface& surface, const TautString& string, std::size_t edge) {
  const std::vector<StringVertex>& vertices = string.vertices();
  const Eigen::Vector3d& a = vertices[edge].position;
  const Eigen::Vector3d& b = vertices[(edge + 1) % vertices.size()].position;
  constexpr double kStep = 1.0;  // mm
  const auto samples = static_cast<std::size_t>(std::clamp(std::ceil((b - a).norm() / kStep), 2.0, 64.0)) | 1U;
  double depth = 0.0;
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = (static_cast<double>(k) + 0.5) / static_cast<double>(samples);
    const double inside = DepthOf(surface, a + t * (b - a));
    depth = std::max(depth, string.rules().side == StringSide::kOnSurface ? std::abs(inside) : inside);
  }
  return depth;
}

bool RunsOnSurface(const SplineSurface& surface, const TautString& string, std::size_t edge) {
  const std::vector<StringVertex>& vertices = string.vertices();
  const StringVertex& a = vertices[edge];
  const StringVertex& b = vertices[(edge + 1) % vertices.size()];
  if (!a.touches || !b.touches || a.position == b.position) return false;
  return string.rules().side == StringSide::kOnSurface || DepthOf(surface, 0.5 * (a.position + b.position)) > 0.0;
}

SurfaceDistance MeasureString(const MeasuredSurface& body, const TautString& string) {
  const SplineSurface& surface = body.surface();
  const StringPieces pieces(surface, string);
  const std::vector<StringVertex>& vertices = string.vertices();
  const auto point = [&](const StringVertex& vertex) {
    return vertex.touches ? RadialPoint(surface, vertex.place)
                          : PathPoint{vertex.place, vertex.position, Eigen::Vector3d::Zero()};
  };
  CurveSum sum(body);
  std::vector<PathPoint> path;
  for (std::size_t k = 0; k < string.edge_count(); ++k) {
    const StringVertex& from = vertices[k];
    path.push_back(point(from));
    if (!pieces.OnSurface(k)) {
      sum.AddStraightPiece(path.back(), point(vertices[(k + 1) % vertices.size()]));
      continue;
    }
    const HermitePiece piece{pieces.Step(k), pieces.SlopeAtStart(k), pieces.SlopeAtEnd(k)};
    sum.AddSurfacePiece(from.place, piece);
    // So close that the polygon through the path's points stays within kPathDepth.
    const double parts = std::min(kMostParts, std::ceil(std::sqrt(DepthOfEdge(surface, string, k) / kPathDepth)));
    for (int part = 1; part < static_cast<int>(parts); ++part) {
      const Eigen::Vector2d at = piece.At(part / parts);
      const double z = std::clamp(from.place.z + at.y(), string.rules().z_min, string.rules().z_max);
      path.push_back(RadialPoint(surface, {WrapAngle(from.place.theta + at.x()), z}));
    }
  }
  if (string.rules().ends == PathEnds::kOpen) path.push_back(point(vertices.back()));
  return {sum.Length(), sum.Knowledge(), std::move(path)};
}

}  // namespace annulus
