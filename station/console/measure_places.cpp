#include "station/console/measure_places.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/units.h"
#include "modeling/measure/closest_point.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kFarthest = 10'000.0;  ///< mm

tl::expected<double, ApiError> Coordinate(const nlohmann::json& place, const char* key, const char* name, double low,
                                          double high) {
  const auto number = NumberField(place, key, low, high);
  if (number) return *number;
  return BadField(name, std::string(key) + ": " + number.error().error.seen, number.error().error.advice);
}

tl::expected<SurfacePlace, ApiError> NearestPlaceField(const MeasuredSurface& body, const nlohmann::json& place,
                                                       const char* name) {
  if (const auto known = OnlyKeys(place, {"x_mm", "y_mm", "z_mm"}); !known) return tl::unexpected(known.error());
  Eigen::Vector3d point;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    static constexpr std::array kKeys{"x_mm", "y_mm", "z_mm"};
    const auto value = Coordinate(place, kKeys.at(static_cast<std::size_t>(axis)), name, -kFarthest, kFarthest);
    if (!value) return tl::unexpected(value.error());
    point[axis] = *value;
  }
  const auto nearest = NearestOnSurface(body, point);
  if (!nearest) return BadField(name, nearest.error());
  return nearest->place;
}

double ToHundredth(double value) { return std::round(value * 100.0) / 100.0; }

/// How far a point is outside the surface along the ray from the axis; nothing above, below, or where it was not seen.
std::optional<double> Outside(const MeasuredSurface& body, const Eigen::Vector3d& point) {
  const SplineSurface& surface = body.surface();
  if (point.z() < surface.z_min() || point.z() > surface.z_max()) return std::nullopt;
  const double theta = WrapAngle(std::atan2(point.y(), point.x()));
  if (body.KnowledgeAt(theta, point.z()) == Knowledge::kUnknown) return std::nullopt;
  return std::hypot(point.x(), point.y()) - body.Radius(theta, point.z());
}

}  // namespace

tl::expected<SurfacePlace, ApiError> PlaceField(const MeasuredSurface& body, const nlohmann::json& json,
                                                const char* name) {
  if (!json.contains(name) || !json.at(name).is_object()) {
    return BadField(name, "it is missing, or no place", "give {theta_deg, z_mm} or {x_mm, y_mm, z_mm}");
  }
  const nlohmann::json& place = json.at(name);
  if (!place.contains("theta_deg")) return NearestPlaceField(body, place, name);
  if (const auto known = OnlyKeys(place, {"theta_deg", "z_mm"}); !known) return tl::unexpected(known.error());
  const auto theta = Coordinate(place, "theta_deg", name, -720.0, 720.0);
  if (!theta) return tl::unexpected(theta.error());
  const auto z = Coordinate(place, "z_mm", name, -kFarthest, kFarthest);
  if (!z) return tl::unexpected(z.error());
  return SurfacePlace{WrapAngle(RadiansFromDegrees(*theta)), *z};
}

tl::expected<Eigen::Vector3d, ApiError> VectorField(const nlohmann::json& json, const char* name) {
  const std::string advice = "give [x, y, z]";
  if (!json.contains(name) || !json.at(name).is_array() || json.at(name).size() != 3) {
    return BadField(name, "it is missing, or no list of three numbers", advice);
  }
  Eigen::Vector3d vector;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const nlohmann::json& one = json.at(name).at(static_cast<std::size_t>(axis));
    const double value = one.is_number() ? one.get<double>() : kFarthest * 2.0;
    if (!(std::abs(value) <= kFarthest)) return BadField(name, "one is no number within 10 m", advice);
    vector[axis] = value;
  }
  return vector;
}

std::optional<SurfacePlace> PickPlace(const MeasuredSurface& body, const Ray& ray) {
  constexpr double kStep = 1.0;
  constexpr double kReach = 5000.0;
  constexpr double kExact = 1e-3;
  std::optional<double> before;
  for (double along = 0.0; along <= kReach; along += kStep) {
    const std::optional<double> now = Outside(body, ray.origin + along * ray.direction);
    if (now && before && *before > 0.0 && *now <= 0.0) {
      double outside = along - kStep;
      double inside = along;
      while (inside - outside > kExact) {
        const double middle = 0.5 * (outside + inside);
        const std::optional<double> there = Outside(body, ray.origin + middle * ray.direction);
        (there && *there <= 0.0 ? inside : outside) = middle;
      }
      const Eigen::Vector3d hit = ray.origin + inside * ray.direction;
      return SurfacePlace{WrapAngle(std::atan2(hit.y(), hit.x())), hit.z()};
    }
    before = now;
  }
  return std::nullopt;
}

Json PointsJson(const std::vector<Eigen::Vector3d>& points) {
  Json list = Json::array();
  for (const Eigen::Vector3d& p : points) list.push_back({ToHundredth(p.x()), ToHundredth(p.y()), ToHundredth(p.z())});
  return list;
}

Json PathJson(const std::vector<PathPoint>& path) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(path.size());
  for (const PathPoint& point : path) points.push_back(point.position);
  return PointsJson(points);
}

}  // namespace annulus
