#include "acquisition/quality_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acquisition/quality_coverage.h"

namespace annulus {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kFront = kPi / 2.0;

/// A running minimum or maximum over a window of an odd number of rows and columns, on a copy. NaN are passed over.
template <class Better>
std::vector<float> Extreme(const std::vector<float>& from, std::size_t columns, std::size_t half_rows,
                           std::size_t half_columns, Better better) {
  const std::size_t rows = from.size() / columns;
  std::vector<float> across(from.size(), kNan);
  const auto take = [&](float& best, float value) {
    if (!std::isnan(value) && (std::isnan(best) || better(value, best))) best = value;
  };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t c = 0; c < columns; ++c) {
      for (std::size_t k = 0; k <= 2 * half_columns; ++k) {
        take(across[row * columns + c], from[row * columns + (c + columns + k - half_columns) % columns]);
      }
    }
  }
  std::vector<float> result(from.size(), kNan);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t low = row > half_rows ? row - half_rows : 0;
    for (std::size_t r = low; r <= std::min(rows - 1, row + half_rows); ++r) {
      for (std::size_t c = 0; c < columns; ++c) take(result[row * columns + c], across[r * columns + c]);
    }
  }
  return result;
}

/// Grows a region to hold a place.
struct Bounds {
  double theta_low = 1e9, theta_high = -1e9, z_low = 1e9, z_high = -1e9;
  std::size_t cells = 0;
  void Add(double theta, double z) {
    theta_low = std::min(theta_low, theta);
    theta_high = std::max(theta_high, theta);
    z_low = std::min(z_low, z);
    z_high = std::max(z_high, z);
    ++cells;
  }
  [[nodiscard]] QualityRegion Region() const {
    QualityRegion region;
    region.theta_from = WrapAngle(theta_low);
    region.theta_to = region.theta_from + (theta_high - theta_low);
    region.z_min = z_low;
    region.z_max = z_high;
    region.cells = cells;
    return region;
  }
};

/// Rows of an image between two heights.
template <class Visit>
void ForRows(const SweepImage& image, double low, double high, Visit visit) {
  for (std::size_t row = 0; row < image.rows(); ++row) {
    if (image.Z(row) >= low && image.Z(row) <= high) visit(row);
  }
}

}  // namespace

SweepImage::SweepImage(const QualityGrid& grid) : columns_(grid.columns()), step_(grid.step()) {
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    if (grid.levels()[k].sweep == grid.levels().front().sweep) levels_.push_back(k);
  }
  std::stable_sort(levels_.begin(), levels_.end(),
                   [&](std::size_t a, std::size_t b) { return grid.levels()[a].z < grid.levels()[b].z; });
  for (const std::size_t level : levels_) z_.push_back(grid.levels()[level].z);
  if (rows() > 1) pitch_ = (z_.back() - z_.front()) / static_cast<double>(rows() - 1);
  const std::size_t half = pitch_ <= kFinePitch ? 2 : 1;
  radius_.assign(rows() * columns_, kNan);
  std::vector<float> window;
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::size_t low = row > half ? row - half : 0;
    const std::size_t high = std::min(rows() - 1, row + half);
    for (std::size_t c = 0; c < columns_; ++c) {
      window.clear();
      for (std::size_t r = low; r <= high; ++r) {
        if (grid.Seen(levels_[r], c)) window.push_back(grid.Radius(levels_[r], c));
      }
      if (window.size() > half) radius_[row * columns_ + c] = static_cast<float>(MedianOf(window));
    }
  }
}

double SweepImage::Crown() const {
  bool above = false;  // the scan began in the air
  for (std::size_t row = rows(); row-- > 0;) {
    std::size_t seen = 0;
    for (std::size_t c = 0; c < columns_; ++c) seen += std::isnan(At(row, c)) ? 0 : 1;
    above = above || 10 * seen <= columns_;
    if (10 * seen >= 9 * columns_) return above ? Z(row) : std::numeric_limits<double>::quiet_NaN();
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::optional<ThinRims> FindThinRims(const SweepImage& image) {
  const double crown = image.Crown();
  if (image.rows() < 50 || image.pitch() > kFinePitch || std::isnan(crown)) return std::nullopt;
  constexpr double kHalfWindow = 6.0;  // mm: rims are thinner than twice that, lids and brows are wider
  constexpr double kProud = 4.0;       // mm
  constexpr double kFaceRadius = 95.0;
  std::vector<float> radii;
  for (std::size_t row = 0; row < image.rows(); ++row) {
    for (std::size_t c = 0; c < image.columns(); ++c) radii.push_back(image.At(row, c));
  }
  const auto half_rows = static_cast<std::size_t>(std::max(1.0, std::round(kHalfWindow / image.pitch())));
  const auto half_columns =
      static_cast<std::size_t>(std::max(1.0, std::round(kHalfWindow / (kFaceRadius * image.step()))));
  const auto less = [](float a, float b) { return a < b; };
  const auto more = [](float a, float b) { return a > b; };
  // What an opening takes away (Serra 1982): everything that the window does not fit under.
  const std::vector<float> floor = Extreme(Extreme(radii, image.columns(), half_rows, half_columns, less),
                                           image.columns(), half_rows, half_columns, more);
  std::array<Bounds, 2> sides;
  std::vector<float> proud;
  ForRows(image, crown - 175.0, crown - 60.0, [&](std::size_t row) {
    for (std::size_t c = 0; c < image.columns(); ++c) {
      const double theta = static_cast<double>(c) * image.step();
      const double beside = kFaceRadius * std::sin(theta - kFront);  // mm, the subject's left positive
      if (std::sin(theta) < 0.5 || std::abs(beside) < 10.0 || std::abs(beside) > 62.0) continue;
      const float height = radii[row * image.columns() + c] - floor[row * image.columns() + c];
      if (!(height > kProud)) continue;
      sides[beside > 0.0 ? 0 : 1].Add(theta, image.Z(row));
      proud.push_back(height);
    }
  });
  const auto wide = [&](const Bounds& side) {
    return side.z_high - side.z_low >= 18.0 && kFaceRadius * (side.theta_high - side.theta_low) >= 18.0;
  };
  ThinRims rims;
  rims.cells = std::min(sides[0].cells, sides[1].cells);
  if (rims.cells == 0 || !wide(sides[0]) || !wide(sides[1])) return std::nullopt;
  rims.proud_mm = MedianOf(proud);
  Bounds both = sides[1];
  both.theta_high = sides[0].theta_high;
  both.z_low = std::min(both.z_low, sides[0].z_low);
  both.z_high = std::max(both.z_high, sides[0].z_high);
  both.cells += sides[0].cells;
  rims.where = both.Region();
  return rims;
}

RoughScalp MeasureScalp(const QualityGrid& grid, const SweepImage& image, double noise_sigma_mm) {
  RoughScalp scalp;
  const double crown = image.Crown();
  if (image.rows() < 10 || std::isnan(crown)) return scalp;
  constexpr double kBlockHeight = 20.0;
  constexpr std::size_t kBlocks = 6;                         // around
  const double least = std::max(0.5, 0.5 * noise_sigma_mm);  // mm; below it chance plays a part
  constexpr double kDepth = 80.0;                            // mm below the crown that are scalp all round
  const std::size_t width = image.columns() / kBlocks;
  if (width < 5) return scalp;
  std::size_t blocks = 0;
  std::vector<double> rough;
  Bounds bounds;
  for (double top = crown - 10.0; top > crown - kDepth; top -= kBlockHeight) {
    for (std::size_t block = 0; block < kBlocks; ++block) {
      std::vector<double> differences;
      double variance = 0.0;
      ForRows(image, top - kBlockHeight, top, [&](std::size_t row) {
        for (std::size_t k = 0; k < width; ++k) {
          const std::size_t c = block * width + k;
          const std::size_t left = (c + image.columns() - 1) % image.columns();
          const std::size_t right = (c + 1) % image.columns();
          // The readings themselves: on steep ground the image's median takes no noise away.
          const std::size_t level = image.Level(row);
          const double difference = grid.Radius(level, left) - 2.0F * grid.Radius(level, c) + grid.Radius(level, right);
          if (std::isnan(difference)) continue;
          differences.push_back(std::abs(difference));
          variance += 255.0 / std::max(5.0, static_cast<double>(grid.Quality(level, c)));
        }
      });
      if (differences.size() < 10) continue;
      ++blocks;
      const double noise = noise_sigma_mm * noise_sigma_mm * variance / static_cast<double>(differences.size());
      const double second = MedianOf(differences) / 0.6744897501960817;
      const double roughness = std::sqrt(std::max(0.0, second * second / 6.0 - noise));
      if (roughness < least) continue;
      rough.push_back(roughness);
      const double theta = (static_cast<double>(block) + 0.5) * kTwoPi / kBlocks;
      bounds.Add(theta, top);
      bounds.Add(theta, top - kBlockHeight);
    }
  }
  if (blocks == 0 || rough.empty()) return scalp;
  scalp.share = static_cast<double>(rough.size()) / static_cast<double>(blocks);
  scalp.rough_mm = MedianOf(rough);
  scalp.where = bounds.Region();
  scalp.where.theta_from = 0.0;
  scalp.where.theta_to = kTwoPi;
  return scalp;
}

HeadEdge FindHeadEdge(const SweepImage& image) {
  HeadEdge edge;
  const double crown = image.Crown();
  if (image.rows() < 50 || image.pitch() > kFinePitch || std::isnan(crown)) return edge;
  constexpr double kStep = 2.5;        // mm outwards …
  constexpr double kWithin = 3.0;      // … within so much height
  constexpr double kSameHeight = 4.0;  // mm between neighbouring directions
  const auto lag = static_cast<std::size_t>(std::max(1.0, std::round(kWithin / image.pitch())));
  std::vector<double> height(image.columns(), std::numeric_limits<double>::quiet_NaN());
  std::vector<double> size(image.columns(), 0.0);
  ForRows(image, crown - 140.0, crown - 40.0, [&](std::size_t row) {
    if (row + lag >= image.rows()) return;
    for (std::size_t c = 0; c < image.columns(); ++c) {
      const double step = image.At(row + lag, c) - image.At(row, c);
      if (!(step > size[c])) continue;
      size[c] = step;
      height[c] = 0.5 * (image.Z(row) + image.Z(row + lag));
    }
  });
  std::size_t found = 0;
  std::vector<double> steps;
  Bounds bounds;
  for (std::size_t c = 0; c < image.columns(); ++c) {
    const std::size_t left = (c + image.columns() - 1) % image.columns();
    const std::size_t right = (c + 1) % image.columns();
    if (size[c] < kStep) continue;
    if (!(std::abs(height[c] - height[left]) < kSameHeight || std::abs(height[c] - height[right]) < kSameHeight))
      continue;
    ++found;
    steps.push_back(size[c]);
    bounds.Add(static_cast<double>(c) * image.step(), height[c]);
  }
  edge.share = static_cast<double>(found) / static_cast<double>(image.columns());
  if (found == 0) return edge;
  edge.step_mm = MedianOf(steps);
  edge.where = bounds.Region();
  edge.where.theta_from = 0.0;
  edge.where.theta_to = kTwoPi;
  return edge;
}

std::vector<WeakRegion> FindWeakReturns(const QualityGrid& grid, CoverageMap& map) {
  const std::size_t n = map.columns;
  if (map.rows < 5 || n < 24) return {};
  std::vector<double> radius(map.cells.size(), 0.0);
  std::vector<double> light(map.cells.size(), 0.0);
  std::vector<std::uint32_t> count(map.cells.size(), 0);
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    const double place = (grid.levels()[k].z - map.z_min) / map.row_mm;
    if (!(place >= 0.0) || place >= static_cast<double>(map.rows)) continue;
    for (std::size_t c = 0; c < n; ++c) {
      if (!grid.Seen(k, c)) continue;
      const std::size_t cell = static_cast<std::size_t>(place) * n + c;
      radius[cell] += static_cast<double>(grid.Radius(k, c));
      light[cell] += static_cast<double>(grid.Quality(k, c)) / 255.0;
      ++count[cell];
    }
  }
  for (std::size_t cell = 0; cell < count.size(); ++cell) {
    if (count[cell] == 0) continue;
    radius[cell] /= count[cell];
    light[cell] /= count[cell];
  }
  // What a surface of this slope returns less, it returns because of the slope.
  constexpr double kSteepest = 0.35;  // cosine
  std::vector<double> shares(map.cells.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<double> known;
  for (std::size_t row = 2; row + 2 < map.rows; ++row) {
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t cell = row * n + c;
      const std::size_t left = row * n + (c + 2) % n;
      const std::size_t right = row * n + (c + n - 2) % n;
      const std::size_t above = cell + 2 * n;
      const std::size_t below = cell - 2 * n;
      if (count[cell] == 0 || count[left] == 0 || count[right] == 0 || count[above] == 0 || count[below] == 0) continue;
      const double around = (radius[left] - radius[right]) / (4.0 * grid.step() * radius[cell]);
      const double up = (radius[above] - radius[below]) / (4.0 * map.row_mm);
      const double cosine = 1.0 / std::sqrt(1.0 + around * around + up * up);
      if (cosine < kSteepest) continue;
      shares[cell] = light[cell] / cosine;
      known.push_back(shares[cell]);
    }
  }
  if (known.size() < 100) return {};
  constexpr double kWeak = 0.35;
  const double usual = MedianOf(known);
  CoverageMap marked = map;
  for (std::size_t cell = 0; cell < shares.size(); ++cell) {
    const bool weak = shares[cell] < kWeak * usual;
    marked.cells[cell] = weak ? CoverageCell::kDoubtful : CoverageCell::kOutside;
    if (weak && map.cells[cell] == CoverageCell::kSeen) map.cells[cell] = CoverageCell::kDoubtful;
  }
  std::vector<WeakRegion> regions;
  constexpr std::size_t kFewestCells = 15;
  for (const QualityRegion& where : RegionsOf(marked, CoverageCell::kDoubtful, {})) {
    if (where.cells < kFewestCells) continue;
    std::vector<double> inside;
    for (std::size_t row = 0; row < map.rows; ++row) {
      const double z = map.z_min + (static_cast<double>(row) + 0.5) * map.row_mm;
      if (z < where.z_min || z > where.z_max) continue;
      for (std::size_t c = 0; c < n; ++c) {
        const double from = WrapAngle(static_cast<double>(c) * grid.step() - where.theta_from);
        const bool here = from <= where.theta_to - where.theta_from;
        if (here && marked.At(row, c) == CoverageCell::kDoubtful) inside.push_back(shares[row * n + c]);
      }
    }
    regions.push_back({where, MedianOf(inside) / usual});
  }
  return regions;
}

}  // namespace annulus
