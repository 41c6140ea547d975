#include "station/fit_scan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "acquisition/reference_returns.h"
#include "fitting/fit_segments.h"
#include "fitting/paper_model.h"
#include "modeling/exchange/paper_json.h"
#include "render/plot.h"
#include "station/command_line.h"
#include "station/sway_report.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

Json ForegroundToJson(const ForegroundObject& object) {
  return {{"z_min_mm", object.z_min},
          {"z_max_mm", object.z_max},
          {"theta_deg", DegreesFromRadians(object.theta)},
          {"returns", object.samples}};
}

const char* NameOf(SampleVerdict verdict) {
  switch (verdict) {
    case SampleVerdict::kForeground:
      return "foreground";
    case SampleVerdict::kUnfitted:
      return "unfitted";
    case SampleVerdict::kGood:
    case SampleVerdict::kOutlier:
      break;
  }
  return "outlier";
}

const char* NameOf(RegionKind kind) {
  switch (kind) {
    case RegionKind::kSeveralLoops:
      return "several loops";
    case RegionKind::kAxisOutside:
      return "axis outside";
    case RegionKind::kInFront:
      return "in front";
    case RegionKind::kOverhang:
      return "overhang";
    case RegionKind::kUnseen:
      return "unseen";
  }
  return "";
}

Json RegionToJson(const SectionRegion& region) {
  return {{"name", region.name},
          {"kind", NameOf(region.kind)},
          {"z_min_mm", region.z_min},
          {"z_max_mm", region.z_max},
          {"theta_from_deg", DegreesFromRadians(region.theta_from)},
          {"theta_to_deg", DegreesFromRadians(region.theta_to)},
          {"returns", region.samples},
          {"share", region.share},
          {"left_out", region.left_out},
          {"why", region.why},
          {"outcome", region.outcome}};
}

Json EdgesToJson(const std::vector<EdgeRegion>& edges) {
  Json json = Json::array();
  for (const EdgeRegion& edge : edges) {
    json.push_back({{"theta_from_deg", DegreesFromRadians(edge.theta_from)},
                    {"theta_to_deg", DegreesFromRadians(edge.theta_to)},
                    {"z_min_mm", edge.z_min},
                    {"z_max_mm", edge.z_max},
                    {"cells", edge.cells}});
  }
  return json;
}

/// Rows of a residual map: as many as leave hardly a row without a level, at most `most`.
Eigen::Index RowsFor(const std::vector<SurfaceSample>& samples, double height, Eigen::Index most) {
  std::map<std::pair<std::uint16_t, std::uint32_t>, double> levels;  // any height of each level
  for (const SurfaceSample& sample : samples) levels.emplace(std::pair{sample.sweep, sample.level}, sample.z);
  std::vector<double> heights;
  heights.reserve(levels.size());
  for (const auto& [key, z] : levels) heights.push_back(z);
  std::sort(heights.begin(), heights.end());
  std::vector<double> gaps;
  for (std::size_t k = 1; k < heights.size(); ++k) gaps.push_back(heights[k] - heights[k - 1]);
  if (gaps.empty()) return 1;
  std::sort(gaps.begin(), gaps.end());
  const double wide = std::max(gaps[gaps.size() * 98 / 100], height / static_cast<double>(most));
  return std::clamp<Eigen::Index>(static_cast<Eigen::Index>(height / wide), 1, most);
}

/// The segment that each sample was used for; null for samples left out.
std::vector<const SurfaceSegment*> SegmentOfSamples(const ScanFit& fit) {
  const SurfaceModel& model = fit.fit.model;
  std::vector<const SurfaceSegment*> segments(fit.samples.size(), &model.main());
  const std::vector<std::uint8_t>& index = fit.fit.summary.segment_of_sample;
  for (std::size_t k = 0; k < index.size(); ++k) {
    segments[k] = index[k] == FitSummary::kNoSegment ? nullptr : &model.segments[index[k]];
  }
  for (const RejectedSample& sample : fit.fit.summary.rejected) segments[sample.index] = nullptr;
  return segments;
}

}  // namespace

SampleResidual ResidualOf(const SurfaceSample& sample, const SurfaceSegment& segment) {
  const Eigen::Vector2d from_axis = sample.Point().head<2>() - segment.axis.At(sample.z);
  const double theta = WrapAngle(std::atan2(from_axis.y(), from_axis.x()));
  return {theta, from_axis.norm() - segment.surface.Radius(theta, sample.z)};
}

namespace {

/// What the calibration that a scan was taken with leaves unknown; of several scans the worst counts.
std::optional<CalibrationErrors> CalibrationErrorsOf(const std::vector<Scan>& scans) {
  std::optional<CalibrationErrors> worst;
  for (const Scan& scan : scans) {
    const auto& uncertainty = scan.header.calibration.uncertainty;
    if (!uncertainty) return std::nullopt;  // one scan of an uncalibrated ring spoils all
    CalibrationErrors errors;
    const auto own = Eigen::Map<const Eigen::ArrayXd>(uncertainty->own_mm.data(),
                                                      static_cast<Eigen::Index>(uncertainty->own_mm.size()));
    errors.offset_covariance = Eigen::MatrixXd(own.square().matrix().asDiagonal());
    if (uncertainty->together_mm.cols() > 0) {
      errors.offset_covariance += uncertainty->together_mm * uncertainty->together_mm.transpose();
    }
    errors.height_scale_sigma = uncertainty->height_scale_sigma;
    errors.height_offset_sigma = uncertainty->height_offset_sigma_mm;
    if (!worst || errors.offset_covariance.sum() > worst->offset_covariance.sum()) worst = std::move(errors);
  }
  return worst;
}

}  // namespace

namespace {

/// What the sensors at the wall saw, as the estimate of sway takes it.
std::vector<ReferenceReading> ReadingsFromWall(const Scan& scan) {
  std::vector<ReferenceReading> readings;
  for (const ReferenceReturn& one : ReferenceReturns(scan)) {
    const std::chrono::duration<double> time = one.time - scan.levels.front().time;
    readings.push_back(
        {time.count(), one.ray.origin, one.ray.direction, one.range_mm, static_cast<std::uint16_t>(one.sensor)});
  }
  return readings;
}

}  // namespace

SwayEstimate SwayOf(const Scan& scan) { return EstimateSway(BuildSamples(scan), ReadingsFromWall(scan), {}); }

Result<ScanFit> FitScans(const std::vector<Scan>& scans, const FitOptions& options, const TaskContext& context) {
  ScanFit result;
  std::string hashes;
  std::uint16_t first_sweep = 0;
  for (const Scan& scan : scans) {
    std::uint16_t sweeps = 0;
    result.sway.push_back(SwayOf(scan));
    for (SurfaceSample& sample : std::exchange(result.sway.back().corrected, {})) {
      sweeps = std::max<std::uint16_t>(sweeps, static_cast<std::uint16_t>(sample.sweep + 1));
      sample.sweep = static_cast<std::uint16_t>(sample.sweep + first_sweep);
      result.samples.push_back(sample);
    }
    first_sweep = static_cast<std::uint16_t>(first_sweep + sweeps);
    hashes += (hashes.empty() ? "" : " ") + ScanHash(scan);
  }
  auto fit = FitBody(result.samples, options, context);
  if (!fit) return Fail(fit);
  result.fit = std::move(*fit);
  // Scans of several stand for each other, so the worst counts.
  if (const SwayEstimate* sway = WorstSway(result.sway); sway != nullptr && sway->errors) {
    auto& systematic = result.fit.model.systematic;
    if (!systematic) systematic.emplace();
    systematic->sway = *sway->errors;
  }
  if (auto calibration = CalibrationErrorsOf(scans)) {
    auto& systematic = result.fit.model.systematic;
    if (!systematic) systematic.emplace();
    systematic->calibration = std::move(*calibration);
  }
  Provenance& provenance = result.fit.model.provenance;
  provenance.recording_hash = hashes;
  const RingCalibration& calibration = scans.front().header.calibration;
  provenance.calibration_hash = calibration.certificate.empty() ? ScanHash({scans.front().header, {}})  // the geometry
                                                                : calibration.certificate;
  provenance.program_version = ProgramVersion();
  provenance.seed = scans.front().header.seed;
  return result;
}

Json FitReport(const ScanFit& fit) {
  const FitSummary& s = fit.fit.summary;
  Json rejected = Json::array();
  for (const RejectedSample& sample : s.rejected) {
    const SurfaceSample& at = fit.samples[sample.index];
    rejected.push_back({{"sweep", at.sweep},
                        {"level", at.level},
                        {"sensor", at.sensor},
                        {"radius_mm", at.radius},
                        {"reason", NameOf(sample.reason)}});
  }
  Json segments = Json::array();
  for (const SurfaceSegment& segment : fit.fit.model.segments) {
    segments.push_back(
        {{"name", segment.name}, {"z_min_mm", segment.surface.z_min()}, {"z_max_mm", segment.surface.z_max()}});
    if (!segment.axis.IsRingAxis()) {
      const Eigen::Vector2d low = segment.axis.At(segment.surface.z_min());
      const Eigen::Vector2d high = segment.axis.At(segment.surface.z_max());
      segments.back()["axis_at_z_min_mm"] = {low.x(), low.y()};
      segments.back()["axis_at_z_max_mm"] = {high.x(), high.y()};
    }
  }
  Json regions = Json::array();
  for (const SectionRegion& region : s.regions) regions.push_back(RegionToJson(region));
  Json foreground = Json::array();
  for (const ForegroundObject& object : s.foreground) foreground.push_back(ForegroundToJson(object));
  Json report{{"termination", s.termination},
              {"time_s",
               {{"screening", s.times.screening_s},
                {"smoothing", s.times.smoothing_s},
                {"solve", s.times.solve_s},
                {"polish", s.times.polish_s},
                {"knowledge", s.times.knowledge_s},
                {"total", s.times.total_s},
                {"sigma", s.times.sigma_s}}},
              {"method", fit.fit.model.provenance.method},
              {"samples", s.samples},
              {"used", s.used},
              {"coefficients", s.coefficients},
              {"effective_parameters", s.effective_parameters},
              {"rms_mm", s.rms_mm},
              {"noise_sigma_mm", s.noise_sigma_mm},
              {"detail_sigma_mm", s.detail_sigma_mm},
              {"smoothing", {{"theta", s.lambda_theta}, {"z", s.lambda_z}}},
              {"cost_start", s.cost_start},
              {"cost_end", s.cost_end},
              {"iterations", s.iterations},
              {"segments", segments},
              {"sway", SwayReport(fit.sway)},
              {"regions", regions},
              {"edges", EdgesToJson(s.edges)},
              {"foreground", foreground},
              {"rejected", rejected}};
  if (s.paper) {
    report["paper"] = PaperReportToJson(fit.fit.model.main().paper->report);
    report["paper"]["tensor_error_mm"] = s.paper->tensor_error;
  }
  return report;
}

Result<RgbImage> ResidualImage(const ScanFit& fit) {
  constexpr Eigen::Index kColumns = 180;
  constexpr Eigen::Index kMaxRows = 360;
  double z_min = fit.fit.model.main().surface.z_min();
  double z_max = fit.fit.model.main().surface.z_max();
  for (const SurfaceSegment& segment : fit.fit.model.segments) {
    z_min = std::min(z_min, segment.surface.z_min());
    z_max = std::max(z_max, segment.surface.z_max());
  }
  const double height = z_max - z_min;
  const Eigen::Index rows = RowsFor(fit.samples, height, kMaxRows);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(rows, kColumns);
  Eigen::MatrixXd count = Eigen::MatrixXd::Zero(rows, kColumns);
  const std::vector<const SurfaceSegment*> segment_of = SegmentOfSamples(fit);
  for (std::size_t k = 0; k < fit.samples.size(); ++k) {
    if (segment_of[k] == nullptr) continue;
    const SurfaceSample& s = fit.samples[k];
    const auto column =
        static_cast<Eigen::Index>(std::lround(s.theta / kTwoPi * static_cast<double>(kColumns))) % kColumns;
    const double down = (z_max - s.z) / height;  // row 0 is the top
    const auto row = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(down * static_cast<double>(rows)), 0, rows - 1);
    sum(row, column) += ResidualOf(s, *segment_of[k]).residual;
    count(row, column) += 1.0;
  }
  HeatMapStyle style;
  style.title = "Residuals: measured - surface";
  style.unit = "mm";
  style.y_from = z_min;
  style.y_to = z_max;
  style.minimum = -3.0 * std::max(fit.fit.summary.noise_sigma_mm, 0.1);
  style.maximum = -style.minimum;
  return RenderHeatMap((sum.array() / count.array()).matrix(), style);  // 0/0 is nan: drawn grey
}

}  // namespace annulus
