#include "station/wrinkly_source.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "modeling/exchange/model_json.h"
#include "modeling/glasses/frame.h"
#include "modeling/mesh/tessellate.h"
#include "modeling/wrinkly/control_mesh_json.h"
#include "modeling/wrinkly/control_nets.h"
#include "modeling/wrinkly/dress.h"
#include "modeling/wrinkly/quad_mesh.h"
#include "station/files.h"
#include "station/glasses_source.h"

namespace annulus {
namespace {

/// A scene of the paper: its net and the heights that its points take.
struct PaperScene {
  const char* name;
  const char* net;
  double low, high;
};
constexpr std::array<PaperScene, 4> kScenes{{{"figure12a", "directions:2x4", 0.0, 22.0},
                                             {"figure12b", "directions:4x4", 0.0, 22.0},
                                             {"figure12c", "ring:12x5", 0.0, 22.0},
                                             {"figure13", "directions:3x5", 0.0, 22.0}}};

std::string FormatOf(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return "";
  const auto format = json.find("format");
  return format != json.end() && format->is_string() ? format->get<std::string>() : "";
}

Result<WrinklySource> Made(ControlMeshParts parts, const WrinklySourceOptions& options, FamilyRule rule) {
  if (options.random) DressAtRandom(parts, options.random->at(0), options.random->at(1), options.seed);
  auto mesh = ControlMesh::Make(std::move(parts), options.cut ? FamilyRule::kCut : rule);
  if (!mesh) return Fail(mesh);
  return WrinklySource{std::move(*mesh)};
}

Result<WrinklySource> OfModel(const std::string& text, const WrinklySourceOptions& options) {
  const auto model = ModelFromJson(text, options.in);
  if (!model) return Fail(model);
  const SplineSurface& surface = model->main().surface;
  Result<ControlMeshParts> parts = Fail("dress " + options.in, fmt::format("its dress is '{}'", options.dress),
                                        "give a model --dress hair or --dress knit");
  if (options.dress == "hair") parts = HairOf(surface, options.length_mm, options.seed);
  if (options.dress == "knit") {
    const double middle = 0.5 * (surface.z_min() + surface.z_max());
    parts =
        KnitOf(surface, {options.z_min.value_or(middle - 60.0), options.z_max.value_or(middle + 60.0)}, options.seed);
  }
  if (!parts) return Fail(parts);
  auto source = Made(std::move(*parts), options, FamilyRule::kRefuse);
  if (!source) return Fail(source);
  TessellationOptions tessellation;
  tessellation.ends = EndClosure::kBoth;
  for (const SurfaceSegment& segment : model->segments) {
    Append(source->beside, TessellateSurface(segment, tessellation));
  }
  return source;
}

Result<WrinklySource> OfFrame(const WrinklySourceOptions& options, CommandIo& io) {
  const auto glasses = ReadGlasses(io.storage(), options.in);
  if (!glasses) return Fail(glasses);
  if (options.dress != "tortoise" && options.dress != "carved") {
    return Fail("dress " + options.in, fmt::format("its dress is '{}'", options.dress),
                "give a frame --dress tortoise or --dress carved");
  }
  std::vector<PatchShell> shells;
  for (const FrameBody& body : FrameBodies(glasses->frame)) {
    shells.insert(shells.end(), body.shells.begin(), body.shells.end());
  }
  const FrameTexture texture = options.dress == "carved" ? FrameTexture::kCarved : FrameTexture::kTortoise;
  auto parts = TexturedFrame(shells, texture, options.seed);
  if (!parts) return Fail(parts);
  return Made(std::move(*parts), options, FamilyRule::kCut);
}

Result<WrinklySource> OfFile(const WrinklySourceOptions& options, CommandIo& io) {
  const auto text = ReadTextFile(io.storage(), options.in);
  if (!text) return Fail(text);
  if (std::filesystem::path(options.in).extension() == ".obj") {
    const auto quads = QuadMeshFromObj(*text, options.in, options.split ? PolygonRule::kSplit : PolygonRule::kRefuse);
    if (!quads) return Fail(quads);
    auto parts = ControlMeshOfQuads(*quads);
    if (!parts) return Fail(parts);
    return Made(std::move(*parts), options, FamilyRule::kRefuse);
  }
  const std::string format = FormatOf(*text);
  if (format == "annulus wrinkly mesh") {
    auto parts = ControlMeshFromJson(*text, options.in);
    if (!parts) return Fail(parts);
    return Made(std::move(*parts), options, FamilyRule::kRefuse);
  }
  if (format == "annulus-model") return OfModel(*text, options);
  if (format == "annulus-frame" || format == "annulus-worn") return OfFrame(options, io);
  return Fail("read " + options.in,
              format.empty() ? std::string("it is no JSON object with a format") : "its format is '" + format + "'",
              "give a control mesh (docs/formats.md), MODEL.json or FRAME.json");
}

}  // namespace

Result<WrinklySource> ReadWrinklySource(const WrinklySourceOptions& options, CommandIo& io) {
  if (options.in == "bear") {
    Bear bear = MakeBear(options.seed);
    auto source = Made(std::move(bear.mesh), options, FamilyRule::kRefuse);
    if (source) source->balls = std::move(bear.balls);
    return source;
  }
  for (const PaperScene& scene : kScenes) {
    if (options.in != scene.name) continue;
    auto parts = MakeNet(std::string_view(scene.net));
    if (!parts) return Fail(parts);
    DressAtRandom(*parts, scene.low, scene.high, options.seed);
    return Made(std::move(*parts), options, FamilyRule::kRefuse);
  }
  const bool is_file = std::filesystem::path(options.in).has_extension();
  if (is_file) return OfFile(options, io);
  auto parts = MakeNet(std::string_view(options.in));
  if (!parts) {
    io.set_failure_code(2);
    return Fail(parts);
  }
  return Made(std::move(*parts), options, FamilyRule::kRefuse);
}

}  // namespace annulus
