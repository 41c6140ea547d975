#include "modeling/elastic/elastic_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "modeling/elastic/elastic_loads.h"
#include "modeling/measure/section.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Result<std::size_t> SegmentOf(const SurfaceModel& model, const ElasticScript& script) {
  if (!script.segment) return std::size_t{0};
  std::string names;
  for (std::size_t k = 0; k < model.segments.size(); ++k) {
    if (model.segments[k].name == *script.segment) return k;
    names += (names.empty() ? "" : ", ") + model.segments[k].name;
  }
  return Fail("edit a model", "it has no segment '" + *script.segment + "', only " + names, "name one of them");
}

/// Perimeter and tape of horizontal sections; they do not depend on where the segment's axis is.
std::vector<SectionEstimates> SectionsOf(const SurfaceSegment& segment, const std::vector<double>& heights) {
  SurfaceModel alone;
  alone.segments.push_back(segment);
  alone.segments[0].normal_matrix.resize(0, 0);
  alone.segments[0].axis = {};
  alone.segments[0].paper = nullptr;
  std::vector<SectionEstimates> sections;
  const auto body = MeasuredSurface::FromModel(alone);
  for (const double z : heights) {
    SectionEstimates none;
    none.perimeter.value = none.tape.value = kNan;
    auto section = body ? SectionAt(*body, z) : Result<SectionEstimates>(Fail(body));
    sections.push_back(section ? std::move(*section) : std::move(none));
  }
  return sections;
}

std::vector<GirthChange> GirthsOf(const SurfaceSegment& before, const SurfaceSegment& after,
                                  const std::vector<double>& heights) {
  const std::vector<SectionEstimates> a = SectionsOf(before, heights);
  const std::vector<SectionEstimates> b = SectionsOf(after, heights);
  std::vector<GirthChange> girths;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    girths.push_back({heights[k], a[k].perimeter.value, b[k].perimeter.value, a[k].tape.value, b[k].tape.value});
  }
  return girths;
}

/// Where a bump can reach.
ThetaZBox BoxOf(const SurfaceSegment& segment, const SkinBump& bump) {
  const double radius = segment.surface.Radius(bump.theta, bump.z);
  // The axis may lean within the bump: some more.
  const double half = bump.radius < 0.7 * radius ? 1.3 * std::asin(bump.radius / radius) : kTwoPi / 2.0;
  return {bump.theta - half, bump.theta + half, bump.z - bump.radius, bump.z + bump.radius};
}

Result<ChangedSegment> FreeEdit(const SurfaceSegment& segment, const SkinBump& bump) {
  if (!(bump.z >= segment.surface.z_min() && bump.z <= segment.surface.z_max())) {
    return Fail("edit the surface freely", "z " + std::to_string(bump.z) + " mm is outside the segment",
                "give a place on the segment");
  }
  const Vector3d centre = segment.Point(bump.theta, bump.z);
  return GrowRadius(segment, BoxOf(segment, bump), [&](double theta, double z) -> std::optional<double> {
    return bump.outward * bump.ShareAt((segment.Point(theta, z) - centre).norm());
  });
}

/// Forces and movements of the loads.
std::vector<LoadResult> LoadsOf(const ElasticScript& script, const SurfaceSegment& segment, const ElasticRegion& region,
                                const ElasticSolution& solution) {
  std::vector<LoadResult> results;
  for (const BumpLoad& load : script.loads) {
    const Vector3d centre = segment.Point(load.bump.theta, load.bump.z);
    LoadResult result;
    double squares = 0.0;
    for (std::size_t stack = 0; stack < region.grid.shape.stacks(); ++stack) {
      const std::size_t node = region.SkinNode(stack);
      const double share = region.OnRim(stack) ? 0.0 : load.bump.ShareAt((region.grid.nodes[node] - centre).norm());
      if (!(share > 0.0)) continue;
      result.movement += share * region.area[stack] * solution.displacement[node].dot(region.normal[stack]);
      result.force += solution.inner[node].dot(region.normal[stack]);
      squares += share * share * region.area[stack];
    }
    result.movement /= squares;
    results.push_back(result);
  }
  return results;
}

/// What the threads of one band do together.
BandResult BandOf(const BandLoad& band, const ElasticProblem& problem, const ElasticOutcome& outcome,
                  std::pair<std::size_t, std::size_t> threads) {
  BandResult result;
  result.band = band;
  ContactPressure sum;
  const GridShape& shape = problem.grid.shape;
  for (std::size_t f = threads.first; f < threads.second; ++f) {
    std::vector<Vector3d> positions;
    for (const FibrePoint& point : problem.fibres[f].points) {
      Vector3d at = point.rest;
      if (point.stack != FibrePoint::kFixed) {
        at += (1.0 - point.upper) * outcome.solution.displacement[outcome.region.SkinNode(point.stack)] +
              point.upper * outcome.solution.displacement[outcome.region.SkinNode(point.stack + shape.columns)];
      }
      positions.push_back(at);
    }
    const ContactPressure one = ContactOf(problem.fibres[f], outcome.solution.fibres[f], positions);
    sum.force += one.force;
    sum.area += one.area;
    sum.largest = std::max(sum.largest, one.largest);
    result.tension += outcome.solution.fibres[f].tension;
  }
  result.pressure_largest = sum.largest;
  result.pressure_mean = sum.area > 0.0 ? sum.force / sum.area : 0.0;
  result.contact_area = sum.area;
  return result;
}

/// Refuses a shape that is none. Past a strain of about a half the layer's cells turn over, and no balance is found.
Status CheckBalance(const ElasticOutcome& outcome) {
  constexpr double kBalance = 1e-4;
  if (outcome.solution.residual <= kBalance) return {};
  const auto& strain = outcome.maps.smallest_strain;
  return Fail("find the shape of an elastic body",
              fmt::format("after {} steps {:.2g} of the forces were not in balance, the layer squeezed by {:.0f} %",
                          outcome.solution.steps, outcome.solution.residual,
                          -100.0 * *std::min_element(strain.begin(), strain.end())),
              "give a thicker layer, a looser band or smaller loads");
}

Result<ElasticOutcome> Solve(const SurfaceSegment& segment, const ElasticScript& script, const TaskContext& task) {
  auto region = MakeElasticRegion(segment, *script.region);
  if (!region) return Fail(region);
  ElasticProblem problem;
  problem.grid = region->grid;
  problem.material = script.material;
  problem.held = region->held;
  problem.given.assign(region->grid.nodes.size(), Vector3d::Zero());
  for (const BumpLoad& load : script.loads) RETURN_IF_ERROR(AddLoad(*region, segment, load, problem));
  std::vector<std::pair<std::size_t, std::size_t>> threads;
  for (const BandLoad& band : script.bands) {
    auto fibres = FibresOf(*region, segment, band);
    if (!fibres) return Fail(fibres);
    threads.emplace_back(problem.fibres.size(), problem.fibres.size() + fibres->size());
    for (BandFibre& fibre : *fibres) problem.fibres.push_back(std::move(fibre));
  }
  ElasticOptions options;
  options.method = script.method;
  auto solution = SolveElastic(problem, options, task);
  if (!solution) return Fail(solution);
  ElasticOutcome outcome{std::move(*region), std::move(*solution), {}, {}, {}, 0.0};
  outcome.maps = MapSkin(outcome.region, problem, outcome.solution);
  RETURN_IF_ERROR(CheckBalance(outcome));
  outcome.loads = LoadsOf(script, segment, outcome.region, outcome.solution);
  for (std::size_t b = 0; b < script.bands.size(); ++b) {
    outcome.bands.push_back(BandOf(script.bands[b], problem, outcome, threads[b]));
    const auto girth = GirthUnder(segment, script.bands[b]);
    outcome.bands.back().girth_before = girth ? *girth : kNan;
  }
  for (std::size_t stack = 0; stack < outcome.region.grid.shape.stacks(); ++stack) {
    outcome.largest_displacement =
        std::max(outcome.largest_displacement, outcome.solution.displacement[outcome.region.SkinNode(stack)].norm());
  }
  return outcome;
}

/// The displaced skin as the segment's surface.
Result<ChangedSegment> WriteBack(const SurfaceSegment& segment, const ElasticOutcome& outcome) {
  const ElasticRegion& region = outcome.region;
  std::vector<Vector3d> skin;
  for (std::size_t stack = 0; stack < region.grid.shape.stacks(); ++stack) {
    skin.push_back(outcome.solution.displacement[region.SkinNode(stack)]);
  }
  const DisplacedSkin displaced(segment, region, skin);
  const double turn =
      region.grid.shape.closure == GridClosure::kClosed ? kTwoPi : region.theta.back() - region.theta.front();
  return GrowRadius(segment, {region.theta.front(), region.theta.front() + turn, region.z.front(), region.z.back()},
                    [&](double theta, double z) { return displaced.Growth(theta, z); });
}

}  // namespace

Result<ElasticEdit> EditElastically(const SurfaceModel& model, const ElasticScript& script, const TaskContext& task) {
  const auto at = SegmentOf(model, script);
  if (!at) return Fail(at);
  ElasticEdit edit;
  edit.model = model;
  edit.segment = *at;
  SurfaceSegment& segment = edit.model.segments[*at];
  edit.volume_before = SegmentVolume(segment);
  for (const SkinBump& bump : script.edits) {
    if (task.stop.stop_requested()) return Fail("edit a model", "it was stopped", "start it again");
    auto changed = FreeEdit(segment, bump);
    if (!changed) return Fail(changed);
    segment = changed->segment;
    changed->segment.normal_matrix.resize(0, 0);
    edit.edits.push_back(std::move(*changed));
  }
  if (!(script.loads.empty() && script.bands.empty())) {
    auto outcome = Solve(segment, script, task);
    if (!outcome) return Fail(outcome);
    auto changed = WriteBack(segment, *outcome);
    if (!changed) return Fail(changed);
    segment = changed->segment;
    changed->segment.normal_matrix.resize(0, 0);
    edit.written = std::move(*changed);
    edit.elastic = std::move(*outcome);
    for (BandResult& band : edit.elastic->bands) {
      const auto girth = GirthUnder(segment, band.band);
      band.girth_after = girth ? *girth : kNan;
    }
  }
  edit.volume_after = SegmentVolume(segment);
  edit.girths = GirthsOf(model.segments[*at], segment, script.girths);
  edit.model.provenance.method += "+elastic";
  return edit;
}

}  // namespace annulus
