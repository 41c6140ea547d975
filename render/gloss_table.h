#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace annulus {

/// A rough mirror: small facets whose slopes follow the anisotropic Trowbridge-Reitz (GGX) distribution, with Smith's
/// height-correlated shadowing. Directions: local, unit, z along the mean normal.
struct Facets {
  float x = 1.0F;  ///< Width of the slopes along x, alpha_x.
  float y = 1.0F;  ///< Across, alpha_y.

  static constexpr float kMinRoughness = 0.03F;
  /// The same in all directions: alpha = roughness^2. Roughness is clamped to kMinRoughness … 1 (nan to the minimum).
  [[nodiscard]] static Facets Polished(float roughness);
  /// With grooves along x: six times wider across them; the mean gloss is about that of Polished.
  [[nodiscard]] static Facets Brushed(float roughness);

  /// sqrt(z^2 + alpha_x^2 x^2 + alpha_y^2 y^2) of a direction; Smith's Lambda is (Stretch - z) / (2 z).
  [[nodiscard]] float Stretch(const Eigen::Vector3f& v) const;
  /// Density of facet normals, per steradian of normal and unit of area: D(h). h.z() > 0.
  [[nodiscard]] float Distribution(const Eigen::Vector3f& half) const;
  /// Density per steradian with which facets seen from `out` (out.z() > 0), of stretch `stretch_out`, mirror it to a
  /// direction `in` with out + in = `sum`: G1 D / (4 out.z). 0 for a sum below the horizon.
  [[nodiscard]] float MirrorDensity(const Eigen::Vector3f& out, float stretch_out, const Eigen::Vector3f& sum) const;
  /// A normal drawn from those that are seen from `out` (out.z() > 0). u, v in [0, 1).
  [[nodiscard]] Eigen::Vector3f SampleVisible(const Eigen::Vector3f& out, float u, float v) const;
};

/// Reflectance of a clear surface of refractive index `index` at the cosine `cosine` (0 … 1) of incidence, unpolarised.
[[nodiscard]] float DielectricReflectance(float cosine, float index);

/// Clear coats whose albedo is tabulated.
enum class Coat { kPlastic, kSkin };
/// 1.5 and 1.4.
[[nodiscard]] float IndexOf(Coat coat);

/// How much of the light from one direction leaves Facets after a single reflection (the directional albedo). The
/// tables are computed when first asked for (some 10 ms) and constant afterwards; thread-safe. They hold over roughness
/// 0.03 … 1 and 0 < mu <= 1, mu the cosine of the angle to the normal; errors are below 0.0015.
///
/// The albedo E of perfectly reflecting facets has a dent at grazing angles about as wide as alpha, so that it is
/// tabulated over (1 + alpha) mu / (mu + alpha). A clear coat's albedo R has this dent beside Fresnel's own rise: its
/// variable is the mean of the above and of the same with a fixed width in place of alpha.
class GlossTable {
 public:
  /// Of Facets::Polished.
  [[nodiscard]] static const GlossTable& Polished();

  /// A roughness' place in the table.
  struct Row {
    std::size_t index = 0;
    float fraction = 0.0F;
  };
  [[nodiscard]] static Row RowOf(float roughness);

  /// E; alpha: the facets' width at the row's roughness.
  [[nodiscard]] float Mirror(const Row& row, float alpha, float mu) const {
    return Lookup(mirror_, row, Bent(mu, alpha));
  }
  /// R.
  [[nodiscard]] float Coated(Coat coat, const Row& row, float alpha, float mu) const {
    return Lookup(coated_[static_cast<std::size_t>(coat)], row, TwiceBent(mu, alpha));
  }
  /// Means of R over the hemisphere: weighted with 2 mu, and with 3 mu^2.
  struct CoatMeans {
    float first = 0.0F;
    float second = 0.0F;
  };
  [[nodiscard]] CoatMeans MeansOf(Coat coat, const Row& row) const {
    const auto k = static_cast<std::size_t>(coat);
    return {Blend(first_mean_[k], row), Blend(second_mean_[k], row)};
  }

 private:
  static constexpr std::size_t kRows = 41;   // even steps of roughness
  static constexpr std::size_t kSteps = 81;  // even steps of the bent cosine
  static constexpr float kRise = 0.1F;       // about where Fresnel's rise is steepest
  using Plane = std::array<std::array<float, kSteps>, kRows>;
  using Column = std::array<float, kRows>;

  GlossTable();
  void FillMeans();

  /// 0 … 1 for mu 0 … 1, stretched at 0 over about `width`.
  [[nodiscard]] static float Bent(float mu, float width) { return (1.0F + width) * mu / (mu + width); }
  /// The mean of Bent(mu, alpha) and Bent(mu, kRise).
  [[nodiscard]] static float TwiceBent(float mu, float alpha) {
    const float a = mu + alpha;
    const float b = mu + kRise;
    return 0.5F * mu * ((1.0F + alpha) * b + (1.0F + kRise) * a) / (a * b);
  }
  [[nodiscard]] static float Blend(const Column& column, const Row& row) {
    return column[row.index] + row.fraction * (column[row.index + 1] - column[row.index]);
  }
  [[nodiscard]] static float Lookup(const Plane& plane, const Row& row, float position) {
    constexpr auto kLast = static_cast<float>(kSteps - 1);
    const float scaled = position * kLast;
    const std::size_t left = scaled < kLast ? static_cast<std::size_t>(scaled) : kSteps - 2;
    const float t = scaled - static_cast<float>(left);
    const std::array<float, kSteps>& a = plane[row.index];
    const std::array<float, kSteps>& b = plane[row.index + 1];
    const float lower = a[left] + t * (a[left + 1] - a[left]);
    const float upper = b[left] + t * (b[left + 1] - b[left]);
    return lower + row.fraction * (upper - lower);
  }

  Plane mirror_{};
  std::array<Plane, 2> coated_{};
  std::array<Column, 2> first_mean_{};
  std::array<Column, 2> second_mean_{};
};

/// E of Facets::Brushed. As GlossTable, with the direction's azimuth as a third variable: it lies above facets of width
/// hypot(alpha_x x, alpha_y y) / hypot(x, y), between alpha_x (along the grooves) and alpha_y.
class BrushedTable {
 public:
  [[nodiscard]] static const BrushedTable& Get();

  /// A roughness' place in the table.
  struct Row {
    std::size_t index = 0;
    float fraction = 0.0F;
  };
  [[nodiscard]] static Row RowOf(float roughness);
  [[nodiscard]] float Mirror(const Row& row, const Facets& facets, const Eigen::Vector3f& direction) const;

 private:
  static constexpr std::size_t kRows = 33;
  static constexpr std::size_t kTurns = 25;  // even steps of the width
  static constexpr std::size_t kSteps = 61;
  using Plane = std::array<std::array<float, kSteps>, kTurns>;

  BrushedTable();
  [[nodiscard]] static float Lookup(const Plane& plane, float turn, float step);

  std::array<Plane, kRows> mirror_{};
};

}  // namespace annulus
