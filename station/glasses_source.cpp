#include "station/glasses_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "modeling/glasses/boxing.h"
#include "modeling/glasses/rim.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// The `format` of a file of ours; "" if it is none.
std::string FormatOf(const std::string& text) {
  const auto root = nlohmann::json::parse(text, nullptr, false);
  if (!root.is_object()) return "";
  const auto format = root.find("format");
  return format != root.end() && format->is_string() ? format->get<std::string>() : "";
}

/// Outline point of `eye` in the frame frame: the rim's frame has x to the wearer's right, the outline to the viewer's.
Vector3d InFrame(const Frame& frame, Eye eye, const Eigen::Vector2d& p) {
  Vector3d at = frame.rim.frame_from_rim * Vector3d(eye == Eye::kRight ? -p.x() : p.x(), 0.0, p.y());
  if (eye == Eye::kLeft) at.x() = -at.x();
  return at;
}

}  // namespace

Result<GlassesSource> ReadGlasses(Storage& storage, const std::string& path) {
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  FrameFile design;
  std::optional<WornFile> worn;
  if (FormatOf(*text) == "annulus-frame") {
    const auto file = FrameFromJson(*text, path);
    if (!file) return Fail(file);
    design = *file;
  } else {
    const auto file = WornFileFromJson(*text, path);
    if (!file) return Fail(file);
    worn = *file;
    design = {file->worn.design, file->material, file->worn.adjustment};
  }
  const auto frame = BuildFrame(design.design, design.adjustment.value_or(StandardAdjustment(design.design)));
  if (!frame) return Fail(frame);
  return GlassesSource{design, worn, *frame};
}

std::vector<SavedGoal> GoalsOf(const GlassesSource& source) {
  std::vector<SavedGoal> goals;
  if (!source.worn) return goals;
  const auto fit = nlohmann::json::parse(source.worn->Section("fit"), nullptr, false);
  if (!fit.is_object() || !fit.contains("goals") || !fit["goals"].is_array()) return goals;
  for (const auto& entry : fit["goals"]) {
    if (!entry.is_object()) continue;
    const auto number = [&entry](const char* key) -> std::optional<double> {
      const auto found = entry.find(key);
      if (found == entry.end() || !found->is_number()) return std::nullopt;
      return found->get<double>();
    };
    const auto text = [&entry](const char* key) {
      const auto found = entry.find(key);
      return found != entry.end() && found->is_string() ? found->get<std::string>() : std::string();
    };
    const auto value = number("value");
    if (!value) continue;
    const auto met = entry.find("met");
    goals.push_back({text("id"), text("term"), text("unit"), *value, number("sigma"), number("low").value_or(*value),
                     number("high").value_or(*value), met != entry.end() && met->is_boolean() && met->get<bool>()});
  }
  return goals;
}

WornPosition PositionOf(const GlassesSource& source, Eye eye) {
  WornPosition position;
  position.face_form_angle = source.design.design.details.face_form;
  if (source.worn) position.pantoscopic_tilt = source.worn->worn.tilt;
  const std::string side = eye == Eye::kRight ? "_right" : "_left";
  for (const SavedGoal& goal : GoalsOf(source)) {
    const auto is = [&](const std::string& name) { return goal.id == name || goal.id == name + side; };
    if (is("vertex_distance")) position.vertex_distance = goal.value;
    if (is("pantoscopic_tilt")) position.pantoscopic_tilt = RadiansFromDegrees(goal.value);
    if (is("face_form_angle") || is("face_form")) position.face_form_angle = RadiansFromDegrees(goal.value);
  }
  return position;
}

std::string SizeMark(const Frame& frame) { return SizeText(BoxingOf(frame), frame.arm_right.overall_length); }

std::optional<PupilPlace> PupilOf(const GlassesSource& source, Eye eye) {
  if (!source.worn) return std::nullopt;
  const WornFrame& worn = source.worn->worn;
  const Eigen::Isometry3d frame_from_station = worn.station_from_frame.inverse();
  const FacePoint& point = eye == Eye::kRight ? worn.face.eye_right : worn.face.eye_left;
  const Vector3d pupil = frame_from_station * point.position;
  const Vector3d gaze = frame_from_station.linear() * Vector3d::UnitY();
  const Vector3d centre = InFrame(source.frame, eye, Eigen::Vector2d::Zero());
  Vector3d normal = source.frame.rim.frame_from_rim.linear() * Vector3d::UnitY();
  if (eye == Eye::kLeft) normal.x() = -normal.x();
  const double along = gaze.dot(normal);
  if (!(along > 0.1)) return std::nullopt;  // the frame does not stand before the face
  PupilPlace place;
  place.in_frame = pupil + (centre - pupil).dot(normal) / along * gaze;
  place.pd = std::abs(place.in_frame.x());
  const LensBox box = BoxOf(LensOutlineOf(source.frame, eye));
  const Eigen::Isometry3d rim_from_frame = source.frame.rim.frame_from_rim.inverse();
  Vector3d on_right = place.in_frame;
  if (eye == Eye::kLeft) on_right.x() = -on_right.x();
  place.height = (rim_from_frame * on_right).z() - (box.centre.y() - 0.5 * box.b);
  // A fit knows the head's level; then its numbers count.
  const std::string side = eye == Eye::kRight ? "_right" : "_left";
  for (const SavedGoal& goal : GoalsOf(source)) {
    if (goal.id == "pd" + side) {
      place.in_frame.x() += std::copysign(goal.value - place.pd, place.in_frame.x());
      place.pd = goal.value;
    } else if (goal.id == "pupil_height" + side) {
      place.in_frame.z() += goal.value - place.height;
      place.height = goal.value;
    }
  }
  return place;
}

}  // namespace annulus
