#include "modeling/wrinkly/dress.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"
#include "modeling/wrinkly/control_nets.h"
#include "modeling/wrinkly/surface_nets.h"

namespace annulus {
namespace {

struct Dress {
  double height = 0.0;
  std::array<double, 3> colour{};
  double opacity = 1.0;
};

void SetNames(ControlMeshParts& parts) {
  parts.attributes = {"height", "red", "green", "blue", "opacity"};
  parts.values = decltype(parts.values)::Zero(static_cast<Eigen::Index>(parts.points.size()), 5);
}

void Set(ControlMeshParts& parts, std::size_t point, const Dress& dress) {
  parts.values.row(static_cast<Eigen::Index>(point)) << dress.height, dress.colour[0], dress.colour[1], dress.colour[2],
      dress.opacity;
}

double Smooth(double from, double to, double at) {
  const double t = std::clamp((at - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

std::array<double, 3> Mixed(const std::array<double, 3>& a, const std::array<double, 3>& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

}  // namespace

void DressAtRandom(ControlMeshParts& parts, double low, double high, std::uint64_t seed) {
  SetNames(parts);
  for (std::size_t k = 0; k < parts.points.size(); ++k) {
    const auto chance = [&](std::uint64_t kind) { return ScatteredNumber(seed + kind, k); };
    Set(parts, k,
        {low + (high - low) * chance(0),
         {0.05 + 0.85 * chance(1), 0.05 + 0.85 * chance(2), 0.05 + 0.85 * chance(3)},
         1.0});
  }
}

Result<ControlMeshParts> HairOf(const SplineSurface& head, double length_mm, std::uint64_t seed) {
  constexpr double kInFront = 45.0;
  constexpr double kBehind = 150.0;
  constexpr double kEdge = 12.0;
  SurfaceNet net;
  net.columns = 60;
  net.rows = 24;
  net.z_max = head.z_max();
  net.z_min = std::max(head.z_min(), head.z_max() - kBehind - kEdge);
  net.top = SurfaceNet::Top::kClosed;
  auto parts = NetOfSurface(head, net);
  if (!parts) return Fail(parts);
  SetNames(*parts);
  for (std::size_t k = 0; k < parts->points.size(); ++k) {
    const Eigen::Vector3d& p = parts->points[k].position;
    // 0 in front, 1 behind.
    const double back = 0.5 - 0.5 * std::sin(std::atan2(p.y(), p.x()));
    const double hairline = head.z_max() - kInFront - (kBehind - kInFront) * Smooth(0.12, 0.75, back);
    const double grown = Smooth(hairline, hairline + kEdge, p.z());
    const double tone = 0.6 + 0.8 * ScatteredNumber(seed + 1, k);
    Set(*parts, k,
        {grown * length_mm * (0.4 + 1.2 * ScatteredNumber(seed, k)), {0.12 * tone, 0.065 * tone, 0.035 * tone}, grown});
  }
  return parts;
}

Result<ControlMeshParts> KnitOf(const SplineSurface& torso, const KnitBand& band, std::uint64_t seed) {
  constexpr double kRibHeight = 1.0;
  constexpr std::array<double, 3> kRed{0.42, 0.035, 0.04};
  constexpr std::array<double, 3> kCream{0.72, 0.66, 0.52};
  const double middle = 0.5 * (band.z_min + band.z_max);
  double girth = 0.0;
  constexpr int kSteps = 180;
  for (int k = 0; k < kSteps; ++k) {
    girth +=
        torso.Radius(2.0 * kPi * k / kSteps, std::clamp(middle, torso.z_min(), torso.z_max())) * 2.0 * kPi / kSteps;
  }
  SurfaceNet net;
  // Ribs and the furrows between them take turns.
  net.columns = 2 * std::max(2, static_cast<int>(std::lround(girth / band.rib_mm)));
  net.rows = std::max(3, static_cast<int>(std::lround(2.0 * (band.z_max - band.z_min) / band.rib_mm)));
  net.z_min = band.z_min;
  net.z_max = band.z_max;
  auto parts = NetOfSurface(torso, net);
  if (!parts) return Fail(parts);
  SetNames(*parts);
  for (std::size_t k = 0; k < parts->points.size(); ++k) {
    const std::size_t column = k % static_cast<std::size_t>(net.columns);
    const std::size_t row = k / static_cast<std::size_t>(net.columns);
    const bool rib = column % 2 == 0;
    const double high = rib ? (row % 2 == 0 ? 2.0 : 1.5) : 0.5;
    const double tone = 0.9 + 0.2 * ScatteredNumber(seed, k);
    auto colour = row / 4 % 2 == 0 ? kRed : kCream;
    for (double& channel : colour) channel *= tone;
    Set(*parts, k, {kRibHeight * high, colour, 1.0});
  }
  return parts;
}

void Append(ControlMeshParts& parts, const ControlMeshParts& more) {
  const auto first = static_cast<PointIndex>(parts.points.size());
  for (ControlPoint point : more.points) {
    for (ControlLink& link : point.link) {
      if (link.kind == ControlLink::Kind::kPoint) link.point += first;
    }
    parts.points.push_back(point);
  }
  decltype(parts.values) values(parts.values.rows() + more.values.rows(), more.values.cols());
  if (parts.values.rows() > 0) values.topRows(parts.values.rows()) = parts.values;
  values.bottomRows(more.values.rows()) = more.values;
  parts.values = std::move(values);
  parts.attributes = more.attributes;
}

Result<ControlMeshParts> TexturedFrame(const std::vector<PatchShell>& shells, FrameTexture texture,
                                       std::uint64_t seed) {
  constexpr int kPerPatch = 4;
  constexpr double kDepth = 0.4;
  constexpr std::array<double, 3> kAmber{0.55, 0.22, 0.035};
  constexpr std::array<double, 3> kDark{0.045, 0.018, 0.008};
  constexpr std::array<double, 3> kHorn{0.52, 0.40, 0.26};
  ControlMeshParts whole;
  for (const PatchShell& shell : shells) {
    auto parts = NetOfShell(shell, kPerPatch);
    if (!parts) return Fail(parts);
    SetNames(*parts);
    for (std::size_t k = 0; k < parts->points.size(); ++k) {
      const double chance = ScatteredNumber(seed, whole.points.size() + k);
      if (texture == FrameTexture::kTortoise) {
        Set(*parts, k, {0.0, Mixed(kAmber, kDark, Smooth(0.45, 0.6, chance)), 1.0});
      } else {
        Set(*parts, k, {-kDepth * chance, Mixed(kHorn, kDark, 0.75 * chance), 1.0});
      }
    }
    Append(whole, *parts);
  }
  return whole;
}

}  // namespace annulus
