#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "modeling/measure/surface_path.h"
#include "station/console/route.h"

namespace annulus {

/// A place of the request's body: {theta_deg, z_mm} on the surface, or {x_mm, y_mm, z_mm}, of which the nearest place
/// is taken. 400, naming `name`, if it is neither, out of range, or if there is nothing near.
[[nodiscard]] tl::expected<SurfacePlace, ApiError> PlaceField(const MeasuredSurface& body, const nlohmann::json& json,
                                                              const char* name);
/// A list of three finite numbers within ± 10 m.
[[nodiscard]] tl::expected<Eigen::Vector3d, ApiError> VectorField(const nlohmann::json& json, const char* name);

/// Where a ray first enters the surface, to 0.001 mm along the ray: of the main segment, in steps of a millimetre, so
/// that thinner skin is passed by. Nothing if it does not within 5 m. Places of which nothing is known are passed
/// through.
[[nodiscard]] std::optional<SurfacePlace> PickPlace(const MeasuredSurface& body, const Ray& ray);

/// [[x, y, z] …] to 0.01 mm.
[[nodiscard]] nlohmann::ordered_json PointsJson(const std::vector<Eigen::Vector3d>& points);
[[nodiscard]] nlohmann::ordered_json PathJson(const std::vector<PathPoint>& path);

}  // namespace annulus
