#include "fitting/section_topology.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <optional>

#include "base/frames.h"
#include "fitting/front_objects.h"
#include "fitting/level_gaps.h"
#include "fitting/overhangs.h"
#include "fitting/ring_image.h"

namespace annulus {
namespace {

constexpr double kShortestRange = 20.0;   // mm; a shorter stretch of other levels is passed over
constexpr double kTouchingKnees = 100.0;  // mm; legs that touch for no longer than this are still legs
constexpr std::size_t kFewestRows = 3;
constexpr double kArmLength = 150.0;    // mm; what stands in front for at least this is an arm
constexpr double kShortestPart = 60.0;  // mm; less is not worth a surface of its own

std::string Text(const char* format, double a, double b = 0.0) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

/// A run of columns between open gaps.
struct Arc {
  std::size_t from = 0;
  std::size_t to = 0;
};

/// Consecutive rows that are seen alike.
struct RowRange {
  std::size_t first = 0;
  std::size_t last = 0;
  LevelView view = LevelView::kOneLoop;
};

/// The rows' open gaps: gaps[first_of_row[row]] … gaps[first_of_row[row + 1]].
class OpenGaps {
 public:
  OpenGaps(const RingImage& image, const std::vector<LevelGap>& gaps) : first_of_row_(image.rows() + 1, 0) {
    for (const LevelGap& gap : gaps) {
      if (gap.open) open_.push_back(gap);
    }
    for (const LevelGap& gap : open_) ++first_of_row_[gap.row + 1];
    std::partial_sum(first_of_row_.begin(), first_of_row_.end(), first_of_row_.begin());
  }
  [[nodiscard]] std::size_t Count(std::size_t row) const { return first_of_row_[row + 1] - first_of_row_[row]; }
  /// The runs between the gaps of a row.
  [[nodiscard]] std::vector<Arc> Arcs(std::size_t row) const {
    std::vector<Arc> arcs;
    const std::size_t n = Count(row);
    for (std::size_t k = 0; k < n; ++k) {
      arcs.push_back({open_[first_of_row_[row] + k].after, open_[first_of_row_[row] + (k + 1) % n].before});
    }
    return arcs;
  }

 private:
  std::vector<LevelGap> open_;
  std::vector<std::size_t> first_of_row_;
};

/// What each row is by its own gaps.
std::vector<LevelView> ViewsOfRows(const RingImage& image, const OpenGaps& gaps) {
  constexpr std::size_t kFewestSeen = 4;
  std::vector<LevelView> views;
  for (std::size_t row = 0; row < image.rows(); ++row) {
    std::size_t seen = 0;
    for (std::size_t column = 0; column < image.columns(); ++column) seen += image.IsSeen(row, column) ? 1 : 0;
    const std::size_t open = gaps.Count(row);
    views.push_back(seen < kFewestSeen ? LevelView::kEmpty
                    : open == 0        ? LevelView::kOneLoop
                    : open == 1        ? LevelView::kAxisOutside
                                       : LevelView::kSeveralLoops);
  }
  return views;
}

bool IsLong(const RingImage& image, const RowRange& range, double shortest) {
  return range.last - range.first + 1 >= kFewestRows && image.z(range.last) - image.z(range.first) >= shortest;
}

/// Runs of rows with and without air at the axis; empty rows belong to the run before them.
std::vector<RowRange> Runs(const std::vector<LevelView>& views) {
  std::vector<RowRange> runs;
  for (std::size_t row = 0; row < views.size(); ++row) {
    if (views[row] == LevelView::kEmpty) continue;
    const bool air = views[row] != LevelView::kOneLoop;
    if (runs.empty() || air != (runs.back().view != LevelView::kOneLoop)) {
      runs.push_back({row, row, air ? LevelView::kSeveralLoops : LevelView::kOneLoop});
    }
    runs.back().last = row;
  }
  return runs;
}

/// Ranges of rows with air at the axis: short interruptions are closed, then short ranges dropped.
std::vector<RowRange> AirRanges(const RingImage& image, const std::vector<LevelView>& views) {
  std::vector<RowRange> ranges;
  for (const RowRange& run : Runs(views)) {
    if (run.view == LevelView::kOneLoop) continue;
    const auto several =
        std::count(views.begin() + static_cast<std::ptrdiff_t>(run.first),
                   views.begin() + static_cast<std::ptrdiff_t>(run.last) + 1, LevelView::kSeveralLoops);
    RowRange range = run;
    if (several < static_cast<std::ptrdiff_t>(kFewestRows)) range.view = LevelView::kAxisOutside;
    if (!ranges.empty()) {
      RowRange& below = ranges.back();
      const double between = image.z(range.first) - image.z(below.last);
      const bool legs = below.view == LevelView::kSeveralLoops && range.view == LevelView::kSeveralLoops;
      if (between <= (legs ? kTouchingKnees : kShortestRange)) {
        below.last = range.last;
        if (range.view == LevelView::kSeveralLoops) below.view = range.view;
        continue;
      }
    }
    ranges.push_back(range);
  }
  std::erase_if(ranges, [&](const RowRange& range) { return !IsLong(image, range, kShortestRange); });
  return ranges;
}

/// A piece between open gaps, followed over the rows.
struct Track {
  std::vector<std::size_t> cells;  ///< Ascending by row.
  Arc last;                        ///< On the last row.
  double z_first = 0.0;            ///< mm
  double z_last = 0.0;             ///< mm
  double x = 0.0;                  ///< Sum over the cells, mm.
};

bool Overlap(const RingImage& image, const Arc& a, const Arc& b) {
  return image.AngleFrom(a.from, b.from) <= image.AngleFrom(a.from, a.to) ||
         image.AngleFrom(b.from, a.from) <= image.AngleFrom(b.from, b.to);
}

void AppendArc(const RingImage& image, std::size_t row, const Arc& arc, const std::vector<char>& in_front,
               Track& track) {
  for (std::size_t column = arc.from;; column = image.grid().Column(column, 1)) {
    const std::size_t cell = image.Index(row, column);
    if (!std::isnan(image.RawRadius(row, column)) && in_front[cell] == 0) {
      track.cells.push_back(cell);
      track.x += image.RawRadius(row, column) * std::cos(image.theta(column));
    }
    if (column == arc.to) break;
  }
  track.last = arc;
  track.z_last = image.z(row);
}

/// Follows the arcs of the rows upward. Only rows with as many arcs as `view` asks for take part.
std::vector<Track> FollowArcs(const RingImage& image, const OpenGaps& gaps, const RowRange& range,
                              const std::vector<char>& in_front) {
  std::vector<Track> tracks;
  for (std::size_t row = range.first; row <= range.last; ++row) {
    const bool several = gaps.Count(row) > 1;
    if (gaps.Count(row) == 0 || several != (range.view == LevelView::kSeveralLoops)) continue;
    std::vector<char> taken(tracks.size(), 0);
    for (const Arc& arc : gaps.Arcs(row)) {
      std::size_t k = 0;
      while (k < taken.size() && (taken[k] != 0 || !Overlap(image, tracks[k].last, arc))) ++k;
      if (k < taken.size()) {
        taken[k] = 1;
      } else {
        k = tracks.size();
        tracks.emplace_back();
        tracks[k].z_first = image.z(row);
      }
      AppendArc(image, row, arc, in_front, tracks[k]);
    }
  }
  std::erase_if(tracks, [](const Track& track) { return track.z_last - track.z_first < kShortestPart; });
  return tracks;
}

const char* Side(double x) { return x >= 0.0 ? "right" : "left"; }

/// Everything found so far, being put together.
class Assembly {
 public:
  Assembly(std::span<const SurfaceSample> samples, const RingImage& image) : image_(image) {
    topology_.main.assign(samples.size(), 1);
    in_front_.assign(image.cells(), 0);
    usable_ = static_cast<double>(std::count_if(samples.begin(), samples.end(), IsUsable));
  }

  void AddObject(const FrontObject& object);
  void AddAir(const OpenGaps& gaps, const RowRange& range);
  void AddUnseen(const std::vector<LevelGap>& gaps);
  void AddOverhangs();
  SectionTopology Finish(std::vector<LevelView> views) &&;

 private:
  SectionRegion& Add(SectionRegion region) {
    region.share = usable_ > 0.0 ? static_cast<double>(region.samples) / usable_ : 0.0;
    topology_.regions.push_back(std::move(region));
    return topology_.regions.back();
  }
  [[nodiscard]] std::vector<std::size_t> SamplesOf(const std::vector<std::size_t>& cells) const {
    std::vector<std::size_t> samples;
    for (const std::size_t k : cells) samples.push_back(image_.grid().At(k / image_.columns(), k % image_.columns()));
    std::sort(samples.begin(), samples.end());
    return samples;
  }
  [[nodiscard]] bool InAir(double z) const {
    return std::any_of(air_.begin(), air_.end(), [&](const RowRange& range) {
      return z >= image_.z(range.first) - kShortestRange && z <= image_.z(range.last) + kShortestRange;
    });
  }

  const RingImage& image_;
  SectionTopology topology_;
  std::vector<char> in_front_;  ///< Per cell.
  std::vector<RowRange> air_;
  double usable_ = 0.0;
};

void Assembly::AddObject(const FrontObject& object) {
  for (const std::size_t k : object.cells) in_front_[k] = 1;
  const std::vector<std::size_t> samples = SamplesOf(object.cells);
  for (const std::size_t k : samples) topology_.main[k] = 0;
  const bool is_arm = object.z_max - object.z_min >= kArmLength;
  const std::string side = Side(object.x);
  SectionRegion region;
  region.kind = RegionKind::kInFront;
  region.name = is_arm ? side + " arm" : "something before the body";
  region.z_min = object.z_min;
  region.z_max = object.z_max;
  region.theta_from = image_.theta(object.column_from);
  region.theta_to = image_.theta(object.column_to);
  region.samples = samples.size();
  region.why = Text("stands a step before the body on both its sides, at (%.0f, %.0f) mm", object.x, object.y);
  Add(region);
  SectionPart part{region.name, topology_.regions.size() - 1, {}};
  std::vector<std::size_t> finger_cells;
  std::vector<std::size_t> arm_cells;
  for (const std::size_t k : object.cells) {
    const double z = image_.z(k / image_.columns());
    const bool finger = object.HasFingers() && z >= object.fingers_z_min && z <= object.fingers_z_max;
    (finger ? finger_cells : arm_cells).push_back(k);
  }
  part.samples = SamplesOf(arm_cells);
  if (object.HasFingers()) {
    region.kind = RegionKind::kSeveralLoops;
    region.name = side + " hand";
    region.z_min = object.fingers_z_min;
    region.z_max = object.fingers_z_max;
    region.samples = finger_cells.size();
    region.why = Text("up to %.0f arcs beside each other: fingers", static_cast<double>(object.fingers));
    Add(region);
  }
  if (is_arm) topology_.parts.push_back(std::move(part));
}

void Assembly::AddAir(const OpenGaps& gaps, const RowRange& range) {
  air_.push_back(range);
  std::vector<Track> tracks = FollowArcs(image_, gaps, range, in_front_);
  SectionRegion region;
  region.kind = range.view == LevelView::kSeveralLoops ? RegionKind::kSeveralLoops : RegionKind::kAxisOutside;
  const bool legs = region.kind == RegionKind::kSeveralLoops && tracks.size() == 2;
  region.name = legs ? "legs" : region.kind == RegionKind::kSeveralLoops ? "several loops" : "beside the axis";
  region.z_min = image_.z(range.first);
  region.z_max = image_.z(range.last);
  region.theta_to = kTwoPi;
  for (std::size_t row = range.first; row <= range.last; ++row) {
    for (std::size_t column = 0; column < image_.columns(); ++column) {
      const std::size_t k = image_.grid().At(row, column);
      if (k == SampleGrid::kNone || in_front_[image_.Index(row, column)] != 0) continue;
      topology_.main[k] = 0;
      ++region.samples;
    }
  }
  region.why = region.kind == RegionKind::kSeveralLoops ? "rays pass between loops and meet nothing up to the axis"
                                                        : "rays reach the axis and meet nothing";
  Add(region);
  for (Track& track : tracks) {
    const std::string name = legs ? std::string(Side(track.x)) + " leg" : "part beside the axis";
    topology_.parts.push_back({name, topology_.regions.size() - 1, SamplesOf(track.cells)});
  }
}

void Assembly::AddUnseen(const std::vector<LevelGap>& gaps) {
  constexpr double kWidest = 40.0;  // mm; a narrower gap is bridged and called inferred
  struct Hole {
    LevelGap last;
    SectionRegion region;
    double widest = 0.0;
  };
  std::vector<Hole> holes;
  for (const LevelGap& gap : gaps) {
    if (gap.open || gap.chord < kWidest || InAir(image_.z(gap.row))) continue;
    const double z = image_.z(gap.row);
    auto hole = std::find_if(holes.begin(), holes.end(), [&](const Hole& h) {
      return z - h.region.z_max <= kShortestRange && Overlap(image_, h.last, gap);
    });
    if (hole == holes.end()) {
      Hole begun;
      begun.region.kind = RegionKind::kUnseen;
      begun.region.name = "unseen";
      begun.region.z_min = z;
      hole = holes.insert(holes.end(), begun);
    }
    hole->last = gap;
    hole->region.z_max = z;
    if (gap.chord > hole->widest) {
      hole->widest = gap.chord;
      hole->region.theta_from = image_.theta(gap.before);
      hole->region.theta_to = image_.theta(gap.after);
    }
  }
  for (Hole& hole : holes) {
    if (hole.region.z_max - hole.region.z_min < kShortestRange) continue;
    hole.region.why = Text("no returns over up to %.0f mm", hole.widest);
    Add(hole.region);
  }
}

void Assembly::AddOverhangs() {
  for (const Overhang& overhang : FindOverhangs(image_, in_front_)) {
    if (InAir(overhang.z_min) || InAir(overhang.z_max)) continue;
    SectionRegion region;
    region.kind = RegionKind::kOverhang;
    region.name = "overhang";
    region.z_min = overhang.z_min;
    region.z_max = overhang.z_max;
    region.theta_from = image_.theta(overhang.column_from);
    region.theta_to = image_.theta(overhang.column_to);
    region.samples = overhang.cells;
    region.why = Text("the radius falls by %.0f mm within %.1f mm of height: what is beneath is hidden", overhang.drop,
                      overhang.height);
    Add(region);
  }
}

SectionTopology Assembly::Finish(std::vector<LevelView> views) && {
  for (const RowRange& range : air_) {
    for (std::size_t row = range.first; row <= range.last; ++row) {
      if (views[row] != LevelView::kEmpty) views[row] = range.view;
    }
  }
  for (std::size_t row = 0; row < views.size(); ++row) {
    const auto begin = in_front_.begin() + static_cast<std::ptrdiff_t>(row * image_.columns());
    const bool front = std::find(begin, begin + static_cast<std::ptrdiff_t>(image_.columns()), 1) !=
                       begin + static_cast<std::ptrdiff_t>(image_.columns());
    if (views[row] == LevelView::kOneLoop && front) views[row] = LevelView::kBehind;
  }
  topology_.levels = std::move(views);
  // From the top down, and the parts' indices with them.
  std::vector<std::size_t> order(topology_.regions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return topology_.regions[a].z_max > topology_.regions[b].z_max;
  });
  std::vector<SectionRegion> sorted;
  std::vector<std::size_t> place(order.size());
  for (const std::size_t k : order) {
    place[k] = sorted.size();
    sorted.push_back(std::move(topology_.regions[k]));
  }
  topology_.regions = std::move(sorted);
  for (SectionPart& part : topology_.parts) part.region = place[part.region];
  std::stable_sort(topology_.parts.begin(), topology_.parts.end(),
                   [](const SectionPart& a, const SectionPart& b) { return a.region < b.region; });
  return std::move(topology_);
}

}  // namespace

std::string SectionRegion::BriefReport() const {
  std::string line = name + Text(", z %.0f to %.0f mm", z_min, z_max);
  const bool all_around = theta_from == 0.0 && theta_to == kTwoPi;
  if (!all_around)
    line += Text(", theta %.0f to %.0f deg", DegreesFromRadians(theta_from), DegreesFromRadians(theta_to));
  line += ": " + why;
  return outcome.empty() ? line : line + "; " + outcome;
}

bool SectionTopology::IsOneLoop() const { return std::find(main.begin(), main.end(), 0) == main.end(); }

SectionTopology FindSectionTopology(std::span<const SurfaceSample> samples, const SampleGrid& grid) {
  const RingImage image(samples, grid);
  const std::vector<LevelGap> gaps = FindLevelGaps(image);
  const OpenGaps open(image, gaps);
  std::vector<LevelView> views = ViewsOfRows(image, open);
  const std::vector<RowRange> air = AirRanges(image, views);
  // Levels whose openings are too short to count are one loop.
  for (LevelView& view : views) {
    if (view != LevelView::kEmpty) view = LevelView::kOneLoop;
  }
  Assembly assembly(samples, image);
  for (const FrontObject& object : FindFrontObjects(image)) assembly.AddObject(object);
  for (const RowRange& range : air) assembly.AddAir(open, range);
  assembly.AddUnseen(gaps);
  assembly.AddOverhangs();
  return std::move(assembly).Finish(std::move(views));
}

}  // namespace annulus
