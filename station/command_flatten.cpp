// flatten: a garment's pieces from lines on a body, laid flat as an elastic sheet (paper 001, section 5).

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/units.h"
#include "modeling/exchange/landmarks_json.h"
#include "modeling/flatten/flat_pattern.h"
#include "modeling/flatten/pattern_drawing.h"
#include "modeling/flatten/pattern_dxf.h"
#include "modeling/flatten/pattern_json.h"
#include "modeling/flatten/pattern_svg.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/mesh/mesh_io.h"
#include "station/commands.h"
#include "station/files.h"
#include "station/loaded_model.h"
#include "station/pattern_sheet.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct FlattenCommand {
  std::string in;
  std::string pattern;
  std::string landmarks;
  std::string second;
  std::vector<std::string> out;
  std::string save;
  std::string json;
};

std::string EndingOf(const std::string& path) { return std::filesystem::path(path).extension().string(); }

bool IsMesh(const std::string& path) {
  const std::string ending = EndingOf(path);
  return ending == ".obj" || ending == ".stl" || ending == ".ply";
}

/// "a/b.svg" becomes "a/b_2.svg".
std::string ForSecond(const std::string& path) {
  const std::filesystem::path whole(path);
  return (whole.parent_path() / (whole.stem().string() + "_2" + whole.extension().string())).string();
}

Status CheckEndings(const FlattenCommand& options, CommandIo& io) {
  for (const std::string& path : options.out) {
    const std::string ending = EndingOf(path);
    if (ending == ".svg" || ending == ".pdf" || ending == ".dxf" || ending == ".json" || ending == ".png") continue;
    io.set_failure_code(2);
    return Fail("write " + path, "its ending is '" + ending + "'", "use .svg, .pdf, .dxf, .json or .png (strain)");
  }
  if (!IsMesh(options.in) && options.pattern.empty()) {
    io.set_failure_code(2);
    return Fail("flatten " + options.in, "no pattern was given", "add --pattern PATTERN.json (docs/formats.md)");
  }
  return {};
}

Result<Pattern> ReadPattern(const FlattenCommand& options, CommandIo& io) {
  if (options.pattern.empty()) {
    Pattern plain;
    plain.name = std::filesystem::path(options.in).stem().string();
    return plain;
  }
  const auto text = ReadTextFile(io.storage(), options.pattern);
  if (!text) return Fail(text);
  return PatternFromJson(*text, options.pattern);
}

/// The landmarks by id; found only if the pattern names one.
Result<std::map<std::string, Eigen::Vector2d>> LandmarksFor(const Pattern& pattern, const LoadedModel& loaded,
                                                            const std::string& path, CommandIo& io) {
  std::map<std::string, Eigen::Vector2d> places;
  if (!NeedsLandmarks(pattern)) return places;
  Result<Landmarks> landmarks = FindLandmarks(loaded.body, {{}, io.stop()});
  if (landmarks && !path.empty()) {
    const auto text = ReadTextFile(io.storage(), path);
    if (!text) return Fail(text);
    landmarks = ApplyLandmarksFile(loaded.body, *landmarks, *text, path);
  }
  if (!landmarks) return Fail(landmarks);
  for (const Landmark& landmark : landmarks->found) {
    const bool point = landmark.kind == LandmarkKind::kPoint;
    places[landmark.id] = {point ? landmark.theta.value : std::numeric_limits<double>::quiet_NaN(), landmark.z.value};
  }
  return places;
}

Json PieceJson(const FlatPiece& piece) {
  double gap = 0.0;
  for (const PieceDart& dart : piece.body.darts) {
    const auto mouth = [&](std::size_t leg) { return piece.points[dart.legs[leg].front()[0]]; };
    gap = std::max(gap, (mouth(0) - mouth(1)).norm());
  }
  return {{"id", piece.id},
          {"triangles", piece.strains.size()},
          {"body_area_mm2", piece.body_area_mm2},
          {"flat_area_mm2", piece.flat_area_mm2},
          {"energy_n_mm", piece.energy},
          {"largest_strain", piece.largest_strain},
          {"strain_98", piece.strain_98},
          {"darts", piece.body.darts.size()},
          {"widest_dart_mm", gap}};
}

Json TipJson(const PatternPlace& place) {
  return {{"theta_deg", DegreesFromRadians(place.turn)},
          {"z_of", place.z_of},
          {"z_towards", place.z_towards},
          {"z_share", place.z_share.value_or(0.0)},
          {"z_mm", place.up}};
}

/// Divisions that the rule added to a piece's own.
Json ProposedSeamsJson(const Pattern& before, const Pattern& after) {
  Json proposals = Json::array();
  for (std::size_t p = 0; p < after.pieces.size(); ++p) {
    const PatternPiece& piece = after.pieces[p];
    for (std::size_t d = before.pieces[p].divisions.size(); d < piece.divisions.size(); ++d) {
      const PatternDivision& division = piece.divisions[d];
      const auto end = [&](std::size_t k) {
        return Json{{"line", after.lines[division.ends[k].line].id}, {"share", division.ends[k].share}};
      };
      Json through = Json::array();
      for (const PatternPlace& place : division.through) through.push_back(TipJson(place));
      proposals.push_back({{"piece", piece.id}, {"from", end(0)}, {"to", end(1)}, {"through", std::move(through)}});
    }
  }
  return proposals;
}

/// Darts that the rule added to a piece's own.
Json ProposedDartsJson(const Pattern& before, const Pattern& after) {
  Json proposals = Json::array();
  for (std::size_t p = 0; p < after.pieces.size(); ++p) {
    const PatternPiece& piece = after.pieces[p];
    for (std::size_t d = before.pieces[p].darts.size(); d < piece.darts.size(); ++d) {
      const PatternDart& dart = piece.darts[d];
      Json proposal{{"piece", piece.id}, {"line", after.lines[dart.line].id}, {"share", dart.share}};
      proposal.update(TipJson(dart.tip));
      proposals.push_back(std::move(proposal));
    }
  }
  return proposals;
}

Json ReportJson(const FlatPattern& flat) {
  Json pieces = Json::array();
  for (const FlatPiece& piece : flat.pieces) pieces.push_back(PieceJson(piece));
  Json seams = Json::array();
  for (const FlatSeam& seam : flat.seams) {
    seams.push_back({{"line", seam.line},
                     {"pieces", {flat.pieces[seam.piece[0]].id, flat.pieces[seam.piece[1]].id}},
                     {"body_mm", seam.body_mm},
                     {"flat_mm", {seam.flat_mm[0], seam.flat_mm[1]}},
                     {"mismatch_mm", std::abs(seam.flat_mm[0] - seam.flat_mm[1])}});
  }
  return {
      {"name", flat.name}, {"energy_n_mm", flat.energy}, {"steps", flat.steps}, {"pieces", pieces}, {"seams", seams}};
}

Status WriteFlat(const Pattern& pattern, const FlatPattern& flat, const std::string& path, CommandIo& io) {
  const std::string ending = EndingOf(path);
  if (ending == ".json") return io.WriteText(path, FlatPatternToJson(flat));
  if (ending == ".png") {
    const auto picture = StrainPicture(flat);
    if (!picture) return Fail(picture);
    return WritePngFile(io.storage(), path, *picture);
  }
  const std::vector<DrawnPiece> drawn = DrawPattern(pattern, flat);
  if (ending == ".svg") return io.WriteText(path, PatternSvg(drawn, flat.name));
  if (ending == ".dxf") return io.WriteText(path, PatternDxf(drawn));
  const auto pdf = PatternPdf(drawn, flat.name);
  if (!pdf) return Fail(pdf);
  return WriteFileAtomically(io.storage(), path, std::span<const std::byte>(*pdf));
}

/// Lays the pattern on one model; proposes darts and seams where the rule says so.
struct Laid {
  Pattern pattern;
  FlatPattern flat;
};
enum class Darts { kPropose, kKeep };
Result<Laid> Lay(const Pattern& pattern, const std::string& model, Darts darts, const FlattenCommand& options,
                 CommandIo& io) {
  const auto loaded = LoadModel(io, model);
  if (!loaded) return Fail(loaded);
  auto landmarks = LandmarksFor(pattern, *loaded, darts == Darts::kPropose ? options.landmarks : "", io);
  if (!landmarks) return Fail(landmarks);
  const PatternBody body{loaded->model->main(), std::move(*landmarks)};
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  Pattern chosen = pattern;
  if (darts == Darts::kPropose && pattern.darts.most + pattern.darts.seams > 0) {
    auto proposed = WithProposedCuts(pattern, body, task);
    if (!proposed) return Fail(proposed);
    chosen = std::move(*proposed);
  }
  auto flat = FlattenPattern(chosen, body, task);
  display.Clear();
  if (io.stop().stop_requested()) return tl::unexpected<Error>(InterruptedError("flatten " + model));
  if (!flat) return Fail(flat);
  return Laid{std::move(chosen), std::move(*flat)};
}

Result<Laid> LayMesh(const Pattern& pattern, const std::string& path, CommandIo& io) {
  const auto mesh = ReadMesh(io.storage(), path);
  if (!mesh) return Fail(mesh);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  auto flat = FlattenMesh(*mesh, pattern, task);
  display.Clear();
  if (io.stop().stop_requested()) return tl::unexpected<Error>(InterruptedError("flatten " + path));
  if (!flat) return Fail(flat);
  Pattern plain = pattern;
  plain.lines.clear();
  plain.pieces.clear();
  return Laid{std::move(plain), std::move(*flat)};
}

std::string Summary(const FlatPattern& flat) {
  std::string text;
  for (const FlatPiece& piece : flat.pieces) {
    text += fmt::format("{:20} {:10.1f} mm2   strain {:.2f} % (98 % of the area), {:.2f} % at most\n", piece.id,
                        piece.flat_area_mm2, 100.0 * piece.strain_98, 100.0 * piece.largest_strain);
  }
  for (const FlatSeam& seam : flat.seams) {
    text += fmt::format("{:20} {:10.1f} mm    both sides within {:.4f} mm\n", seam.line, seam.flat_mm[0],
                        std::abs(seam.flat_mm[0] - seam.flat_mm[1]));
  }
  return text;
}

Status RunFlatten(const FlattenCommand& options, CommandIo& io) {
  RETURN_IF_ERROR(CheckEndings(options, io));
  const auto pattern = ReadPattern(options, io);
  if (!pattern) return Fail(pattern);
  const auto first =
      IsMesh(options.in) ? LayMesh(*pattern, options.in, io) : Lay(*pattern, options.in, Darts::kPropose, options, io);
  if (!first) return Fail(first);
  Json report = ReportJson(first->flat);
  if (!IsMesh(options.in)) {
    report["proposed_darts"] = ProposedDartsJson(*pattern, first->pattern);
    report["proposed_seams"] = ProposedSeamsJson(*pattern, first->pattern);
  }
  std::optional<Laid> second;
  if (!options.second.empty()) {
    // Graded: the first body's pattern, darts included, laid anew on the second.
    auto graded = Lay(first->pattern, options.second, Darts::kKeep, options, io);
    if (!graded) return Fail(graded);
    report["model2"] = ReportJson(graded->flat);
    second = std::move(*graded);
  }
  for (const std::string& path : options.out) {
    RETURN_IF_ERROR(WriteFlat(first->pattern, first->flat, path, io));
    if (second) RETURN_IF_ERROR(WriteFlat(second->pattern, second->flat, ForSecond(path), io));
  }
  if (!options.save.empty()) RETURN_IF_ERROR(io.WriteText(options.save, PatternToJson(first->pattern)));
  if (!options.json.empty()) return io.WriteJson(options.json, report);
  return io.Print(Summary(first->flat));
}

}  // namespace

void AddFlattenCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<FlattenCommand>();
  CLI::App* command = app.add_subcommand("flatten", "cut a garment's pieces out of a body and lay them flat");
  command->add_option("model", options->in, "MODEL.json, or a mesh with one rim (.obj, .stl, .ply)")
      ->required()
      ->type_name("MODEL");
  command->add_option("--pattern", options->pattern, "lines and pieces (docs/formats.md, \"Pattern\")")
      ->type_name("PATTERN.json");
  command->add_option("--landmarks", options->landmarks, "landmarks set by hand")->type_name("F.json");
  command->add_option("--model2", options->second, "lay the same pattern on this body, too; its files end in _2")
      ->type_name("MODEL2.json");
  command
      ->add_option("--out", options->out,
                   "the pieces at 1:1: .svg, .pdf (A4 pages), .dxf; .json: triangles and strain; .png: strain")
      ->type_name("F");
  command->add_option("--save-pattern", options->save, "the pattern with the proposed darts and seams")
      ->type_name("F.json");
  AddJsonOption(*command, options->json);
  command->footer(
      "Example: annulus flatten body.json --pattern bodice.json --out bodice.pdf --out bodice.dxf --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunFlatten(*options, io); }; });
}

}  // namespace annulus
