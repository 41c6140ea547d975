#include "fitting/paper_fit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "fitting/cell_grid.h"
#include "fitting/ring_table.h"

namespace annulus {
namespace {

constexpr double kSmallestNoise = 1e-3;    // mm; a scan without noise is fitted as if it had this much
constexpr double kWidestGap = kTwoPi / 6;  // rad; wider is not "all around"
constexpr double kBridgedWeight = 1e-3;    // of a value that a section has by bridging a hole
constexpr std::size_t kFewest = 2 * (2 * kLocalCubicHalfWidth + 1);  // levels and sensors: two windows of eq. 2.5

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The part of the scan that is fitted.
struct Trunk {
  RingTable table;
  std::vector<char> complete;
  RowRange rows;
  double noise = 0.0;  ///< mm

  [[nodiscard]] std::vector<double> Heights(const RowRange& range) const {
    return {table.z.begin() + static_cast<std::ptrdiff_t>(range.begin),
            table.z.begin() + static_cast<std::ptrdiff_t>(range.end)};
  }
  [[nodiscard]] CurveSamples Section(std::size_t row) const {
    const auto at = static_cast<Eigen::Index>(row);
    const Eigen::VectorXd radius = table.radius.row(at);
    const Eigen::VectorXd weight = table.weight.row(at);
    return {table.theta, {radius.begin(), radius.end()}, {weight.begin(), weight.end()}, kTwoPi};
  }
};

Error TooFewLevels(std::size_t levels, std::size_t sensors) {
  return {"fit a surface by the paper's method",
          "the ring saw all around on " + std::to_string(levels) + " levels in sequence, with " +
              std::to_string(sensors) + " sensors",
          "it needs " + std::to_string(kFewest) + " of each: use --method adaptive, or scan more"};
}

Result<Trunk> FindTrunk(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                        std::span<const SampleVerdict> verdicts) {
  Trunk trunk;
  trunk.table = BuildRingTable(samples, grid, verdicts);
  trunk.complete = CompleteRows(trunk.table, kWidestGap);
  trunk.rows = LongestRange(trunk.complete, 2 * kLocalCubicHalfWidth);
  trunk.noise = std::max(kSmallestNoise, EstimateNoise(samples, grid, verdicts));
  const std::size_t levels = trunk.rows.end - trunk.rows.begin;
  if (levels >= kFewest && trunk.table.theta.size() >= kFewest) return trunk;
  return tl::unexpected(TooFewLevels(levels, trunk.table.theta.size()));
}

/// A section with what is needed to place knots on it.
struct RatedSection {
  PaperSection section;
  std::vector<FeaturePoint> features;
  PaperDirection direction;  ///< Place, complexity, noise; the rest still empty.
};

RatedSection Rate(CurveSamples samples, double place, double noise) {
  RatedSection rated;
  rated.section.slopes = EstimateSlopes(samples);
  rated.section.samples = std::move(samples);
  rated.features = FindFeatures(rated.section.samples, rated.section.slopes, noise);
  rated.direction.place = place;
  rated.direction.complexity = MeasureComplexity(rated.section.samples, rated.section.slopes, rated.features);
  rated.direction.noise_sd = noise;
  rated.direction.gate = SignificanceGate(rated.section.samples.size());
  return rated;
}

void KeepMoreComplex(std::optional<RatedSection>& best, RatedSection candidate) {
  if (!best || best->direction.complexity < candidate.direction.complexity) best = std::move(candidate);
}

RatedSection MostComplexSection(const Trunk& trunk) {
  std::optional<RatedSection> best;
  for (std::size_t row = trunk.rows.begin; row < trunk.rows.end; ++row) {
    if (trunk.complete[row] != 0) KeepMoreComplex(best, Rate(trunk.Section(row), trunk.table.z[row], trunk.noise));
  }
  return *best;
}

/// Knots, lambda and Ceres' move for the chosen section; `rated` with its direction filled in.
Result<PaperDirection> FindKnots(const RatedSection& rated, const KnotRules& rules) {
  const CurveSamples& samples = rated.section.samples;
  PaperDirection direction = rated.direction;
  const KnotPlan plan = PlaceKnots(samples, rated.section.slopes, rated.features, rules);
  direction.lambda = ChooseLambda(KnotSplineBasis(plan.knots, plan.period), samples);
  auto move = MoveKnots(samples, plan, direction.lambda, rules);
  if (!move) return Fail(move);
  direction.plan = std::move(move->plan);
  direction.cost_by_rule = move->cost_start;
  direction.cost_moved = move->cost_end;
  direction.iterations = move->iterations;
  const CurveFitter fitter(KnotSplineBasis(direction.plan.knots, direction.plan.period), samples.x, direction.lambda);
  direction.effective = fitter.EffectiveParameters(samples.weight);
  return direction;
}

/// f(theta_i) of every level (eq. 2.3 with the same knots), as one column per knot, with weights.
struct KnotLines {
  RowRange rows;  ///< Of the table.
  Eigen::MatrixXd radius;
  Eigen::MatrixXd weight;     ///< A whole row of 0 where a level is not used.
  std::vector<double> noise;  ///< Per knot, sd of f(theta_i), mm.
  std::size_t folded = 0;     ///< Levels of weight 0 because their section turns back on itself.
};

/// 1 where both sensors beside a knot saw the level, less where one or none did.
double WeightAt(const Trunk& trunk, Eigen::Index row, double theta) {
  const std::vector<double>& columns = trunk.table.theta;
  const double wrapped = WrapAngle(theta - columns.front()) + columns.front();
  const auto above =
      static_cast<std::size_t>(std::upper_bound(columns.begin(), columns.end(), wrapped) - columns.begin());
  double seen = 0.0;
  for (const std::size_t column : {above - 1, above % columns.size()}) {
    if (trunk.table.weight(row, static_cast<Eigen::Index>(column)) > 0.0) seen += 0.5;
  }
  return std::max(kBridgedWeight, seen);
}

/// f(theta_i) of every level that can be fitted (eq. 2.3).
KnotLines FitSections(const Trunk& trunk, const PaperDirection& around) {
  const std::vector<double>& knots = around.plan.knots;
  CurveFitter fitter(KnotSplineBasis(knots, kTwoPi), trunk.table.theta, around.lambda);
  const auto rows = static_cast<Eigen::Index>(trunk.rows.end - trunk.rows.begin);
  KnotLines lines{trunk.rows, Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(knots.size())), {}, {}, 0};
  lines.weight = lines.radius;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const std::size_t row = trunk.rows.begin + static_cast<std::size_t>(k);
    const CurveSamples section = trunk.Section(row);
    const auto fit = fitter.Fit(section.value, section.weight);
    if (!fit) continue;  // a level that determines nothing
    for (std::size_t i = 0; i < knots.size(); ++i) {
      lines.radius(k, static_cast<Eigen::Index>(i)) = fitter.basis().Value(fit->coefficients, knots[i]);
      lines.weight(k, static_cast<Eigen::Index>(i)) = WeightAt(trunk, static_cast<Eigen::Index>(row), knots[i]);
    }
  }
  for (const double knot : knots) lines.noise.push_back(trunk.noise * fitter.NoiseGain(knot));
  return lines;
}

/// Leaves out levels whose own closed curve (eqs. 2.8, 2.9) turns back on itself: a step of the radius too sharp for
/// the knots. Few in sequence count as a hole; more of them end the range.
KnotLines WithoutFoldedLevels(const Trunk& trunk, KnotLines lines, const std::vector<double>& theta) {
  std::vector<char> sound(trunk.complete.size(), 0);
  std::vector<char> folds;  // one per row of the lines
  for (Eigen::Index k = 0; k < lines.radius.rows(); ++k) {
    const std::size_t row = lines.rows.begin + static_cast<std::size_t>(k);
    const Eigen::MatrixXd control = ClosedControlPoints(SectionPoints(theta, lines.radius.row(k)));
    folds.push_back(TurnsBack(control) ? 1 : 0);
    if (folds.back() != 0) lines.weight.row(k).setZero();
    sound[row] = folds.back() == 0 ? trunk.complete[row] : 0;
  }
  const RowRange range = LongestRange(sound, 2 * kLocalCubicHalfWidth);
  const std::size_t skipped = range.end > 0 ? range.begin - lines.rows.begin : 0;
  const auto first = static_cast<Eigen::Index>(skipped);
  const auto count = static_cast<Eigen::Index>(range.end - range.begin);
  const auto folded = std::count(folds.begin() + first, folds.begin() + first + count, 1);
  return {range, lines.radius.middleRows(first, count), lines.weight.middleRows(first, count), std::move(lines.noise),
          static_cast<std::size_t>(folded)};
}

/// The longitudinal section at knot line `i`, without the bridged values.
CurveSamples Longitudinal(const std::vector<double>& z, const KnotLines& lines, Eigen::Index i) {
  const Eigen::VectorXd radius = lines.radius.col(i);
  Eigen::VectorXd weight = lines.weight.col(i);
  weight = (weight.array() <= kBridgedWeight).select(0.0, weight);
  return {z, {radius.begin(), radius.end()}, {weight.begin(), weight.end()}, 0.0};
}

RatedSection MostComplexLongitudinal(const std::vector<double>& z, const KnotLines& lines,
                                     const std::vector<double>& theta) {
  std::optional<RatedSection> best;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    KeepMoreComplex(best, Rate(Longitudinal(z, lines, static_cast<Eigen::Index>(i)), theta[i], lines.noise[i]));
  }
  return *best;
}

/// f(theta_i, z_j) (eq. 2.12) at every knot: one row per z_j.
Result<Eigen::MatrixXd> FitLongitudinals(const std::vector<double>& z, const KnotLines& lines,
                                         const PaperDirection& along) {
  const std::vector<double>& knots = along.plan.knots;
  CurveFitter fitter(KnotSplineBasis(knots, 0.0), z, along.lambda);
  Eigen::MatrixXd radius(static_cast<Eigen::Index>(knots.size()), lines.radius.cols());
  for (Eigen::Index i = 0; i < radius.cols(); ++i) {
    const Eigen::VectorXd values = lines.radius.col(i);
    const Eigen::VectorXd weights = lines.weight.col(i);
    const auto fit = fitter.Fit({values.data(), z.size()}, {weights.data(), z.size()});
    if (!fit) return Fail(fit);
    for (std::size_t j = 0; j < knots.size(); ++j) {
      radius(static_cast<Eigen::Index>(j), i) = fitter.basis().Value(fit->coefficients, knots[j]);
    }
  }
  return radius;
}

struct Built {
  PaperModel model;
  PaperSections sections;
};

Result<Built> Build(const Trunk& trunk, const RatedSection& section, const KnotRules& rules) {
  auto around = FindKnots(section, rules);
  if (!around) return Fail(around);
  const std::vector<double>& theta = around->plan.knots;
  const KnotLines lines = WithoutFoldedLevels(trunk, FitSections(trunk, *around), theta);
  const std::size_t levels = lines.rows.end - lines.rows.begin;
  if (levels < kFewest) return tl::unexpected(TooFewLevels(levels, trunk.table.theta.size()));
  const std::vector<double> z = trunk.Heights(lines.rows);
  const RatedSection longitudinal = MostComplexLongitudinal(z, lines, theta);
  auto along = FindKnots(longitudinal, rules);
  if (!along) return Fail(along);
  const auto radius = FitLongitudinals(z, lines, *along);
  if (!radius) return Fail(radius);
  auto surface = PaperSurface::Through(theta, along->plan.knots, *radius);
  if (!surface) return Fail(surface);
  PaperFitReport report{std::move(*around), std::move(*along), levels, trunk.table.z.size() - levels, lines.folded};
  return Built{{std::move(*surface), std::move(report)}, {section.section, longitudinal.section}};
}

/// Levels of which the fit makes use.
std::size_t LevelsUsed(const Built& built) { return built.model.report.levels - built.model.report.levels_folded; }

/// The loosest rules under which all levels can be used; if none are, those under which most can.
Result<Built> BuildByEverStricterRules(const Trunk& trunk, const RatedSection& section) {
  // The end rule Q0 = Q1 alone takes the slope at the ends of z to 0.63.
  constexpr std::array<double, 3> kStricter{0.4, 0.5, 0.6};
  const std::size_t all = trunk.rows.end - trunk.rows.begin;
  KnotRules rules;
  Result<Built> best = Build(trunk, section, rules);
  for (const double least_slope : kStricter) {
    if (best && LevelsUsed(*best) == all) break;
    rules.least_slope = least_slope;
    auto built = Build(trunk, section, rules);
    if (built && !(best && LevelsUsed(*best) >= LevelsUsed(*built))) best = std::move(built);
  }
  return best;
}

/// Good samples of the fitted levels stay good; the others are left out.
std::vector<SampleVerdict> Within(std::span<const SurfaceSample> samples, std::vector<SampleVerdict> verdicts,
                                  const PaperModel& paper) {
  const double low = paper.surface.z_min();
  const double high = paper.surface.z_max();
  const double half_pitch = 0.5 * (high - low) / static_cast<double>(paper.report.levels - 1);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const bool inside = samples[k].z > low - half_pitch && samples[k].z < high + half_pitch;
    if (verdicts[k] == SampleVerdict::kGood && !inside) verdicts[k] = SampleVerdict::kOutlier;
  }
  return verdicts;
}

void FillSummary(std::span<const SurfaceSample> samples, Screening& screening,
                 const std::vector<SampleVerdict>& verdicts, const PaperModel& paper, FitSummary& summary) {
  summary.termination = "surface of " + std::to_string(paper.surface.theta_knots().size()) + " x " +
                        std::to_string(paper.surface.z_knots().size()) + " knots";
  summary.samples = samples.size();
  double squares = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (screening.verdicts[k] != SampleVerdict::kGood) summary.rejected.push_back({k, screening.verdicts[k]});
    summary.segment_of_sample.push_back(verdicts[k] == SampleVerdict::kGood ? 0 : FitSummary::kNoSegment);
    if (verdicts[k] != SampleVerdict::kGood) continue;
    ++summary.used;
    const double miss = samples[k].radius - paper.surface.Radius(samples[k].theta, samples[k].z);
    squares += miss * miss;
  }
  summary.foreground = std::move(screening.foreground);
  summary.coefficients = paper.surface.control().size();
  summary.effective_parameters = paper.report.around.effective * paper.report.along.effective;
  const auto used = static_cast<double>(summary.used);
  summary.rms_mm = std::sqrt(squares / std::max(1.0, used));
  summary.noise_sigma_mm = std::sqrt(squares / std::max(1.0, used - summary.effective_parameters));
  summary.lambda_theta = paper.report.around.lambda;
  summary.lambda_z = paper.report.along.lambda;
  summary.cost_start = paper.report.around.cost_by_rule;
  summary.cost_end = paper.report.around.cost_moved;
  summary.iterations = paper.report.around.iterations + paper.report.along.iterations;
}

}  // namespace

Result<FitResult> FitPaper(std::span<const SurfaceSample> samples, const FitOptions& options,
                           const TaskContext& context) {
  const auto start = std::chrono::steady_clock::now();
  FitResult result;
  FitTimes& times = result.summary.times;
  context.Report("screening", 0.0, 1.0);
  const SampleGrid grid(samples);
  Screening screening = ScreenSamples(samples, grid, options.screening);
  const auto trunk = FindTrunk(samples, grid, screening.verdicts);
  if (!trunk) return Fail(trunk);
  times.screening_s = SecondsSince(start);

  context.Report("fitting", 0.2, 1.0);
  auto built = BuildByEverStricterRules(*trunk, MostComplexSection(*trunk));
  if (!built) return Fail(built);
  times.solve_s = SecondsSince(start) - times.screening_s;

  context.Report("fitting", 0.7, 1.0);
  const auto paper = std::make_shared<const PaperModel>(std::move(built->model));
  const std::vector<SampleVerdict> verdicts = Within(samples, screening.verdicts, *paper);
  FillSummary(samples, screening, verdicts, *paper, result.summary);
  result.summary.paper = std::move(built->sections);
  TensorApproximation tensor = ApproximateByTensor(paper->surface);
  result.summary.paper->tensor_error = tensor.largest_error;
  SurfaceSegment segment{"body", std::move(tensor.surface), KnowledgeMap(), {}, {}, {}, paper};
  segment.knowledge = BuildKnowledge(CellGrid(samples, grid, verdicts), segment.surface);
  times.total_s = SecondsSince(start);
  times.knowledge_s = times.total_s - times.screening_s - times.solve_s;
  result.model.segments.push_back(std::move(segment));
  result.model.noise_sigma_mm = result.summary.noise_sigma_mm;
  result.model.provenance.method = "paper";
  context.Report("fitting", 1.0, 1.0);
  return result;
}

}  // namespace annulus
