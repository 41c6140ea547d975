#include "modeling/glasses/frame_json.h"

#include <nlohmann/json.hpp>

#include "modeling/glasses/design_json.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus-frame";
constexpr int kVersion = 2;
constexpr const char* kAdvice = "make it again with annulus glasses design";

/// The name of the style; a file need not have one.
Result<std::string> ReadStyle(const JsonReader& reader, const Json& object) {
  return object.contains("style") ? reader.Text(object, "style") : std::string();
}

Status CheckBuilds(const JsonReader& reader, const FrameFile& file) {
  const Result<Frame> frame = BuildFrame(file.design, file.adjustment.value_or(StandardAdjustment(file.design)));
  if (!frame) return reader.Refuse(frame.error().seen);
  return {};
}

}  // namespace

std::string FrameToJson(const FrameFile& file) {
  Json root{{"format", kFormat}, {"version", kVersion}};
  PutDesign(root, file.design, file.material);
  if (file.adjustment) root["adjustment"] = AdjustmentToJson(*file.adjustment);
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool IsFrameJson(std::string_view text) { return text.substr(0, 200).find(kFormat) != std::string_view::npos; }

Result<FrameFile> FrameFromJson(std::string_view json, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const Result<Json> root = reader.Root(json);
  if (!root) return Fail(root);
  const Result<int> version = reader.Version(*root, kFormat, kVersion);
  if (!version) return Fail(version);
  RETURN_IF_ERROR(*version == 1 ? reader.OnlyKeys(*root, {"format", "version", "style", "parameters"})
                                : reader.OnlyKeys(*root, {"format", "version", "style", "material", "parameters",
                                                          "details", "adjustment"}));
  FrameFile file;
  const Result<FrameDesign> design = ReadDesign(reader, *root);
  if (!design) return Fail(design);
  file.design = *design;
  const Result<std::string> style = ReadStyle(reader, *root);
  if (!style) return Fail(style);
  file.design.style = *style;
  const auto material = ReadMaterial(reader, *root);
  if (!material) return Fail(material);
  file.material = *material;
  if (root->contains("adjustment")) {
    const Result<FrameAdjustment> adjustment = ReadAdjustment(reader, *root);
    if (!adjustment) return Fail(adjustment);
    file.adjustment = *adjustment;
  }
  RETURN_IF_ERROR(CheckBuilds(reader, file));
  return file;
}

}  // namespace annulus
