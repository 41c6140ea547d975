#include "station/drift_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "render/plot.h"
#include "render/xy_plot.h"

namespace annulus {
namespace {

constexpr int kWidth = 900;
constexpr int kMapHeight = 420;
constexpr int kLinesHeight = 360;
constexpr std::size_t kMostLines = 6;

const std::array kColours{LinearFromHex(0xc0262d), LinearFromHex(0x1f4e8c), LinearFromHex(0xd98a1f),
                          LinearFromHex(0x2a8a4a), LinearFromHex(0x7a3fa0), LinearFromHex(0x6b7280)};
const LinearRgb kLimit = LinearFromHex(0x9aa0a8);

/// A sensor's deviation in one scan, mm.
double Deviation(const DriftRecord& record, const DriftState& state, std::size_t sensor) {
  const double baseline = state.sensors[sensor].baseline_mm;
  return record.offset_mm[sensor] - (std::isfinite(baseline) ? baseline : 0.0);
}

Result<RgbImage> DrawMap(const DriftHistory& history, const DriftState& state) {
  const std::size_t first = history.SinceCalibration();
  const auto scans = static_cast<Eigen::Index>(history.records().size() - first);
  Eigen::MatrixXd values(scans, static_cast<Eigen::Index>(history.sensors()));
  for (Eigen::Index row = 0; row < scans; ++row) {
    const DriftRecord& record = history.records()[first + static_cast<std::size_t>(row)];
    for (Eigen::Index sensor = 0; sensor < values.cols(); ++sensor) {
      values(row, sensor) = Deviation(record, state, static_cast<std::size_t>(sensor));
    }
  }
  HeatMapStyle style;
  style.title = state.baseline_ready ? "Sensors against their neighbours: change since the calibration"
                                     : "Sensors against their neighbours (baseline not yet made)";
  style.unit = "mm";
  style.x_label = "sensor";
  style.y_label = "scan since the calibration";
  style.x_from = -0.5;
  style.x_to = static_cast<double>(history.sensors()) - 0.5;
  style.y_from = static_cast<double>(scans) + 0.5;  // the newest lowest
  style.y_to = 0.5;
  style.minimum = -0.5;
  style.maximum = 0.5;
  style.width = kWidth;
  style.height = kMapHeight;
  return RenderHeatMap(values, style);
}

/// Those that are told; else the three that have moved most.
std::vector<std::size_t> SensorsToShow(const DriftState& state) {
  std::vector<std::size_t> shown;
  for (const DriftAlarm& alarm : state.alarms) {
    if (shown.size() < kMostLines) shown.push_back(alarm.sensor);
  }
  if (!shown.empty()) return shown;
  std::vector<std::size_t> order;
  const auto moved = [&](std::size_t sensor) {
    const SensorState& at = state.sensors[sensor];
    return std::abs(at.offset_mm - (std::isfinite(at.baseline_mm) ? at.baseline_mm : 0.0));
  };
  for (std::size_t sensor = 0; sensor < state.sensors.size(); ++sensor) {
    if (std::isfinite(moved(sensor))) order.push_back(sensor);
  }
  constexpr std::size_t kThree = 3;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return moved(a) > moved(b); });
  order.resize(std::min(order.size(), kThree));
  return order;
}

Result<RgbImage> DrawLines(const DriftHistory& history, const DriftState& state) {
  const std::size_t first = history.SinceCalibration();
  const std::size_t scans = history.records().size() - first;
  std::vector<XySeries> series;
  const double limit = DriftRules{}.limit_mm;
  for (const double level : {-limit, limit}) {
    XySeries line;
    line.points = {{0.5, level}, {static_cast<double>(scans) + 0.5, level}};
    line.label = level > 0.0 ? "limit" : "";
    line.colour = kLimit;
    series.push_back(line);
  }
  std::size_t colour = 0;
  for (const std::size_t sensor : SensorsToShow(state)) {
    XySeries dots;
    for (std::size_t k = 0; k < scans; ++k) {
      dots.points.emplace_back(static_cast<double>(k + 1), Deviation(history.records()[first + k], state, sensor));
    }
    dots.colour = kColours[colour % kColours.size()];
    dots.mark = XyMark::kDisc;
    dots.size = 3;
    XySeries line = dots;
    line.mark = XyMark::kLine;
    line.size = 1;
    dots.label = "sensor " + std::to_string(sensor);
    series.push_back(std::move(line));
    series.push_back(std::move(dots));
    ++colour;
  }
  XyPlotStyle style;
  style.title = state.alarms.empty() ? "No drift: the sensors that have moved most"
                                     : std::to_string(state.alarms.size()) + " drift alarm(s)";
  style.x_label = "scan since the calibration";
  style.y_label = "reads longer by [mm]";
  style.width = kWidth;
  style.height = kLinesHeight;
  return RenderXyPlot(series, style);
}

/// `b` below `a`, of the same width.
RgbImage Stacked(const RgbImage& a, const RgbImage& b) {
  RgbImage both = a;
  both.height += b.height;
  both.rgb.insert(both.rgb.end(), b.rgb.begin(), b.rgb.end());
  both.depth.insert(both.depth.end(), b.depth.begin(), b.depth.end());
  return both;
}

}  // namespace

Result<RgbImage> DrawDrift(const DriftHistory& history, const DriftState& state) {
  if (state.scans == 0) return Fail("draw the drift", "the history has no scan", "add scans with 'annulus drift'");
  const auto map = DrawMap(history, state);
  if (!map) return map;
  const auto lines = DrawLines(history, state);
  if (!lines) return lines;
  return Stacked(*map, *lines);
}

}  // namespace annulus
