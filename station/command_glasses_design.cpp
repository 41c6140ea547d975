// glasses design: a frame from the library of styles, its size and its fields.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "modeling/glasses/boxing.h"
#include "modeling/glasses/design_request.h"
#include "modeling/glasses/frame_fields.h"
#include "render/scene.h"
#include "station/command_glasses.h"
#include "station/design_picture.h"
#include "station/files.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct DesignOptions {
  DesignRequest request;
  std::vector<std::pair<std::string, std::string>> fields;  ///< One per field; empty texts are not asked for.
  std::string library;
  bool list = false;
  std::string out;
  std::string json;
  std::string picture;
  int picture_width = 720;
};

Json FieldToJson(const FrameField& field, const FrameDesign& design) {
  if (field.unit == FieldUnit::kWord) return FormWord(field, design);
  const auto number = ShownNumber(field, design);
  return number ? Json(*number) : Json();
}

DesignMaterial MaterialOf(const ComposedDesign& composed) {
  return composed.file.material.value_or(DesignMaterial::kAcetate);
}

/// Every field in its unit; details that the paper decides are null.
Json DesignReport(const ComposedDesign& composed, const Frame& frame) {
  const FrameDesign& design = composed.file.design;
  Json fields = Json::object();
  Json words = Json::object();
  for (const FrameField& field : FrameFields()) {
    fields[std::string(field.key)] = FieldToJson(field, design);
    if (!field.words.empty()) words[std::string(field.option)] = NearestWord(field, design);
  }
  const FrameBoxing boxing = BoxingOf(frame);
  const double temple = frame.arm_right.overall_length;
  return {{"style", design.style},
          {"material", DesignMaterialWord(MaterialOf(composed))},
          {"size", SizeText(boxing, temple)},
          {"boxing",
           {{"a_mm", boxing.a},
            {"b_mm", boxing.b},
            {"ed_mm", boxing.ed},
            {"dbl_mm", boxing.dbl},
            {"circumference_mm", boxing.circumference},
            {"temple_mm", temple}}},
          {"fields", fields},
          {"words", words},
          {"adjusted", composed.messages}};
}

/// A line on stderr that is no error.
void PrintNote(const std::string& text) {
  const std::string line = "annulus: " + text + "\n";
  std::fputs(line.c_str(), stderr);
}

std::string LibraryTable(const FrameLibrary& library) {
  std::string text = fmt::format("{:<20} {:<8} {:<34} {}\n", "style", "material", "sizes", "description");
  for (const LibraryStyle& style : library.styles) {
    std::string sizes;
    for (const SoldSize& size : style.sizes) {
      sizes += fmt::format("{}{:.0f}□{:.0f}-{:.0f}", sizes.empty() ? "" : " ", size.a, size.dbl, size.temple);
    }
    // By hand: the square counts as one column, not as its three bytes.
    const std::size_t columns = sizes.size() - 2 * style.sizes.size();
    text += fmt::format(
        "{:<20} {:<8} {}{} {}\n", style.name, DesignMaterialWord(style.material), sizes.empty() ? "-" : sizes,
        std::string(34 - std::min<std::size_t>(34, sizes.empty() ? 1 : columns), ' '), style.description);
  }
  return text;
}

Result<FrameLibrary> LibraryOf(const DesignOptions& options, CommandIo& io) {
  if (options.library.empty()) return BuiltInFrameLibrary();
  Result<FrameLibrary> own = ReadFrameLibraryFile(io.storage(), options.library);
  if (!own) return Fail(own);
  return Merged(*std::move(own), BuiltInFrameLibrary());
}

Status List(const FrameLibrary& library, const DesignOptions& options, CommandIo& io) {
  if (options.json.empty()) return io.Print(LibraryTable(library));
  Json json = Json::parse(FrameLibraryToJson(library));
  return io.WriteJson(options.json, json);
}

Status RunDesign(const DesignOptions& options, CommandIo& io) {
  const Result<FrameLibrary> library = LibraryOf(options, io);
  if (!library) return Fail(library);
  if (options.list) return List(*library, options, io);
  io.set_failure_code(2);  // What was typed is wrong.
  if (options.out.empty() && options.json.empty() && options.picture.empty()) {
    return Fail("design a frame", "nothing was asked for",
                "give --out FRAME.json, --json FILE, --picture F.png or --list");
  }
  DesignRequest request = options.request;
  for (const auto& [option, text] : options.fields) {
    if (!text.empty()) request.fields.emplace_back(option, text);
  }
  const Result<ComposedDesign> composed = ComposeDesign(*library, request);
  if (!composed) return Fail(composed);
  io.set_failure_code(1);
  for (const std::string& message : composed->messages) PrintNote("adjusted: " + message);
  const FrameFile& file = composed->file;
  const Result<Frame> frame = BuildFrame(file.design, file.adjustment.value_or(StandardAdjustment(file.design)));
  if (!frame) return Fail(frame);
  if (!options.out.empty()) RETURN_IF_ERROR(io.WriteText(options.out, FrameToJson(file)));
  if (!options.picture.empty()) {
    TaskContext task;
    task.stop = io.stop();
    const auto image = DrawDesign(*frame, MaterialOf(*composed), options.picture_width, task);
    if (!image) return Fail(image);
    RETURN_IF_ERROR(WritePngFile(io.storage(), options.picture, *image));
  }
  return options.json.empty() ? Status{} : io.WriteJson(options.json, DesignReport(*composed, *frame));
}

}  // namespace

void AddGlassesDesign(CLI::App& parent, CommandWork& chosen) {
  auto options = std::make_shared<DesignOptions>();
  options->request.style = "boston";
  CLI::App* command = parent.add_subcommand("design", "a frame from a style, a size and what is to differ");
  command->add_option("--style", options->request.style, "starting point; --list shows them")
      ->type_name("S")
      ->capture_default_str();
  command->add_option("--size", options->request.size, "a size of the style, or A-DBL-TEMPLE such as 50-18-145")
      ->type_name("NAME|MM-MM-MM");
  command->add_option("--library", options->library, "file of your own styles, beside the built-in ones")
      ->type_name("F.json");
  command->add_flag("--list", options->list, "print the library of styles");
  // Reserved first: the command line keeps references into it.
  options->fields.reserve(FrameFields().size());
  for (const FrameField& field : FrameFields()) {
    auto& entry = options->fields.emplace_back(std::string(field.option), std::string());
    command->add_option("--" + entry.first, entry.second, std::string(field.description))
        ->type_name(FieldSyntax(field));
  }
  command->add_option("--out", options->out, "frame to write")->type_name("FRAME.json");
  command->add_option("--picture", options->picture, "picture of the frame from the front")->type_name("F.png");
  command->add_option("--picture-width", options->picture_width, "its pixels")
      ->check(CLI::Range(16, kMaxImageSize))
      ->capture_default_str();
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus glasses design --style round --size 46-22-145 --bridge keyhole --out frame.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunDesign(*options, io); }; });
}

}  // namespace annulus
