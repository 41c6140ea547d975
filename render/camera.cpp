#include "render/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "base/frames.h"

namespace annulus {
namespace {

/// A box is never framed tighter than this, mm.
constexpr double kSmallestExtent = 1.0;
constexpr double kLargestCoordinate = 1e6;
constexpr double kMostTurns = 100.0 * 360.0;

std::optional<double> ParseNumber(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Rows right, up, forward of a camera that looks from `view` at the origin.
Eigen::Matrix3d RotationOf(const View& view) {
  const double cos_az = std::cos(view.azimuth);
  const double sin_az = std::sin(view.azimuth);
  const double cos_el = std::cos(view.elevation);
  const double sin_el = std::sin(view.elevation);
  Eigen::Matrix3d camera_from_station;
  camera_from_station.row(0) << -sin_az, cos_az, 0.0;
  camera_from_station.row(1) << -cos_az * sin_el, -sin_az * sin_el, cos_el;
  camera_from_station.row(2) << -cos_az * cos_el, -sin_az * cos_el, -sin_el;
  return camera_from_station;
}

Status CheckFraming(const Eigen::AlignedBox3d& bounds, const View& view, const Framing& framing) {
  constexpr const char* kAttempted = "aim the camera";
  const auto in_range = [](const Eigen::Vector3d& corner) {
    return corner.allFinite() && corner.cwiseAbs().maxCoeff() <= kLargestCoordinate;
  };
  if (bounds.isEmpty() || !in_range(bounds.min()) || !in_range(bounds.max())) {
    return Fail(kAttempted, "there is nothing within 1 km to look at", "give a subject with at least one vertex");
  }
  if (!std::isfinite(view.azimuth) || !(std::abs(view.elevation) <= kPi / 2.0 + 1e-12)) {
    return Fail(kAttempted, "the view is not finite or its elevation exceeds 90 degrees",
                "give a finite azimuth and an elevation from -90 to 90 degrees");
  }
  const bool ok = framing.aspect >= 1e-4 && framing.aspect <= 1e4 && framing.margin >= 0.0 && framing.margin <= 0.9 &&
                  framing.vertical_field_of_view >= 0.01 && framing.vertical_field_of_view <= 2.5;
  if (!ok) {
    return Fail(kAttempted, "aspect, margin or field of view is out of range",
                "keep the margin in 0 ... 0.9 and the field of view in 0.01 ... 2.5 rad");
  }
  return {};
}

}  // namespace

Result<View> ParseView(std::string_view text) {
  if (text == "front") return View{RadiansFromDegrees(90.0), 0.0};
  if (text == "left45") return View{RadiansFromDegrees(135.0), 0.0};
  if (text == "right45") return View{RadiansFromDegrees(45.0), 0.0};
  const std::string attempted = "read the view '" + std::string(text.substr(0, 60)) + "'";
  constexpr const char* kAdvice = "give front, left45, right45, or AZ,EL in degrees (front is 90,0)";
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return Fail(attempted, "it is no known name and has no comma", kAdvice);
  const std::optional<double> azimuth = ParseNumber(text.substr(0, comma));
  const std::optional<double> elevation = ParseNumber(text.substr(comma + 1));
  if (!azimuth || std::abs(*azimuth) > kMostTurns) return Fail(attempted, "the azimuth is not an angle", kAdvice);
  if (!elevation) return Fail(attempted, "the elevation is not a number", kAdvice);
  if (std::abs(*elevation) > 90.0) return Fail(attempted, "the elevation is outside -90 ... 90 degrees", kAdvice);
  return View{WrapAngle(RadiansFromDegrees(*azimuth)), RadiansFromDegrees(*elevation)};
}

Result<Camera> FrameCamera(const Eigen::AlignedBox3d& bounds, const View& view, const Framing& framing) {
  RETURN_IF_ERROR(CheckFraming(bounds, view, framing));
  Camera camera;
  camera.projection = framing.projection;
  camera.camera_from_station = RotationOf(view);
  const Eigen::Vector3d centre = bounds.center();
  const double usable = 1.0 - framing.margin;
  const double tangent = std::tan(0.5 * framing.vertical_field_of_view);
  double distance = 0.0;  // perspective: eye to centre
  double half_height = 0.5 * kSmallestExtent;
  double front = 0.5 * kSmallestExtent;  // extent of the box towards the eye
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d corner = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
    const Eigen::Vector3d p = camera.camera_from_station * (corner - centre);
    const double extent = std::max({std::abs(p.y()), std::abs(p.x()) / framing.aspect, 0.5 * kSmallestExtent}) / usable;
    half_height = std::max(half_height, extent);
    front = std::max(front, -p.z());
    // The corner is inside the picture if extent <= tangent * (distance + p.z).
    distance = std::max(distance, extent / tangent - p.z());
  }
  if (framing.projection == Projection::kOrthographic) {
    camera.half_height = half_height;
    distance = 2.0 * front + 100.0;
  } else {
    camera.half_height = tangent;
    distance = std::max(distance, front + 1.0);
  }
  camera.near_mm = std::min(1.0, 0.5 * (distance - front));
  camera.eye_in_station = centre - distance * camera.camera_from_station.row(2).transpose();
  return camera;
}

}  // namespace annulus
