#include "acquisition/quality_notices.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "acquisition/quality_coverage.h"
#include "acquisition/quality_surface.h"

namespace annulus {
namespace {

constexpr float kChanged = 30.0F;  // mm: more than people sway and breathe

/// Share of the directions that see something, and its mean radius.
struct Section {
  double share = 0.0, radius = 0.0;
};
Section SectionOf(const QualityGrid& grid, std::size_t level) {
  Section section;
  std::size_t seen = 0;
  for (const float radius : grid.Radii(level)) {
    if (!(radius > 0.0F)) continue;
    ++seen;
    section.radius += static_cast<double>(radius);
  }
  if (seen > 0) section.radius /= static_cast<double>(seen);
  section.share = static_cast<double>(seen) / static_cast<double>(std::max<std::size_t>(1, grid.columns()));
  return section;
}

constexpr double kAlmostNothing = 0.03;  // of the directions: stray light
constexpr std::size_t kFewestEmpty = 4;  // levels

std::string Format(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

QualityRegion AllRound(double z_min, double z_max) {
  QualityRegion region;
  region.theta_to = kTwoPi;
  region.z_min = z_min;
  region.z_max = z_max;
  return region;
}

/// Collects notices with what they need from each other.
class NoticeFinder {
 public:
  NoticeFinder(const QualityGrid& grid, const std::vector<ComparedLevel>& compared, ScanQuality& quality)
      : grid_(grid), compared_(compared), quality_(quality) {
    low_ = quality.map.z_min;
    high_ = low_ + static_cast<double>(quality.map.rows) * quality.map.row_mm;
  }

  std::vector<QualityNotice> Find() {
    if (quality_.coverage == 0.0) {
      Add({NoticeCode::kLeft, QualityVerdict::kRepeat, AllRound(low_, high_), 0.0, "levels", "nothing was seen at all",
           "see that somebody stands in the middle of the ring, then scan again"});
      return std::move(notices_);
    }
    FindPerson();
    FindHead();
    FindSurface();
    FindSensors();
    std::stable_sort(notices_.begin(), notices_.end(),
                     [](const QualityNotice& a, const QualityNotice& b) { return a.verdict > b.verdict; });
    return std::move(notices_);
  }

 private:
  void Add(QualityNotice notice) { notices_.push_back(std::move(notice)); }
  void FindPerson();
  void FindMotion();
  void FindHead();
  void FindSurface();
  void FindSensors();

  const QualityGrid& grid_;
  const std::vector<ComparedLevel>& compared_;
  ScanQuality& quality_;
  double low_ = 0.0, high_ = 0.0;
  std::vector<QualityNotice> notices_;
};

void NoticeFinder::FindPerson() {
  if (const auto left = FindLeft(grid_)) {
    const QualityGrid::Level& at = grid_.levels()[left->level];
    Add({NoticeCode::kLeft, QualityVerdict::kRepeat, AllRound(low_, high_), at.time_s, "s",
         "nobody is in the ring from " + Format("%.1f s", at.time_s) + " on (carriage at " +
             Format("%.2f m", at.z / 1000.0) + ")",
         "ask the person to stand still until the ring has stopped, then scan again"});
    return;  // what else differs between the sweeps follows from that
  }
  FindMotion();
}

void NoticeFinder::FindMotion() {
  const Flutter flutter = MeasureFlutter(grid_, compared_, quality_.noise_sigma_mm);
  const bool flutters = flutter.share >= kMuchFlutter;
  const char* const stand =
      "ask the person to stand on the marks, hold the grips and look at one point, then scan again";
  if (const auto moved = FindMoved(grid_, compared_)) {
    Add({NoticeCode::kMoved, QualityVerdict::kRepeat, AllRound(moved->z_min, moved->z_max), moved->shift_mm, "mm",
         "the person moved by about " + Format("%.0f mm", moved->shift_mm) + ", first seen " +
             Format("%.1f s", moved->time_s) + " after the start",
         stand});
    return;
  }
  constexpr double kMuch = 3.0;  // mm: below it girths, depths and lengths are within their class limits anyway
  if (!flutters && quality_.motion && quality_.motion->largest_mm >= kMuch) {
    Add({NoticeCode::kSwayed, QualityVerdict::kUsable, AllRound(low_, high_), quality_.motion->largest_mm, "mm",
         "the person swayed by up to " + Format("%.0f mm", quality_.motion->largest_mm) +
             " between the sweeps: lengths and depths get a wider interval",
         "for better lengths wait until the person stands quietly, some 20 s, and scan again"});
  }
  std::optional<QualityRegion> largest;
  for (const ChangedParts& parts : FindChangedParts(grid_, compared_)) {
    for (const QualityRegion& region : parts.regions) {
      if (!largest || region.cells > largest->cells) largest = region;
    }
  }
  if (largest) {
    Add({NoticeCode::kPartMoved, QualityVerdict::kRepeat, *largest, largest->z_max - largest->z_min, "mm",
         "something is there in one sweep and not in another, " + RegionText(*largest) + ": an arm?",
         "ask the person to keep the arms where they are, and nobody else to reach into the ring; then scan again"});
  }
  if (flutters) {
    Add({NoticeCode::kLooseClothing, QualityVerdict::kRepeat, AllRound(flutter.z_min, flutter.z_max), flutter.sigma_mm,
         "mm",
         "the surface changes by " + Format("%.1f mm", flutter.sigma_mm) + " (sd) between sweeps, " +
             RegionText(AllRound(flutter.z_min, flutter.z_max)) + ": loose clothing?",
         "take loose clothes off or put tight ones on, then scan again"});
  }
}

void NoticeFinder::FindHead() {
  const SweepImage image(grid_);
  constexpr std::size_t kFewestRimCells = 25;
  if (const auto rims = FindThinRims(image); rims && rims->cells >= kFewestRimCells) {
    Add({NoticeCode::kSpectacles, QualityVerdict::kRepeat, rims->where, rims->proud_mm, "mm",
         "something thin stands " + Format("%.0f mm", rims->proud_mm) + " before the face, " + RegionText(rims->where) +
             ": spectacles?",
         "take off the spectacles, then scan again"});
  }
  const RoughScalp scalp = MeasureScalp(grid_, image, quality_.noise_sigma_mm);
  constexpr double kMuchHair = 0.30;
  if (scalp.share >= kMuchHair) {
    Add({NoticeCode::kHair, QualityVerdict::kUsable, scalp.where, scalp.rough_mm, "mm",
         "the scalp is rough (" + Format("%.1f mm", scalp.rough_mm) + " sd): hair; the head measures over it",
         "tie the hair up, or put the thin cap on, and scan again if the head's measures matter"});
    return;
  }
  const HeadEdge edge = FindHeadEdge(image);
  constexpr double kRound = 0.60;
  if (edge.share >= kRound) {
    Add({NoticeCode::kCap, QualityVerdict::kUsable, edge.where, edge.step_mm, "mm",
         "an edge of " + Format("%.0f mm", edge.step_mm) + " runs around the head, " + RegionText(edge.where) +
             ": a cap or band? The head measures over it",
         "take it off, or put the thin cap on, and scan again if the head's measures matter"});
  }
}

void NoticeFinder::FindSurface() {
  for (const WeakRegion& weak : FindWeakReturns(grid_, quality_.map)) {
    Add({NoticeCode::kWeakReturns, QualityVerdict::kUsable, weak.where, weak.light, "share",
         "only " + Format("%.0f %%", 100.0 * weak.light) + " of the usual light comes back, " + RegionText(weak.where) +
             ": something dark or shiny",
         "cover the place with something light and dull, or take it off; it is measured less well"});
  }
  constexpr double kTooLittle = 0.85;
  constexpr std::size_t kMostGaps = 5;
  std::size_t told = 0;
  for (const QualityRegion& gap : quality_.gaps) {
    if (++told > kMostGaps) break;
    Add({NoticeCode::kGaps, quality_.coverage < kTooLittle ? QualityVerdict::kRepeat : QualityVerdict::kUsable, gap,
         static_cast<double>(gap.cells), "cells", "not seen: " + RegionText(gap),
         "measure elsewhere, or scan again with nothing in the way there"});
  }
}

void NoticeFinder::FindSensors() {
  std::string dead;
  std::string stuck;
  std::size_t dead_count = 0;
  std::size_t stuck_count = 0;
  for (std::size_t sensor = 0; sensor < quality_.sensors.size(); ++sensor) {
    const auto list = [&](std::string& names, std::size_t& count) {
      constexpr std::size_t kMostNames = 15;
      if (++count <= kMostNames) names += (names.empty() ? "" : ", ") + std::to_string(sensor);
      if (count == kMostNames + 1) names += " …";
    };
    if (quality_.sensors[sensor].dead) list(dead, dead_count);
    if (quality_.sensors[sensor].stuck) list(stuck, stuck_count);
  }
  const QualityRegion all = AllRound(low_, high_);
  if (dead_count > 0) {
    const bool refuse = quality_.sensors_verdict == SensorsVerdict::kRefuse;
    Add({NoticeCode::kSensorsDead, refuse ? QualityVerdict::kRepeat : QualityVerdict::kUsable, all,
         static_cast<double>(dead_count), "sensors",
         "no return from sensor " + dead + " though something lay before it",
         refuse ? "clean the windows of these sensors; if that does not help call the service before you scan again"
                : "clean the windows of these sensors after the scan"});
  }
  if (stuck_count > 0) {
    Add({NoticeCode::kSensorsStuck, stuck_count > 2 ? QualityVerdict::kRepeat : QualityVerdict::kUsable, all,
         static_cast<double>(stuck_count), "sensors",
         "sensor " + stuck + " said the same again and again; these readings are left out",
         "switch the ring off and on; if it happens again call the service"});
  }
  constexpr double kManySpikes = 0.006;
  constexpr double kTooManySpikes = 0.05;
  if (quality_.spike_rate > kManySpikes) {
    Add({NoticeCode::kSpikes, quality_.spike_rate > kTooManySpikes ? QualityVerdict::kRepeat : QualityVerdict::kUsable,
         all, quality_.spike_rate, "share",
         Format("%.1f %%", 100.0 * quality_.spike_rate) +
             " of the readings are far from their neighbours; they are left out",
         "keep sunlight, mirrors and bright jewellery out of the booth"});
  }
  constexpr double kMuchNoise = 1.2;  // mm
  constexpr double kTooMuchNoise = 2.5;
  if (quality_.noise_sigma_mm > kMuchNoise) {
    Add({NoticeCode::kNoise,
         quality_.noise_sigma_mm > kTooMuchNoise ? QualityVerdict::kRepeat : QualityVerdict::kUsable, all,
         quality_.noise_sigma_mm, "mm",
         "the readings scatter by " + Format("%.1f mm", quality_.noise_sigma_mm) + " (sd)",
         "clean the windows of the ring; if that does not help have it calibrated"});
  }
}

}  // namespace

std::optional<LeftAt> FindLeft(const QualityGrid& grid) {
  if (grid.levels().empty()) return std::nullopt;
  const std::uint16_t first_sweep = grid.levels().front().sweep;
  constexpr double kBody = 0.5;                    // of the directions
  constexpr double kSmallest = 35.0;               // mm, mean radius: a neck; a crown or a toe is smaller when it ends
  constexpr double kLeastHeight = 40.0;            // mm without anything
  constexpr double kNearby = 12.0;                 // mm
  std::vector<std::pair<double, double>> profile;  // of the first sweep: height, share
  std::size_t empty = 0;
  Section before;
  double z_before = 0.0;
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    const QualityGrid::Level& level = grid.levels()[k];
    const Section section = SectionOf(grid, k);
    if (k > 0 && level.sweep != grid.levels()[k - 1].sweep) empty = 0;
    if (level.sweep == first_sweep) {
      profile.emplace_back(level.z, section.share);
      if (section.share > kAlmostNothing) {
        before = section;
        z_before = level.z;
        empty = 0;
        continue;
      }
      ++empty;
      const bool was_body = before.share >= kBody && before.radius >= kSmallest;
      if (was_body && empty >= kFewestEmpty && std::abs(level.z - z_before) >= kLeastHeight)
        return LeftAt{k + 1 - empty};
      continue;
    }
    const auto nearest = std::min_element(profile.begin(), profile.end(), [&](const auto& a, const auto& b) {
      return std::abs(a.first - level.z) < std::abs(b.first - level.z);
    });
    const bool body =
        nearest != profile.end() && std::abs(nearest->first - level.z) < kNearby && nearest->second >= kBody;
    empty = body && section.share <= kAlmostNothing ? empty + 1 : 0;
    if (empty >= kFewestEmpty) return LeftAt{k + 1 - empty};
  }
  return std::nullopt;
}

std::vector<ChangedParts> FindChangedParts(const QualityGrid& grid, const std::vector<ComparedLevel>& compared) {
  std::map<std::uint16_t, std::vector<const ComparedLevel*>> sweeps;
  for (const ComparedLevel& level : compared) sweeps[grid.levels()[level.level].sweep].push_back(&level);
  std::vector<ChangedParts> changed;
  for (const auto& [sweep, levels] : sweeps) {
    if (levels.size() < 5) continue;
    const double first = grid.levels()[levels.front()->level].z;
    const double last = grid.levels()[levels.back()->level].z;
    ChangedParts parts;
    parts.sweep = sweep;
    parts.map.columns = grid.columns();
    parts.map.row_mm = std::abs(last - first) / static_cast<double>(levels.size() - 1);
    parts.map.z_min = std::min(first, last) - 0.5 * parts.map.row_mm;
    parts.map.rows = levels.size();
    if (!(parts.map.row_mm > 0.0)) continue;
    parts.map.cells.assign(parts.map.rows * parts.map.columns, CoverageCell::kOutside);
    for (const ComparedLevel* level : levels) {
      const double place = (grid.levels()[level->level].z - parts.map.z_min) / parts.map.row_mm;
      const std::size_t row = std::min(parts.map.rows - 1, static_cast<std::size_t>(std::max(0.0, place)));
      for (std::size_t c = 0; c < grid.columns(); ++c) {
        if (std::abs(level->residual[c]) > kChanged)
          parts.map.cells[row * grid.columns() + c] = CoverageCell::kDoubtful;
      }
    }
    constexpr LeastRegion kLeast{40.0, 5};
    parts.regions = RegionsOf(parts.map, CoverageCell::kDoubtful, kLeast);
    changed.push_back(std::move(parts));
  }
  return changed;
}

Flutter MeasureFlutter(const QualityGrid& grid, const std::vector<ComparedLevel>& compared, double noise_sigma_mm) {
  constexpr double kBlockHeight = 50.0;
  constexpr std::size_t kBlockColumns = 20;
  const double cloth = std::max(2.0, 1.5 * noise_sigma_mm);  // mm, sd of one sweep
  std::map<std::pair<long, std::size_t>, std::vector<double>> blocks;
  for (const ComparedLevel& level : compared) {
    if (level.shift.points == 0) continue;
    const auto row = static_cast<long>(std::floor(grid.levels()[level.level].z / kBlockHeight));
    for (std::size_t c = 0; c < grid.columns(); ++c) {
      const float residual = level.residual[c];
      if (std::abs(residual) < kChanged) blocks[{row, c / kBlockColumns}].push_back(std::abs(residual));
    }
  }
  Flutter flutter;
  std::size_t judged = 0;
  std::vector<double> sigmas;
  flutter.z_min = 1e9;
  flutter.z_max = -1e9;
  for (auto& [place, residuals] : blocks) {
    if (residuals.size() < 30) continue;
    ++judged;
    const double both = 1.4826 * MedianOf(residuals);
    const double sigma = std::sqrt(std::max(0.0, 0.5 * both * both - noise_sigma_mm * noise_sigma_mm));
    if (sigma < cloth) continue;
    sigmas.push_back(sigma);
    flutter.z_min = std::min(flutter.z_min, static_cast<double>(place.first) * kBlockHeight);
    flutter.z_max = std::max(flutter.z_max, static_cast<double>(place.first + 1) * kBlockHeight);
  }
  if (sigmas.empty()) return {};
  flutter.share = static_cast<double>(sigmas.size()) / static_cast<double>(judged);
  flutter.sigma_mm = MedianOf(sigmas);
  return flutter;
}

std::optional<MovedSpan> FindMoved(const QualityGrid& grid, const std::vector<ComparedLevel>& compared) {
  constexpr double kFurther = 20.0;  // mm at hip height; a lean grows with the height
  constexpr double kHip = 900.0;
  constexpr std::size_t kInARow = 5;
  MovedSpan span{0, 0.0, 1e9, -1e9, 0.0};
  std::vector<double> shifts;
  std::size_t row = 0;
  for (const ComparedLevel& level : compared) {
    if (level.shift.points == 0) continue;
    const QualityGrid::Level& at = grid.levels()[level.level];
    const bool far = ShiftOf(level) > kFurther * std::max(1.0, at.z / kHip);
    row = far ? row + 1 : 0;
    if (!far) continue;
    if (row == kInARow && span.levels == 0) {
      span.levels = 1;  // believed from here on
      span.time_s = at.time_s;
    }
    shifts.push_back(ShiftOf(level));
    span.z_min = std::min(span.z_min, at.z);
    span.z_max = std::max(span.z_max, at.z);
  }
  if (span.levels == 0) return std::nullopt;
  span.levels = shifts.size();
  span.shift_mm = MedianOf(shifts);
  return span;
}

std::vector<QualityNotice> FindNotices(const QualityGrid& grid, const std::vector<ComparedLevel>& compared,
                                       ScanQuality& quality) {
  return NoticeFinder(grid, compared, quality).Find();
}

}  // namespace annulus
