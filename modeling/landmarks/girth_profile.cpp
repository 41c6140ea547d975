#include "modeling/landmarks/girth_profile.h"

#include <algorithm>
#include <cmath>

#include "base/frames.h"
#include "modeling/measure/section_sampler.h"

namespace annulus {
namespace {

constexpr std::size_t kCurvePoints = 240;
constexpr double kSeenShare = 0.6;           // of a section; with less, the inferred rest is taken too
constexpr double kLongestGap = 60.0;         // mm without a known section that are bridged
constexpr double kWidestGap = kTwoPi / 3.0;  // rad without a seen direction

bool IsKnownAllAround(const MeasuredSurface& body, double z) {
  const std::size_t columns = std::max<std::size_t>(1, body.segment().knowledge.columns());
  for (std::size_t k = 0; k < columns; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(columns);
    if (body.KnowledgeAt(theta, z) == Knowledge::kUnknown) return false;
  }
  return true;
}

/// A level is looked for on what was seen: a stretch hidden by an arm leans towards the shoulder above it, and would
/// draw the chest upwards. The tape spans it in a straight line.
Girth GirthOf(const MeasuredSurface& body, const SectionSampler& sampler, double z) {
  const std::vector<Eigen::Vector2d> curve = sampler.Points(z);
  std::vector<Eigen::Vector2d> seen;
  double skin = 0.0;
  for (std::size_t k = 0; k < curve.size(); ++k) {
    skin += (curve[(k + 1) % curve.size()] - curve[k]).norm();
    if (body.KnowledgeAt(sampler.directions()[k], z) == Knowledge::kMeasured) seen.push_back(curve[k]);
  }
  const double whole = TapeLength(curve);
  const bool enough = static_cast<double>(seen.size()) >= kSeenShare * static_cast<double>(curve.size());
  return {z, enough ? TapeLength(seen) : whole, skin / whole - 1.0, false};
}

/// Appends to a run; what was not seen in between is bridged.
void Append(const Girth& next, GirthRun& run) {
  if (!run.empty()) {
    const Girth last = run.back();
    const auto steps = static_cast<std::size_t>(std::lround((last.z - next.z) / kGirthStep));
    for (std::size_t k = 1; k < steps; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(steps);
      const auto between = [share](double from, double to) { return from + share * (to - from); };
      run.push_back({between(last.z, next.z), between(last.tape, next.tape), between(last.hollow, next.hollow), true});
    }
  }
  run.push_back(next);
}

GirthRun Smoothed(const GirthRun& run) {
  GirthRun smooth = run;
  for (std::size_t k = 1; k + 1 < run.size(); ++k) {
    smooth[k].tape = (run[k - 1].tape + 2.0 * run[k].tape + run[k + 1].tape) / 4.0;
  }
  return smooth;
}

}  // namespace

std::vector<GirthRun> GirthRuns(const MeasuredSurface& body, const TaskContext& context) {
  std::vector<GirthRun> runs;
  const SectionSampler sampler(body.surface(), EvenDirections(kCurvePoints));
  const double top = body.surface().z_max();
  const auto steps = static_cast<std::size_t>((top - body.surface().z_min()) / kGirthStep);
  for (std::size_t k = 0; k <= steps; ++k) {
    const double z = top - static_cast<double>(k) * kGirthStep;
    if (IsKnownAllAround(body, z)) {
      if (runs.empty() || runs.back().back().z - z > kLongestGap) runs.emplace_back();
      Append(GirthOf(body, sampler, z), runs.back());
    }
    context.Report("finding levels", static_cast<double>(k), static_cast<double>(steps));
  }
  for (GirthRun& run : runs) run = Smoothed(run);
  return runs;
}

std::size_t IndexBelow(const GirthRun& run, std::size_t from, double distance) {
  return std::min(run.size() - 1, from + static_cast<std::size_t>(distance / kGirthStep));
}

std::vector<double> SeenDirections(const MeasuredSurface& body, double z, double half, std::size_t count) {
  const std::vector<double> all = EvenDirections(count);
  std::vector<double> seen;
  for (const double theta : all) {
    bool measured = true;
    for (double at = z - half; measured && at <= z + half; at += kGirthStep) {
      measured = body.KnowledgeAt(theta, at) == Knowledge::kMeasured;
    }
    if (measured) seen.push_back(theta);
  }
  if (static_cast<double>(seen.size()) < kSeenShare * static_cast<double>(count)) return all;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double next = k + 1 < seen.size() ? seen[k + 1] : seen.front() + kTwoPi;
    if (next - seen[k] > kWidestGap) return all;
  }
  return seen;
}

}  // namespace annulus
