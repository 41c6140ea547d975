#include "station/inside_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "base/units.h"
#include "render/canvas.h"

namespace annulus {
namespace {

using nlohmann::ordered_json;

constexpr int kCaption = 24;  // pixels under a picture
constexpr int kGap = 6;       // between pictures
constexpr double kMostDegrees = 60.0;
constexpr std::size_t kMostGazes = 8;
constexpr double kGridStep = 5.0;  // degrees, of the report

bool Asked(const std::vector<Eye>& eyes, Eye eye) { return std::find(eyes.begin(), eyes.end(), eye) != eyes.end(); }

const char* NameOf(Eye eye) { return eye == Eye::kRight ? "right" : "left"; }

/// A number and what follows it.
std::optional<double> TakeNumber(std::string_view& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}
bool Take(std::string_view& text, char letter) {
  if (text.empty() || text.front() != letter) return false;
  text.remove_prefix(1);
  return true;
}

void Paste(const RgbImage& part, int left, int top, RgbImage& whole) {
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      whole.rgb[whole.Index(left + x, top + y)] = part.rgb[part.Index(x, y)];
    }
  }
}

std::string PowerText(const SpheroCylinder& power) {
  std::string text = fmt::format("{:+.2f}", power.sphere);
  if (power.cylinder != 0.0) {
    text += fmt::format(" {:+.2f} x {:.0f}", power.cylinder, DegreesFromRadians(power.axis));
  }
  return text;
}

std::string GazeText(const Gaze& gaze) {
  const double left = DegreesFromRadians(gaze.left);
  const double up = DegreesFromRadians(gaze.up);
  std::string text;
  if (std::abs(left) > 0.05) text += fmt::format(" {:.0f} deg {}", std::abs(left), left > 0.0 ? "left" : "right");
  if (std::abs(up) > 0.05) text += fmt::format(" {:.0f} deg {}", std::abs(up), up > 0.0 ? "up" : "down");
  return text.empty() ? " straight ahead" : text;
}

/// The line under a picture.
std::string CaptionOf(const InsideEye& eye, const Gaze& gaze, const InsideViewOptions& options) {
  std::string text =
      fmt::format("{} eye {}, gaze{}", eye.eye == Eye::kLeft ? "Left" : "Right", PowerText(eye.order), GazeText(gaze));
  const FieldPoint point = FieldPointAt(eye.Sight(), eye.goal, gaze);
  if (point.path == SightPath::kLens) {
    text += fmt::format(": error {:+.2f} D, astigmatism {:.2f} D", point.mean_error, point.astigmatism);
  } else {
    text += fmt::format(": {}", point.path == SightPath::kBeside ? "past the lens" : "on the frame");
  }
  text += options.pupil_diameter > 0.0 ? fmt::format(", pupil {:.1f} mm", options.pupil_diameter) : ", all sharp";
  if (eye.add) text += fmt::format(" (ADD {:+.2f} not in the lens)", *eye.add);
  return text;
}

RgbImage Caption(const std::string& text, int width) {
  Canvas canvas(width, kCaption);
  const double size = width >= 700 ? 0.45 : 0.34;
  canvas.Text(text, {6.0, 16.0}, size, Anchor::kLeft);
  return canvas.ToImage();
}

Result<RgbImage> EyePictureOf(const InsideEye& eye, const Gaze& gaze, const BeforeTheEye& before,
                              const InsideViewOptions& options, const TaskContext& task) {
  SeeingEye seeing;
  seeing.gaze = gaze;
  seeing.pupil_diameter = options.pupil_diameter;
  seeing.correction = eye.correction;
  seeing.vertex_distance = eye.pose.vertex_distance;
  return RenderEyeView(seeing, before, options.view, task);
}

BeforeTheEye BeforeOf(const InsideGlasses& glasses, const InsideEye& eye, const SurfaceModel* model,
                      const InsideViewOptions& options) {
  BeforeTheEye before;
  SolidLens lens;
  lens.form = eye.form;
  lens.outline = eye.outline;
  lens.abbe = eye.goal.abbe;
  lens.station_from_lens = eye.Sight().lens_from_view().inverse();
  lens.finish = options.finish;
  before.lens = std::move(lens);
  before.near = NearScene(glasses, eye.eye, options.frame, model);
  return before;
}

ordered_json JsonOf(const SpheroCylinder& power) {
  ordered_json json{{"sph_d", power.sphere}, {"cyl_d", power.cylinder}};
  if (power.cylinder != 0.0) json["axis_deg"] = DegreesFromRadians(power.axis);
  return json;
}

ordered_json JsonOf(const FieldPoint& point) {
  ordered_json json{{"left_deg", DegreesFromRadians(point.gaze.left)},
                    {"up_deg", DegreesFromRadians(point.gaze.up)},
                    {"path", SightPathName(point.path)}};
  if (point.path != SightPath::kLens) return json;
  json["mean_error_d"] = point.mean_error;
  json["astigmatism_d"] = point.astigmatism;
  json["axis_deg"] = DegreesFromRadians(point.axis);
  json["worst_error_d"] = point.worst_error;
  json["prism_cm_m"] = {{"left", point.prism.x()}, {"up", point.prism.y()}};
  json["chromatic_cm_m"] = point.chromatic;
  json["thickness_mm"] = point.thickness;
  json["object_left_deg"] = DegreesFromRadians(point.object.left);
  json["object_up_deg"] = DegreesFromRadians(point.object.up);
  // At the very edge a neighbour may miss the lens.
  if (std::isfinite(point.magnification)) json["magnification_percent"] = 100.0 * (point.magnification - 1.0);
  json["lens_x_mm"] = point.place.x();
  json["lens_y_mm"] = point.place.y();
  return json;
}

ordered_json JsonOf(const FieldEdge& edge) {
  ordered_json json{{"gaze_deg", DegreesFromRadians(edge.gaze)}, {"object_deg", DegreesFromRadians(edge.object)}};
  if (!std::isfinite(edge.beside)) return json;
  json["beside_deg"] = DegreesFromRadians(edge.beside);
  json["gap_deg"] = DegreesFromRadians(edge.gap());
  return json;
}

ordered_json JsonOf(const InsideEye& eye, const std::vector<Gaze>& gazes) {
  const LensSight sight = eye.Sight();
  const FieldLimits limits = FieldLimitsOf(sight);
  FieldGrid fine;
  const FieldShares shares = SharesOf(LensFieldOf(sight, eye.goal, fine));
  FieldGrid coarse;
  coarse.step = RadiansFromDegrees(kGridStep);
  ordered_json json;
  json["order"] = JsonOf(eye.order);
  json["wanted_at_vertex"] = JsonOf(SpheroCylinderFrom(eye.goal.power));
  json["vertex_distance_mm"] = eye.pose.vertex_distance;
  if (eye.add) json["add_d_not_in_the_lens"] = *eye.add;
  json["field"] = {
      {"left", JsonOf(limits.left)}, {"right", JsonOf(limits.right)},      {"up", JsonOf(limits.up)},
      {"down", JsonOf(limits.down)}, {"gaze_sr", limits.gaze_solid_angle}, {"object_sr", limits.object_solid_angle}};
  json["within"] = {{"0.25_d", shares.quarter}, {"0.5_d", shares.half}, {"1_d", shares.one}};
  json["gaze"] = ordered_json::array();
  for (const Gaze& gaze : gazes) json["gaze"].push_back(JsonOf(FieldPointAt(sight, eye.goal, gaze)));
  ordered_json points = ordered_json::array();
  for (const FieldPoint& point : LensFieldOf(sight, eye.goal, coarse).points) points.push_back(JsonOf(point));
  json["grid"] = {{"step_deg", kGridStep}, {"points", points}};
  return json;
}

}  // namespace

Result<std::vector<Gaze>> ParseGazes(std::string_view text) {
  const std::string whole(text);
  std::vector<Gaze> gazes;
  do {
    const auto left = TakeNumber(text);
    const bool comma = left && Take(text, ',');
    const auto up = comma ? TakeNumber(text) : std::nullopt;
    if (!up || std::abs(*left) > kMostDegrees || std::abs(*up) > kMostDegrees) {
      return Fail("read the gaze '" + whole + "'", "it is not LEFT,UP in degrees, each at most 60",
                  "write 0,0 for straight ahead, \"20,0;0,-25\" for 20 degrees left and 25 degrees down");
    }
    gazes.push_back({RadiansFromDegrees(*left), RadiansFromDegrees(*up)});
  } while (Take(text, ';'));
  if (!text.empty() || gazes.size() > kMostGazes) {
    return Fail("read the gaze '" + whole + "'", text.empty() ? "there are more than 8" : "'" + std::string(text) + "'",
                "write LEFT,UP in degrees, several with semicolons between");
  }
  return gazes;
}

Result<RgbImage> DrawInsideView(const InsideGlasses& glasses, const SurfaceModel* model,
                                const InsideViewOptions& options, const TaskContext& task) {
  if (options.eyes.empty() || options.gazes.empty() || options.gazes.size() > kMostGazes) {
    return Fail("draw the view from inside", "no eye or no gaze is asked for, or more than 8", "name eyes and gazes");
  }
  std::vector<Eye> eyes;
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {  // as the wearer has them
    if (Asked(options.eyes, eye)) eyes.push_back(eye);
  }
  const auto columns = static_cast<int>(eyes.size());
  const auto rows = static_cast<int>(options.gazes.size());
  const int width = options.view.width;
  const int height = options.view.height + kCaption;
  const GazeScene world = GazeScene::Make(options.scene);
  RgbImage whole;
  for (int column = 0; column < columns; ++column) {
    const InsideEye& eye = glasses.of(eyes[static_cast<std::size_t>(column)]);
    BeforeTheEye before = BeforeOf(glasses, eye, model, options);
    before.world = &world;
    for (int row = 0; row < rows; ++row) {
      const Gaze& gaze = options.gazes[static_cast<std::size_t>(row)];
      TaskContext part;
      part.stop = task.stop;
      part.progress = [&](std::string_view stage, double done, double total) {
        task.Report(stage, (column * rows + row) * total + done, columns * rows * total);
      };
      const auto picture = EyePictureOf(eye, gaze, before, options, part);
      if (!picture) return picture;
      if (whole.width == 0) {  // its size is known to be possible now
        whole = RgbImage::Filled(columns * width + (columns - 1) * kGap, rows * height + (rows - 1) * kGap,
                                 LinearRgb::Ones());
      }
      const int left = column * (width + kGap);
      const int top = row * (height + kGap);
      Paste(*picture, left, top, whole);
      Paste(Caption(CaptionOf(eye, gaze, options), width), left, top + options.view.height, whole);
    }
  }
  return whole;
}

ordered_json InsideReport(const InsideGlasses& glasses, const std::vector<Eye>& eyes, const std::vector<Gaze>& gazes) {
  ordered_json report{{"format", "annulus-inside-view"}, {"version", 1}, {"notes", glasses.notes}};
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    if (Asked(eyes, eye)) report[NameOf(eye)] = JsonOf(glasses.of(eye), gazes);
  }
  return report;
}

}  // namespace annulus
