#include "fitting/section_topology.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <optional>

#include "base/frames.h"
#include "fitting/air_ranges.h"
#include "fitting/front_objects.h"
#include "fitting/level_gaps.h"
#include "fitting/overhangs.h"
#include "fitting/ring_image.h"

namespace annulus {
namespace {

constexpr double kShortestRange = 20.0;  // mm; what is seen over less height is passed over
constexpr double kArmLength = 150.0;     // mm; what stands in front for at least this is an arm
constexpr double kShortestPart = 60.0;   // mm; less is not worth a surface of its own

std::string Text(const char* format, double a, double b = 0.0) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

/// A piece between open gaps, followed over the rows.
struct Track {
  std::vector<std::size_t> cells;  ///< Ascending by row.
  ColumnArc last;                  ///< On the last row.
  double z_first = 0.0;            ///< mm
  double z_last = 0.0;             ///< mm
  double x = 0.0;                  ///< Sum over the cells, mm.
};

void AppendArc(const RingImage& image, std::size_t row, const ColumnArc& arc, const std::vector<char>& in_front,
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
std::vector<Track> FollowArcs(const RingImage& image, const OpenGaps& gaps, const AirRange& range,
                              const std::vector<char>& in_front) {
  std::vector<Track> tracks;
  for (std::size_t row = range.first; row <= range.last; ++row) {
    const bool several = gaps.Count(row) > 1;
    if (gaps.Count(row) == 0 || several != (range.view == LevelView::kSeveralLoops)) continue;
    std::vector<char> taken(tracks.size(), 0);
    for (const ColumnArc& arc : gaps.Arcs(row)) {
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
  void AddAir(const OpenGaps& gaps, const AirRange& range);
  void AddUnseen(const std::vector<LevelGap>& gaps);
  void AddOverhangs();
  SectionTopology Finish(std::vector<LevelView> views) &&;

 private:
  SectionRegion& Add(SectionRegion region) {
    topology_.regions.push_back(std::move(region));
    return topology_.regions.back();
  }
  [[nodiscard]] std::vector<std::size_t> SamplesOf(const std::vector<std::size_t>& cells) const {
    std::vector<std::size_t> samples;
    for (const std::size_t k : cells) samples.push_back(image_.grid().At(k / image_.columns(), k % image_.columns()));
    std::sort(samples.begin(), samples.end());
    return samples;
  }
  [[nodiscard]] std::vector<std::size_t> SeamAbove(const std::vector<std::size_t>& cells) const;
  [[nodiscard]] bool TrunkEndsAtTop(const FrontObject& object) const;
  [[nodiscard]] bool InAir(double z) const {
    return std::any_of(air_.begin(), air_.end(), [&](const AirRange& range) {
      return z >= image_.z(range.first) - kShortestRange && z <= image_.z(range.last) + kShortestRange;
    });
  }

  const RingImage& image_;
  SectionTopology topology_;
  std::vector<char> in_front_;  ///< Per cell.
  std::vector<AirRange> air_;
  double usable_ = 0.0;
};

/// Samples of the one loop on the row above the highest of `cells` that continue them. `cells` ascend by row.
std::vector<std::size_t> Assembly::SeamAbove(const std::vector<std::size_t>& cells) const {
  constexpr double kContinues = 25.0;  // mm; a larger step is an edge
  std::vector<std::size_t> seam;
  const std::size_t top = cells.empty() ? image_.rows() : cells.back() / image_.columns();
  if (top + 1 >= image_.rows() || image_.z(top + 1) - image_.z(top) > kShortestRange) return seam;
  for (auto cell = cells.rbegin(); cell != cells.rend() && *cell / image_.columns() == top; ++cell) {
    const std::size_t column = *cell % image_.columns();
    const std::size_t k = image_.grid().At(top + 1, column);
    if (k == SampleGrid::kNone || topology_.main[k] == 0) continue;
    if (std::abs(image_.Radius(top + 1, column) - image_.RawRadius(top, column)) < kContinues) seam.push_back(k);
  }
  std::sort(seam.begin(), seam.end());
  return seam;
}

/// Whether what is behind an object loses a fifth of its radius where the object begins: the crotch, seen by a ring
/// whose axis lies in the other leg.
bool Assembly::TrunkEndsAtTop(const FrontObject& object) const {
  constexpr double kLoss = 0.8;
  const std::size_t top = object.cells.back() / image_.columns();
  const std::size_t above = std::min(top + 2, image_.rows() - 1);
  double sum_top = 0.0;
  double sum_above = 0.0;
  for (std::size_t column = 0; column < image_.columns(); ++column) {
    if (in_front_[image_.Index(top, column)] != 0 || in_front_[image_.Index(above, column)] != 0) continue;
    if (!image_.IsSeen(top, column) || !image_.IsSeen(above, column)) continue;
    sum_top += image_.Radius(top, column);
    sum_above += image_.Radius(above, column);
  }
  return sum_top < kLoss * sum_above;
}

void Assembly::AddObject(const FrontObject& object) {
  for (const std::size_t k : object.cells) in_front_[k] = 1;
  const std::vector<std::size_t> samples = SamplesOf(object.cells);
  for (const std::size_t k : samples) topology_.main[k] = 0;
  const bool is_limb = object.z_max - object.z_min >= kArmLength;
  const std::string side = Side(object.x);
  const std::string limb = side + (TrunkEndsAtTop(object) ? " leg" : " arm");
  SectionRegion region;
  region.kind = RegionKind::kInFront;
  region.name = is_limb ? limb : "something before the body";
  region.z_min = object.z_min;
  region.z_max = object.z_max;
  region.theta_from = image_.theta(object.column_from);
  region.theta_to = image_.theta(object.column_to);
  region.samples = samples.size();
  region.why = Text("stands a step before the body on both its sides, at (%.0f, %.0f) mm", object.x, object.y);
  Add(region);
  SectionPart part{region.name, topology_.regions.size() - 1, {}, {}};
  std::vector<std::size_t> finger_cells;
  std::vector<std::size_t> arm_cells;
  for (const std::size_t k : object.cells) {
    const double z = image_.z(k / image_.columns());
    const bool finger = object.HasFingers() && z >= object.fingers_z_min && z <= object.fingers_z_max;
    (finger ? finger_cells : arm_cells).push_back(k);
  }
  part.samples = SamplesOf(arm_cells);
  part.seam = SeamAbove(arm_cells);
  topology_.regions.back().samples = part.samples.size();
  if (object.HasFingers()) {
    region.kind = RegionKind::kSeveralLoops;
    region.name = side + " hand";
    region.z_min = object.fingers_z_min;
    region.z_max = object.fingers_z_max;
    region.samples = finger_cells.size();
    region.why = Text("up to %.0f arcs beside each other: fingers", static_cast<double>(object.fingers));
    Add(region);
  }
  if (is_limb) topology_.parts.push_back(std::move(part));
}

void Assembly::AddAir(const OpenGaps& gaps, const AirRange& range) {
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
    topology_.parts.push_back({name, topology_.regions.size() - 1, SamplesOf(track.cells), SeamAbove(track.cells)});
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
  for (const AirRange& range : air_) {
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
  for (SectionRegion& region : topology_.regions) {
    region.share = usable_ > 0.0 ? static_cast<double>(region.samples) / usable_ : 0.0;
  }
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
  const std::vector<AirRange> air = FindAirRanges(image, views);
  // Levels whose openings are too short to count are one loop.
  for (LevelView& view : views) {
    if (view != LevelView::kEmpty) view = LevelView::kOneLoop;
  }
  Assembly assembly(samples, image);
  for (const FrontObject& object : FindFrontObjects(image)) assembly.AddObject(object);
  for (const AirRange& range : air) assembly.AddAir(open, range);
  assembly.AddUnseen(gaps);
  assembly.AddOverhangs();
  return std::move(assembly).Finish(std::move(views));
}

}  // namespace annulus
