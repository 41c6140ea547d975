#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/csv_scan.h"
#include "fitting/fit_surface.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/measure/closest_point.h"
#include "modeling/measure/curvature.h"
#include "modeling/measure/geodesic.h"
#include "modeling/measure/plane_cut.h"
#include "modeling/measure/region.h"
#include "modeling/measure/section.h"
#include "modeling/measure/section_svg.h"
#include "modeling/measure/slab.h"
#include "modeling/measure/surface_cursor.h"
#include "modeling/measure/systematic.h"
#include "modeling/measure/taut_tape.h"
#include "modeling/table/table.h"
#include "tests/bench/bench_scan.h"

// Queries of one fitted model that is loaded: what a person waits for. No single one may take more than 20 ms.

namespace annulus::bench {
namespace {

/// A fitted model and its measured surface, which borrows it.
struct QueryBody {
  std::unique_ptr<const SurfaceModel> model;
  Result<MeasuredSurface> body;

  [[nodiscard]] const SplineSurface& surface() const { return body->surface(); }
  /// The height at a share of the range, mm.
  [[nodiscard]] double HeightAt(double share) const {
    return surface().z_min() + share * (surface().z_max() - surface().z_min());
  }
};

/// A fit of the shared scan `name`; of a tube if `name` is "tube". Says why where there is none.
Result<QueryBody> FitBody(const std::string& name) {
  std::vector<SurfaceSample> samples;
  if (name == "tube") {
    samples = BuildSamples(TubeScan(360));
  } else {
    const std::string path = DataPath(name + "_noisy.csv.gz");
    PosixStorage storage;
    const Result<Scan> scan =
        path.empty() ? Fail("find " + name, "no data", "set ANNULUS_DATA") : ReadCsvScan(storage, path);
    if (!scan) return Fail(scan);
    samples = BuildSamples(*scan);
  }
  auto fit = FitSurface(samples, {}, {});
  if (!fit) return Fail(fit);
  auto model = std::make_unique<const SurfaceModel>(std::move(fit->model));
  auto body = MeasuredSurface::FromModel(*model);
  if (!body) return Fail(body);
  return QueryBody{std::move(model), std::move(body)};
}

template <class Query>
void Run(benchmark::State& state, const QueryBody& body, const Query& query) {
  if (const auto tried = query(body); !tried) {
    state.SkipWithError(tried.error().Text().c_str());
    return;
  }
  for (auto unused : state) benchmark::DoNotOptimize(query(body));
  state.counters["coefficients"] = static_cast<double>(body.surface().coefficients().size());
}

/// Systematic errors of a calibrated ring and of a swaying person.
SystematicErrors Errors() {
  return {CalibrationErrors{OffsetCovariance(180, 0.2, 0.3), 1e-4, 0.2}, SwayErrors{2.0, 3.0, 100.0}};
}

Result<SystematicSigmas> SystematicOfSlab(const QueryBody& b) {
  const auto slab = SlabBetween(*b.body, b.HeightAt(0.4), b.HeightAt(0.6));
  if (!slab) return Fail(slab);
  return SigmasFrom(Errors(), *b.body, slab->volume);
}

/// The whole table with its landmarks: what a customer waits for.
Result<MeasurementTable> WholeTable(const QueryBody& b) { return MeasureTable(*b.body, FindLandmarks(*b.body, {})); }

/// Two places on the front and the left side, between which distances are taken.
SurfacePlace FrontOf(const QueryBody& b) { return {1.3, b.HeightAt(0.62)}; }
SurfacePlace SideOf(const QueryBody& b) { return {2.6, b.HeightAt(0.45)}; }

/// A patch of the front, cut by two planes.
Result<RegionEstimates> PatchOfFront(const QueryBody& b) {
  return RegionBetween(
      *b.body, {{1.2, b.HeightAt(0.5)}, {1.9, b.HeightAt(0.5)}, {1.55, b.HeightAt(0.52)}, {1.55, b.HeightAt(0.48)}});
}

/// One row per query and body. A query returns a Result; a new one is a line more.
[[maybe_unused]] const bool registered = [] {
  for (const std::string name : {"tube", "head_leeperrysmith", "torso_mean_female", "body_mean_female"}) {
    // Fitted when the first of its rows runs, and kept for the others.
    const auto body = std::make_shared<std::unique_ptr<Result<QueryBody>>>();
    const auto add = [&](const std::string& query_name, auto query) {
      const auto run = [body, name, query](benchmark::State& state) {
        if (*body == nullptr) *body = std::make_unique<Result<QueryBody>>(FitBody(name));
        const Result<QueryBody>& fitted = **body;
        if (!fitted) return state.SkipWithError(fitted.error().Text().c_str());
        Run(state, *fitted, query);
      };
      benchmark::RegisterBenchmark((query_name + "/" + name).c_str(), run)
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    };
    add("MeasureSection", [](const QueryBody& b) { return MeasureSection(*b.body, b.HeightAt(0.5)); });
    add("SectionSvg", [](const QueryBody& b) { return SectionSvg(*b.body, b.HeightAt(0.5), {}); });
    add("MeasureSlab", [](const QueryBody& b) { return MeasureSlab(*b.body, b.HeightAt(0.4), b.HeightAt(0.6)); });
    add("SystematicOfSlab", SystematicOfSlab);
    add("MeridianLength",
        [](const QueryBody& b) { return MeridianLength(*b.body, 0.5 * kPi, b.HeightAt(0.3), b.HeightAt(0.7)); });
    add("Curvature", [](const QueryBody& b) { return CurvatureAt(*b.body, {1.0, b.HeightAt(0.5)}); });
    add("NearestOutside", [](const QueryBody& b) {
      return NearestOnSurface(*b.body, {300.0, 200.0, b.HeightAt(0.5)});
    });
    add("NearestFromAxis", [](const QueryBody& b) { return NearestOnSurface(*b.body, {0.0, 0.0, b.HeightAt(0.5)}); });
    add("CursorStraight", [](const QueryBody& b) {
      return MoveCursorStraight(*b.body, {1.0, b.HeightAt(0.5)}, 0.3, 300.0);
    });
    add("CursorStep", [](const QueryBody& b) { return StepCursor(*b.body, {1.0, b.HeightAt(0.5)}, 1.0, 10.0); });
    add("Landmarks", [](const QueryBody& b) { return Result<Landmarks>(FindLandmarks(*b.body, {})); });
    add("TableWithLandmarks", WholeTable);
    add("DistanceByPlane", [](const QueryBody& b) {
      return DistanceByPlane(*b.body, FrontOf(b), {1.9, b.HeightAt(0.55)}, SideOf(b), CutMethod::kSpline);
    });
    add("Geodesic", [](const QueryBody& b) { return GeodesicDistance(*b.body, FrontOf(b), SideOf(b)); });
    add("TautTape", [](const QueryBody& b) { return TautTape(*b.body, FrontOf(b), SideOf(b)); });
    add("TautLoop", [](const QueryBody& b) { return TautLoop(*b.body, b.HeightAt(0.5)); });
    add("Region", PatchOfFront);
  }
  return true;
}();

}  // namespace
}  // namespace annulus::bench
