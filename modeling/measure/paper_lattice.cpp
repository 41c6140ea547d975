#include "modeling/measure/paper_lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/ensure.h"
#include "base/frames.h"
#include "modeling/measure/number_text.h"

namespace annulus {
namespace {

/// A mesh and the edges by which the cut enters and leaves it with ⊕ on the left. Edge e runs from corner e to e + 1.
struct Crossed {
  LatticeCell cell;
  std::size_t in = 0;
  std::size_t out = 0;
};

/// The plane's cut over the lattice: signs of corners, crossings of edges, the way from mesh to mesh.
class LatticeTracer {
 public:
  LatticeTracer(const SplineSurface& surface, LatticeSize size, const CuttingPlane& plane)
      : lattice_(surface, size), curve_(surface, plane) {}

  [[nodiscard]] const PaperLattice& lattice() const { return lattice_; }

  /// The segment in the meshes around a place that comes nearest to it; nothing if none is cut.
  [[nodiscard]] std::optional<Crossed> Nearest(const SurfacePlace& place, const Eigen::Vector3d& point) const {
    const LatticeCell middle = lattice_.CellAt(place);
    std::optional<Crossed> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (long level = middle.level - 1; level <= middle.level + 1; ++level) {
      for (long angle = middle.angle - 1; angle <= middle.angle + 1; ++angle) {
        for (const Crossed& crossed : SegmentsOf({angle, level})) {
          const double distance = Distance(crossed, point);
          if (distance >= least) continue;
          least = distance;
          nearest = crossed;
        }
      }
    }
    return nearest;
  }

  /// The next mesh with ⊕ on the left; nothing beyond the first or last level.
  [[nodiscard]] std::optional<Crossed> Next(const Crossed& from) const {
    const LatticeCell cell = Neighbour(from.cell, from.out);
    if (!lattice_.Has(cell)) return std::nullopt;
    const auto plus = Signs(cell);
    const std::size_t in = (from.out + 2) % 4;
    // Around the ⊕ corner on the left first: where two ways cross a mesh, its ⊕ corners are told apart.
    for (std::size_t k = 1; k < 4; ++k) {
      const std::size_t out = (in + 4 - k) % 4;
      if (!plus[out] && plus[(out + 1) % 4]) return Crossed{cell, in, out};
    }
    return std::nullopt;
  }

  /// The mesh before it: Next backwards.
  [[nodiscard]] std::optional<Crossed> Previous(const Crossed& from) const {
    const LatticeCell cell = Neighbour(from.cell, from.in);
    if (!lattice_.Has(cell)) return std::nullopt;
    const auto plus = Signs(cell);
    const std::size_t out = (from.in + 2) % 4;
    for (std::size_t k = 1; k < 4; ++k) {
      const std::size_t in = (out + k) % 4;
      if (plus[in] && !plus[(in + 1) % 4]) return Crossed{cell, in, out};
    }
    return std::nullopt;
  }

  /// Where the plane crosses an edge: eqs. 3.2–3.4.
  [[nodiscard]] PathPoint Crossing(const LatticeCell& cell, std::size_t edge) const {
    const auto corners = CornersOf(cell);
    const LatticeCell& low = corners[edge];
    const LatticeCell& high = corners[(edge + 1) % 4];
    const Eigen::Vector3d p_low = lattice_.Point(low.angle, low.level);
    const Eigen::Vector3d p_high = lattice_.Point(high.angle, high.level);
    const double height = curve_.plane().Height(p_low);
    const double alpha = height / (height - curve_.plane().Height(p_high));
    const SurfacePlace a = lattice_.Place(low.angle, low.level);
    const SurfacePlace b = lattice_.Place(high.angle, high.level);
    PathPoint point = curve_.InPlane({a.theta + alpha * (b.theta - a.theta), a.z + alpha * (b.z - a.z)});
    point.position = p_low + alpha * (p_high - p_low);
    return point;
  }

  [[nodiscard]] double Distance(const Crossed& crossed, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d a = Crossing(crossed.cell, crossed.in).position;
    const Eigen::Vector3d ab = Crossing(crossed.cell, crossed.out).position - a;
    const double length_squared = ab.squaredNorm();
    const double t = length_squared > 0.0 ? std::clamp((point - a).dot(ab) / length_squared, 0.0, 1.0) : 0.0;
    return (point - a - t * ab).norm();
  }

  [[nodiscard]] bool Same(const Crossed& a, const Crossed& b) const {
    const long m = static_cast<long>(lattice_.size().angles);
    return a.cell.level == b.cell.level && a.in == b.in && (a.cell.angle - b.cell.angle) % m == 0;
  }

 private:
  static LatticeCell Neighbour(LatticeCell cell, std::size_t edge) {
    if (edge == 0) --cell.level;
    if (edge == 1) ++cell.angle;
    if (edge == 2) ++cell.level;
    if (edge == 3) --cell.angle;
    return cell;
  }

  [[nodiscard]] std::array<bool, 4> Signs(const LatticeCell& cell) const {
    const auto corners = CornersOf(cell);
    std::array<bool, 4> plus{};
    for (std::size_t k = 0; k < 4; ++k) {
      plus[k] = curve_.plane().Height(lattice_.Point(corners[k].angle, corners[k].level)) >= 0.0;
    }
    return plus;
  }

  [[nodiscard]] std::vector<Crossed> SegmentsOf(const LatticeCell& cell) const {
    std::vector<Crossed> segments;
    if (!lattice_.Has(cell)) return segments;
    const auto plus = Signs(cell);
    for (std::size_t in = 0; in < 4; ++in) {
      if (!plus[in] || plus[(in + 1) % 4]) continue;
      for (std::size_t k = 1; k < 4; ++k) {
        const std::size_t out = (in + 4 - k) % 4;
        if (plus[out] || !plus[(out + 1) % 4]) continue;
        segments.push_back({cell, in, out});
        break;
      }
    }
    return segments;
  }

  PaperLattice lattice_;
  CutCurve curve_;
};

/// All meshes of one connected cut, in walking order with ⊕ on the left. Step 0 is the start; a closed cut goes on
/// periodically, `turn` angles further each time.
struct Chain {
  std::vector<Crossed> steps;
  long first = 0;  // number of the first step: 0, or negative if the cut is open
  bool closed = false;
  long turn = 0;

  [[nodiscard]] Crossed At(long number) const {
    const long count = static_cast<long>(steps.size());
    const long around =
        closed ? static_cast<long>(std::floor(static_cast<double>(number) / static_cast<double>(count))) : 0;
    Crossed step = steps[static_cast<std::size_t>(closed ? number - around * count : number - first)];
    step.cell.angle += around * turn;
    return step;
  }
};

Chain Follow(const LatticeTracer& tracer, const Crossed& start) {
  Chain chain;
  chain.steps.push_back(start);
  const LatticeSize& size = tracer.lattice().size();
  const std::size_t most = 4 * size.angles * size.levels;
  while (chain.steps.size() < most) {
    const auto next = tracer.Next(chain.steps.back());
    if (!next) break;
    if (tracer.Same(*next, start)) {
      chain.closed = true;
      chain.turn = next->cell.angle - start.cell.angle;
      return chain;
    }
    chain.steps.push_back(*next);
  }
  std::vector<Crossed> before;
  Crossed at = start;
  while (before.size() < most) {
    const auto previous = tracer.Previous(at);
    if (!previous) break;
    before.push_back(*previous);
    at = *previous;
  }
  chain.first = -static_cast<long>(before.size());
  chain.steps.insert(chain.steps.begin(), before.rbegin(), before.rend());
  return chain;
}

/// The chain's step at a place; fails if the chain does not come near it.
Result<long> StepAt(const LatticeTracer& tracer, const Chain& chain, const Click& click, const Eigen::Vector3d& point) {
  const LatticeCell cell = tracer.lattice().CellAt(click.place);
  const auto corners = CornersOf(cell);
  std::array<Eigen::Vector3d, 4> p;
  for (std::size_t k = 0; k < 4; ++k) p[k] = tracer.lattice().Point(corners[k].angle, corners[k].level);
  double least = 1.5 * std::max((p[2] - p[0]).norm(), (p[3] - p[1]).norm());
  std::optional<long> best;
  for (std::size_t k = 0; k < chain.steps.size(); ++k) {
    const double distance = tracer.Distance(chain.steps[k], point);
    if (distance >= least) continue;
    least = distance;
    best = static_cast<long>(k) + chain.first;
  }
  if (best) return *best;
  return Fail("follow the cut over the meshes of the lattice", "it does not pass " + click.name,
              "choose points on one loop that stays within the scanned range");
}

/// The part of the chain between two steps as a path from the one to the other.
LatticePath PathAlong(const LatticeTracer& tracer, const Chain& chain, const ClickedPlane& clicked, long from,
                      long to) {
  LatticePath path{clicked, {}, {}, from < to ? CutDirection::kPlusLeft : CutDirection::kPlusRight};
  const long way = from < to ? 1 : -1;
  for (long k = from; k != to; k += way) {
    const Crossed step = chain.At(k);
    path.cells.push_back(step.cell);
    path.points.push_back(tracer.Crossing(step.cell, way > 0 ? step.out : step.in));
  }
  path.cells.push_back(chain.At(to).cell);
  return path;
}

/// Puts the clicked places at the ends of the crossings.
void AddEnds(const SplineSurface& surface, const SurfacePlace& from, const SurfacePlace& to, LatticePath& path) {
  const auto beside = [](const SurfacePlace& place, double theta) {
    return SurfacePlace{theta + AngleDifference(place.theta, theta), place.z};
  };
  path.points.insert(path.points.begin(), RadialPoint(surface, beside(from, path.points.front().place.theta)));
  path.points.push_back(RadialPoint(surface, beside(to, path.points.back().place.theta)));
}

tl::unexpected<Error> TooCoarse(const Click& a, const Click& b) {
  return Fail("follow the cut over the meshes of the lattice",
              a.name + " and " + b.name + " lie in one mesh or beside each other",
              "choose points further apart, or the spline's own surface");
}

double MeanDepth(const LatticePath& path, const Eigen::Vector3d& view) {
  double depth = 0.0;
  for (const PathPoint& point : path.points) depth += view.dot(point.position);
  return depth / static_cast<double>(path.points.size());
}

}  // namespace

PaperLattice::PaperLattice(const SplineSurface& surface, LatticeSize size) : surface_(&surface), size_(size) {
  ENSURE(size.angles >= 3 && size.levels >= 2, "a lattice has meshes");
}

LatticeSize PaperLattice::SizeOfScan(const MeasuredSurface& body) {
  const KnowledgeMap& map = body.segment().knowledge;
  return {std::max<std::size_t>(map.columns(), 8), std::max<std::size_t>(map.rows(), 1) + 1};
}

SurfacePlace PaperLattice::Place(long angle, long level) const {
  const double share = static_cast<double>(level) / static_cast<double>(size_.levels - 1);
  return {kTwoPi * static_cast<double>(angle) / static_cast<double>(size_.angles),
          surface_->z_min() + share * (surface_->z_max() - surface_->z_min())};
}

Eigen::Vector3d PaperLattice::Point(long angle, long level) const {
  const SurfacePlace place = Place(angle, level);
  return surface_->Point(place.theta, place.z);
}

LatticeCell PaperLattice::CellAt(const SurfacePlace& place) const {
  const double u = std::floor(place.theta / kTwoPi * static_cast<double>(size_.angles));
  const double share = (place.z - surface_->z_min()) / (surface_->z_max() - surface_->z_min());
  const double w = std::floor(share * static_cast<double>(size_.levels - 1));
  return {static_cast<long>(u), std::clamp(static_cast<long>(w), 0L, static_cast<long>(size_.levels) - 2)};
}

bool PaperLattice::Has(const LatticeCell& cell) const {
  return cell.level >= 0 && cell.level < static_cast<long>(size_.levels) - 1;
}

std::array<LatticeCell, 4> CornersOf(const LatticeCell& cell) {
  return {{cell, {cell.angle + 1, cell.level}, {cell.angle + 1, cell.level + 1}, {cell.angle, cell.level + 1}}};
}

Result<LatticePath> LatticeCut(const MeasuredSurface& body, LatticeSize size, const std::array<Click, 3>& from_via_to) {
  const auto& [from, via, to] = from_via_to;
  const auto clicked = ClickedPlane::Through(body, {from, to, via});
  if (!clicked) return Fail(clicked);
  const LatticeTracer tracer(body.surface(), size, clicked->plane());
  const auto start = tracer.Nearest(via.place, clicked->corner(2));
  if (!start) return Fail("follow the cut over the meshes of the lattice", "no mesh is cut at " + via.name, "move it");
  const Chain chain = Follow(tracer, *start);
  const auto at_from = StepAt(tracer, chain, from, clicked->corner(0));
  if (!at_from) return Fail(at_from);
  const auto at_to = StepAt(tracer, chain, to, clicked->corner(1));
  if (!at_to) return Fail(at_to);
  if (*at_from == *at_to) return TooCoarse(from, to);
  // Nearer than this, the meshes do not tell on which side of a point the third one lies.
  const auto beside_start = [&](long step) {
    const long around = chain.closed ? static_cast<long>(chain.steps.size()) - std::abs(step) : std::abs(step);
    return std::min(std::abs(step), around) <= 1;
  };
  if (beside_start(*at_from)) return TooCoarse(from, via);
  if (beside_start(*at_to)) return TooCoarse(via, to);
  // The start is step 0: of a closed cut, the further end is reached backwards.
  long first = *at_from;
  long last = *at_to;
  if (chain.closed) (first < last ? last : first) -= static_cast<long>(chain.steps.size());
  if (std::min(first, last) > 0 || std::max(first, last) < 0) {
    return Fail("follow the cut over the meshes of the lattice", via.name + " is not between the other two",
                "choose a point between them");
  }
  LatticePath path = PathAlong(tracer, chain, *clicked, first, last);
  AddEnds(body.surface(), from.place, to.place, path);
  return path;
}

Result<LatticePath> LatticeViewCut(const MeasuredSurface& body, LatticeSize size, const std::array<Click, 2>& from_to,
                                   const Eigen::Vector3d& view) {
  const auto& [from, to] = from_to;
  const auto clicked = ClickedPlane::InView(body, from_to, view);
  if (!clicked) return Fail(clicked);
  const LatticeTracer tracer(body.surface(), size, clicked->plane());
  const auto start = tracer.Nearest(from.place, clicked->corner(0));
  if (!start) return Fail("follow the cut over the meshes of the lattice", "no mesh is cut at " + from.name, "move it");
  const Chain chain = Follow(tracer, *start);
  const auto at_to = StepAt(tracer, chain, to, clicked->corner(1));
  if (!at_to) return Fail(at_to);
  if (*at_to == 0) return TooCoarse(from, to);
  LatticePath path = PathAlong(tracer, chain, *clicked, 0, *at_to);
  if (chain.closed) {
    LatticePath other = PathAlong(tracer, chain, *clicked, 0, *at_to - static_cast<long>(chain.steps.size()));
    const Eigen::Vector3d unit = view.stableNormalized();
    if (MeanDepth(other, unit) < MeanDepth(path, unit)) path = std::move(other);
  }
  AddEnds(body.surface(), from.place, to.place, path);
  return path;
}

Result<SurfaceDistance> LatticeDistance(const MeasuredSurface& body, const Result<LatticePath>& path) {
  if (!path) return Fail(path);
  SurfaceDistance distance;
  distance.path = path->points;
  for (PathPoint& point : distance.path) point.place.theta = WrapAngle(point.place.theta);
  distance.knowledge = KnowledgeAlong(body, distance.path, PathEnds::kOpen);
  RETURN_IF_ERROR(CheckKnown(distance.knowledge, "measure along a plane over the meshes of the lattice"));
  distance.length = ClickedLength(body.surface(), path->clicked, distance.path);
  return distance;
}

}  // namespace annulus
