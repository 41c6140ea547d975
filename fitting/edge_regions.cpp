#include "fitting/edge_regions.h"

#include <algorithm>

namespace annulus {
namespace {

constexpr std::size_t kLeastCells = 4;
constexpr std::size_t kMostRegions = 50;

/// A cell of a region; its column is counted on from the first cell's, so that it may be negative or beyond the last.
struct Place {
  std::ptrdiff_t column = 0;
  std::ptrdiff_t row = 0;
};

/// Takes the flagged cells that hang together with the first one off the flags.
std::vector<Place> Take(const CellGrid& cells, const Place& first, std::vector<char>& flags) {
  const auto columns = static_cast<std::ptrdiff_t>(cells.columns());
  const auto rows = static_cast<std::ptrdiff_t>(cells.rows());
  std::vector<Place> region;
  std::vector<Place> open;
  const auto visit = [&](const Place& place) {
    if (place.row < 0 || place.row >= rows) return;
    char& flag = flags[static_cast<std::size_t>(place.row * columns + (place.column % columns + columns) % columns)];
    if (flag == 0) return;
    flag = 0;
    region.push_back(place);
    open.push_back(place);
  };
  visit(first);
  while (!open.empty()) {
    const Place at = open.back();
    open.pop_back();
    for (std::ptrdiff_t dr = -1; dr <= 1; ++dr) {
      for (std::ptrdiff_t dc = -1; dc <= 1; ++dc) visit({at.column + dc, at.row + dr});
    }
  }
  return region;
}

}  // namespace

std::vector<EdgeRegion> FindEdgeRegions(const CellGrid& cells, const std::vector<char>& edges) {
  std::vector<EdgeRegion> regions;
  std::vector<char> flags = edges;
  for (std::size_t cell = 0; cell < flags.size(); ++cell) {
    if (flags[cell] == 0) continue;
    const Place first{static_cast<std::ptrdiff_t>(cell % cells.columns()),
                      static_cast<std::ptrdiff_t>(cell / cells.columns())};
    const std::vector<Place> region = Take(cells, first, flags);
    if (region.size() < kLeastCells) continue;
    const auto [left, right] = std::minmax_element(region.begin(), region.end(),
                                                   [](const Place& a, const Place& b) { return a.column < b.column; });
    const auto [low, high] =
        std::minmax_element(region.begin(), region.end(), [](const Place& a, const Place& b) { return a.row < b.row; });
    const double step = cells.theta_step();
    const double turn = left->column < 0 ? kTwoPi : 0.0;
    const double from = (static_cast<double>(left->column) - 0.5) * step + turn;
    const double to = std::min((static_cast<double>(right->column) + 0.5) * step + turn, from + kTwoPi);
    regions.push_back({from, to, cells.z(static_cast<std::size_t>(low->row)),
                       cells.z(static_cast<std::size_t>(high->row)), region.size()});
  }
  std::stable_sort(regions.begin(), regions.end(),
                   [](const EdgeRegion& a, const EdgeRegion& b) { return a.cells > b.cells; });
  if (regions.size() > kMostRegions) regions.resize(kMostRegions);
  return regions;
}

}  // namespace annulus
