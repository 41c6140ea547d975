#include "fitting/air_ranges.h"

#include <algorithm>
#include <numeric>

namespace annulus {
namespace {

constexpr double kShortestRange = 20.0;   // mm
constexpr double kTouchingKnees = 100.0;  // mm
constexpr std::size_t kFewestRows = 3;

/// Runs of rows with and without air at the axis; empty rows belong to the run below them.
std::vector<AirRange> Runs(const std::vector<LevelView>& views) {
  std::vector<AirRange> runs;
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

}  // namespace

bool Overlap(const RingImage& image, const ColumnArc& a, const ColumnArc& b) {
  return image.AngleFrom(a.from, b.from) <= image.AngleFrom(a.from, a.to) ||
         image.AngleFrom(b.from, a.from) <= image.AngleFrom(b.from, b.to);
}

OpenGaps::OpenGaps(const RingImage& image, const std::vector<LevelGap>& gaps) : first_of_row_(image.rows() + 1, 0) {
  for (const LevelGap& gap : gaps) {
    if (gap.open) open_.push_back(gap);
  }
  for (const LevelGap& gap : open_) ++first_of_row_[gap.row + 1];
  std::partial_sum(first_of_row_.begin(), first_of_row_.end(), first_of_row_.begin());
}

std::vector<ColumnArc> OpenGaps::Arcs(std::size_t row) const {
  std::vector<ColumnArc> arcs;
  const std::size_t n = Count(row);
  for (std::size_t k = 0; k < n; ++k) {
    arcs.push_back({open_[first_of_row_[row] + k].after, open_[first_of_row_[row] + (k + 1) % n].before});
  }
  return arcs;
}

std::vector<LevelView> ViewsOfRows(const RingImage& image, const OpenGaps& gaps) {
  constexpr std::size_t kFewestSeen = 4;
  std::vector<LevelView> views;
  views.reserve(image.rows());
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

std::vector<AirRange> FindAirRanges(const RingImage& image, const std::vector<LevelView>& views) {
  std::vector<AirRange> ranges;
  for (AirRange range : Runs(views)) {
    if (range.view == LevelView::kOneLoop) continue;
    const auto begin = views.begin() + static_cast<std::ptrdiff_t>(range.first);
    const auto end = views.begin() + static_cast<std::ptrdiff_t>(range.last) + 1;
    const auto several = static_cast<std::size_t>(std::count(begin, end, LevelView::kSeveralLoops));
    if (several < kFewestRows) range.view = LevelView::kAxisOutside;
    if (!ranges.empty()) {
      AirRange& below = ranges.back();
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
  std::erase_if(ranges, [&](const AirRange& range) {
    return range.last - range.first + 1 < kFewestRows || image.z(range.last) - image.z(range.first) < kShortestRange;
  });
  return ranges;
}

}  // namespace annulus
