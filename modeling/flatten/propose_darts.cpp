#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "modeling/flatten/flat_pattern.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

/// The search for darts uses elements so much larger than the pattern's.
constexpr double kCoarser = 1.6;
/// Of the square root of a piece's area: how far curvature counts for a tip, and how near to the rim or another tip a
/// tip may be.
constexpr double kGather = 0.1;
constexpr double kKeepAway = 0.08;
constexpr std::size_t kMouths = 12;

/// The one piece of a pattern by itself, with larger elements.
Pattern Alone(const Pattern& pattern, std::size_t piece) {
  Pattern alone = pattern;
  alone.pieces = {pattern.pieces[piece]};
  alone.element_mm *= kCoarser;
  return alone;
}

/// Where the most curvature is gathered, (theta, z); nothing if only saddles and places near rim and tips are left.
std::optional<Vector2d> Tip(const FlatPiece& piece) {
  SheetTopology topology;
  topology.rims = {piece.rim};
  const std::vector<double> defects = AngleDefects(piece.body.sheet, topology);
  const auto& places = piece.body.sheet.places;
  const double scale = std::sqrt(piece.body_area_mm2);
  std::vector<Eigen::Vector3d> avoid;
  for (const std::uint32_t v : piece.rim) avoid.push_back(places[v]);
  for (const PieceDart& dart : piece.body.darts) avoid.push_back(places[dart.legs[1].back()[1]]);
  double best = 0.0;
  std::optional<Vector2d> tip;
  for (std::size_t v = 0; v < places.size(); ++v) {
    const bool near = std::any_of(avoid.begin(), avoid.end(),
                                  [&](const Eigen::Vector3d& p) { return (p - places[v]).norm() < kKeepAway * scale; });
    if (near) continue;
    double gathered = 0.0;
    for (std::size_t w = 0; w < places.size(); ++w) {
      const double near_share = 1.0 - (places[w] - places[v]).norm() / (kGather * scale);
      if (near_share > 0.0) gathered += near_share * defects[w];
    }
    if (gathered <= best) continue;
    best = gathered;
    tip = piece.body.theta_z[v];
  }
  return tip;
}

/// The tip as a place that other bodies have, too: its height as a part of the way between the lowest and the highest
/// level that the pattern names; in mm if it names fewer than two.
PatternPlace PlaceOfTip(const Pattern& pattern, const PatternBody& body, const Vector2d& tip) {
  PatternPlace place;
  place.turn = tip.x();
  place.up = tip.y();
  std::vector<std::pair<double, std::string>> levels;
  for (const PatternLine& line : pattern.lines) {
    for (const PatternPlace& one : line.places) {
      for (const std::string& id : {one.z_of, one.z_towards}) {
        const auto found = body.landmarks.find(id);
        if (found != body.landmarks.end()) levels.emplace_back(found->second.y(), id);
      }
    }
  }
  if (levels.empty()) return place;
  const auto [low, high] = std::minmax_element(levels.begin(), levels.end());
  if (high->first - low->first < 1.0) return place;
  place.up = 0.0;
  place.z_of = low->second;
  place.z_towards = high->second;
  place.z_share = (tip.y() - low->first) / (high->first - low->first);
  return place;
}

/// Places of the outline at which a dart may begin, about evenly spread.
std::vector<PatternDart> Mouths(const Pattern& pattern, const std::vector<SampledLine>& lines,
                                const PatternPlace& tip) {
  std::vector<PatternDart> all;
  for (const LineUse& use : pattern.pieces.front().outline) {
    const std::vector<double>& shares = lines[use.line].shares;
    for (std::size_t k = 1; k + 1 < shares.size(); ++k) {
      const auto& darts = pattern.pieces.front().darts;
      const bool taken = std::any_of(darts.begin(), darts.end(), [&](const PatternDart& dart) {
        return dart.line == use.line && std::abs(dart.share - shares[k]) < 0.02;
      });
      if (taken) continue;
      all.push_back({use.line, shares[k], tip});
    }
  }
  if (all.size() <= kMouths) return all;
  std::vector<PatternDart> spread;
  for (std::size_t k = 0; k < kMouths; ++k) spread.push_back(all[k * all.size() / kMouths]);
  return spread;
}

/// The dart that relieves most; nothing if none can be cut.
std::optional<PatternDart> Best(const Pattern& alone, const PatternBody& body, const FlatPiece& flat,
                                const TaskContext& task) {
  const auto tip = Tip(flat);
  const auto lines = SampleLines(alone, body);
  if (!tip || !lines) return {};
  double least = flat.energy;
  std::optional<PatternDart> best;
  for (const PatternDart& dart : Mouths(alone, *lines, PlaceOfTip(alone, body, *tip))) {
    if (task.stop.stop_requested()) return {};
    Pattern trial = alone;
    trial.pieces.front().darts.push_back(dart);
    const auto made = FlattenPattern(trial, body, {{}, task.stop});  // what cannot be cut or overlaps is no candidate
    if (!made || made->pieces.front().energy >= least) continue;
    least = made->pieces.front().energy;
    best = dart;
  }
  return best;
}

}  // namespace

Result<Pattern> WithProposedDarts(const Pattern& pattern, const PatternBody& body, const TaskContext& task) {
  Pattern proposed = pattern;
  for (std::size_t p = 0; p < pattern.pieces.size(); ++p) {
    for (std::size_t count = 0; count < pattern.darts.most; ++count) {
      task.Report("propose darts", static_cast<double>(p * pattern.darts.most + count),
                  static_cast<double>(pattern.pieces.size() * pattern.darts.most));
      Pattern alone = Alone(proposed, p);
      const auto flat = FlattenPattern(alone, body, {{}, task.stop});
      if (!flat) return Fail(flat);
      if (flat->pieces.front().strain_98 <= pattern.darts.strain) break;
      const auto dart = Best(alone, body, flat->pieces.front(), task);
      if (!dart) break;
      proposed.pieces[p].darts.push_back(*dart);
    }
  }
  return proposed;
}

}  // namespace annulus
