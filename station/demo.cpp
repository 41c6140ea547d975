#include "station/demo.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "acquisition/recording.h"
#include "modeling/exchange/model_json.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/glasses/frame_library.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/measure/section.h"
#include "render/plot.h"
#include "render/png.h"
#include "station/command_io.h"
#include "station/files.h"
#include "station/fit_scan.h"
#include "station/glasses_fit_report.h"
#include "station/measurement_output.h"
#include "station/pictures.h"
#include "station/report.h"
#include "station/sim_subject.h"
#include "station/worn_glasses.h"

namespace annulus {
namespace {

constexpr const char* kStyle = "boston";
constexpr double kExaggeration = 20.0;  // of differences in section plots

/// Share of the time that each step of one subject takes, measured; for the time left.
struct Step {
  const char* name;
  double weight;
};
constexpr Step kScanStep{"scan", 3.0};
constexpr Step kFitStep{"fit the surface", 4.0};
constexpr Step kMeasureStep{"measure", 1.0};
constexpr Step kPictureStep{"draw", 2.0};
constexpr double kSubjectWeight = kScanStep.weight + kFitStep.weight + kMeasureStep.weight + kPictureStep.weight;

/// Turns the progress of steps into progress of the whole demo.
class DemoProgress {
 public:
  DemoProgress(const TaskContext& task, std::size_t subjects)
      : task_(task), total_(kSubjectWeight * static_cast<double>(subjects)) {}

  /// The context of the next step; the step before has ended. Valid as long as this object.
  TaskContext Begin(const std::string& subject, const Step& step) {
    before_ += weight_;
    weight_ = step.weight;
    share_ = 0.0;
    stage_ = subject + ": " + step.name;
    Show();
    TaskContext context;
    context.stop = task_.stop;
    context.progress = [this](std::string_view, double done, double total) {
      // Steps have stages of their own that begin at 0 again; the whole only grows.
      if (total > 0.0) share_ = std::max(share_, std::clamp(done / total, 0.0, 1.0));
      Show();
    };
    return context;
  }
  void End() { task_.Report("done", 100.0, 100.0); }

 private:
  void Show() const { task_.Report(stage_, 100.0 * (before_ + share_ * weight_) / total_, 100.0); }

  const TaskContext& task_;
  double total_;
  double before_ = 0.0;
  double weight_ = 0.0;
  double share_ = 0.0;
  std::string stage_;
};

/// Shares of the cells of the main surface.
KnowledgeShares SharesOf(const SurfaceModel& model) {
  const KnowledgeMap& map = model.main().knowledge;
  std::array<double, 3> cells{};
  for (std::size_t row = 0; row < map.rows(); ++row) {
    for (std::size_t column = 0; column < map.columns(); ++column) {
      cells[static_cast<std::size_t>(map.Cell(column, row))] += 1.0;
    }
  }
  const double all = std::max(1.0, static_cast<double>(map.rows() * map.columns()));
  return {cells[2] / all, cells[1] / all, cells[0] / all};
}

/// The image alone: nothing else of a picture is told of.
Result<RgbImage> ImageOf(Result<Picture> picture) {
  if (!picture) return Fail(picture);
  return std::move(picture->image);
}

/// The chain on one subject; steps in the order of Run.
class SubjectRun {
 public:
  SubjectRun(const DemoOptions& options, const std::string& subject, Storage& storage, DemoProgress& progress)
      : options_(options), storage_(storage), progress_(progress), truth_(BareSubject(subject)) {
    result_.name = subject;
    result_.title = subject == "body" ? "Standing person" : "Head";
  }

  Result<DemoSubject> Run() {
    RETURN_IF_ERROR(Scan());
    RETURN_IF_ERROR(Fit());
    RETURN_IF_ERROR(Measure());
    RETURN_IF_ERROR(Draw());
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::string NameOf(const std::string& suffix) const { return result_.name + suffix; }
  [[nodiscard]] std::string PathOf(const std::string& name) const { return options_.folder + "/" + name; }
  Status Write(const std::string& name, const std::string& text, const std::string& purpose) {
    result_.files.push_back({name, purpose});
    return WriteFileAtomically(storage_, PathOf(name), text);
  }
  Status AddPicture(const std::string& name, const Result<RgbImage>& image, const std::string& caption);

  Status Scan();
  Status Fit();
  Status Measure();
  Status PutGlassesOn(const MeasuredSurface& surface);
  Status Draw();
  Status DrawBody(const TaskContext& task);
  Status DrawGlasses(const TaskContext& task);
  Status DrawSections();

  const DemoOptions& options_;
  Storage& storage_;
  DemoProgress& progress_;
  sim::ParametricBody truth_;
  DemoSubject result_;
  ScanFit fit_;
};

Status SubjectRun::AddPicture(const std::string& name, const Result<RgbImage>& image, const std::string& caption) {
  if (!image) return Fail(image);
  auto png = EncodePng(*image);
  if (!png) return Fail(png);
  RETURN_IF_ERROR(WriteFileAtomically(storage_, PathOf(name), std::span<const std::byte>(*png)));
  result_.files.push_back({name, caption});
  result_.pictures.push_back({name, caption, std::move(*png)});
  return {};
}

Status SubjectRun::Scan() {
  const TaskContext task = progress_.Begin(result_.name, kScanStep);
  Config config = SimulatedConfig();
  config.sim.subject = result_.name;
  config.sim.seed = options_.seed;
  const ScanRequest request{result_.name, PathOf(NameOf(".mcap")), "", ""};
  auto outcome = RunScanJob(config, request, storage_, task);
  if (!outcome) return Fail(outcome);
  if (outcome->summary.cancelled) return tl::unexpected(InterruptedError("run the demo"));
  result_.scan = std::move(*outcome);
  result_.files.push_back({NameOf(".mcap"), "recording: every range that the ring measured"});
  return {};
}

Status SubjectRun::Fit() {
  const TaskContext task = progress_.Begin(result_.name, kFitStep);
  const auto scan = ReadRecording(storage_, PathOf(NameOf(".mcap")));
  if (!scan) return Fail(scan);
  auto fit = FitScans({*scan}, FitOptions{}, task);
  if (!fit) return Fail(fit);
  fit_ = std::move(*fit);
  result_.fit = fit_.fit.summary;
  result_.shares = SharesOf(fit_.fit.model);
  return Write(NameOf(".json"), ModelToJson(fit_.fit.model), "the fitted surface with its uncertainty");
}

Status SubjectRun::Measure() {
  const TaskContext task = progress_.Begin(result_.name, kMeasureStep);
  const auto surface = MeasuredSurface::FromModel(fit_.fit.model);
  if (!surface) return Fail(surface);
  auto table = MeasureTable(*surface, FindLandmarks(*surface, task));
  if (!table) return Fail(table);
  result_.table = std::move(*table);
  auto comparisons = CompareWithTruth(*surface, result_.table, truth_);
  if (!comparisons) return Fail(comparisons);
  result_.comparisons = std::move(*comparisons);
  RETURN_IF_ERROR(Write(NameOf("_measurements.csv"), MeasurementsToCsv(result_.table), "measurement table"));
  RETURN_IF_ERROR(Write(NameOf("_measurements.json"), MeasurementsToJson(result_.table).dump(1) + "\n",
                        "measurement table with definitions"));
  return result_.name == "head" ? PutGlassesOn(*surface) : Status{};
}

Status SubjectRun::PutGlassesOn(const MeasuredSurface& surface) {
  const auto style = BuiltInFrameLibrary().Find(kStyle);
  if (!style) return Fail(style);
  const LibraryStyle& start = **style;
  GlassesFitOptions options;
  options.size = FitSize::kMadeToMeasure;
  auto fit = FitGlasses(surface, start.design, options);
  if (!fit) return Fail(fit);
  const auto stl = FrameStl(fit->worn);
  if (!stl) return Fail(stl);
  WornFile worn{fit->worn, start.material, {}};
  worn.SetSection("fit", FitReport(*fit).dump());
  RETURN_IF_ERROR(Write("frame.json", FrameToJson({start.design, start.material, {}}), "the frame's design"));
  RETURN_IF_ERROR(Write("worn.json", WornFileToJson(worn), "the frame made to this head's measure"));
  result_.glasses = DemoGlasses{kStyle, std::move(*fit)};
  return Write("frame.stl", *stl, "the frame as closed solids, for making it");
}

Status SubjectRun::DrawBody(const TaskContext& task) {
  PictureStudio studio(fit_.fit.model);
  PictureOptions picture;
  picture.size = 900;
  for (const auto& [name, caption] : {std::pair{"front", "From the front"}, std::pair{"left45", "From 45° left"}}) {
    const auto view = ParseView(name);
    if (!view) return Fail(view);
    picture.view = *view;
    RETURN_IF_ERROR(AddPicture(NameOf(std::string("_") + name + ".png"),
                               ImageOf(studio.Take(nullptr, "", picture, task)), caption));
  }
  return {};
}

Status SubjectRun::DrawGlasses(const TaskContext& task) {
  PictureStudio studio(fit_.fit.model);
  const WornFrame& frame = result_.glasses->fit.worn;
  const auto built = BuildWornFrame(frame);
  if (!built) return Fail(built);
  const GlassesSource worn{{frame.design, {}, frame.adjustment}, WornFile{frame, {}, {}}, *built};
  PictureOptions picture;
  picture.size = 720;
  for (const auto& [name, caption] : {std::pair{"front", "Glasses worn, from the front"},
                                      std::pair{"left45", "From 45° left"}, std::pair{"right45", "From 45° right"}}) {
    const auto view = ParseView(name);
    if (!view) return Fail(view);
    picture.view = *view;
    RETURN_IF_ERROR(AddPicture(NameOf(std::string("_") + name + ".png"),
                               ImageOf(studio.Take(&worn, "the demo's glasses", picture, task)), caption));
  }
  return {};
}

Status SubjectRun::DrawSections() {
  const auto surface = MeasuredSurface::FromModel(fit_.fit.model);
  if (!surface) return Fail(surface);
  for (const sim::NamedLevel& level : truth_.levels()) {
    auto measured = SectionCurve(*surface, level.z_mm, 720);
    if (!measured) return Fail(measured);
    SectionPlotStyle style;
    style.title = fmt::format("{} at z = {:.0f} mm", level.id, level.z_mm);
    std::vector<Eigen::Vector2d> outline = TrueOutline(truth_, level.z_mm);
    std::vector<Eigen::Vector2d> difference = Exaggerated(*measured, outline, kExaggeration);
    const std::vector<SectionSeries> series{
        {std::move(difference), fmt::format("difference x {:g}", kExaggeration), LinearFromHex(0x8fb8d8)},
        {std::move(outline), "true", LinearFromHex(0x9aa0a8)},
        {std::move(*measured), "surface", LinearFromHex(0xc2410c)}};
    RETURN_IF_ERROR(AddPicture(NameOf("_section_" + level.id + ".png"), RenderSectionPlot(series, style),
                               "Section at the " + level.id + " level, surface against truth"));
  }
  return {};
}

Status SubjectRun::Draw() {
  const TaskContext task = progress_.Begin(result_.name, kPictureStep);
  RETURN_IF_ERROR(result_.glasses ? DrawGlasses(task) : DrawBody(task));
  RETURN_IF_ERROR(AddPicture(NameOf("_residuals.png"), ResidualImage(fit_),
                             "Where returns and surface differ; grey: no return was used"));
  return DrawSections();
}

}  // namespace

Result<DemoResult> RunDemo(const DemoOptions& options, Storage& storage, const TaskContext& task) {
  RETURN_IF_ERROR(storage.CreateFolder(options.folder));
  DemoProgress progress(task, options.subjects.size());
  DemoResult result;
  result.seed = options.seed;
  for (const std::string& subject : options.subjects) {
    auto done = SubjectRun(options, subject, storage, progress).Run();
    if (!done) return Fail(done);
    result.subjects.push_back(std::move(*done));
    if (task.stop.stop_requested()) return tl::unexpected(InterruptedError("run the demo"));
  }
  RETURN_IF_ERROR(WriteFileAtomically(storage, options.folder + "/report.html", RenderReport(result)));
  progress.End();
  return result;
}

}  // namespace annulus
