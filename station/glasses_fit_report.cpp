#include "station/glasses_fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

Json PointToJson(const Eigen::Vector3d& point) { return {point.x(), point.y(), point.z()}; }

Json GoalToJson(const FitGoal& goal) {
  Json json{{"id", goal.id}, {"term", goal.term}, {"unit", goal.unit}, {"value", goal.value}};
  if (std::isfinite(goal.sigma)) json["sigma"] = goal.sigma;
  json["low"] = goal.low;
  json["high"] = goal.high;
  json["met"] = goal.met;
  if (!goal.advice.empty()) json["advice"] = goal.advice;
  return json;
}

Json GoalsToJson(const std::vector<FitGoal>& goals) {
  Json list = Json::array();
  for (const FitGoal& goal : goals) list.push_back(GoalToJson(goal));
  return list;
}

Json FacePointsToJson(const FacePoints& face) {
  Json points = Json::object();
  for (const NamedFacePoint& named : FacePointNames()) {
    const FacePoint& point = face.*named.member;
    points[std::string(named.name)] = {{"position_mm", PointToJson(point.position)},
                                       {"source", LandmarkSourceName(point.source)}};
  }
  return points;
}

std::string FacePointsText(const FacePoints& face) {
  std::string text;
  for (const NamedFacePoint& named : FacePointNames()) {
    const FacePoint& point = face.*named.member;
    text += fmt::format("{:<12} {:8.1f} {:8.1f} {:8.1f} mm  {}\n", named.name, point.position.x(), point.position.y(),
                        point.position.z(), LandmarkSourceName(point.source));
  }
  return text;
}

}  // namespace

Json FitReport(const GlassesFit& fit) {
  Json contacts = Json::array();
  for (const FrameContact& contact : fit.contacts) {
    contacts.push_back({{"part", contact.part},
                        {"position_mm", PointToJson(contact.position)},
                        {"normal", PointToJson(contact.normal)},
                        {"distance_mm", contact.distance},
                        {"load_share", contact.load_share},
                        {"pressure_kpa", contact.pressure_kpa}});
  }
  return {{"wearable", fit.wearable},
          {"score", fit.score},
          {"advice", fit.advice},
          {"goals", GoalsToJson(fit.goals)},
          {"contacts", contacts},
          {"penetration_mm", fit.penetration},
          {"balance",
           {{"frame_g", fit.balance.frame_g},
            {"lenses_g", fit.balance.lenses_g},
            {"centre_of_gravity_mm", PointToJson(fit.balance.centre_of_gravity)},
            {"nose_share", fit.balance.nose_share},
            {"right_share", fit.balance.right_share}}},
          {"face_points", FacePointsToJson(fit.worn.face)}};
}

std::string FitText(const GlassesFit& fit) {
  std::string text;
  for (const FitGoal& goal : fit.goals) {
    const std::string sigma = std::isfinite(goal.sigma) ? fmt::format("± {:.2f}", goal.sigma) : "";
    text += fmt::format("{:<44} {:7.2f} {:<7} {:<4} {:6.1f} … {:<6.1f} {}\n", goal.term, goal.value, sigma, goal.unit,
                        goal.low, goal.high, goal.met ? "" : "not met");
  }
  for (const FrameContact& contact : fit.contacts) {
    text += fmt::format("{:<14} {:6.2f} mm from the head, {:3.0f} % of the weight\n", contact.part, contact.distance,
                        100.0 * contact.load_share);
  }
  text += fmt::format("weight {:.1f} g with lenses of {:.1f} g, {:.0f} % on the nose; deepest entry {:.3f} mm\n",
                      fit.balance.frame_g + fit.balance.lenses_g, fit.balance.lenses_g, 100.0 * fit.balance.nose_share,
                      fit.penetration);
  text += FacePointsText(fit.worn.face);
  text += fit.wearable ? fmt::format("fits, score {:.0f} of 100\n", fit.score)
                       : fmt::format("does not fit, score {:.0f} of 100:\n", fit.score);
  for (const std::string& advice : fit.advice) text += "- " + advice + "\n";
  return text;
}

std::string ClearanceCsv(const GlassesFit& fit) {
  std::string text = "part,x_mm,y_mm,z_mm,distance_mm\n";
  for (const Clearance& place : fit.clearance) {
    text += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.3f}\n", place.part, place.position.x(), place.position.y(),
                        place.position.z(), place.distance);
  }
  return text;
}

Json PlacementReport(const WornFrame& worn) {
  return {{"width_mm", worn.design.parameters.width},
          {"tilt_deg", DegreesFromRadians(worn.tilt)},
          {"forward_shift_mm", worn.forward_shift},
          {"clearance_mm", worn.clearance},
          {"temple_right_mm", worn.l6_right},
          {"temple_left_mm", worn.l6_left},
          {"residuals_mm",
           {{"eye_right", worn.residuals.eye_right},
            {"eye_left", worn.residuals.eye_left},
            {"bridge", worn.residuals.bridge},
            {"ear_right", worn.residuals.ear_right},
            {"ear_left", worn.residuals.ear_left}}},
          {"face_points", FacePointsToJson(worn.face)}};
}

std::string PlacementText(const WornFrame& worn) {
  std::string text = fmt::format(
      "rim width {:.1f} mm, tilt {:.1f} degrees, moved {:.1f} mm forward to clear the face by "
      "{:.1f} mm\n",
      worn.design.parameters.width, DegreesFromRadians(worn.tilt), worn.forward_shift, worn.clearance);
  text += fmt::format("residuals: eyes {:.2f} and {:.2f} mm, bridge {:.2f} mm, ears {:.2f} and {:.2f} mm\n",
                      worn.residuals.eye_right, worn.residuals.eye_left, worn.residuals.bridge,
                      worn.residuals.ear_right, worn.residuals.ear_left);
  return text + FacePointsText(worn.face);
}

Json RankReport(const std::vector<RankedFrame>& ranked, std::size_t count) {
  Json frames = Json::array();
  for (std::size_t k = 0; k < std::min(count, ranked.size()); ++k) {
    const RankedFrame& frame = ranked[k];
    frames.push_back({{"rank", k + 1},
                      {"style", frame.candidate.style},
                      {"size", frame.candidate.size},
                      {"marking", frame.candidate.size_text},
                      {"score", frame.score},
                      {"wearable", frame.wearable},
                      {"advice", frame.advice},
                      {"goals", GoalsToJson(frame.goals)}});
  }
  return {{"tried", ranked.size()}, {"frames", frames}};
}

std::string RankText(const std::vector<RankedFrame>& ranked, std::size_t count) {
  std::string text;
  for (std::size_t k = 0; k < std::min(count, ranked.size()); ++k) {
    const RankedFrame& frame = ranked[k];
    text += fmt::format("{:3} {:<20} {:<7} {:<12} {:5.1f}  {}\n", k + 1, frame.candidate.style, frame.candidate.size,
                        frame.candidate.size_text, frame.score,
                        frame.wearable || frame.advice.empty() ? "fits" : frame.advice.front());
  }
  return text;
}

}  // namespace annulus
