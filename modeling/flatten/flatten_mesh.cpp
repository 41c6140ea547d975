#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "modeling/flatten/flat_pattern.h"
#include "modeling/flatten/gathered_curvature.h"
#include "modeling/flatten/sheet_cut.h"

namespace annulus {
namespace {

constexpr std::size_t kMouths = 12;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// The grain line of a mesh.
std::array<std::uint32_t, 2> LowestAndHighest(const TriangleMesh& mesh) {
  std::array<std::uint32_t, 2> ends{};
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t v : face) {
      if (mesh.vertices[v].z() < mesh.vertices[ends[0]].z()) ends[0] = v;
      if (mesh.vertices[v].z() > mesh.vertices[ends[1]].z()) ends[1] = v;
    }
  }
  if (ends[0] == ends[1]) ends = {mesh.faces.front()[0], mesh.faces.front()[1]};
  return ends;
}

/// For every vertex the next one on its shortest way along sides to `tip`, inside the rim (Dijkstra 1959).
std::vector<std::uint32_t> WaysTo(std::uint32_t tip, const FlatPiece& piece) {
  const CurvedSheet& sheet = piece.body.sheet;
  std::vector<bool> on_rim(sheet.places.size(), false);
  for (const std::uint32_t v : piece.rim) on_rim[v] = true;
  std::vector<std::vector<std::pair<std::uint32_t, double>>> around(sheet.places.size());
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = sheet.faces[f][k];
      const std::uint32_t b = sheet.faces[f][(k + 1) % 3];
      around[a].emplace_back(b, sheet.lengths[f][k]);
      around[b].emplace_back(a, sheet.lengths[f][k]);
    }
  }
  std::vector<double> length(sheet.places.size(), std::numeric_limits<double>::infinity());
  std::vector<std::uint32_t> next(sheet.places.size(), kNone);
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  length[tip] = 0.0;
  queue.push({0.0, tip});
  while (!queue.empty()) {
    const auto [way, v] = queue.top();
    queue.pop();
    if (way > length[v] || on_rim[v]) continue;
    for (const auto& [w, side] : around[v]) {
      if (way + side >= length[w]) continue;
      length[w] = way + side;
      next[w] = v;
      queue.push({length[w], w});
    }
  }
  return next;
}

/// Cuts a dart from a vertex of the rim along the ways to its tip.
BodyPiece WithDart(BodyPiece body, std::uint32_t mouth, std::uint32_t tip, const std::vector<std::uint32_t>& ways) {
  std::vector<std::uint32_t> chain{mouth};
  while (chain.back() != tip) chain.push_back(ways[chain.back()]);
  const auto first = static_cast<std::uint32_t>(body.sheet.places.size());
  body.sheet = CutAlong(std::move(body.sheet), chain, SheetCutEnd::kTip);
  PieceDart dart{PieceDart::kNoLine, 0.0, body.theta_z[tip], {}};
  for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
    body.theta_z.push_back(body.theta_z[chain[k]]);
    const auto copy = static_cast<std::uint32_t>(first + k);
    dart.legs[0].push_back({copy, k + 2 < chain.size() ? copy + 1 : tip});
    dart.legs[1].push_back({chain[k], chain[k + 1]});
  }
  body.darts.push_back(std::move(dart));
  return body;
}

/// Places of the rim at which a dart may begin, about evenly spread.
std::vector<std::uint32_t> Mouths(const FlatPiece& piece, const std::vector<std::uint32_t>& ways) {
  std::vector<bool> taken(piece.points.size(), false);
  for (const PieceDart& dart : piece.body.darts) {
    for (const SideChain& leg : dart.legs) {
      for (const auto& side : leg) taken[side[0]] = taken[side[1]] = true;
    }
  }
  std::vector<std::uint32_t> all;
  for (const std::uint32_t v : piece.rim) {
    if (!taken[v] && ways[v] != kNone) all.push_back(v);
  }
  if (all.size() <= kMouths) return all;
  std::vector<std::uint32_t> spread;
  for (std::size_t k = 0; k < kMouths; ++k) spread.push_back(all[k * all.size() / kMouths]);
  return spread;
}

/// The mesh with the dart that relieves most; nothing if none does.
std::optional<FlatPattern> Relieved(const FlatPattern& flat, const Pattern& pattern, const TaskContext& task) {
  const FlatPiece& piece = flat.pieces.front();
  const auto tip = MostCurved(piece, Curved::kDomes);
  if (!tip) return std::nullopt;
  const std::vector<std::uint32_t> ways = WaysTo(*tip, piece);
  std::optional<FlatPattern> best;
  for (const std::uint32_t mouth : Mouths(piece, ways)) {
    if (task.stop.stop_requested()) return std::nullopt;
    auto made = LayFlat(pattern, {WithDart(piece.body, mouth, *tip, ways)}, {});
    if (made && made->energy < (best ? best->energy : flat.energy)) best = std::move(*made);
  }
  return best;
}

}  // namespace

Result<FlatPattern> FlattenMesh(const TriangleMesh& mesh, const Pattern& pattern, const TaskContext& task) {
  Pattern plain = pattern;
  plain.lines.clear();
  plain.pieces.clear();
  BodyPiece body;
  body.id = "mesh";
  body.label = pattern.name;
  body.sheet = SheetOfMesh(mesh);
  for (const Eigen::Vector3d& p : mesh.vertices) body.theta_z.emplace_back(std::atan2(p.y(), p.x()), p.z());
  const auto topology = CheckSheet(body.sheet);
  if (!topology) return Fail(topology);
  body.grain = LowestAndHighest(mesh);
  auto flat = LayFlat(plain, {std::move(body)}, {});
  for (std::size_t n = 0; flat && n < pattern.darts.most; ++n) {
    task.Report("propose darts", static_cast<double>(n), static_cast<double>(pattern.darts.most));
    if (flat->pieces.front().strain_98 <= pattern.darts.strain) break;
    auto better = Relieved(*flat, plain, task);
    if (!better) break;
    flat = std::move(*better);
  }
  return flat;
}

}  // namespace annulus
