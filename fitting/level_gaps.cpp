#include "fitting/level_gaps.h"

#include <algorithm>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr std::size_t kFewestLost = 3;   // fewer are lost returns
constexpr double kNarrowest = 0.06;      // rad
constexpr double kSilhouetteFall = 0.7;  // 35 degrees; a trunk of 2 : 1 falls by at most 0.75 and on one side only
constexpr double kFaintFall = 0.25;      // enough beside a gap that is open
constexpr double kTooWideToMiss = 70.0 * kPi / 180.0;  // no hair or dead board is wider beside an open gap
constexpr double kShortestOpening = 20.0;              // mm
constexpr std::size_t kFewestRows = 3;
constexpr double kEdge = 0.3;  // rad; the slope of an end is taken over at most this

/// Slope with which the radius falls over the last seen columns towards a gap: `at` is the position of the gap's end in
/// `seen`, `inward` the step away from the gap. Over two columns, or over one where the next gap is near.
double FallTowards(const RingImage& image, std::size_t row, const std::vector<std::size_t>& seen, std::size_t at,
                   std::ptrdiff_t inward) {
  const auto n = static_cast<std::ptrdiff_t>(seen.size());
  const std::size_t end = seen[at];
  for (const std::ptrdiff_t steps : {2, 1}) {
    const std::size_t inner =
        seen[static_cast<std::size_t>((static_cast<std::ptrdiff_t>(at) + steps * inward + 2 * n) % n)];
    const double angle = inward < 0 ? image.AngleFrom(inner, end) : image.AngleFrom(end, inner);
    if (!(angle > 0.0) || angle > kEdge) continue;
    const double r = image.Radius(row, end);
    return (image.Radius(row, inner) - r) / (std::max(1.0, r) * angle);
  }
  return 0.0;
}

void AppendGaps(const RingImage& image, std::size_t row, std::vector<LevelGap>& gaps) {
  const std::vector<std::size_t> seen = image.SeenColumns(row);
  const std::size_t n = seen.size();
  if (n < 4) return;
  // By angle, not by columns: a sensor that never saw anything has no column.
  const double spacing = kTwoPi / static_cast<double>(image.grid().RingSize());
  const double narrowest = std::max(kNarrowest, (static_cast<double>(kFewestLost) + 0.5) * spacing);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t next = (k + 1) % n;
    LevelGap gap;
    gap.row = row;
    gap.before = seen[k];
    gap.after = seen[next];
    gap.width = image.AngleFrom(gap.before, gap.after);
    if (gap.width < narrowest) continue;
    const double a = image.Radius(row, gap.before);
    const double b = image.Radius(row, gap.after);
    gap.chord = std::sqrt(std::max(0.0, a * a + b * b - 2.0 * a * b * std::cos(gap.width)));
    gap.fall = std::min(FallTowards(image, row, seen, k, -1), FallTowards(image, row, seen, next, 1));
    gap.open = gap.fall >= kSilhouetteFall;
    gaps.push_back(gap);
  }
}

/// Opens gaps that continue an open gap of the row before, in the order of `gaps` given. Empty rows are passed over.
template <class Iterator>
void Spread(const RingImage& image, Iterator begin, Iterator end) {
  auto row_begin = begin;
  auto above_begin = begin;
  auto above_end = begin;
  while (row_begin != end) {
    auto row_end = row_begin;
    while (row_end != end && row_end->row == row_begin->row) ++row_end;
    for (auto gap = row_begin; gap != row_end; ++gap) {
      if (gap->open || (gap->fall < kFaintFall && gap->width < kTooWideToMiss)) continue;
      gap->open = std::any_of(above_begin, above_end, [&](const LevelGap& other) {
        const std::size_t rows = std::max(gap->row, other.row) - std::min(gap->row, other.row);
        return other.open && rows <= kFewestRows && Overlap(image, *gap, other);
      });
    }
    above_begin = row_begin;
    above_end = row_end;
    row_begin = row_end;
  }
}

/// Closes open gaps that do not hang together over enough rows.
void CloseShort(const RingImage& image, std::vector<LevelGap>& gaps) {
  // The tracks of open gaps, by the index of the last gap of each.
  std::vector<std::size_t> track(gaps.size(), gaps.size());
  std::vector<std::vector<std::size_t>> tracks;
  for (std::size_t k = 0; k < gaps.size(); ++k) {
    if (!gaps[k].open) continue;
    for (std::size_t j = k; j-- > 0 && gaps[j].row + kFewestRows >= gaps[k].row;) {
      if (track[j] == gaps.size() || gaps[j].row == gaps[k].row || !Overlap(image, gaps[j], gaps[k])) continue;
      track[k] = track[j];
      break;
    }
    if (track[k] == gaps.size()) {
      track[k] = tracks.size();
      tracks.emplace_back();
    }
    tracks[track[k]].push_back(k);
  }
  for (const std::vector<std::size_t>& members : tracks) {
    const LevelGap& low = gaps[members.front()];
    const LevelGap& high = gaps[members.back()];
    if (high.row - low.row + 1 >= kFewestRows && image.z(high.row) - image.z(low.row) >= kShortestOpening) continue;
    for (const std::size_t k : members) gaps[k].open = false;
  }
}

}  // namespace

bool Overlap(const RingImage& image, const LevelGap& a, const LevelGap& b) {
  return image.AngleFrom(a.before, b.before) < a.width || image.AngleFrom(b.before, a.before) < b.width;
}

std::vector<LevelGap> FindLevelGaps(const RingImage& image) {
  std::vector<LevelGap> gaps;
  for (std::size_t row = 0; row < image.rows(); ++row) AppendGaps(image, row, gaps);
  Spread(image, gaps.begin(), gaps.end());
  Spread(image, gaps.rbegin(), gaps.rend());
  CloseShort(image, gaps);
  return gaps;
}

}  // namespace annulus
