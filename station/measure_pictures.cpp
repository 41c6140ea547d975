#include "station/measure_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "modeling/landmarks/landmarks.h"
#include "modeling/table/table.h"
#include "station/clearance_map.h"
#include "station/difference_map.h"
#include "station/picture_parts.h"
#include "station/residual_map.h"
#include "station/sheet_figure.h"
#include "station/units_text.h"
#include "station/values_map.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "draw a map";
constexpr Eigen::Index kColumns = 360;  // of an unrolled map
const LinearRgb kPlainFrame = LinearFromHex(0x5a5a5c);

Status CheckOptions(const std::vector<PictureSubject>& subjects, const MeasurePictureOptions& options) {
  if (subjects.empty()) return Fail(kAttempted, "there is no model", "give one");
  if (options.size < 100 || options.size > 4096) {
    return Fail(kAttempted, "a size of " + std::to_string(options.size), "give 100 ... 4096 pixels");
  }
  if (options.range && !((*options.range)[0] < (*options.range)[1])) {
    return Fail(kAttempted, fmt::format("a range from {:g} to {:g}", (*options.range)[0], (*options.range)[1]),
                "give A,B with A < B");
  }
  return {};
}

Result<BodyField> FieldOf(MapKind kind, const PictureSubject& subject, const MapInput& input) {
  switch (kind) {
    case MapKind::kResidual:
      if (subject.samples == nullptr) return Fail(kAttempted, "residuals need the scan", "give it beside the model");
      return ResidualField(*subject.model, *subject.samples);
    case MapKind::kMeanCurvature:
    case MapKind::kGaussianCurvature:
    case MapKind::kLargestCurvature:
    case MapKind::kSmallestCurvature:
      return CurvatureField(*subject.body, kind);
    case MapKind::kAreaStrain:
    case MapKind::kLargestStrain:
    case MapKind::kSmallestStrain:
      if (!input.against) return Fail(kAttempted, "a strain needs a second model", "give it beside the first");
      return StrainField(*subject.body, *input.against->body, kind);
    case MapKind::kDifference:
      if (!input.against) return Fail(kAttempted, "a difference needs a second model", "give it beside the first");
      return DifferenceField(*subject.model, *subject.body, *input.against->model, *input.against->body);
    case MapKind::kKnowledge:
      return KnowledgeField(*subject.model);
    case MapKind::kSigma:
      return SigmaField(*subject.body);
    case MapKind::kValues:
      return ValuesField(*subject.model, input.values_csv, input.values_name);
    case MapKind::kClearance:
      break;
  }
  return Fail(kAttempted, "a clearance needs a worn frame", "give it beside the model");
}

/// The frame without values.
Result<std::vector<MapMesh>> PlainFrame(const WornFrame& worn) {
  const auto frame = BuildWornFrame(worn);
  if (!frame) return Fail(frame);
  std::vector<MapMesh> meshes;
  for (const SceneItem& item : FrameItems(*frame, worn.station_from_frame, {})) {
    meshes.push_back({item.mesh, item.normals, {}, {}, kPlainFrame});
  }
  return meshes;
}

/// The body without values.
std::vector<MapMesh> PlainBody(const SurfaceModel& model) {
  BodyField none;
  none.value = [](const BodyPlace&) { return 0.0; };
  std::vector<MapMesh> meshes = MapMeshes(model, none, BodyParts::kSeen);
  for (MapMesh& mesh : meshes) mesh.values.clear();
  return meshes;
}

Eigen::Index RowsOf(const SplineSurface& surface) {
  const double tall = surface.z_max() - surface.z_min();
  return std::clamp<Eigen::Index>(static_cast<Eigen::Index>(tall), 20, 450);
}

double MeanGirth(const SplineSurface& surface) {
  constexpr int kSteps = 24;
  double radius = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double z = surface.z_min() + (surface.z_max() - surface.z_min()) * (j + 0.5) / kSteps;
      radius += surface.Radius(kTwoPi * i / kSteps, z) / (kSteps * kSteps);
    }
  }
  return kTwoPi * std::max(radius, 1.0);
}

bool HasGap(const std::vector<MapMesh>& meshes) {
  return std::any_of(meshes.begin(), meshes.end(), [](const MapMesh& mesh) {
    return std::any_of(mesh.values.begin(), mesh.values.end(), [](double value) { return std::isnan(value); });
  });
}

std::string RuleText(const BodyField& field, bool is_given) {
  if (is_given) return "as it was given";
  if (field.usual_range) return "always the same for this map";
  const double percent = 100.0 * field.share;
  switch (field.rule) {
    case ScaleRule::kAboutZero:
      return fmt::format("± what {:.0f} % of the area does not exceed, rounded up", percent);
    case ScaleRule::kFromZero:
      return fmt::format("from zero to what {:.0f} % of the area does not exceed, rounded up", percent);
    case ScaleRule::kPercentiles:
      break;
  }
  return fmt::format("without the {0:.0f} % of the area below and above, rounded outward", 100.0 - percent);
}

/// "1.4 %", "under 0.1 %".
std::string PercentText(double share) {
  return share < 1e-3 ? std::string("under 0.1 %") : fmt::format("{:.1f} %", 100.0 * share);
}

/// "; 1.4 % of the area lies below and 2 % above it, in the colours of its tips"; "" if nothing does.
std::string BeyondText(const ValueRange& range) {
  std::string where;
  if (range.below > 0.0) where = PercentText(range.below) + " of the area lies below it";
  if (range.above > 0.0) {
    where += (where.empty() ? PercentText(range.above) + " of the area lies" : " and " + PercentText(range.above)) +
             " above it";
  }
  return where.empty() ? "" : "; " + where + ", in the colours of its tips";
}

/// A number to three figures, with a true minus.
std::string Figures(double value) {
  std::string text = std::abs(value) < 1e-12   ? "0"
                     : std::abs(value) >= 1e3  ? fmt::format("{:.0f}", value)
                     : std::abs(value) >= 1e-3 ? fmt::format("{:.3g}", value)
                                               : fmt::format("{:.4f}", value);
  if (!text.empty() && text.front() == '-') text = "−" + text.substr(1);
  return text;
}

SheetColour ColourOfSource(LandmarkSource source) {
  switch (source) {
    case LandmarkSource::kDetected:
      return {0.04, 0.36, 0.42};
    case LandmarkSource::kProportion:
      return {0.72, 0.40, 0.02};
    case LandmarkSource::kGiven:
      break;
  }
  return {0.44, 0.20, 0.56};
}

/// The line in which a level cuts the surface, as far as it is known.
std::vector<std::vector<Eigen::Vector3d>> LevelLine(const MeasuredSurface& body, double z) {
  constexpr int kSteps = 180;
  std::vector<std::vector<Eigen::Vector3d>> lines(1);
  for (int k = 0; k <= kSteps; ++k) {
    const double theta = kTwoPi * k / kSteps;
    if (body.KnowledgeAt(theta, z) == Knowledge::kUnknown) {
      if (!lines.back().empty()) lines.emplace_back();
      continue;
    }
    lines.back().push_back(body.Point(theta, z));
  }
  return lines;
}

}  // namespace

Result<MeasurePicture> MeasurePicture::Prepare(const std::vector<PictureSubject>& subjects, const MapInput& input,
                                               const MeasurePictureOptions& options, const TaskContext& task) {
  RETURN_IF_ERROR(CheckOptions(subjects, options));
  MeasurePicture picture;
  picture.options_ = options;
  if (options.map == MapKind::kClearance) {
    RETURN_IF_ERROR(picture.AddClearance(subjects));
  } else {
    RETURN_IF_ERROR(picture.AddMap(subjects, input));
  }
  RETURN_IF_ERROR(picture.AddMarks(subjects, task));
  if (task.stop.stop_requested()) return Fail(kAttempted, "it was stopped", "start it again");
  return picture;
}

void MeasurePicture::AddField(const PictureSubject& subject, const BodyField& field) {
  Panel& panel = panels_.back();
  if (options_.form == PictureForm::kUnrolled) {
    const SplineSurface& surface = subject.model->main().surface;
    panel.unrolled = Unroll(*subject.model, field, kColumns, RowsOf(surface));
    panel.girth = MeanGirth(surface);
    return;
  }
  const bool all = options_.map == MapKind::kKnowledge;
  for (MapMesh& mesh : MapMeshes(*subject.model, field, all ? BodyParts::kAll : BodyParts::kSeen)) {
    panel.meshes.push_back(std::move(mesh));
  }
}

Status MeasurePicture::AddMap(const std::vector<PictureSubject>& subjects, const MapInput& input) {
  std::vector<WeightedValue> values;
  std::optional<BodyField> first;
  for (const PictureSubject& subject : subjects) {
    panels_.emplace_back();
    panels_.back().caption = subject.caption;
    if (options_.map) {
      auto field = FieldOf(*options_.map, subject, input);
      if (!field) return Fail(field);
      AddField(subject, *field);
      const Panel& panel = panels_.back();
      const std::vector<WeightedValue> own = panel.unrolled ? panel.unrolled->weighted : AreaWeighted(panel.meshes);
      values.insert(values.end(), own.begin(), own.end());
      if (!first) first = std::move(*field);
    } else if (options_.form == PictureForm::kBody) {
      panels_.back().meshes = PlainBody(*subject.model);
    } else {
      return Fail("draw an unrolled picture", "nothing is shown on it", "choose a map");
    }
    if (subject.worn != nullptr && options_.form == PictureForm::kBody) {
      auto frame = PlainFrame(*subject.worn);
      if (!frame) return Fail(frame);
      for (MapMesh& mesh : *frame) panels_.back().meshes.push_back(std::move(mesh));
    }
  }
  if (!first) return {};
  Describe(*first);
  if (first->categories.empty()) {
    DescribeRange(*first, values);
    if (range_->weight == 0.0) {
      return Fail(kAttempted, "no place of the model has a value", "check that what was given belongs to the model");
    }
  } else {
    DescribeClasses(values);
  }
  return {};
}

Status MeasurePicture::AddClearance(const std::vector<PictureSubject>& subjects) {
  std::vector<WeightedValue> values;
  std::optional<BodyField> first;
  for (const PictureSubject& subject : subjects) {
    if (subject.worn == nullptr) {
      return Fail(kAttempted, "a clearance needs a worn frame", "give it beside the model");
    }
    auto maps = ClearanceOf(*subject.model, *subject.body, *subject.worn);
    if (!maps) return Fail(maps);
    const std::string name = subject.caption.empty() ? "" : subject.caption + ": ";
    panels_.emplace_back();
    panels_.back().caption = name + "on the head, frame taken off";
    AddField(subject, maps->head);
    const std::vector<WeightedValue> own = AreaWeighted(maps->frame);
    values.insert(values.end(), own.begin(), own.end());
    if (options_.form == PictureForm::kBody) {
      panels_.emplace_back();
      panels_.back().caption = name + "on frame and lenses";
      panels_.back().meshes = PlainBody(*subject.model);
      for (MapMesh& mesh : maps->frame) panels_.back().meshes.push_back(std::move(mesh));
    }
    if (!first) first = std::move(maps->head);
  }
  Describe(*first);
  DescribeRange(*first, values);
  text_.notes.emplace_back("The numbers are those of frame and lenses.");
  return {};
}

void MeasurePicture::Describe(const BodyField& field) {
  text_.title = field.title;
  text_.notes.push_back(field.definition);
  legend_.emplace();
  legend_->unit = field.unit;
  legend_->under_label = field.under_label;
  legend_->over_label = field.over_label;
  legend_->colours.categories = field.categories;
  legend_->colours.isolines = field.isolines;
  if (field.hatched) {
    const auto is_hatched = [](const Panel& panel) {
      if (panel.unrolled) return panel.unrolled->hatch.maxCoeff() > 0.5;
      return std::any_of(panel.meshes.begin(), panel.meshes.end(), [](const MapMesh& mesh) {
        return std::any_of(mesh.hatch.begin(), mesh.hatch.end(), [](float mark) { return mark > 0.5F; });
      });
    };
    if (std::any_of(panels_.begin(), panels_.end(), is_hatched)) legend_->hatch_label = field.hatch_label;
  }
  for (const Panel& panel : panels_) {
    legend_->grey = legend_->grey || (panel.unrolled ? panel.unrolled->values.hasNaN() : HasGap(panel.meshes));
  }
}

void MeasurePicture::DescribeRange(const BodyField& field, const std::vector<WeightedValue>& values) {
  std::optional<std::array<double, 2>> ends = options_.range;
  if (!ends) ends = field.usual_range;
  range_ = ends ? RangeGiven(values, (*ends)[0], (*ends)[1]) : RangeByRule(values, field.rule, field.share);
  legend_->range = *range_;
  ValueScale& scale = legend_->colours.scale;
  scale = {field.map, range_->minimum, range_->maximum, field.under, field.over};
  const std::string unit = field.unit.empty() ? "" : " " + field.unit;
  text_.notes.push_back(fmt::format("Least {}{}, greatest {}{}, mean {}{}, rms {}{}. Scale: {}{}.",
                                    Figures(range_->least), unit, Figures(range_->greatest), unit,
                                    Figures(range_->mean), unit, Figures(range_->rms), unit,
                                    RuleText(field, options_.range.has_value()), BeyondText(*range_)));
  if (options_.form == PictureForm::kBody) {
    text_.notes.emplace_back(
        "Light on the body darkens a colour by up to 15 % and keeps its hue: values read off by hue are right to 1 % "
        "of "
        "the scale.");
  }
}

void MeasurePicture::DescribeClasses(const std::vector<WeightedValue>& values) {
  std::vector<double> shares(legend_->colours.categories.size(), 0.0);
  double all = 0.0;
  for (const WeightedValue& one : values) {
    const auto k = static_cast<std::size_t>(std::max(0.0, one.value));
    if (!std::isfinite(one.value) || k >= shares.size()) continue;
    shares[k] += one.weight;
    all += one.weight;
  }
  std::string text = "Shares of the area:";
  for (std::size_t k = 0; k < shares.size() && all > 0.0; ++k) {
    text +=
        fmt::format("{} {} {:.1f} %", k == 0 ? "" : ",", legend_->colours.categories[k].label, 100.0 * shares[k] / all);
  }
  text_.notes.push_back(text + ".");
}

Status MeasurePicture::AddMarks(const std::vector<PictureSubject>& subjects, const TaskContext& task) {
  if (options_.tapes == TapeChoice::kNone && options_.landmarks == LandmarkChoice::kNone) return {};
  const std::size_t panels_each = panels_.size() / subjects.size();
  for (std::size_t k = 0; k < subjects.size(); ++k) {
    Panel& panel = panels_[k * panels_each];
    const MeasuredSurface& body = *subjects[k].body;
    Landmarks landmarks = FindLandmarks(body, task);
    if (options_.landmarks == LandmarkChoice::kAll) {
      for (const Landmark& one : landmarks.found) {
        const SheetColour colour = ColourOfSource(one.source);
        if (one.kind == LandmarkKind::kPoint) {
          panel.marks.push_back({one.position, colour, one.term});
        } else if (options_.tapes == TapeChoice::kNone) {  // else its girth shows it
          panel.tapes.push_back({LevelLine(body, one.z.value), colour, one.term});
        }
      }
    }
    if (options_.tapes == TapeChoice::kNone) continue;
    const auto table = MeasureTable(body, std::move(landmarks));
    if (!table) return Fail(table);
    int last = 0;
    for (const NumberedMeasurement& numbered : NumberForSheet(*table)) {
      const Measurement& m = *numbered.measurement;
      const bool is_girth = m.id.ends_with("_girth");
      if (numbered.number <= last || (options_.tapes == TapeChoice::kGirths && !is_girth)) continue;
      last = numbered.number;
      const ValueText value = DescribeValue(m, LengthUnit::kMillimetre);
      panel.tapes.push_back(
          {m.paths, ColourOf(GroupOf(m)), fmt::format("{} {} ± {} {}", m.term, value.value, value.half95, value.unit)});
    }
  }
  if (text_.title.empty()) {
    text_.title = options_.tapes == TapeChoice::kNone ? "Landmarks" : "Tapes";
    if (options_.tapes != TapeChoice::kNone && options_.landmarks == LandmarkChoice::kAll) {
      text_.title = "Tapes and landmarks";
    }
  }
  text_.notes.emplace_back("Dashed lines and open circles lie behind the body.");
  if (options_.tapes != TapeChoice::kNone) {
    text_.notes.back() += " Numbers behind ± are half widths of 95 % intervals.";
  }
  if (options_.landmarks == LandmarkChoice::kAll) {
    text_.notes.emplace_back("Landmarks: blue-green found on the surface, orange placed by proportion, violet given.");
  }
  return {};
}

}  // namespace annulus
