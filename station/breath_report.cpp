#include "station/breath_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "render/xy_plot.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kFor95 = 1.96;  // standard deviations of a 95 % interval

const LinearRgb kGirthColour = LinearFromHex(0x1f4e8c);
const LinearRgb kLimitColour = LinearFromHex(0xd98a1f);

Json PointsJson(const std::vector<GirthPoint>& points) {
  Json json = Json::array();
  for (const GirthPoint& point : points) json.push_back({point.time_s, point.girth_mm});
  return json;
}

XySeries LineOf(const std::vector<GirthPoint>& points, std::string label) {
  XySeries series;
  for (const GirthPoint& point : points) series.points.emplace_back(point.time_s, point.girth_mm);
  series.label = std::move(label);
  series.colour = kGirthColour;
  series.size = 2;
  return series;
}

/// Smallest, mean and largest girth from one time to another.
std::vector<XySeries> Limits(const BreathMeasures& breath, double from_s, double to_s) {
  std::vector<XySeries> lines;
  for (const auto& [name, number] :
       {std::pair{"max", breath.max_mm}, std::pair{"mean", breath.mean_mm}, std::pair{"min", breath.min_mm}}) {
    XySeries line;
    line.points = {{from_s, number.value}, {to_s, number.value}};
    line.label = fmt::format("{} {:.1f} mm", name, number.value);
    line.colour = kLimitColour;
    lines.push_back(std::move(line));
  }
  return lines;
}

RgbImage Beside(const RgbImage& left, const RgbImage& right) {
  RgbImage both =
      RgbImage::Filled(left.width + right.width, std::max(left.height, right.height), LinearRgb::Constant(1.0F));
  int at = 0;
  for (const RgbImage* image : {&left, &right}) {
    for (int y = 0; y < image->height; ++y) {
      for (int x = 0; x < image->width; ++x) both.rgb[both.Index(at + x, y)] = image->rgb[image->Index(x, y)];
    }
    at += image->width;
  }
  return both;
}

}  // namespace

Result<BreathMeasures> BreathOfScan(const Scan& scan, const TaskContext& task) {
  return MeasureBreath(BuildSamples(scan), task);
}

Json JsonFromBreath(const BreathMeasures& breath) {
  return {{"z_mm", breath.z_mm},
          {"breathing", breath.breathing},
          {"breaths", breath.breaths},
          {"period_s", breath.breathing ? Json(breath.period_s) : Json()},
          {"min_mm", breath.min_mm.value},
          {"mean_mm", breath.mean_mm.value},
          {"max_mm", breath.max_mm.value},
          {"min_sigma_mm", breath.min_mm.sigma},
          {"sigma_mm", breath.mean_mm.sigma},
          {"max_sigma_mm", breath.max_mm.sigma},
          {"amplitude_mm", breath.amplitude_mm.value},
          {"amplitude_sigma_mm", breath.amplitude_mm.sigma},
          {"lowest_mm", breath.lowest_mm},
          {"highest_mm", breath.highest_mm},
          {"measured_share", breath.measured_share},
          {"curve", PointsJson(breath.curve)},
          {"course", PointsJson(breath.course)}};
}

std::string TextFromBreath(const BreathMeasures& breath) {
  const auto number = [](const Uncertain& value) {
    return fmt::format("{:.1f} ± {:.1f} mm", value.value, kFor95 * value.sigma);
  };
  const double seconds = breath.course.back().time_s - breath.course.front().time_s;
  std::string text = fmt::format("girth at {:.0f} mm, {:.1f} s:\n", breath.z_mm, seconds);
  if (!breath.breathing) {
    return text + fmt::format("  mean {}\n  no breathing is seen: it varies by {:.1f} mm, which is not significant\n",
                              number(breath.mean_mm), breath.highest_mm - breath.lowest_mm);
  }
  text += fmt::format("  breathed out {}, mean {}, breathed in {}\n", number(breath.min_mm), number(breath.mean_mm),
                      number(breath.max_mm));
  text += fmt::format("  a breath: {} in {:.1f} s (mean of {})\n", number(breath.amplitude_mm), breath.period_s,
                      breath.breaths);
  return text + fmt::format("  the whole time: {:.1f} to {:.1f} mm\n", breath.lowest_mm, breath.highest_mm);
}

Result<RgbImage> DrawBreath(const BreathMeasures& breath) {
  XyPlotStyle style;
  style.title = fmt::format("Girth at {:.0f} mm", breath.z_mm);
  style.x_label = "time [s]";
  style.y_label = "girth [mm]";
  style.width = 720;
  style.height = 420;
  std::vector<XySeries> all = Limits(breath, breath.course.front().time_s, breath.course.back().time_s);
  all.push_back(LineOf(breath.course, "girth"));
  auto course = RenderXyPlot(all, style);
  if (!course || !breath.breathing) return course;
  style.title = fmt::format("One breath of {:.1f} s (mean of {})", breath.period_s, breath.breaths);
  style.width = 420;
  const auto curve = RenderXyPlot({LineOf(breath.curve, "")}, style);
  if (!curve) return Fail(curve);
  return Beside(*course, *curve);
}

}  // namespace annulus
