#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "modeling/flatten/flat_pattern.h"
#include "modeling/flatten/gathered_curvature.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

/// The search for darts uses elements so much larger than the pattern's.
constexpr double kCoarser = 1.6;
constexpr double kMostBend = 60.0 / 360.0 * kTwoPi;  ///< Of a division at its place inside.
constexpr std::size_t kMouths = 12;

/// The one piece of a pattern by itself, with larger elements.
Pattern Alone(const Pattern& pattern, std::size_t piece) {
  Pattern alone = pattern;
  alone.pieces = {pattern.pieces[piece]};
  alone.element_mm *= kCoarser;
  return alone;
}

/// The piece, or the part of it, that is strained most.
const FlatPiece& Worst(const FlatPattern& flat) {
  return *std::max_element(flat.pieces.begin(), flat.pieces.end(),
                           [](const FlatPiece& a, const FlatPiece& b) { return a.strain_98 < b.strain_98; });
}

/// A place that other bodies have, too: its height as a part of the way between the lowest and the highest
/// level that the pattern names; in mm if it names fewer than two.
PatternPlace PlaceOf(const Pattern& pattern, const PatternBody& body, const Vector2d& at) {
  PatternPlace place;
  place.turn = at.x();
  place.up = at.y();
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
  place.z_share = (at.y() - low->first) / (high->first - low->first);
  return place;
}

/// Places of the outline at which a cut may begin, about evenly spread.
std::vector<PatternDivision::End> Mouths(const Pattern& pattern, const std::vector<SampledLine>& lines) {
  const PatternPiece& piece = pattern.pieces.front();
  std::vector<PatternDivision::End> taken;
  for (const PatternDart& dart : piece.darts) taken.push_back({dart.line, dart.share});
  for (const PatternDivision& division : piece.divisions) {
    taken.insert(taken.end(), division.ends.begin(), division.ends.end());
  }
  std::vector<PatternDivision::End> all;
  for (const LineUse& use : piece.outline) {
    const std::vector<double>& shares = lines[use.line].shares;
    for (std::size_t k = 1; k + 1 < shares.size(); ++k) {
      const bool free = std::none_of(taken.begin(), taken.end(), [&](const PatternDivision::End& end) {
        return end.line == use.line && std::abs(end.share - shares[k]) < 0.02;
      });
      if (free) all.push_back({use.line, shares[k]});
    }
  }
  if (all.size() <= kMouths) return all;
  std::vector<PatternDivision::End> spread;
  for (std::size_t k = 0; k < kMouths; ++k) spread.push_back(all[k * all.size() / kMouths]);
  return spread;
}

/// How much a division bends at `middle`, rad, between two places of the outline.
double BendAt(const Vector2d& middle, const std::array<Vector2d, 2>& ends, double radius) {
  std::array<Vector2d, 2> ways;
  for (std::size_t k = 0; k < 2; ++k) {
    ways[k] = ends[k] - middle;
    ways[k].x() = radius * std::remainder(ways[k].x(), kTwoPi);
  }
  const double cosine = -ways[0].dot(ways[1]) / (ways[0].norm() * ways[1].norm());
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// The place of a share of a line that is one of its steps.
Vector2d StepAt(const SampledLine& line, double share) {
  const auto at = std::lower_bound(line.shares.begin(), line.shares.end(), share - 2e-6);
  return line.places[static_cast<std::size_t>(at - line.shares.begin())];
}

/// One piece of a pattern and its flat shape, to which cuts are added. Borrows body and task.
struct Search {
  const PatternBody* body;
  const TaskContext* task;
  Pattern alone;
  FlatPattern flat;

  /// The piece with one more cut; nothing if that cannot be made or leaves no less energy than `least`.
  [[nodiscard]] std::optional<Search> Try(PatternPiece piece, double least) const {
    if (task->stop.stop_requested()) return std::nullopt;
    Pattern trial = alone;
    trial.pieces.front() = std::move(piece);
    auto made = FlattenPattern(trial, *body, {{}, task->stop});
    if (!made || made->energy >= least) return std::nullopt;
    return Search{body, task, std::move(trial), std::move(*made)};
  }

  /// With the dart that relieves most; nothing if none does.
  [[nodiscard]] std::optional<Search> WithDart() const {
    const FlatPiece& worst = Worst(flat);
    const auto tip = MostCurved(worst, Curved::kDomes);
    const auto lines = SampleLines(alone, *body);
    if (!tip || !lines) return std::nullopt;
    const PatternPlace place = PlaceOf(alone, *body, worst.body.theta_z[*tip]);
    std::optional<Search> best;
    for (const PatternDivision::End& mouth : Mouths(alone, *lines)) {
      PatternPiece piece = alone.pieces.front();
      piece.darts.push_back({mouth.line, mouth.share, place});
      auto made = Try(std::move(piece), best ? best->flat.energy : flat.energy);
      if (made) best.emplace(std::move(*made));
    }
    return best;
  }

  /// With the division that relieves most; nothing if none does.
  [[nodiscard]] std::optional<Search> WithDivision() const {
    const FlatPiece& worst = Worst(flat);
    const auto most_curved = MostCurved(worst, Curved::kDomesAndSaddles);
    const auto lines = SampleLines(alone, *body);
    if (!most_curved || !lines) return std::nullopt;
    const Vector2d middle = worst.body.theta_z[*most_curved];
    const std::vector<PatternDivision::End> mouths = Mouths(alone, *lines);
    const double radius = body->segment.surface.Radius(middle.x(), middle.y());
    const auto place = [&](const PatternDivision::End& end) { return StepAt((*lines)[end.line], end.share); };
    std::optional<Search> best;
    for (std::size_t a = 0; a < mouths.size(); ++a) {
      for (std::size_t b = a + 1; b < mouths.size(); ++b) {
        if (BendAt(middle, {place(mouths[a]), place(mouths[b])}, radius) > kMostBend) continue;
        PatternPiece piece = alone.pieces.front();
        piece.divisions.push_back({{mouths[a], mouths[b]}, {PlaceOf(alone, *body, middle)}});
        auto made = Try(std::move(piece), best ? best->flat.energy : flat.energy);
        if (made) best.emplace(std::move(*made));
      }
    }
    return best;
  }
};

/// A piece with the cuts that the rule asks for.
Result<PatternPiece> Relieved(const Pattern& pattern, std::size_t p, const PatternBody& body, const TaskContext& task) {
  Pattern alone = Alone(pattern, p);
  auto flat = FlattenPattern(alone, body, {{}, task.stop});
  if (!flat) return Fail(flat);
  Search search{&body, &task, std::move(alone), std::move(*flat)};
  std::size_t darts = 0;
  std::size_t divisions = 0;
  while (Worst(search.flat).strain_98 > pattern.darts.strain) {
    auto next = darts < pattern.darts.most ? search.WithDart() : std::nullopt;
    if (next) {
      ++darts;
    } else if (divisions < pattern.darts.seams) {
      next = search.WithDivision();
      ++divisions;
    }
    if (!next) break;
    search = std::move(*next);
  }
  return search.alone.pieces.front();
}

}  // namespace

Result<Pattern> WithProposedCuts(const Pattern& pattern, const PatternBody& body, const TaskContext& task) {
  Pattern proposed = pattern;
  for (std::size_t p = 0; p < pattern.pieces.size(); ++p) {
    task.Report("propose darts and seams", static_cast<double>(p), static_cast<double>(pattern.pieces.size()));
    auto piece = Relieved(pattern, p, body, task);
    if (!piece) return Fail(piece);
    proposed.pieces[p] = std::move(*piece);
  }
  return proposed;
}

}  // namespace annulus
