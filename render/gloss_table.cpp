#include "render/gloss_table.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/units.h"

namespace annulus {
namespace {

float Clamped(float roughness) { return std::min(1.0F, std::max(Facets::kMinRoughness, roughness)); }

/// 0 … 1 over the range of roughness.
float ShareOf(float roughness) { return (Clamped(roughness) - Facets::kMinRoughness) / (1.0F - Facets::kMinRoughness); }
float RoughnessAt(double share) {
  return static_cast<float>(Facets::kMinRoughness + (1.0 - Facets::kMinRoughness) * share);
}

/// Azimuths and a number of heights over which the facets seen from a direction are asked.
struct Fan {
  std::vector<Eigen::Vector2f> azimuths;
  int heights = 0;
};

/// `turn`: 2 pi, or pi where both halves are alike.
Fan MakeFan(int around, double turn, int heights) {
  Fan fan{{}, heights};
  for (int k = 0; k < around; ++k) {
    const double azimuth = turn * (k + 0.5) / around;
    fan.azimuths.emplace_back(static_cast<float>(std::cos(azimuth)), static_cast<float>(std::sin(azimuth)));
  }
  return fan;
}

/// Mean over the facets that `out` sees of what each reflects: reflectance(cosine on the facet) times the share
/// G2(out, in) / G1(out) that finds its way out (Heitz 2014). Facets are laid out as SampleVisible draws them, more
/// densely towards the far end, where the rarest and steepest ones are.
template <class Reflectance>
double ReflectedFrom(const Facets& facets, const Eigen::Vector3f& out, const Fan& fan, const Reflectance& reflectance) {
  const float stretch_out = facets.Stretch(out);
  const Eigen::Vector3f from = Eigen::Vector3f(facets.x * out.x(), facets.y * out.y(), out.z()) / stretch_out;
  double sum = 0.0;
  for (int i = 0; i < fan.heights; ++i) {
    const float rest = 1.0F - (static_cast<float>(i) + 0.5F) / static_cast<float>(fan.heights);
    const float z = rest * rest * (1.0F + from.z()) - from.z();  // v = 1 - rest^2
    const float sine = std::sqrt(std::max(0.0F, 1.0F - z * z));
    double row = 0.0;
    for (const Eigen::Vector2f& azimuth : fan.azimuths) {
      Eigen::Vector3f half(facets.x * (sine * azimuth.x() + from.x()), facets.y * (sine * azimuth.y() + from.y()),
                           std::max(1e-12F, z + from.z()));
      half /= std::sqrt(half.squaredNorm());
      const float cosine = out.dot(half);
      const Eigen::Vector3f in = 2.0F * cosine * half - out;
      if (in.z() <= 0.0F || cosine <= 0.0F) continue;
      const float escapes = (stretch_out + out.z()) * in.z() / (stretch_out * in.z() + facets.Stretch(in) * out.z());
      row += escapes * reflectance(cosine);
    }
    sum += 2.0F * rest * row;
  }
  return sum / (static_cast<double>(fan.heights) * static_cast<double>(fan.azimuths.size()));
}

Eigen::Vector3f DirectionAt(float mu, float azimuth) {
  const float sine = std::sqrt(std::max(0.0F, 1.0F - mu * mu));
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), mu};
}

/// The mu in 0 … 1, but not quite 0, whose `position` (rising with mu) is `wanted`.
template <class Position>
float CosineAt(double wanted, float width, const Position& position) {
  float low = 1e-4F * width;
  float high = 1.0F;
  for (int k = 0; k < 40; ++k) {
    const float middle = 0.5F * (low + high);
    (position(middle, width) < wanted ? low : high) = middle;
  }
  return high;
}

/// Chebyshev's points on 0 … 1, both ends included.
std::vector<double> ChebyshevPoints(int count) {
  std::vector<double> points;
  for (int k = 0; k < count; ++k) points.push_back(0.5 - 0.5 * std::cos(kPi * k / (count - 1)));
  return points;
}

/// Row i: the weights with which values at ChebyshevPoints(`points`) give their polynomial's value at i / (steps - 1)
/// (barycentric formula).
Eigen::MatrixXd InterpolationTo(std::size_t steps, int points) {
  const std::vector<double> at = ChebyshevPoints(points);
  Eigen::MatrixXd weights(static_cast<Eigen::Index>(steps), points);
  for (Eigen::Index i = 0; i < weights.rows(); ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(steps - 1);
    for (int k = 0; k < points; ++k) {
      const double scale = (k % 2 == 0 ? 1.0 : -1.0) * (k == 0 || k == points - 1 ? 0.5 : 1.0);
      const double away = x - at[static_cast<std::size_t>(k)];
      // On a point its weight wins over all others.
      weights(i, k) = scale / (std::abs(away) < 1e-13 ? 1e-13 : away);
    }
    weights.row(i) /= weights.row(i).sum();
  }
  return weights;
}

/// Values of function(roughness, position) at Chebyshev's points, interpolated to even steps.
template <class Function>
Eigen::MatrixXd Tabulate(std::size_t rows, std::size_t steps, int roughnesses, const Function& function) {
  constexpr int kPositions = 17;
  const std::vector<double> shares = ChebyshevPoints(roughnesses);
  const std::vector<double> positions = ChebyshevPoints(kPositions);
  Eigen::MatrixXd values(roughnesses, kPositions);
  for (int i = 0; i < roughnesses; ++i) {
    for (int k = 0; k < kPositions; ++k) {
      values(i, k) = function(RoughnessAt(shares[static_cast<std::size_t>(i)]), positions[static_cast<std::size_t>(k)]);
    }
  }
  return InterpolationTo(rows, roughnesses) * values * InterpolationTo(steps, kPositions).transpose();
}

template <class Plane>
void Store(const Eigen::MatrixXd& values, Plane& plane) {
  for (std::size_t i = 0; i < plane.size(); ++i) {
    for (std::size_t k = 0; k < plane[i].size(); ++k) {
      plane[i][k] = static_cast<float>(values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)));
    }
  }
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

float Facets::MirrorDensity(const Eigen::Vector3f& out, float stretch_out, const Eigen::Vector3f& sum) const {
  if (!(sum.z() > 0.0F)) return 0.0F;
  // With h = sum / |sum|, D = (x y)^3 |sum|^4 / (pi q^2), q as below, and G1 / out.z = 2 / (out.z + stretch).
  const float xy = x * y;
  const float sx = y * sum.x();
  const float sy = x * sum.y();
  const float sz = xy * sum.z();
  const float q = sx * sx + sy * sy + sz * sz;
  if (!(q > 1e-36F)) return 0.0F;  // out + in is nothing but rounding
  const float ratio = xy * sum.squaredNorm() / q;
  return 0.5F / static_cast<float>(kPi) * xy * ratio * ratio / (out.z() + stretch_out);
}

float DielectricReflectance(float cosine, float index) {
  const float c = std::clamp(cosine, 0.0F, 1.0F);
  const float g = std::sqrt(index * index - 1.0F + c * c);
  // s = (g - c) / (g + c), p = s (c (g + c) - 1) / (c (g - c) + 1); the mean of their squares.
  const float less = g - c;
  const float more = g + c;
  const float up = c * more - 1.0F;
  const float down = c * less + 1.0F;
  const float both = more * down;
  return 0.5F * less * less * (down * down + up * up) / (both * both);
}

float IndexOf(Coat coat) { return coat == Coat::kPlastic ? 1.5F : 1.4F; }

GlossTable::Row GlossTable::RowOf(float roughness) {
  const float position = ShareOf(roughness) * static_cast<float>(kRows - 1);
  const std::size_t index = std::min(static_cast<std::size_t>(position), kRows - 2);
  return {index, position - static_cast<float>(index)};
}

const GlossTable& GlossTable::Polished() {
  static const GlossTable kTable;
  return kTable;
}

GlossTable::GlossTable() {
  const Fan fan = MakeFan(24, kPi, 64);
  Store(Tabulate(kRows, kSteps, 9,
                 [&fan](float roughness, double position) {
                   const Facets facets = Facets::Polished(roughness);
                   const float mu = CosineAt(position, facets.x, Bent);
                   return ReflectedFrom(facets, DirectionAt(mu, 0.0F), fan, [](float) { return 1.0F; });
                 }),
        mirror_);
  for (const Coat coat : {Coat::kPlastic, Coat::kSkin}) {
    const auto reflectance = [index = IndexOf(coat)](float cosine) { return DielectricReflectance(cosine, index); };
    Store(Tabulate(kRows, kSteps, 12,
                   [&fan, &reflectance](float roughness, double position) {
                     const Facets facets = Facets::Polished(roughness);
                     const float mu = CosineAt(position, facets.x, TwiceBent);
                     return ReflectedFrom(facets, DirectionAt(mu, 0.0F), fan, reflectance);
                   }),
          coated_[static_cast<std::size_t>(coat)]);
  }
  FillMeans();
}

void GlossTable::FillMeans() {
  constexpr int kSamples = 512;
  for (std::size_t row = 0; row < kRows; ++row) {
    const Row at{std::min(row, kRows - 2), row == kRows - 1 ? 1.0F : 0.0F};
    const float alpha = Facets::Polished(RoughnessAt(static_cast<double>(row) / (kRows - 1))).x;
    // mu = s^2 samples grazing angles more densely; d(mu) = 2 s ds.
    for (const Coat coat : {Coat::kPlastic, Coat::kSkin}) {
      const auto k = static_cast<std::size_t>(coat);
      first_mean_[k][row] = static_cast<float>(
          MeanOver(kSamples, [&](float s) { return 4.0F * s * s * s * Coated(coat, at, alpha, s * s); }));
      second_mean_[k][row] = static_cast<float>(
          MeanOver(kSamples, [&](float s) { return 6.0F * s * s * s * s * s * Coated(coat, at, alpha, s * s); }));
    }
  }
}

const BrushedTable& BrushedTable::Get() {
  static const BrushedTable kTable;
  return kTable;
}

BrushedTable::BrushedTable() {
  constexpr int kPoints = 7;
  const Fan fan = MakeFan(40, 2.0 * kPi, 40);
  const std::vector<double> turns = ChebyshevPoints(kPoints);
  const Eigen::MatrixXd weights = InterpolationTo(kTurns, kPoints);
  for (int point = 0; point < kPoints; ++point) {
    const auto turn = static_cast<float>(turns[static_cast<std::size_t>(point)]);
    const Eigen::MatrixXd values = Tabulate(kRows, kSteps, 9, [&fan, turn](float roughness, double position) {
      const Facets facets = Facets::Brushed(roughness);
      const float width = facets.x + turn * (facets.y - facets.x);
      // cos^2 of the azimuth at which the facets are that wide.
      const float along = (facets.y * facets.y - width * width) / (facets.y * facets.y - facets.x * facets.x);
      const float azimuth = std::acos(std::sqrt(std::clamp(along, 0.0F, 1.0F)));
      const float mu = CosineAt(position, width, [](float m, float w) { return (1.0F + w) * m / (m + w); });
      return ReflectedFrom(facets, DirectionAt(mu, azimuth), fan, [](float) { return 1.0F; });
    });
    for (std::size_t row = 0; row < kRows; ++row) {
      for (std::size_t i = 0; i < kTurns; ++i) {
        for (std::size_t k = 0; k < kSteps; ++k) {
          mirror_[row][i][k] +=
              static_cast<float>(weights(static_cast<Eigen::Index>(i), point) *
                                 values(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k)));
        }
      }
    }
  }
}

BrushedTable::Row BrushedTable::RowOf(float roughness) {
  const float position = ShareOf(roughness) * static_cast<float>(kRows - 1);
  const std::size_t index = std::min(static_cast<std::size_t>(position), kRows - 2);
  return {index, position - static_cast<float>(index)};
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

float BrushedTable::Mirror(const Row& row, const Facets& facets, const Eigen::Vector3f& direction) const {
  const float xx = direction.x() * direction.x() + 1e-20F;
  const float yy = direction.y() * direction.y() + 1e-20F;
  const float width = std::sqrt((facets.x * facets.x * xx + facets.y * facets.y * yy) / (xx + yy));
  const float turn = (width - facets.x) / (facets.y - facets.x);
  const float step = (1.0F + width) * std::abs(direction.z()) / (std::abs(direction.z()) + width);
  const float lower = Lookup(mirror_[row.index], turn, step);
  const float upper = Lookup(mirror_[row.index + 1], turn, step);
  return lower + row.fraction * (upper - lower);
}

}  // namespace annulus
