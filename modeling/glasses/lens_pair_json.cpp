#include <cmath>
#include <nlohmann/json.hpp>

#include "modeling/glasses/lens_design.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// Infinite radii and the like are null.
Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json Vector(const Eigen::Vector2d& v) { return Json::array({v.x(), v.y()}); }
Json Vector(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }
Json Maybe(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

const char* SeverityName(LensSeverity severity) { return severity == LensSeverity::kWarning ? "warning" : "note"; }

Json ToJson(const std::vector<LensMessage>& messages) {
  Json json = Json::array();
  for (const LensMessage& message : messages) {
    json.push_back({{"severity", SeverityName(message.severity)}, {"text", message.text}});
  }
  return json;
}

/// Prism by the nose: base in and up positive.
Json ToJson(const LensPower& power, Eye eye) {
  const double nose = eye == Eye::kRight ? 1.0 : -1.0;
  return {{"sph_d", power.power.sphere},
          {"cyl_d", power.power.cylinder},
          {"axis_deg", DegreesFromRadians(power.power.axis)},
          {"prism_in_cm_m", nose * power.prism.x()},
          {"prism_up_cm_m", power.prism.y()}};
}

Json ToJson(const WornPowerReport& report, Eye eye) {
  return {{"prescribed", ToJson(report.prescribed, eye)},
          {"wanted_at_worn_vertex", ToJson(report.wanted, eye)},
          {"at_cornea", ToJson(report.at_cornea, eye)},
          {"tilt_deg", DegreesFromRadians(report.tilt.angle)},
          {"tilt_axis_deg", DegreesFromRadians(report.tilt.axis)},
          {"martin", ToJson(report.martin, eye)},
          {"uncompensated_as_worn", ToJson(report.uncompensated, eye)},
          {"uncompensated_error_d", report.uncompensated_error},
          {"uncompensated_prism_error_cm_m", report.uncompensated_prism_error},
          {"uncompensated_within_tolerance", report.uncompensated_within_tolerance},
          {"to_surface", ToJson(report.to_surface, eye)},
          {"as_worn", ToJson(report.as_worn, eye)},
          {"as_worn_error_d", report.as_worn_error},
          {"as_worn_prism_error_cm_m", report.as_worn_prism_error},
          {"within_tolerance", report.within_tolerance}};
}

/// Thickness on a grid over the box; null outside the outline (the edge's points).
Json ThicknessMapToJson(const LensDesign& design) {
  constexpr double kStep = 2.0;  // mm
  LensOutline outline;
  for (const EdgePoint& point : design.edge.points) outline.points.push_back(point.position);
  const ThicknessMap map = ThicknessMapOf(design.form, outline, kStep);
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < map.thickness.rows(); ++row) {
    Json cells = Json::array();
    for (Eigen::Index column = 0; column < map.thickness.cols(); ++column) {
      cells.push_back(Number(map.thickness(row, column)));
    }
    rows.push_back(std::move(cells));
  }
  return {{"x0_mm", map.x0}, {"y0_mm", map.y0}, {"step_mm", map.step}, {"thickness_mm", rows}};
}

Json EdgeToJson(const LensDesign& design) {
  Json points = Json::array();
  for (std::size_t i = 0; i < design.edge.points.size(); ++i) {
    const EdgePoint& point = design.edge.points[i];
    points.push_back({{"angle_deg", DegreesFromRadians(point.angle)},
                      {"x_mm", point.position.x()},
                      {"y_mm", point.position.y()},
                      {"thickness_mm", Number(point.thickness())},
                      {"front_z_mm", Number(point.front_z)},
                      {"bevel_z_mm", Number(design.bevel.apex_z[i])}});
  }
  return {{"thinnest_mm", design.edge.thinnest},
          {"thinnest_angle_deg", DegreesFromRadians(design.edge.thinnest_angle)},
          {"thickest_mm", design.edge.thickest},
          {"thickest_angle_deg", DegreesFromRadians(design.edge.thickest_angle)},
          {"points", points}};
}

Json ToJson(const LensSurface& surface) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < 3; ++row) {
    rows.push_back(Vector(Eigen::Vector3d(surface.lens_from_surface.linear().row(row))));
  }
  return {{"vertex_mm", Vector(Eigen::Vector3d(surface.lens_from_surface.translation()))},
          {"rotation", rows},
          {"curvature_u_per_mm", surface.curvature_u},
          {"curvature_v_per_mm", surface.curvature_v}};
}

Json ToJson(const WornPosition& position) {
  return {{"vertex_distance_mm", position.vertex_distance},
          {"pantoscopic_tilt_deg", DegreesFromRadians(position.pantoscopic_tilt)},
          {"face_form_angle_deg", DegreesFromRadians(position.face_form_angle)}};
}

Json ToJson(const LensDesign& design, const WornPosition& position) {
  const LensForm& form = design.form;
  return {{"box",
           {{"a_mm", design.box.a},
            {"b_mm", design.box.b},
            {"ed_mm", design.box.ed},
            {"circumference_mm", design.box.circumference},
            {"centre_mm", Vector(design.box.centre)}}},
          {"position", ToJson(position)},
          {"decentration_in_mm", design.decentration_in},
          {"decentration_up_mm", design.decentration.y()},
          {"fitting_height_mm", design.fitting_height},
          {"base_d", design.base},
          {"front_radius_mm", Number(design.front_radius)},
          {"back_radius_flat_mm", Number(design.back_radius_flat)},
          {"back_radius_steep_mm", Number(design.back_radius_steep)},
          {"centre_thickness_mm", form.centre_thickness},
          {"thinnest_mm", design.thinnest},
          {"thickest_mm", design.thickest},
          {"volume_mm3", design.body.volume},
          {"weight_g", design.body.weight},
          {"centre_of_gravity_mm", Vector(design.body.centre_of_gravity)},
          {"blank",
           {{"minimum_mm", design.blank.minimum},
            {"exact_mm", design.blank.exact},
            {"stocked_mm", Maybe(design.blank.stocked)}}},
          {"bevel",
           {{"mean_z_mm", design.bevel.mean_z},
            {"unevenness_mm", design.bevel.unevenness},
            {"smallest_front_mm", design.bevel.smallest_front},
            {"smallest_back_mm", design.bevel.smallest_back}}},
          {"add_d", Maybe(design.add)},
          {"power", ToJson(design.power, design.eye)},
          {"surfaces",
           {{"reference_mm", Vector(form.reference)}, {"front", ToJson(form.front)}, {"back", ToJson(form.back)}}},
          {"edge", EdgeToJson(design)},
          {"thickness_map", ThicknessMapToJson(design)},
          {"messages", ToJson(design.messages)}};
}

}  // namespace

std::string LensPairToJson(const LensPair& pair) {
  const Json root{{"format", "annulus-lenses"},
                  {"version", 1},
                  {"material",
                   {{"name", pair.material.name},
                    {"index", pair.material.index},
                    {"line", SpectralLineName(pair.material.line)},
                    {"abbe", pair.material.abbe},
                    {"density_g_cm3", pair.material.density}}},
                  {"dbl_mm", pair.dbl},
                  {"centration", {{"confirmed", pair.centration_confirmed}, {"text", pair.centration}}},
                  {"right", ToJson(pair.right, pair.position_right)},
                  {"left", ToJson(pair.left, pair.position_left)},
                  {"messages", ToJson(pair.messages)}};
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace annulus
