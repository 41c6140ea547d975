// render: pictures of a model, with worn glasses or without; one, or many by a batch file.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "render/colour_choice.h"
#include "render/image_file.h"
#include "station/commands.h"
#include "station/contact_sheet.h"
#include "station/picture_maker.h"
#include "station/picture_sources.h"
#include "station/render_batch.h"
#include "station/render_options.h"
#include "station/turntable.h"

namespace annulus {
namespace {

struct RenderCommandOptions {
  RenderRequest picture;
  std::string batch;
  std::string json;
  std::string key_file;
  std::string colour_chooser;
};

Status WriteImage(Storage& storage, const std::string& path, const RgbImage& image, ImagePlane plane) {
  if (path.empty()) return {};
  const auto bytes = EncodeImage(image, plane, path);
  if (!bytes) return Fail(bytes);
  return WriteFileAtomically(storage, path, std::span<const std::byte>(*bytes));
}

Status WritePicture(Storage& storage, const RenderRequest& request, const RgbImage& image) {
  const bool transparent = request.background == PictureBackground::kNone;
  RETURN_IF_ERROR(WriteImage(storage, request.out, image, transparent ? ImagePlane::kRgba : ImagePlane::kColour));
  RETURN_IF_ERROR(WriteImage(storage, request.alpha, image, ImagePlane::kAlpha));
  return WriteImage(storage, request.depth, image, ImagePlane::kDepth);
}

nlohmann::ordered_json Report(const RenderRequest& request, const MadePicture& picture, double seconds) {
  const Camera& camera = picture.camera;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back(
        {camera.camera_from_station(row, 0), camera.camera_from_station(row, 1), camera.camera_from_station(row, 2)});
  }
  nlohmann::ordered_json report = {
      {"out", request.out},
      {"model", request.model},
      {"view", request.view},
      {"method", request.method == RenderMethod::kTrace ? "trace" : "zbuffer"},
      {"width", picture.frames.front().width},
      {"height", picture.frames.front().height},
      {"frames", picture.frames.size()},
      {"camera",
       {{"eye_mm", {camera.eye_in_station.x(), camera.eye_in_station.y(), camera.eye_in_station.z()}},
        {"camera_from_station", rows},
        {"tangent_of_half_height", camera.half_height}}},
      {"notes", picture.notes},
      {"time_s", seconds}};
  if (!picture.numbers.empty()) report["numbers"] = nlohmann::ordered_json::parse(picture.numbers);
  return report;
}

/// Makes and writes one picture.
Result<MadePicture> RunPicture(const RenderRequest& request, PictureSources& sources, CommandIo& io,
                               const TaskContext& task) {
  auto options = PictureOptionsOf(request, io.storage());
  if (!options) {
    io.set_failure_code(2);
    return Fail(options);
  }
  if (!request.progressive.empty()) {
    // A snapshot that cannot be written is not worth the picture: the end will say so.
    options->on_pass = [&](const TracePass& pass) {
      static_cast<void>(WriteImage(io.storage(), request.progressive, pass.image, ImagePlane::kColour));
    };
  }
  auto made = MakePicture(request, *options, sources, task);
  if (!made) return Fail(made);
  RETURN_IF_ERROR(request.turntable > 0 ? WriteTurntable(io.storage(), request.out, made->frames, {})
                                        : WritePicture(io.storage(), request, made->frames.front()));
  return made;
}

Status RunRequests(const RenderBatch& batch, const std::string& json, CommandIo& io) {
  PictureSources sources(io.storage(), batch.key_file);
  ProgressDisplay display(io.progress_mode());
  nlohmann::ordered_json reports = nlohmann::ordered_json::array();
  std::vector<ContactTile> tiles;
  for (std::size_t k = 0; k < batch.pictures.size(); ++k) {
    const RenderRequest& request = batch.pictures[k];
    TaskContext task;
    task.stop = io.stop();
    const std::string number =
        batch.pictures.size() == 1 ? "" : " " + std::to_string(k + 1) + " of " + std::to_string(batch.pictures.size());
    task.progress = [&](std::string_view stage, double done, double total) {
      display.Show(std::string(stage) + number, done, total);
    };
    const auto start = std::chrono::steady_clock::now();
    auto picture = RunPicture(request, sources, io, task);
    display.Clear();
    if (io.stop().stop_requested()) return tl::unexpected(InterruptedError("render " + request.model));
    if (!picture) return Fail(picture);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const std::string& note : picture->notes) std::fprintf(stderr, "annulus: note: %s\n", note.c_str());
    reports.push_back(Report(request, *picture, seconds));
    if (!batch.sheet.out.empty()) tiles.push_back({std::move(picture->frames.front()), request.caption});
  }
  if (!batch.sheet.out.empty()) {
    const auto sheet = ContactSheet(tiles, {.columns = batch.sheet.columns, .title = batch.sheet.title});
    if (!sheet) return Fail(sheet);
    RETURN_IF_ERROR(WriteImage(io.storage(), batch.sheet.out, *sheet, ImagePlane::kColour));
  }
  return json.empty() ? Status{} : io.WriteJson(json, {{"pictures", reports}});
}

/// The page that colours are chosen from (paper 000, fig. 23), with a mark at one.
Status DrawColourChooser(const std::string& text, const std::string& out, CommandIo& io) {
  const auto colour = ParseColourChoice(text);
  const Status path =
      out.empty() ? Fail("draw the colour chooser", "--out is missing", "say where it is to go") : CheckImagePath(out);
  if (!colour || !path) {
    io.set_failure_code(2);
    return colour ? path : Status(Fail(colour));
  }
  return WriteImage(io.storage(), out, ColourChooser(*colour), ImagePlane::kColour);
}

Status RunRender(const RenderCommandOptions& options, CommandIo& io) {
  if (!options.colour_chooser.empty()) return DrawColourChooser(options.colour_chooser, options.picture.out, io);
  RenderBatch batch;
  if (!options.batch.empty()) {
    const auto text = ReadTextFile(io.storage(), options.batch);
    if (!text) return Fail(text);
    auto read = RenderBatchFromJson(*text, options.batch);
    if (!read) return Fail(read);
    batch = std::move(*read);
  } else {
    const Status checked = options.picture.out.empty()
                               ? Fail("draw a picture", "--out is missing", "say where it is to go")
                               : CheckRequest(options.picture);
    if (!checked) {  // what was typed is wrong, whatever the files are
      io.set_failure_code(2);
      return checked;
    }
    batch.pictures.push_back(options.picture);
  }
  batch.key_file = options.key_file;
  return RunRequests(batch, options.json, io);
}

}  // namespace

void AddRenderCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<RenderCommandOptions>();
  CLI::App* command = app.add_subcommand("render", "a picture of a model, with glasses or without");
  AddRenderOptions(*command, options->picture);
  command->add_option("--batch", options->batch, "many pictures in one process (docs/formats.md)")
      ->type_name("FILE.json");
  command->add_option("--colour-chooser", options->colour_chooser, "draw the page that colours are chosen from instead")
      ->type_name("COLOUR");
  AddJsonOption(*command, options->json);
  AddKeyFileOption(*command, options->key_file);
  command->footer(
      "Example: annulus render model.json --worn worn.json --view left45 --method trace --out picture.png\n"
      "Colours: #rrggbb, sample:NAME, bar:0.4, rgb:120,60,20, each with ,brighter:0.2 ,vivid:-0.3 behind it.");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunRender(*options, io); }; });
}

}  // namespace annulus
