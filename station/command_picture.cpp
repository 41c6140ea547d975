// The options of `render` for pictures that measure: maps, tapes, landmarks, side by side, around.

#include "station/command_picture.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>
#include <utility>

#include "acquisition/recording.h"
#include "base/units.h"
#include "station/commands.h"
#include "station/files.h"
#include "station/key_file.h"
#include "station/loaded_model.h"
#include "station/residual_map.h"
#include "station/turntable.h"

namespace annulus {
namespace {

/// A file's name without folder and ending.
std::string StemOf(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
  const std::size_t dot = name.find('.');
  return dot == std::string::npos || dot == 0 ? name : name.substr(0, dot);
}

Result<std::array<double, 2>> ParseRange(const std::string& text) {
  std::array<double, 2> ends{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t k = 0; k < 2; ++k) {
    const auto read = std::from_chars(at, end, ends[k]);
    const bool ok = read.ec == std::errc() && (k == 0 ? read.ptr < end && *read.ptr == ',' : read.ptr == end);
    if (!ok) return Fail("read --range " + text, "it is not two numbers", "give A,B, for example -2,2");
    at = read.ptr + 1;
  }
  if (!(ends[0] < ends[1])) return Fail("read --range " + text, "its ends do not rise", "give A,B with A < B");
  return ends;
}

Result<MeasurePictureOptions> OptionsOf(const MeasurePictureRequest& request, const MeasurePictureFlags& flags) {
  MeasurePictureOptions options;
  options.size = request.size;
  if (!flags.map.empty()) {
    const auto kind = ParseMapKind(flags.map);
    if (!kind) return Fail(kind);
    options.map = *kind;
  }
  if (!flags.range.empty()) {
    const auto range = ParseRange(flags.range);
    if (!range) return Fail(range);
    options.range = *range;
  }
  if (flags.tapes == "girths") options.tapes = TapeChoice::kGirths;
  if (flags.tapes == "all") options.tapes = TapeChoice::kAll;
  if (flags.landmarks) options.landmarks = LandmarkChoice::kAll;
  if (flags.unrolled) options.form = PictureForm::kUnrolled;
  return options;
}

/// All that a panel borrows.
struct SubjectFiles {
  std::optional<LoadedModel> model;
  std::optional<WornFrame> worn;
  std::optional<std::vector<SurfaceSample>> samples;
  std::string caption;

  /// As a subject; `fallback` stands in for what was not read.
  [[nodiscard]] PictureSubject Subject(const SubjectFiles* fallback) const {
    const SubjectFiles& of_model = model || fallback == nullptr ? *this : *fallback;
    PictureSubject subject;
    subject.model = of_model.model->model.get();
    subject.body = &of_model.model->body;
    subject.samples = of_model.samples ? &*of_model.samples : nullptr;
    if (worn) subject.worn = &*worn;
    subject.caption = caption;
    return subject;
  }
};

Result<std::vector<SurfaceSample>> ReadSamples(const std::vector<std::string>& paths, const KeySource* keys,
                                               CommandIo& io) {
  std::vector<Scan> scans;
  for (const std::string& path : paths) {
    auto scan = ReadRecording(io.storage(), path, keys);
    if (!scan) return Fail(scan);
    scans.push_back(std::move(*scan));
  }
  return FittedSamples(scans);
}

/// Reads what was named; an empty path reads nothing.
Status Read(SubjectFiles& files, const std::string& model, const std::string& worn,
            const std::vector<std::string>& scans, const std::string& key_file, CommandIo& io) {
  if (!model.empty()) {
    auto loaded = LoadModel(io, model);
    if (!loaded) return Fail(loaded);
    files.model.emplace(std::move(*loaded));
    files.caption = StemOf(model);
  }
  if (!worn.empty()) {
    auto read = ReadWornFile(io.storage(), worn);
    if (!read) return Fail(read);
    files.worn = std::move(*read);
    files.caption += (files.caption.empty() ? "" : ", ") + StemOf(worn);
  }
  if (scans.empty()) return {};
  const auto keys = OpenKeys(key_file);
  if (!keys) return Fail(keys);
  auto samples = ReadSamples(scans, keys->get(), io);
  if (!samples) return Fail(samples);
  files.samples = std::move(*samples);
  return {};
}

Status Draw(const std::vector<PictureSubject>& subjects, const MapInput& input, const MeasurePictureOptions& options,
            const MeasurePictureRequest& request, CommandIo& io) {
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const auto picture = MeasurePicture::Prepare(subjects, input, options, task);
  if (!picture) return Fail(picture);
  if (request.turntable > 0) {
    const auto frames = picture->DrawAround(request.view, request.turntable, task);
    display.Clear();
    if (!frames) return Fail(frames);
    return WriteTurntable(io.storage(), request.out, *frames, {request.frame_ms, 0});
  }
  const auto image = picture->Draw(request.view, task);
  display.Clear();
  if (!image) return Fail(image);
  return WritePngFile(io.storage(), request.out, *image);
}

}  // namespace

void AddMeasurePictureOptions(CLI::App& command, MeasurePictureFlags& flags) {
  constexpr const char* kGroup = "Pictures that measure";
  command
      .add_option(
          "--map", flags.map,
          "colours on the body with a legend: residual, curvature, gaussian, largest-curvature, "
          "smallest-curvature, clearance, strain, largest-strain, smallest-strain, knowledge, sigma, difference "
          "or values")
      ->type_name("MAP")
      ->group(kGroup);
  command.add_option("--range", flags.range, "ends of the scale (by the map's rule)")->type_name("A,B")->group(kGroup);
  command.add_option("--scan", flags.scans, "recording that the residuals are of; may be repeated")
      ->allow_extra_args(false)
      ->type_name("SCAN")
      ->group(kGroup);
  command.add_option("--against", flags.against, "second model of a difference or a strain")
      ->type_name("MODEL_B.json")
      ->group(kGroup);
  command.add_option("--values", flags.values, "table theta_deg,z_mm,value that --map values shows")
      ->type_name("F.csv")
      ->group(kGroup);
  command.add_option("--tapes", flags.tapes, "draw tapes with their numbers: girths or all")
      ->check(CLI::IsMember({"girths", "all"}).description(""))
      ->type_name("girths|all")
      ->group(kGroup);
  command.add_flag("--landmarks", flags.landmarks, "mark and name the landmarks")->group(kGroup);
  command.add_flag("--unrolled", flags.unrolled, "the map over theta and height instead of on the body")->group(kGroup);
  AddKeyFileOption(command, flags.key_file);
  command.add_option("--beside", flags.beside, "another model beside the first, from the same view at the same scale")
      ->type_name("OTHER.json")
      ->group(kGroup);
  command
      .add_option("--beside-worn", flags.beside_worn, "other glasses beside the first, on the same model or on OTHER")
      ->type_name("WORN.json")
      ->group(kGroup);
  command.add_option("--beside-scan", flags.beside_scans, "recording that the residuals of OTHER are of")
      ->allow_extra_args(false)
      ->type_name("SCAN")
      ->group(kGroup);
}

Status RunMeasurePicture(const MeasurePictureRequest& request, const MeasurePictureFlags& flags, CommandIo& io) {
  const auto options = OptionsOf(request, flags);
  if (!options) {
    io.set_failure_code(2);
    return Fail(options);
  }
  SubjectFiles first;
  SubjectFiles second;
  SubjectFiles against;
  RETURN_IF_ERROR(Read(first, request.model, request.worn, flags.scans, flags.key_file, io));
  RETURN_IF_ERROR(Read(second, flags.beside, flags.beside_worn, flags.beside_scans, flags.key_file, io));
  RETURN_IF_ERROR(Read(against, flags.against, "", {}, flags.key_file, io));
  std::vector<PictureSubject> subjects{first.Subject(nullptr)};
  if (second.model || second.worn) subjects.push_back(second.Subject(&first));
  MapInput input;
  if (against.model) {
    input.against = against.Subject(nullptr);
    for (PictureSubject& subject : subjects) subject.caption += " → " + against.caption;
  }
  if (!flags.values.empty()) {
    auto text = ReadTextFile(io.storage(), flags.values);
    if (!text) return Fail(text);
    input.values_csv = std::move(*text);
    input.values_name = flags.values;
  }
  return Draw(subjects, input, *options, request, io);
}

}  // namespace annulus
