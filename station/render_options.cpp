#include "station/render_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "render/colour_choice.h"
#include "render/image_file.h"
#include "station/look_file.h"
#include "station/look_words.h"

namespace annulus {
namespace {

const std::map<std::string, RenderMethod> kMethods{{"zbuffer", RenderMethod::kZBuffer},
                                                   {"trace", RenderMethod::kTrace}};
const std::map<std::string, PictureBackground> kBackgrounds{{"backdrop", PictureBackground::kBackdrop},
                                                            {"none", PictureBackground::kNone},
                                                            {"environment", PictureBackground::kEnvironment}};

/// Words as CLI11 takes them.
template <class Value, std::size_t kCount>
std::map<std::string, Value> ByWord(const std::array<Word<Value>, kCount>& words) {
  std::map<std::string, Value> names;
  for (const Word<Value>& word : words) names.emplace(word.word, word.value);
  return names;
}
/// Names in the order of an enumeration.
template <class Value, std::size_t kCount>
std::map<std::string, Value> ByName(const std::array<std::string_view, kCount>& ordered) {
  std::map<std::string, Value> names;
  for (std::size_t k = 0; k < kCount; ++k) names.emplace(ordered[k], static_cast<Value>(k));
  return names;
}

/// --map's words.
std::map<std::string, MapKind> MapNames() {
  std::map<std::string, MapKind> names;
  for (int k = 0; k <= static_cast<int>(MapKind::kValues); ++k) {
    names.emplace(MapKindName(static_cast<MapKind>(k)), static_cast<MapKind>(k));
  }
  return names;
}

/// An option that takes one of the names of a map.
template <class Value, class Names>
CLI::Option* AddChoice(CLI::App& command, const std::string& name, Value& value, const Names& names,
                       const std::string& help) {
  return command.add_option(name, value, help)
      ->transform(CLI::CheckedTransformer(names, CLI::ignore_case).description(""))
      ->type_name("NAME");
}

void AddPictureOptions(CLI::App& command, RenderRequest& request) {
  const std::string group = "Picture";
  command.add_option("--view", request.view, "front, left45, right45, or AZ,EL in degrees (front is 90,0)")
      ->type_name("VIEW")
      ->group(group);
  command.add_option("--size", request.size, "pixels of the longer side")
      ->check(CLI::Range(16, kMaxImageSize))
      ->capture_default_str()
      ->group(group);
  command.add_option("--out", request.out, "picture to write: .png or .exr (linear light)")
      ->type_name("P.png")
      ->group(group);
  command.add_option("--alpha", request.alpha, "also the coverage: 16-bit .png, or .exr")->type_name("A")->group(group);
  command.add_option("--depth", request.depth, "also the depth: 16-bit .png of 0.1 mm, or .exr in mm")
      ->type_name("D")
      ->group(group);
  AddChoice(command, "--method", request.method, kMethods, "zbuffer (default) or trace")->group(group);
  AddChoice(command, "--background", request.background, kBackgrounds,
            "backdrop (default), none (transparent), or environment (trace only)")
      ->group(group);
  command.add_option("--supersampling", request.supersampling, "zbuffer: samples per pixel along each side")
      ->check(CLI::Range(1, 8))
      ->capture_default_str()
      ->group(group);
  static const std::map<std::string, LensMedium> kMedia{{"thin", LensMedium::kThin}, {"filled", LensMedium::kFilled}};
  AddChoice(command, "--lens-medium", request.lens_medium, kMedia,
            "zbuffer: what lies behind a lens sheet: thin (default), or filled, as the paper says")
      ->group(group);
  command.add_option("--caption", request.caption, "text under the picture on the sheet of a batch")->group(group);
}

void AddTraceOptions(CLI::App& command, RenderRequest& request) {
  const std::string group = "Path tracer";
  AddChoice(command, "--light", request.light, ByName<LightPreset>(LightPresetNames()),
            "studio (default), shop, or daylight")
      ->group(group);
  command.add_option("--samples", request.samples, "paths per pixel")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str()
      ->group(group);
  command.add_option("--seed", request.seed, "of the random numbers")->capture_default_str()->group(group);
  command.add_flag("--no-denoise", request.no_denoise, "leave the noise in")->group(group);
  command.add_flag("--dispersion", request.dispersion, "lenses split colours as their Abbe number says")->group(group);
  command.add_option("--progressive", request.progressive, "file that is replaced each time the picture got better")
      ->type_name("P.png")
      ->group(group);
}

void AddLookOptions(CLI::App& command, RenderRequest& request) {
  const std::string group = "Look";
  const std::string colour = "COLOUR";
  command.add_option("--look", request.look, "colours, materials, textures, lenses, make-up")
      ->type_name("LOOK.json")
      ->group(group);
  command.add_option("--frame-colour", request.frame_colour, "of both halves")->type_name(colour)->group(group);
  command.add_option("--upper-colour", request.upper_colour, "of the upper half")->type_name(colour)->group(group);
  command.add_option("--lower-colour", request.lower_colour, "of the lower half")->type_name(colour)->group(group);
  AddChoice(command, "--frame-material", request.frame_material, ByWord(kMaterialWords),
            "plastic, translucent, metal, brushed")
      ->group(group);
  AddChoice(command, "--upper-material", request.upper_material, ByWord(kMaterialWords), "likewise")->group(group);
  AddChoice(command, "--lower-material", request.lower_material, ByWord(kMaterialWords), "likewise")->group(group);
  AddChoice(command, "--upper-texture", request.upper_texture, ByWord(kPatternWords),
            "plain, tortoiseshell, horn, pearl, carved")
      ->group(group);
  AddChoice(command, "--lower-texture", request.lower_texture, ByWord(kPatternWords), "likewise")->group(group);
  command.add_option("--lens-colour", request.lens_colour, "of the lenses' dye")->type_name(colour)->group(group);
  command.add_option("--lens-transmittance", request.lens_transmittance, "share of the light that the lenses pass")
      ->check(CLI::Range(0.0, 1.0))
      ->group(group);
  command.add_option("--lens-lower-transmittance", request.lens_lower_transmittance, "at the lower edge: a gradient")
      ->check(CLI::Range(0.0, 1.0))
      ->group(group);
  AddChoice(command, "--lens-coating", request.lens_coating, ByWord(kCoatingWords), "none, anti_reflective, or mirror")
      ->group(group);
  command.add_option("--lens-power", request.lens_power, "D, where WORN.json keeps no prescription")
      ->check(CLI::Range(-30.0, 30.0))
      ->group(group);
  const std::string layer = "COLOUR[@STRENGTH]";
  command.add_option("--lips", request.lips, "colour of the lips")->type_name(layer)->group(group);
  command.add_option("--cheeks", request.cheeks, "of the cheeks")->type_name(layer)->group(group);
  command.add_option("--brows", request.brows, "of the brows")->type_name(layer)->group(group);
}

void AddInsideOptions(CLI::App& command, RenderRequest& request) {
  const std::string group = "View from inside";
  command.add_option("--inside", request.inside, "what the wearer sees with the right, left or both eyes")
      ->check(CLI::IsMember({"right", "left", "both"}))
      ->type_name("EYE")
      ->group(group);
  command.add_option("--gaze", request.gaze, "directions of gaze in degrees, left and up positive: \"0,0;20,-10\"")
      ->type_name("LEFT,UP")
      ->capture_default_str()
      ->group(group);
  command.add_flag("--inside-map", request.inside_map, "power and astigmatism over the lens instead of the view")
      ->group(group);
  AddChoice(command, "--inside-scene", request.inside_scene, ByName<GazeSceneKind>(GazeSceneNames()),
            "shop (default), or grid")
      ->group(group);
  command.add_option("--pupil-mm", request.pupil_mm, "diameter of the pupil; 0: all sharp")
      ->check(CLI::Range(0.0, 9.0))
      ->capture_default_str()
      ->group(group);
}

void AddMeasureOptions(CLI::App& command, RenderRequest& request) {
  const std::string group = "Pictures that measure";
  AddChoice(command, "--map", request.map, MapNames(),
            "residual, curvature, gaussian, clearance, strain, knowledge, sigma, difference, values, ...")
      ->group(group);
  command.add_option("--range", request.range, "ends of the scale instead of what the map suggests")
      ->type_name("A,B")
      ->group(group);
  command.add_option("--scan", request.scan, "recording, for --map residual")->type_name("SCAN")->group(group);
  command.add_option("--against", request.against, "second model, for --map difference and strain")
      ->type_name("MODEL.json")
      ->group(group);
  command.add_option("--values", request.values, "theta_deg,z_mm,value, for --map values")
      ->type_name("F.csv")
      ->group(group);
  static const std::map<std::string, TapeChoice> kTapes{{"girths", TapeChoice::kGirths}, {"all", TapeChoice::kAll}};
  AddChoice(command, "--tapes", request.tapes, kTapes, "girths, or all lines of the measurements, on the body")
      ->group(group);
  command.add_flag("--landmarks", request.landmarks, "landmarks on the body")->group(group);
  command.add_flag("--unrolled", request.unrolled, "the map over theta and z instead of on the body")->group(group);
  command.add_option("--beside", request.beside, "another model beside it, same view and scale")
      ->type_name("MODEL.json")
      ->group(group);
  command.add_option("--beside-worn", request.beside_worn, "what the other wears; alone: on the same model")
      ->type_name("WORN.json")
      ->group(group);
  command.add_option("--beside-scan", request.beside_scan, "the other's recording")->type_name("SCAN")->group(group);
  command
      .add_option("--turntable", request.turntable,
                  "frames all around: --out F.webp, or a folder for PNG frames and animation")
      ->check(CLI::Range(0, 720))
      ->type_name("N")
      ->group(group);
}

/// Takes over a colour if one was typed.
Status Take(const std::string& text, LinearRgb& colour) {
  if (text.empty()) return {};
  const auto parsed = ParseColourChoice(text);
  if (!parsed) return Fail(parsed);
  colour = *parsed;
  return {};
}

template <class Value>
void Take(const std::optional<Value>& given, Value& value) {
  if (given) value = *given;
}

/// "COLOUR" or "COLOUR@STRENGTH".
Status TakeLayer(const std::string& text, MakeUpLayer& layer) {
  if (text.empty()) return {};
  std::string colour = text;
  layer.strength = 0.7;
  const std::size_t at = text.rfind('@');
  if (at != std::string::npos) {
    colour = text.substr(0, at);
    const std::string number = text.substr(at + 1);
    char* end = nullptr;
    layer.strength = std::strtod(number.c_str(), &end);
    if (number.empty() || *end != '\0' || !(layer.strength >= 0.0 && layer.strength <= 1.0)) {
      return Fail("read the make-up '" + text + "'", "'" + number + "' is not a strength",
                  "give COLOUR@STRENGTH with a strength of 0 ... 1");
    }
  }
  return Take(colour, layer.colour);
}

Status TakeFrame(const RenderRequest& request, Look& look) {
  for (PartLook* part : {&look.upper, &look.lower}) {
    // Metal without a colour is gold, not dark brown.
    const bool turns_metal = request.frame_material == Finish::kMetal && request.look.empty();
    if (turns_metal) part->colour = LinearFromHex(0xffd791);
    RETURN_IF_ERROR(Take(request.frame_colour, part->colour));
    Take(request.frame_material, part->finish);
  }
  RETURN_IF_ERROR(Take(request.upper_colour, look.upper.colour));
  RETURN_IF_ERROR(Take(request.lower_colour, look.lower.colour));
  Take(request.upper_material, look.upper.finish);
  Take(request.lower_material, look.lower.finish);
  Take(request.upper_texture, look.upper.texture.pattern);
  Take(request.lower_texture, look.lower.texture.pattern);
  return {};
}

/// File names that fit what is written to them.
Status CheckOutputs(const RenderRequest& request) {
  const bool film = request.turntable > 0;
  const bool planes = !request.alpha.empty() || !request.depth.empty();
  const bool plain = !film && !IsMeasuring(request) && request.inside.empty();
  if (planes && !plain) return Fail("write alpha or depth", "only a plain picture has them", "leave them out");
  for (const std::string& path :
       {film ? std::string() : request.out, request.alpha, request.depth, request.progressive}) {
    if (!path.empty()) RETURN_IF_ERROR(CheckImagePath(path));
  }
  return {};
}

}  // namespace

bool IsMeasuring(const RenderRequest& request) {
  return request.map || request.tapes || request.landmarks || request.unrolled || !request.beside.empty() ||
         !request.beside_worn.empty();
}

Result<MeasurePictureOptions> MeasureOptionsOf(const RenderRequest& request) {
  MeasurePictureOptions options;
  options.map = request.map;
  options.tapes = request.tapes.value_or(TapeChoice::kNone);
  options.landmarks = request.landmarks ? LandmarkChoice::kAll : LandmarkChoice::kNone;
  options.form = request.unrolled ? PictureForm::kUnrolled : PictureForm::kBody;
  options.size = request.size;
  if (!request.range.empty()) {
    std::array<double, 2> range{};
    int end = 0;
    const bool read = std::sscanf(request.range.c_str(), "%lf,%lf%n", &range[0], &range[1], &end) == 2 &&
                      end == static_cast<int>(request.range.size()) && std::isfinite(range[0]) &&
                      std::isfinite(range[1]) && range[0] < range[1];
    if (!read) return Fail("read the range '" + request.range + "'", "it is not two rising numbers", "give A,B");
    options.range = range;
  }
  return options;
}

void AddRenderOptions(CLI::App& command, RenderRequest& request) {
  command.add_option("model", request.model, "model");
  command.add_option("--worn", request.worn, "glasses placed on it")->type_name("WORN.json");
  AddPictureOptions(command, request);
  AddLookOptions(command, request);
  AddTraceOptions(command, request);
  AddMeasureOptions(command, request);
  AddInsideOptions(command, request);
}

Status CheckRequest(const RenderRequest& request) {
  const auto missing = [](const std::string& what) {
    return Fail("understand what picture is wanted", what + " is missing", "see annulus render --help");
  };
  if (request.model.empty()) return missing("the model");
  if (!request.inside.empty()) {
    if (request.worn.empty()) return missing("--worn, what is looked through,");
    const auto inside = InsideOptionsOf(request);
    if (!inside) return Fail(inside);
  } else {
    if (request.view.empty()) return missing("--view");
    const auto view = ParseView(request.view);
    if (!view) return Fail(view);
  }
  RETURN_IF_ERROR(CheckOutputs(request));
  if (IsMeasuring(request)) {
    const auto measure = MeasureOptionsOf(request);
    if (!measure) return Fail(measure);
  }
  const bool traced = request.method == RenderMethod::kTrace;
  if (!traced && request.background == PictureBackground::kEnvironment) {
    return Fail("show the environment behind the body", "--method zbuffer has none", "add --method trace");
  }
  if (!traced && !request.progressive.empty()) {
    return Fail("write a picture that gets better", "--method zbuffer makes it at once", "add --method trace");
  }
  return {};
}

Result<Look> LookOf(const RenderRequest& request, Storage& storage) {
  Look look;
  if (!request.look.empty()) {
    const auto text = ReadTextFile(storage, request.look);
    if (!text) return Fail(text);
    auto read = LookFromJson(*text, request.look);
    if (!read) return Fail(read);
    look = *read;
  }
  RETURN_IF_ERROR(TakeFrame(request, look));
  RETURN_IF_ERROR(Take(request.lens_colour, look.lens.tint));
  if (request.lens_transmittance) look.lens.lower_transmittance = *request.lens_transmittance;
  Take(request.lens_transmittance, look.lens.transmittance);
  Take(request.lens_lower_transmittance, look.lens.lower_transmittance);
  Take(request.lens_coating, look.lens.coating);
  Take(request.lens_power, look.lens.power);
  RETURN_IF_ERROR(TakeLayer(request.lips, look.make_up.lips));
  RETURN_IF_ERROR(TakeLayer(request.cheeks, look.make_up.cheeks));
  RETURN_IF_ERROR(TakeLayer(request.brows, look.make_up.brows));
  return look;
}

Result<InsideViewOptions> InsideOptionsOf(const RenderRequest& request) {
  InsideViewOptions options;
  auto gazes = ParseGazes(request.gaze);
  if (!gazes) return Fail(gazes);
  options.gazes = std::move(*gazes);
  if (request.inside == "right") options.eyes = {Eye::kRight};
  if (request.inside == "left") options.eyes = {Eye::kLeft};
  options.scene = request.inside_scene;
  options.pupil_diameter = request.pupil_mm;
  options.view.width = request.size;
  options.view.height = std::max(16, 2 * request.size / 3);
  return options;
}

Result<PictureOptions> PictureOptionsOf(const RenderRequest& request, Storage& storage) {
  PictureOptions options;
  if (!request.view.empty()) {
    const auto view = ParseView(request.view);
    if (!view) return Fail(view);
    options.view = *view;
  }
  auto look = LookOf(request, storage);
  if (!look) return Fail(look);
  options.look = std::move(*look);
  options.size = request.size;
  options.method = request.method;
  options.background = request.background;
  options.supersampling = request.supersampling;
  options.lens_medium = request.lens_medium;
  options.light = request.light;
  options.samples = request.samples;
  options.seed = request.seed;
  options.denoising = request.no_denoise ? Denoising::kOff : Denoising::kOn;
  options.dispersion = request.dispersion ? Dispersion::kOn : Dispersion::kOff;
  return options;
}

}  // namespace annulus
