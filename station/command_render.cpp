// render: a picture of a model, with worn glasses or without.

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <optional>

#include "station/commands.h"
#include "station/files.h"
#include "station/pictures.h"

namespace annulus {
namespace {

enum class RenderMethod { kZBuffer, kTrace };
enum class FrameMaterial { kPlastic, kMetal };

struct RenderCommandOptions {
  std::string model;
  std::string worn;
  std::string view;
  int size = 720;
  RenderMethod method = RenderMethod::kZBuffer;
  std::string frame_colour;
  FrameMaterial frame_material = FrameMaterial::kPlastic;
  std::string lens_colour = "#6f5a48";
  double lens_transmittance = 0.85;
  std::string out;
};

Result<FrameLook> LookOf(const RenderCommandOptions& options) {
  FrameLook look;
  const bool metal = options.frame_material == FrameMaterial::kMetal;
  if (!options.frame_colour.empty() || metal) {
    const auto colour = ParseHexColour(options.frame_colour.empty() ? "#ffd791" : options.frame_colour);
    if (!colour) return Fail(colour);
    look.frame = metal ? MetalMaterial(*colour) : PlasticMaterial(*colour);
  }
  const auto tint = ParseHexColour(options.lens_colour);
  if (!tint) return Fail(tint);
  look.lens = LensSheetMaterial(*tint, options.lens_transmittance);
  return look;
}

Status RunRender(const RenderCommandOptions& options, CommandIo& io) {
  if (options.method == RenderMethod::kTrace) return NotYet(io, "render with --method trace");
  PictureOptions picture;
  picture.size = options.size;
  const auto view = ParseView(options.view);
  const auto look = LookOf(options);
  if (!view || !look) {  // what was typed is wrong, whatever the files are
    io.set_failure_code(2);
    return tl::unexpected(view ? look.error() : view.error());
  }
  picture.view = *view;
  picture.look = *look;
  const auto model = ReadModelFile(io.storage(), options.model);
  if (!model) return Fail(model);
  std::optional<WornFrame> worn;
  if (!options.worn.empty()) {
    auto read = ReadWornFile(io.storage(), options.worn);
    if (!read) return Fail(read);
    worn = std::move(*read);
  }
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const auto image = worn ? DrawWorn(*model, *worn, picture, task) : DrawModel(*model, picture, task);
  display.Clear();
  if (!image) return Fail(image);
  return WritePngFile(io.storage(), options.out, *image);
}

}  // namespace

void AddRenderCommand(CLI::App& app, CommandWork& chosen) {
  static const std::map<std::string, RenderMethod> kMethods{{"zbuffer", RenderMethod::kZBuffer},
                                                            {"trace", RenderMethod::kTrace}};
  static const std::map<std::string, FrameMaterial> kMaterials{{"plastic", FrameMaterial::kPlastic},
                                                               {"metal", FrameMaterial::kMetal}};
  auto options = std::make_shared<RenderCommandOptions>();
  CLI::App* command = app.add_subcommand("render", "a picture of a model, with glasses or without");
  command->add_option("model", options->model, "model")->required();
  command->add_option("--worn", options->worn, "glasses placed on it")->type_name("WORN.json");
  command->add_option("--view", options->view, "front, left45, right45, or AZ,EL in degrees (front is 90,0)")
      ->required()
      ->type_name("VIEW");
  command->add_option("--size", options->size, "pixels of the longer side")
      ->check(CLI::Range(16, kMaxImageSize))
      ->capture_default_str();
  command->add_option("--method", options->method, "zbuffer (default) or trace")
      ->transform(CLI::CheckedTransformer(kMethods, CLI::ignore_case).description(""))
      ->type_name("METHOD");
  command->add_option("--frame-colour", options->frame_colour, "colour of the frame (dark brown)")
      ->type_name("#rrggbb");
  command->add_option("--frame-material", options->frame_material, "plastic (default) or metal")
      ->transform(CLI::CheckedTransformer(kMaterials, CLI::ignore_case).description(""))
      ->type_name("MATERIAL");
  command->add_option("--lens-colour", options->lens_colour, "colour of the lenses' dye")
      ->type_name("#rrggbb")
      ->capture_default_str();
  command->add_option("--lens-transmittance", options->lens_transmittance, "share of the light that the lenses pass")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--out", options->out, "picture to write")->required()->type_name("P.png");
  command->footer("Example: annulus render model.json --worn worn.json --view left45 --out picture.png");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunRender(*options, io); }; });
}

}  // namespace annulus
