#include "render/gloss_table.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

float Clamped(float roughness) { return std::min(1.0F, std::max(Facets::kMinRoughness, roughness)); }

float RoughnessAt(std::size_t row, std::size_t rows) {
  return Facets::kMinRoughness +
         (1.0F - Facets::kMinRoughness) * static_cast<float>(row) / static_cast<float>(rows - 1);
}

float PositionOf(float roughness, std::size_t rows) {
  return (Clamped(roughness) - Facets::kMinRoughness) / (1.0F - Facets::kMinRoughness) * static_cast<float>(rows - 1);
}

/// Weights of one reflection, averaged over the facets seen from a direction.
struct Reflected {
  double all = 0.0;      // of perfect mirrors
  double plastic = 0.0;  // with Fresnel's reflectance
  double skin = 0.0;
};

/// How many facets are asked: along the azimuth (periodic, so that few do) and along the polar angle.
struct Counts {
  int around = 16;
  int down = 24;
};

/// Facets drawn as they are seen reflect `out` into `in` with the weight G2(out, in) / G1(out) (Heitz 2014).
Reflected ReflectedFrom(const Facets& facets, const Eigen::Vector3f& out, const Counts& counts) {
  Reflected sum;
  const float stretch_out = facets.Stretch(out);
  for (int i = 0; i < counts.down; ++i) {
    for (int k = 0; k < counts.around; ++k) {
      const float u = (static_cast<float>(k) + 0.5F) / static_cast<float>(counts.around);
      const float v = (static_cast<float>(i) + 0.5F) / static_cast<float>(counts.down);
      const Eigen::Vector3f half = facets.SampleVisible(out, u, v);
      const float cosine = out.dot(half);
      const Eigen::Vector3f in = 2.0F * cosine * half - out;
      if (in.z() <= 0.0F || cosine <= 0.0F) continue;
      const double weight = (stretch_out + out.z()) * in.z() / (stretch_out * in.z() + facets.Stretch(in) * out.z());
      sum.all += weight;
      sum.plastic += weight * DielectricReflectance(cosine, IndexOf(Coat::kPlastic));
      sum.skin += weight * DielectricReflectance(cosine, IndexOf(Coat::kSkin));
    }
  }
  const double scale = 1.0 / (counts.around * counts.down);
  return {sum.all * scale, sum.plastic * scale, sum.skin * scale};
}

Eigen::Vector3f DirectionAt(float mu, float azimuth) {
  const float sine = std::sqrt(std::max(0.0F, 1.0F - mu * mu));
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), mu};
}

constexpr float kGrazing = 1e-4F;

/// The mu with (1 + width) mu / (mu + width) = position, not quite 0.
float CosineAt(float position, float width) {
  return std::clamp(width * position / (1.0F + width - position), kGrazing * width, 1.0F);
}

/// Midpoints of even steps over 0 … 1.
template <class Function>
double MeanOver(int steps, const Function& function) {
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) sum += function((static_cast<float>(k) + 0.5F) / static_cast<float>(steps));
  return sum / steps;
}

}  // namespace

Facets Facets::Polished(float roughness) {
  const float r = Clamped(roughness);
  return {r * r, r * r};
}

Facets Facets::Brushed(float roughness) {
  const float r2 = Clamped(roughness) * Clamped(roughness);
  const float across = 2.5F * r2 / (1.0F + 1.5F * r2);
  return {across / 6.0F, across};
}

float Facets::Stretch(const Eigen::Vector3f& v) const {
  const float sx = x * v.x();
  const float sy = y * v.y();
  return std::sqrt(v.z() * v.z() + sx * sx + sy * sy);
}

float Facets::Distribution(const Eigen::Vector3f& half) const {
  const float sx = half.x() / x;
  const float sy = half.y() / y;
  const float sum = sx * sx + sy * sy + half.z() * half.z();
  return 1.0F / (static_cast<float>(kPi) * x * y * sum * sum);
}

Eigen::Vector3f Facets::SampleVisible(const Eigen::Vector3f& out, float u, float v) const {
  // Stretched, the facets are a hemisphere whose reflections of `from` fill a cap evenly (Dupuy, Benyoub 2023).
  const Eigen::Vector3f from = Eigen::Vector3f(x * out.x(), y * out.y(), out.z()).normalized();
  const float z = (1.0F - v) * (1.0F + from.z()) - from.z();
  const float sine = std::sqrt(std::max(0.0F, 1.0F - z * z));
  const float azimuth = 2.0F * static_cast<float>(kPi) * u;
  const Eigen::Vector3f bisector(sine * std::cos(azimuth) + from.x(), sine * std::sin(azimuth) + from.y(),
                                 z + from.z());
  return Eigen::Vector3f(x * bisector.x(), y * bisector.y(), std::max(1e-12F, bisector.z())).normalized();
}

float DielectricReflectance(float cosine, float index) {
  const float c = std::clamp(cosine, 0.0F, 1.0F);
  const float g = std::sqrt(index * index - 1.0F + c * c);
  const float s = (g - c) / (g + c);
  const float p = (index * index * c - g) / (index * index * c + g);
  return 0.5F * (s * s + p * p);
}

float IndexOf(Coat coat) { return coat == Coat::kPlastic ? 1.5F : 1.4F; }

GlossTable::Row GlossTable::RowOf(float roughness) {
  const float position = PositionOf(roughness, kRows);
  const std::size_t index = std::min(static_cast<std::size_t>(position), kRows - 2);
  return {index, position - static_cast<float>(index)};
}

const GlossTable& GlossTable::Polished() {
  static const GlossTable kTable;
  return kTable;
}

GlossTable::GlossTable() {
  for (std::size_t row = 0; row < kRows; ++row) {
    FillAlbedo(row);
    FillFresnel(row);
    FillMeans(row);
  }
}

void GlossTable::FillAlbedo(std::size_t row) {
  const Facets facets = Facets::Polished(RoughnessAt(row, kRows));
  for (std::size_t k = 0; k < kSteps; ++k) {
    const float y = static_cast<float>(k) / static_cast<float>(kSteps - 1);
    const float mu = CosineAt(y, facets.x);
    albedo_[row][k] = static_cast<float>(ReflectedFrom(facets, DirectionAt(mu, 0.0F), {}).all);
  }
}

void GlossTable::FillFresnel(std::size_t row) {
  const Facets facets = Facets::Polished(RoughnessAt(row, kRows));
  for (std::size_t k = 0; k < kSteps; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(kSteps - 1);
    const float mu = std::max(CosineAt(t, kBend), kGrazing * facets.x);
    const Reflected reflected = ReflectedFrom(facets, DirectionAt(mu, 0.0F), {});
    fresnel_[0][row][k] = static_cast<float>(reflected.plastic / reflected.all);
    fresnel_[1][row][k] = static_cast<float>(reflected.skin / reflected.all);
  }
}

void GlossTable::FillMeans(std::size_t row) {
  const Row at{std::min(row, kRows - 2), row == kRows - 1 ? 1.0F : 0.0F};
  const float alpha = Facets::Polished(RoughnessAt(row, kRows)).x;
  constexpr int kSamples = 512;
  // mu = s^2 samples grazing angles more densely; d(mu) = 2 s ds.
  mean_albedo_[row] = static_cast<float>(MeanOver(kSamples, [&](float s) {
    const float mu = s * s;
    return 2.0F * s * 2.0F * mu * Albedo(at, alpha, mu);
  }));
  for (const Coat coat : {Coat::kPlastic, Coat::kSkin}) {
    const auto reflected = [&](float mu) { return Albedo(at, alpha, mu) * Fresnel(coat, at, mu); };
    const auto k = static_cast<std::size_t>(coat);
    first_mean_[k][row] =
        static_cast<float>(MeanOver(kSamples, [&](float s) { return 2.0F * s * 2.0F * s * s * reflected(s * s); }));
    second_mean_[k][row] = static_cast<float>(
        MeanOver(kSamples, [&](float s) { return 2.0F * s * 3.0F * s * s * s * s * reflected(s * s); }));
  }
}

const BrushedTable& BrushedTable::Get() {
  static const BrushedTable kTable;
  return kTable;
}

BrushedTable::BrushedTable() {
  for (std::size_t row = 0; row < kRows; ++row) FillRow(row);
}

BrushedTable::Row BrushedTable::RowOf(float roughness) const {
  const float position = PositionOf(roughness, kRows);
  const std::size_t index = std::min(static_cast<std::size_t>(position), kRows - 2);
  const float fraction = position - static_cast<float>(index);
  return {index, fraction, mean_albedo_[index] + fraction * (mean_albedo_[index + 1] - mean_albedo_[index])};
}

float BrushedTable::Lookup(const Plane& plane, float turn, float step) {
  const float across = std::clamp(turn, 0.0F, 1.0F) * static_cast<float>(kTurns - 1);
  const float along = std::clamp(step, 0.0F, 1.0F) * static_cast<float>(kSteps - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(across), kTurns - 2);
  const std::size_t k = std::min(static_cast<std::size_t>(along), kSteps - 2);
  const float s = across - static_cast<float>(i);
  const float t = along - static_cast<float>(k);
  const float lower = plane[i][k] + t * (plane[i][k + 1] - plane[i][k]);
  const float upper = plane[i + 1][k] + t * (plane[i + 1][k + 1] - plane[i + 1][k]);
  return lower + s * (upper - lower);
}

float BrushedTable::Albedo(const Row& row, const Facets& facets, const Eigen::Vector3f& direction) const {
  const float xx = direction.x() * direction.x();
  const float yy = direction.y() * direction.y();
  const float width = std::sqrt((facets.x * facets.x * xx + facets.y * facets.y * yy + 1e-20F * facets.y * facets.y) /
                                (xx + yy + 1e-20F));
  const float turn = (width - facets.x) / (facets.y - facets.x);
  const float step = (1.0F + width) * direction.z() / (direction.z() + width);
  const float lower = Lookup(albedo_[row.index], turn, step);
  const float upper = Lookup(albedo_[row.index + 1], turn, step);
  return lower + row.fraction * (upper - lower);
}

void BrushedTable::FillRow(std::size_t row) {
  const Facets facets = Facets::Brushed(RoughnessAt(row, kRows));
  for (std::size_t i = 0; i < kTurns; ++i) {
    const float turn = static_cast<float>(i) / static_cast<float>(kTurns - 1);
    const float width = facets.x + turn * (facets.y - facets.x);
    const float along =
        (facets.y * facets.y - width * width) / (facets.y * facets.y - facets.x * facets.x);  // cos^2 of the azimuth
    const float azimuth = std::acos(std::sqrt(std::clamp(along, 0.0F, 1.0F)));
    for (std::size_t k = 0; k < kSteps; ++k) {
      const float y = static_cast<float>(k) / static_cast<float>(kSteps - 1);
      const Eigen::Vector3f out = DirectionAt(CosineAt(y, width), azimuth);
      albedo_[row][i][k] = static_cast<float>(ReflectedFrom(facets, out, {24, 20}).all);
    }
  }
  const Row at{std::min(row, kRows - 2), row == kRows - 1 ? 1.0F : 0.0F, 1.0F};
  mean_albedo_[row] = static_cast<float>(MeanOver(64, [&](float s) {
    return 4.0F * s * s * s * MeanOver(32, [&](float turn) {
             return Albedo(at, facets, DirectionAt(s * s, 0.5F * static_cast<float>(kPi) * turn));
           });
  }));
}

}  // namespace annulus
