#include "station/wrinkly_targets.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "station/fit_scan.h"
#include "station/residual_map.h"

namespace annulus {
namespace {

/// A channel between the middles of pixels; shares of the picture from its left and its lower edge.
double ValueAt(const RgbImage& image, ImageChannel channel, double across, double up) {
  const double x = std::clamp(across * image.width - 0.5, 0.0, image.width - 1.0);
  const double y = std::clamp((1.0 - up) * image.height - 0.5, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(0, image.width - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, image.height - 2));
  const auto value = [&](int column, int row) {
    const LinearRgb& rgb = image.rgb[image.Index(std::min(column, image.width - 1), std::min(row, image.height - 1))];
    const bool is_grey = channel == ImageChannel::kGrey;
    return static_cast<double>(is_grey ? rgb.sum() / 3.0F : rgb[static_cast<Eigen::Index>(channel)]);
  };
  const double a = value(x0, y0) + (x - x0) * (value(x0 + 1, y0) - value(x0, y0));
  const double b = value(x0, y0 + 1) + (x - x0) * (value(x0 + 1, y0 + 1) - value(x0, y0 + 1));
  return a + (y - y0) * (b - a);
}

double Turned(double theta) {
  const double turned = std::fmod(theta, 2.0 * kPi);
  return turned < 0.0 ? turned + 2.0 * kPi : turned;
}

}  // namespace

Result<std::vector<WrinklyTarget>> TargetsOfImage(const WrinklySurface& surface, const RgbImage& image,
                                                  const ImageTargets& how) {
  if (image.width < 2 || image.height < 2) {
    return Fail("lay the picture over the surface", fmt::format("it has {} x {} pixels", image.width, image.height),
                "use a larger one");
  }
  const ControlMesh& mesh = surface.mesh();
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    if (!mesh.HasPatch(static_cast<PointIndex>(k))) continue;
    for (const auto& row : surface.base().net(static_cast<PointIndex>(k))) {
      for (const Eigen::Vector3d& point : row) box.extend(point);
    }
  }
  const Eigen::Vector3d size = box.sizes().cwiseMax(1e-9);
  std::vector<WrinklyTarget> targets;
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    const auto patch = static_cast<PointIndex>(k);
    if (!mesh.HasPatch(patch)) continue;
    for (int i = 0; i < how.per_side; ++i) {
      for (int j = 0; j < how.per_side; ++j) {
        WrinklyTarget target{patch, (i + 0.5) / how.per_side, (j + 0.5) / how.per_side};
        const Eigen::Vector3d at = surface.base().At(patch, target.u, target.v).point;
        const bool flat = how.lay == ImageLay::kFlat;
        const double across =
            flat ? (at.x() - box.min().x()) / size.x() : Turned(std::atan2(at.y(), at.x())) / (2.0 * kPi);
        const double up = flat ? (at.y() - box.min().y()) / size.y() : (at.z() - box.min().z()) / size.z();
        target.value = how.high * ValueAt(image, how.channel, across, up);
        targets.push_back(target);
      }
    }
  }
  return targets;
}

std::vector<WrinklyTarget> TargetsOfScan(const SurfaceModel& model, const SurfaceNet& net,
                                         const std::vector<SurfaceSample>& samples) {
  const SurfaceSegment& segment = model.main();
  std::vector<WrinklyTarget> targets;
  for (const SurfaceSample& sample : samples) {
    if (sample.weight <= 0.0F || sample.z < net.z_min || sample.z > net.z_max) continue;
    const SampleResidual residual = ResidualOf(sample, segment);
    if (!(std::abs(residual.residual) <= kResidualReach)) continue;
    const double column = Turned(residual.theta - net.theta_from) / std::min(net.theta_over, 2.0 * kPi) * net.columns;
    const double row = (sample.z - net.z_min) / (net.z_max - net.z_min) * net.rows;
    if (column >= net.columns) continue;
    const int at_column = static_cast<int>(column);
    const int at_row = std::min(static_cast<int>(row), net.rows - 1);
    const Eigen::Vector3d normal = segment.surface.Normal(residual.theta, sample.z);
    const double slope = normal.x() * std::cos(residual.theta) + normal.y() * std::sin(residual.theta);
    targets.push_back(
        {at_row * net.columns + at_column, column - at_column, row - at_row, residual.residual * slope, sample.weight});
  }
  return targets;
}

}  // namespace annulus
