// glasses export: the files from which a frame and its lenses are made.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "station/command_glasses.h"
#include "station/files.h"
#include "station/glasses_drawing.h"
#include "station/glasses_export.h"
#include "station/order_sheet.h"

namespace annulus {
namespace {

struct ExportOptions {
  std::string source;
  std::vector<std::string> outs;
  std::string order_sheet;
  std::string prescription;
  double least_wall = 0.0;
  std::string json;
  bool fused = false;
  bool force = false;
  GlassesExportOptions glasses;
};

/// What a name ends in, and what is written then.
struct ExportFormat {
  const char* ending;
  std::function<Result<ExportedFile>(const GlassesSource&, const GlassesExportOptions&)> write;
};

const std::vector<ExportFormat>& Formats() {
  static const std::vector<ExportFormat> formats = {
      {".stl", GlassesStl},
      {".step", GlassesStep},
      {".dcs", GlassesDcs},
      {".json", [](const GlassesSource& source,
                   const GlassesExportOptions&) { return Result<ExportedFile>(GlassesJson(source)); }},
      {".pdf", GlassesDrawing},
  };
  return formats;
}

Result<const ExportFormat*> FormatOf(const std::string& path) {
  for (const ExportFormat& format : Formats()) {
    if (path.ends_with(format.ending)) return &format;
  }
  return Fail("export glasses to " + path, "the format is not known from this name",
              "give a name that ends in .stl, .step, .dcs, .json or .pdf");
}

/// The error with the source and the target in front.
tl::unexpected<Error> FailTo(const std::string& source, const std::string& target, Error error) {
  error.attempted = fmt::format("export {} to {}: {}", source, target, error.attempted);
  return tl::unexpected(error);
}

using MadeFiles = std::vector<std::pair<std::string, ExportedFile>>;

/// {"notes": ["file: what its maker should know", …], "solids": [{"name", "volume_mm3", "fused", "pieces"}, …]}.
nlohmann::ordered_json ReportOf(const MadeFiles& made) {
  nlohmann::ordered_json report{{"notes", nlohmann::ordered_json::array()},
                                {"solids", nlohmann::ordered_json::array()}};
  for (const auto& [path, file] : made) {
    for (const std::string& note : file.notes) report["notes"].push_back(fmt::format("{}: {}", path, note));
    for (const ExportedSolid& solid : file.solids) {
      report["solids"].push_back(
          {{"name", solid.body}, {"volume_mm3", solid.volume}, {"fused", solid.fused}, {"pieces", solid.pieces}});
    }
  }
  return report;
}

Status RunExport(ExportOptions options, CommandIo& io) {
  std::vector<const ExportFormat*> formats;
  for (const std::string& out : options.outs) {
    const auto format = FormatOf(out);
    if (!format) return Fail(format);
    formats.push_back(*format);
  }
  const auto source = ReadGlasses(io.storage(), options.source);
  if (!source) return Fail(source);
  if (!options.prescription.empty()) {
    const auto text = ReadTextFile(io.storage(), options.prescription);
    if (!text) return Fail(text);
    const auto order = PrescriptionFromJson(*text, options.prescription);
    if (!order) return Fail(order);
    options.glasses.prescription = *order;
  } else if (source->worn) {
    auto kept = KeptOrderOf(*source->worn, options.source);
    if (!kept) return Fail(kept);
    if (*kept) {
      options.glasses.prescription = (*kept)->order;
      options.glasses.lenses = Completed(options.glasses.lenses, (*kept)->choice);
    }
  }
  if (options.fused) options.glasses.skin = GlassesExportOptions::Skin::kFused;
  if (options.force) options.glasses.thin_walls = GlassesExportOptions::ThinWalls::kWarn;
  if (options.least_wall > 0.0) options.glasses.least_wall = options.least_wall;
  // All files are made before the first is written: an error leaves nothing behind.
  MadeFiles made;
  for (std::size_t k = 0; k < formats.size(); ++k) {
    auto file = formats[k]->write(*source, options.glasses);
    if (!file) return FailTo(options.source, options.outs[k], file.error());
    made.emplace_back(options.outs[k], std::move(*file));
  }
  if (!options.order_sheet.empty()) {
    auto sheet = OrderSheet(*source, options.glasses);
    if (!sheet) return FailTo(options.source, options.order_sheet, sheet.error());
    made.emplace_back(options.order_sheet, std::move(*sheet));
  }
  std::string text;
  for (const auto& [path, file] : made) {
    RETURN_IF_ERROR(io.WriteText(path, file.bytes));
    for (const std::string& note : file.notes) text += fmt::format("{}: {}\n", path, note);
  }
  return options.json.empty() ? io.Print(text) : io.WriteJson(options.json, ReportOf(made));
}

}  // namespace

void AddGlassesExport(CLI::App& parent, CommandWork& chosen) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = parent.add_subcommand("export", "the files from which a frame and its lenses are made");
  command->add_option("source", options->source, "worn frame, or a design")
      ->required()
      ->type_name("WORN.json|FRAME.json");
  command
      ->add_option(
          "--out", options->outs,
          "file to write; may be repeated: .stl for printing, .step solid, .dcs trace for the lab, .json design, "
          ".pdf drawing 1:1")
      ->required()
      ->type_name("F.{stl,step,dcs,json,pdf}");
  command->add_option("--order-sheet", options->order_sheet, "order sheet to write besides")->type_name("F.pdf");
  command
      ->add_option("--rx", options->prescription,
                   "prescription of the lenses; without it that of the fit, with its lenses")
      ->type_name("RX.json");
  AddLensOptions(*command, options->glasses.lenses);
  command
      ->add_option("--confirmed-by", options->glasses.confirmed_by,
                   "who confirmed PDs and heights; without it no .dcs is written")
      ->type_name("NAME");
  command->add_option("--reference", options->glasses.reference, "of the customer or the order")->type_name("REF");
  command->add_option("--min-wall", options->least_wall, "thinnest wall of your process, mm")
      ->type_name("MM")
      ->check(CLI::Range(0.01, 20.0));
  command->add_flag("--fused", options->fused, "STL with one skin round each body");
  command->add_flag("--force", options->force, "write although a wall is too thin");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus glasses export worn.json --out frame.stl --out frame.pdf");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunExport(*options, io); }; });
}

}  // namespace annulus
