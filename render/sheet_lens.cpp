#include "render/sheet_lens.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace annulus {
namespace {

/// A sheet whose radius is above 100 m is flat.
constexpr double kFlat = 1e-5;  // 1/mm
/// Rays that would only graze the surface are taken to meet it at this cosine.
constexpr double kLeastCosine = 0.05;

/// Snell's law: the direction behind a surface of unit normal `normal` (against the ray) for index ratio `eta` = index
/// before / index behind; nothing beyond the critical angle.
std::optional<Eigen::Vector3d> Snell(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal, double eta) {
  const double cosine = -direction.dot(normal);
  const double square = 1.0 - eta * eta * (1.0 - cosine * cosine);
  if (cosine <= 0.0 || square <= 0.0) return std::nullopt;
  return Eigen::Vector3d((eta * direction + (eta * cosine - std::sqrt(square)) * normal).normalized());
}

Eigen::Vector3d WithZAway(const Eigen::Vector3f& v) { return {v.x(), v.y(), -v.z()}; }

/// The faces of an item and what they add up to.
struct SheetShape {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  std::vector<double> vertex_area;  // a third of the faces around, per vertex of the item
  double area = 0.0;
};

SheetShape ShapeOf(const PreparedScene& prepared, std::size_t item) {
  const std::uint32_t first = item == 0 ? 0 : prepared.items[item - 1].end_face;
  const std::uint32_t first_vertex = prepared.items[item].first_vertex;
  SheetShape shape;
  shape.vertex_area.assign(prepared.items[item].item->mesh.vertices.size(), 0.0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (std::uint32_t face = first; face < prepared.items[item].end_face; ++face) {
    const auto& corner = prepared.mesh.faces[face];
    const Eigen::Vector3d& a = prepared.mesh.vertices[corner[0]];
    const Eigen::Vector3d& b = prepared.mesh.vertices[corner[1]];
    const Eigen::Vector3d& c = prepared.mesh.vertices[corner[2]];
    const Eigen::Vector3d twice = (b - a).cross(c - a);
    const double area = 0.5 * twice.norm();
    // Faces that turn the other way round count as their own back.
    sum += (sum.dot(twice) < 0.0 ? -0.5 : 0.5) * twice;
    moment += area / 3.0 * (a + b + c);
    shape.area += area;
    for (const std::uint32_t vertex : corner) shape.vertex_area[vertex - first_vertex] += area / 3.0;
  }
  if (shape.area > 0.0) shape.middle = moment / shape.area;
  const double length = sum.norm();
  if (length > 0.0 && std::isfinite(length)) shape.axis = sum / length;
  return shape;
}

/// Least squares of (lateral normal) = k (lateral offset) + constant.
double CurvatureOf(const PreparedScene& prepared, std::size_t item, const SheetShape& shape) {
  const std::uint32_t first = prepared.items[item].first_vertex;
  const auto lateral = [&shape](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(v - v.dot(shape.axis) * shape.axis);
  };
  double reach = 0.0;
  for (std::size_t k = 0; k < shape.vertex_area.size(); ++k) {
    if (shape.vertex_area[k] > 0.0) {
      reach = std::max(reach, lateral(prepared.mesh.vertices[first + k] - shape.middle).norm());
    }
  }
  double weights = 0.0;
  Eigen::Vector3d mean_offset = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_normal = Eigen::Vector3d::Zero();
  double products = 0.0;
  double squares = 0.0;
  for (std::size_t k = 0; k < shape.vertex_area.size(); ++k) {
    const Eigen::Vector3d offset = lateral(prepared.mesh.vertices[first + k] - shape.middle);
    Eigen::Vector3d normal = WithZAway(prepared.normals[first + k]);
    const double length = normal.norm();
    if (!(reach > 0.0) || !(length > 1e-6)) continue;
    normal /= normal.dot(shape.axis) < 0.0 ? -length : length;
    const double inside = 1.0 - offset.squaredNorm() / (reach * reach);
    const double weight = shape.vertex_area[k] * inside * inside;
    weights += weight;
    mean_offset += weight * offset;
    mean_normal += weight * lateral(normal);
    products += weight * offset.dot(lateral(normal));
    squares += weight * offset.squaredNorm();
  }
  if (!(weights > 0.0)) return 0.0;
  const double denominator = squares - mean_offset.squaredNorm() / weights;
  const double curvature = (products - mean_offset.dot(mean_normal) / weights) / denominator;
  return denominator > 0.0 && std::isfinite(curvature) ? curvature : 0.0;
}

}  // namespace

SheetPower SheetPowerOf(double power_dioptre, double own_curvature, LensMedium medium) {
  const double power = power_dioptre / 1000.0;
  if (power == 0.0) return {1.0, own_curvature};
  constexpr double kNearestToAir = 1e-3;
  const bool is_flat = std::abs(own_curvature) < kFlat;
  if (medium == LensMedium::kThin) {
    const double wanted = is_flat ? kGreatestSheetIndex : 1.0 + std::abs(power / own_curvature);
    const double index = std::clamp(wanted, 1.0 + kNearestToAir, kGreatestSheetIndex);
    return {index, power / (index - 1.0)};
  }
  const double inverse = is_flat ? 0.0 : 1.0 - power / own_curvature;
  double index = inverse > 0.0 ? std::clamp(1.0 / inverse, kLeastSheetIndex, kGreatestSheetIndex) : kGreatestSheetIndex;
  if (std::abs(index - 1.0) < kNearestToAir) index = index < 1.0 ? 1.0 - kNearestToAir : 1.0 + kNearestToAir;
  return {index, power * index / (index - 1.0)};
}

SheetLens::SheetLens(const PreparedScene& prepared, std::size_t item, LensMedium medium) : medium_(medium) {
  const double power = prepared.items[item].item->material.lens_power;
  if (power == 0.0) return;
  const SheetShape shape = ShapeOf(prepared, item);
  middle_ = shape.middle;
  axis_ = shape.axis;
  curvature_ = CurvatureOf(prepared, item, shape);
  front_ = SheetPowerOf(power, curvature_, medium);
  back_ = SheetPowerOf(power, -curvature_, medium);
}

std::optional<Eigen::Vector3d> SheetLens::Refract(const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                                                  const Eigen::Vector3d& direction) const {
  const bool from_front = normal.dot(axis_) >= 0.0;
  const SheetPower& power = from_front ? front_ : back_;
  const Eigen::Vector3d axis = from_front ? axis_ : Eigen::Vector3d(-axis_);
  const double own = from_front ? curvature_ : -curvature_;
  const Eigen::Vector3d offset = p - middle_;
  // Bent as much more as the power needs; a sphere stays one.
  Eigen::Vector3d bent = normal + (power.curvature - own) * (offset - offset.dot(axis) * axis);
  bent.normalize();
  const double cosine = -direction.dot(bent);
  if (!(cosine >= kLeastCosine)) bent = (bent - (kLeastCosine - cosine) * direction).normalized();
  const std::optional<Eigen::Vector3d> inside = Snell(direction, bent, 1.0 / power.index);
  if (!inside || medium_ == LensMedium::kFilled) return inside;
  return Snell(*inside, axis, power.index);
}

}  // namespace annulus
