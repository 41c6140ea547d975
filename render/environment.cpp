#include "render/environment.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/ensure.h"
#include "base/units.h"
#include "render/light_presets.h"

namespace annulus {
namespace {

constexpr auto kPiF = static_cast<float>(kPi);

/// A point of the unit square on which all directions are spread with equal areas for equal solid angles.
struct SquarePoint {
  float x = 0.0F;
  float y = 0.0F;
};

/// Of the angle whose tangent is t, 0 … 1, in quarter turns.
float QuarterTurns(float t) { return std::atan(t) * (2.0F / kPiF); }

/// Octahedron unfolded to a square, area-preserving (Clarberg 2008): the middle looks up, the corners down.
SquarePoint SquareOf(const Eigen::Vector3f& d) {
  const float x = std::abs(d.x());
  const float z = std::abs(d.z());
  const float up = std::abs(d.y());
  // sqrt(1 - up), without cancellation near the poles.
  const float radius = std::sqrt((x * x + z * z) / (1.0F + up));
  const float large = std::max(x, z);
  const float turn = large > 0.0F ? QuarterTurns(std::min(x, z) / large) : 0.0F;
  const float quarter = x < z ? 1.0F - turn : turn;  // azimuth from x, in quarter turns
  float b = quarter * radius;
  float a = radius - b;
  if (d.y() < 0.0F) {
    const float folded = 1.0F - b;
    b = 1.0F - a;
    a = folded;
  }
  return {0.5F + 0.5F * std::copysign(a, d.x()), 0.5F + 0.5F * std::copysign(b, d.z())};
}

Eigen::Vector3f DirectionOf(const SquarePoint& point) {
  const float a = 2.0F * point.x - 1.0F;
  const float b = 2.0F * point.y - 1.0F;
  const float height = 1.0F - std::abs(a) - std::abs(b);  // >= 0: upper half
  const float radius = 1.0F - std::abs(height);
  const float azimuth = radius > 0.0F ? 0.25F * kPiF * ((std::abs(b) - std::abs(a)) / radius + 1.0F) : 0.0F;
  const float across = radius * std::sqrt(std::max(0.0F, 2.0F - radius * radius));
  const float up = std::max(0.0F, 1.0F - radius * radius);
  return {std::copysign(across * std::cos(azimuth), a), std::copysign(up, height),
          std::copysign(across * std::sin(azimuth), b)};
}

float LuminanceOf(const LinearRgb& rgb) { return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2]; }

/// Piecewise constant densities over [0, 1), each of `steps` even steps, drawn from by inverting their sums. All in one
/// piece of memory: a draw waits for it more than for anything else.
class Inversions {
 public:
  /// `weights`: those of the first density, then of the second …; each has a positive sum.
  Inversions(const std::vector<float>& weights, std::size_t steps) : steps_(steps) {
    const std::size_t count = weights.size() / steps;
    sums_.reserve(count * (steps + 1));
    first_.reserve(count * steps);
    for (std::size_t k = 0; k < count; ++k) Append(&weights[k * steps]);
  }

  struct Place {
    std::size_t step = 0;
    float within = 0.0F;  // 0 … 1
  };
  [[nodiscard]] Place Find(std::size_t density, float u) const {
    const float* sums = &sums_[density * (steps_ + 1)];
    std::size_t step = first_[density * steps_ + static_cast<std::size_t>(u * static_cast<float>(steps_))];
    while (sums[step + 1] <= u) ++step;
    return {step, std::clamp((u - sums[step]) / (sums[step + 1] - sums[step]), 0.0F, 1.0F)};
  }

 private:
  void Append(const float* weights) {
    double total = 0.0;
    for (std::size_t k = 0; k < steps_; ++k) total += weights[k];
    const std::size_t begin = sums_.size();
    sums_.push_back(0.0F);
    double sum = 0.0;
    for (std::size_t k = 0; k < steps_; ++k) {
      sum += weights[k];
      sums_.push_back(static_cast<float>(sum / total));
    }
    sums_.back() = 1.0F;
    std::size_t at = 0;
    for (std::size_t k = 0; k < steps_; ++k) {
      const float u = static_cast<float>(k) / static_cast<float>(steps_);
      while (sums_[begin + at + 1] <= u) ++at;
      first_.push_back(static_cast<std::uint16_t>(at));
    }
  }

  std::size_t steps_;
  std::vector<float> sums_;           // per density steps + 1
  std::vector<std::uint16_t> first_;  // per density: where the search for k / steps begins
};

}  // namespace

const std::array<std::string_view, 3>& LightPresetNames() {
  static constexpr std::array<std::string_view, 3> kNames = {"studio", "shop", "daylight"};
  return kNames;
}

/// Radiance on a grid over SquareOf, interpolated; density on cells of `kTexels` x `kTexels` of its steps.
struct Environment::Table {
  static constexpr int kTexels = 2;
  static constexpr double kExposure = 0.9;

  template <class Light>
  Table(int cells_per_side, const Light& light);

  [[nodiscard]] const LinearRgb& Texel(int column, int row) const {
    return radiance[static_cast<std::size_t>(row + 1) * static_cast<std::size_t>(texels + 2) +
                    static_cast<std::size_t>(column + 1)];
  }
  [[nodiscard]] LinearRgb Interpolated(const SquarePoint& point) const;
  [[nodiscard]] std::size_t CellOf(const SquarePoint& point) const {
    const auto scale = static_cast<float>(cells);
    const int column = std::min(static_cast<int>(point.x * scale), cells - 1);
    const int row = std::min(static_cast<int>(point.y * scale), cells - 1);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(cells) + static_cast<std::size_t>(column);
  }
  [[nodiscard]] SquarePoint MiddleOf(int column, int row) const {
    return {(static_cast<float>(column) + 0.5F) / static_cast<float>(texels),
            (static_cast<float>(row) + 0.5F) / static_cast<float>(texels)};
  }
  /// Scales the light so that a white matte surface that faces where most light comes from reflects kExposure.
  void Expose();
  /// Last step of the making.
  void Finish() {
    WrapEdges();
    SpreadDensity();
  }
  void WrapEdges();
  void SpreadDensity();

  int cells = 0;                    // per side
  int texels = 0;                   // per side
  std::vector<LinearRgb> radiance;  // (texels + 2)^2: a rim on each side repeats what lies across the fold
  std::vector<float> density;       // cells^2, per steradian
  Inversions columns{{}, 1};        // per row of cells
  Inversions rows{{}, 1};           // one
};

template <class Light>
Environment::Table::Table(int cells_per_side, const Light& light)
    : cells(cells_per_side), texels(kTexels * cells_per_side) {
  radiance.resize(static_cast<std::size_t>(texels + 2) * static_cast<std::size_t>(texels + 2));
  for (int row = 0; row < texels; ++row) {
    for (int column = 0; column < texels; ++column) {
      const LinearRgb seen = light(DirectionOf(MiddleOf(column, row)));
      ENSURE(seen.allFinite() && seen.minCoeff() >= 0.0F, "radiance must be finite and not negative");
      radiance[static_cast<std::size_t>(row + 1) * static_cast<std::size_t>(texels + 2) +
               static_cast<std::size_t>(column + 1)] = seen;
    }
  }
}

void Environment::Table::Expose() {
  std::vector<Eigen::Vector3f> directions;
  directions.reserve(radiance.size());
  Eigen::Vector3d flow = Eigen::Vector3d::Zero();
  for (int row = 0; row < texels; ++row) {
    for (int column = 0; column < texels; ++column) {
      directions.push_back(DirectionOf(MiddleOf(column, row)));
      flow += LuminanceOf(Texel(column, row)) * directions.back().cast<double>();
    }
  }
  const Eigen::Vector3f normal = flow.normalized().cast<float>();
  double sum = 0.0;
  for (std::size_t k = 0; k < directions.size(); ++k) {
    const auto column = static_cast<int>(k) % texels;
    const auto row = static_cast<int>(k) / texels;
    sum += std::max(0.0F, normal.dot(directions[k])) * LuminanceOf(Texel(column, row));
  }
  // Irradiance over pi; a texel stands for 4 pi / texels^2.
  const double reflected = 4.0 * sum / (static_cast<double>(texels) * texels);
  const auto factor = static_cast<float>(kExposure / reflected);
  for (LinearRgb& seen : radiance) seen *= factor;
}

/// Each edge of the square is folded about its middle.
void Environment::Table::WrapEdges() {
  const auto at = [this](int column, int row) -> LinearRgb& {
    return radiance[static_cast<std::size_t>(row + 1) * static_cast<std::size_t>(texels + 2) +
                    static_cast<std::size_t>(column + 1)];
  };
  const int last = texels - 1;
  for (int k = 0; k < texels; ++k) {
    at(k, -1) = at(last - k, 0);
    at(k, texels) = at(last - k, last);
    at(-1, k) = at(0, last - k);
    at(texels, k) = at(last, last - k);
  }
  at(-1, -1) = at(last, last);
  at(texels, -1) = at(0, last);
  at(-1, texels) = at(last, 0);
  at(texels, texels) = at(0, 0);
}

void Environment::Table::SpreadDensity() {
  // The light that interpolation may show in a cell comes from its texels and one more all around.
  std::vector<float> weights(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  double total = 0.0;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      float sum = 0.0F;
      for (int y = -1; y <= kTexels; ++y) {
        for (int x = -1; x <= kTexels; ++x) {
          const bool inner = x >= 0 && x < kTexels && y >= 0 && y < kTexels;
          sum += (inner ? 1.0F : 0.25F) * LuminanceOf(Texel(kTexels * column + x, kTexels * row + y));
        }
      }
      weights[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells) + static_cast<std::size_t>(column)] = sum;
      total += sum;
    }
  }
  // A little everywhere, so that no direction is impossible.
  const double mean = total / static_cast<double>(weights.size());
  const float floor = mean > 0.0 ? static_cast<float>(1e-3 * mean) : 1.0F;
  const double scale =
      static_cast<double>(weights.size()) / (4.0 * kPi * (total + floor * static_cast<double>(weights.size())));
  std::vector<float> row_weights;
  for (int row = 0; row < cells; ++row) {
    const std::size_t begin = static_cast<std::size_t>(row) * static_cast<std::size_t>(cells);
    float sum = 0.0F;
    for (std::size_t k = begin; k < begin + static_cast<std::size_t>(cells); ++k) {
      weights[k] += floor;
      sum += weights[k];
      density.push_back(static_cast<float>(weights[k] * scale));
    }
    row_weights.push_back(sum);
  }
  columns = Inversions(weights, static_cast<std::size_t>(cells));
  rows = Inversions(row_weights, static_cast<std::size_t>(cells));
}

LinearRgb Environment::Table::Interpolated(const SquarePoint& point) const {
  const float x = point.x * static_cast<float>(texels) - 0.5F;
  const float y = point.y * static_cast<float>(texels) - 0.5F;
  const int column = std::clamp(static_cast<int>(x + 1.0F) - 1, -1, texels - 1);
  const int row = std::clamp(static_cast<int>(y + 1.0F) - 1, -1, texels - 1);
  const float s = x - static_cast<float>(column);
  const float t = y - static_cast<float>(row);
  const LinearRgb* upper = &Texel(column, row);
  const LinearRgb* lower = upper + texels + 2;
  const LinearRgb above = upper[0] + s * (upper[1] - upper[0]);
  const LinearRgb below = lower[0] + s * (lower[1] - lower[0]);
  return above + t * (below - above);
}

Environment Environment::Uniform(const LinearRgb& radiance) {
  const auto table = std::make_shared<Table>(1, [&radiance](const Eigen::Vector3f&) { return radiance; });
  table->Finish();
  return Environment(table);
}

Environment Environment::Preset(LightPreset preset) {
  const auto make = [](LightPreset which) {
    constexpr int kCells = 256;
    auto table = std::make_shared<Table>(
        kCells, [which](const Eigen::Vector3f& direction) { return PresetRadiance(which, direction); });
    table->Expose();
    table->Finish();
    return std::shared_ptr<const Table>(std::move(table));
  };
  switch (preset) {
    case LightPreset::kShop: {
      static const std::shared_ptr<const Table> kShop = make(LightPreset::kShop);
      return Environment(kShop);
    }
    case LightPreset::kDaylight: {
      static const std::shared_ptr<const Table> kDaylight = make(LightPreset::kDaylight);
      return Environment(kDaylight);
    }
    case LightPreset::kStudio:
      break;
  }
  static const std::shared_ptr<const Table> kStudio = make(LightPreset::kStudio);
  return Environment(kStudio);
}

LinearRgb Environment::Radiance(const Eigen::Vector3f& direction) const {
  return table_->Interpolated(SquareOf(direction));
}

float Environment::Density(const Eigen::Vector3f& direction) const {
  return table_->density[table_->CellOf(SquareOf(direction))];
}

Environment::Draw Environment::At(const Eigen::Vector3f& direction) const {
  const SquarePoint point = SquareOf(direction);
  return {direction, table_->Interpolated(point), table_->density[table_->CellOf(point)]};
}

Environment::Draw Environment::Sample(float u, float v) const {
  const Inversions::Place row = table_->rows.Find(0, v);
  const Inversions::Place column = table_->columns.Find(row.step, u);
  const auto scale = static_cast<float>(table_->cells);
  const SquarePoint point{(static_cast<float>(column.step) + column.within) / scale,
                          (static_cast<float>(row.step) + row.within) / scale};
  const std::size_t cell = row.step * static_cast<std::size_t>(table_->cells) + column.step;
  return {DirectionOf(point), table_->Interpolated(point), table_->density[cell]};
}

}  // namespace annulus
