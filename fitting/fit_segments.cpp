#include "fitting/fit_segments.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include "fitting/section_topology.h"
#include "fitting/segment_axis.h"

namespace annulus {
namespace {

constexpr double kLeastStarShaped = 0.7;   // share of a piece on levels that are star-shaped about its axis
constexpr std::size_t kMostSegments = 32;  // more pieces than a body has limbs
constexpr double kWidestBridge = 40.0;     // mm; wider stretches that no sensor saw stay unknown in a further segment

std::vector<SurfaceSample> Pick(std::span<const SurfaceSample> samples, std::span<const std::size_t> indices) {
  std::vector<SurfaceSample> picked;
  picked.reserve(indices.size());
  for (const std::size_t k : indices) picked.push_back(samples[k]);
  return picked;
}

/// A context that reports into a part of another's range.
TaskContext PartOf(const TaskContext& context, double from, double to) {
  TaskContext part;
  part.stop = context.stop;
  if (!context.progress) return part;
  part.progress = [&context, from, to](std::string_view stage, double done, double total) {
    const double share = total > 0.0 ? std::clamp(done / total, 0.0, 1.0) : 0.0;
    context.progress(stage, from + (to - from) * share, 1.0);
  };
  return part;
}

/// Indices into a subset become indices into all samples.
void Renumber(std::span<const std::size_t> indices, FitSummary& summary) {
  for (RejectedSample& sample : summary.rejected) sample.index = indices[sample.index];
}

/// Makes unknown what lies in rows between `z_min` and `z_max`.
void Forget(double z_min, double z_max, KnowledgeMap& map) {
  const double height = (map.z_max() - map.z_min()) / static_cast<double>(map.rows());
  for (std::size_t row = 0; row < map.rows(); ++row) {
    const double z = map.z_min() + (static_cast<double>(row) + 0.5) * height;
    if (z < z_min || z > z_max) continue;
    for (std::size_t column = 0; column < map.columns(); ++column) map.SetCell(column, row, Knowledge::kUnknown);
  }
}

/// Makes unknown the inferred cells of stretches around that are too wide to bridge: a limb is seen from one side.
void ForgetUnseenSide(SurfaceSegment& segment) {
  KnowledgeMap& map = segment.knowledge;
  const std::size_t n = map.columns();
  const double step = kTwoPi / static_cast<double>(n);
  for (std::size_t row = 0; row < map.rows(); ++row) {
    const double z =
        map.z_min() + (static_cast<double>(row) + 0.5) * (map.z_max() - map.z_min()) / static_cast<double>(map.rows());
    std::size_t first = 0;
    while (first < n && map.Cell(first, row) != Knowledge::kMeasured) ++first;
    std::vector<std::size_t> stretch;
    double length = 0.0;
    const auto end_stretch = [&] {
      if (length > kWidestBridge) {
        for (const std::size_t column : stretch) map.SetCell(column, row, Knowledge::kUnknown);
      }
      stretch.clear();
      length = 0.0;
    };
    for (std::size_t k = 1; k <= n; ++k) {
      const std::size_t column = (first + k) % n;
      if (first < n && map.Cell(column, row) == Knowledge::kMeasured) {
        end_stretch();
        continue;
      }
      stretch.push_back(column);
      length += step * std::abs(segment.surface.Radius(static_cast<double>(column) * step, z));
    }
    end_stretch();
  }
}

/// Adds a further segment's figures to the main one's.
void Join(const FitSummary& part, FitSummary& all) {
  const auto squares = [](const FitSummary& s) { return s.rms_mm * s.rms_mm * static_cast<double>(s.used); };
  const double sum = squares(all) + squares(part);
  all.used += part.used;
  all.rms_mm = all.used > 0 ? std::sqrt(sum / static_cast<double>(all.used)) : 0.0;
  all.rejected.insert(all.rejected.end(), part.rejected.begin(), part.rejected.end());
  all.coefficients += part.coefficients;
  all.effective_parameters += part.effective_parameters;
  all.times.screening_s += part.times.screening_s;
  all.times.smoothing_s += part.times.smoothing_s;
  all.times.solve_s += part.times.solve_s;
  all.times.polish_s += part.times.polish_s;
  all.times.knowledge_s += part.times.knowledge_s;
  all.times.sigma_s += part.times.sigma_s;
}

/// One piece as it was fitted about an axis of its own.
struct PartFit {
  FitResult fit;
  std::vector<std::size_t> samples;  ///< Those given to the fit, of all samples, the seam included.
  std::size_t turning_back = 0;      ///< Samples on levels that are not star-shaped.
};

Result<PartFit> FitPart(std::span<const SurfaceSample> all, const SectionPart& part, const FitOptions& options,
                        const TaskContext& context) {
  std::vector<std::size_t> indices = part.samples;
  indices.insert(indices.end(), part.seam.begin(), part.seam.end());
  std::sort(indices.begin(), indices.end());
  const std::vector<SurfaceSample> samples = Pick(all, indices);
  const auto axis = FindSegmentAxis(samples);
  if (!axis) return Fail(axis);
  const std::vector<char> fits = StarShapedLevels(samples, *axis);
  PartFit result;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (fits[k] != 0) result.samples.push_back(indices[k]);
  }
  result.turning_back = samples.size() - result.samples.size();
  const auto kept = static_cast<double>(result.samples.size());
  if (kept < kLeastStarShaped * static_cast<double>(samples.size())) {
    return Fail("fit a limb", "on too many levels it turns back about any axis through it", "stretch it");
  }
  auto fit = FitSurface(SamplesAboutAxis(Pick(all, result.samples), *axis), options, context);
  if (!fit) return Fail(fit);
  result.fit = std::move(*fit);
  SurfaceSegment& segment = result.fit.model.segments.front();
  segment.name = part.name;
  segment.axis = *axis;
  ForgetUnseenSide(segment);
  return result;
}

void ListForeground(const SectionTopology& topology, FitSummary& summary) {
  for (const SectionRegion& region : topology.regions) {
    if (region.kind != RegionKind::kInFront) continue;
    const double middle = WrapAngle(region.theta_from + 0.5 * WrapAngle(region.theta_to - region.theta_from));
    summary.foreground.push_back({region.z_min, region.z_max, middle, region.samples});
  }
}

/// What became of the regions that no piece was made of.
void CompleteOutcomes(std::vector<SectionRegion>& regions) {
  for (SectionRegion& region : regions) {
    if (!region.outcome.empty()) continue;
    switch (region.kind) {
      case RegionKind::kOverhang:
        region.outcome = "the body's surface goes on over it";
        break;
      case RegionKind::kUnseen:
        region.outcome = "left open; inferred within 40 mm of what was seen";
        break;
      case RegionKind::kSeveralLoops:
      case RegionKind::kAxisOutside:
      case RegionKind::kInFront:
        region.outcome = "not fitted: no piece of it is large enough for a surface of its own";
        break;
    }
  }
}

/// The fit of a body in several pieces.
class BodyFit {
 public:
  BodyFit(std::span<const SurfaceSample> samples, SectionTopology topology)
      : samples_(samples), topology_(std::move(topology)) {}

  Status FitMain(const FitOptions& options, const TaskContext& context);
  void FitParts(const FitOptions& options, const TaskContext& context);
  void Add(PartFit part);
  FitResult Finish() &&;

 private:
  [[nodiscard]] double ShareOf(std::size_t count) const {
    return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, samples_.size()));
  }

  std::span<const SurfaceSample> samples_;
  SectionTopology topology_;
  FitResult result_;
  double progress_ = 0.0;  ///< Share of the work that is done.
};

Status BodyFit::FitMain(const FitOptions& options, const TaskContext& context) {
  std::vector<std::size_t> indices;
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    if (topology_.main[k] != 0) indices.push_back(k);
  }
  progress_ = ShareOf(indices.size());
  auto fit = FitSurface(Pick(samples_, indices), options, PartOf(context, 0.0, progress_));
  if (!fit) {
    Error error = fit.error();
    error.seen += " where the section is one loop around the ring's axis";
    return tl::unexpected(std::move(error));
  }
  result_ = std::move(*fit);
  for (SectionRegion& region : topology_.regions) {
    const bool goes_on = region.kind == RegionKind::kOverhang || region.kind == RegionKind::kUnseen;
    region.left_out = goes_on ? 0 : region.samples;
  }
  Renumber(indices, result_.summary);
  result_.summary.segment_of_sample.assign(samples_.size(), FitSummary::kNoSegment);
  for (const std::size_t k : indices) result_.summary.segment_of_sample[k] = 0;
  for (const SectionRegion& region : topology_.regions) {
    const bool all_around = region.theta_from == 0.0 && region.theta_to == kTwoPi;
    if (all_around) Forget(region.z_min, region.z_max, result_.model.segments.front().knowledge);
  }
  return {};
}

void BodyFit::FitParts(const FitOptions& options, const TaskContext& context) {
  for (const SectionPart& part : topology_.parts) {
    if (result_.model.segments.size() >= kMostSegments) break;
    const double end = std::min(1.0, progress_ + ShareOf(part.samples.size()));
    auto fitted = FitPart(samples_, part, options, PartOf(context, progress_, end));
    progress_ = end;
    std::string& outcome = topology_.regions[part.region].outcome;
    if (!outcome.empty()) outcome += "; ";
    if (!fitted) {
      outcome += part.name + " not fitted: " + fitted.error().seen;
      continue;
    }
    outcome += "fitted as segment " + part.name;
    if (fitted->turning_back > 0) {
      outcome += ", not fitted: " + std::to_string(fitted->turning_back) + " returns of levels that turn back";
    }
    topology_.regions[part.region].left_out -=
        std::min(part.samples.size() - fitted->turning_back, topology_.regions[part.region].left_out);
    Add(std::move(*fitted));
  }
}

void BodyFit::Add(PartFit part) {
  Renumber(part.samples, part.fit.summary);
  std::vector<std::uint8_t>& segment_of_sample = result_.summary.segment_of_sample;
  std::erase_if(part.fit.summary.rejected,
                [&](const RejectedSample& sample) { return segment_of_sample[sample.index] == 0; });  // of the seam
  Join(part.fit.summary, result_.summary);
  for (const std::size_t k : part.samples) {
    if (segment_of_sample[k] == 0) continue;
    segment_of_sample[k] = static_cast<std::uint8_t>(result_.model.segments.size());
  }
  result_.model.segments.push_back(std::move(part.fit.model.segments.front()));
}

FitResult BodyFit::Finish() && {
  FitSummary& summary = result_.summary;
  summary.samples = samples_.size();
  for (const RejectedSample& sample : summary.rejected) {
    summary.segment_of_sample[sample.index] = FitSummary::kNoSegment;
  }
  std::vector<char> is_rejected(samples_.size(), 0);
  for (const RejectedSample& sample : summary.rejected) is_rejected[sample.index] = 1;
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    if (summary.segment_of_sample[k] != FitSummary::kNoSegment || is_rejected[k] != 0) continue;
    summary.rejected.push_back({k, SampleVerdict::kUnfitted});
  }
  summary.used = summary.samples - summary.rejected.size();
  std::sort(summary.rejected.begin(), summary.rejected.end(),
            [](const RejectedSample& a, const RejectedSample& b) { return a.index < b.index; });
  ListForeground(topology_, summary);
  CompleteOutcomes(topology_.regions);
  summary.regions = std::move(topology_.regions);
  return std::move(result_);
}

}  // namespace

Result<FitResult> FitBody(std::span<const SurfaceSample> samples, const FitOptions& options,
                          const TaskContext& context) {
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  SectionTopology topology = FindSectionTopology(samples, SampleGrid(samples));
  const double topology_s = elapsed();
  if (topology.IsOneLoop()) {
    auto fit = FitSurface(samples, options, context);
    if (!fit) return fit;
    CompleteOutcomes(topology.regions);
    fit->summary.regions = std::move(topology.regions);
    fit->summary.times.screening_s += topology_s;
    fit->summary.times.total_s += topology_s;
    return fit;
  }
  BodyFit body(samples, std::move(topology));
  RETURN_IF_ERROR(body.FitMain(options, context));
  body.FitParts(options, context);
  FitResult result = std::move(body).Finish();
  result.summary.times.screening_s += topology_s;
  result.summary.times.total_s = elapsed() - result.summary.times.sigma_s;
  context.Report("fitting", 1.0, 1.0);
  return result;
}

}  // namespace annulus
