// section, slab and measure: numbers from a model.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/storage.h"
#include "base/units.h"
#include "modeling/exchange/landmarks_json.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/measure/plane_cut.h"
#include "modeling/measure/section.h"
#include "modeling/measure/section_svg.h"
#include "modeling/measure/slab.h"
#include "modeling/measure/taut_tape.h"
#include "modeling/table/table.h"
#include "station/commands.h"
#include "station/loaded_model.h"
#include "station/measurement_files.h"
#include "station/measurement_output.h"
#include "station/section_output.h"
#include "station/units_text.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct SectionOptions {
  std::string model;
  double z_mm = 0.0;
  double tilt_deg = 0.0;
  double lean_deg = 0.0;
  std::string svg;
  std::string json;

  [[nodiscard]] bool IsLevel() const { return tilt_deg == 0.0 && lean_deg == 0.0; }
};

/// The girth in a plane that is not level. It crosses the ring's axis at the height asked for.
Status RunTiltedSection(const SectionOptions& options, CommandIo& io) {
  if (!options.svg.empty()) {
    io.set_failure_code(2);
    return Fail("draw the section", "a tilted plane was asked for", "leave out --svg, or --tilt and --lean");
  }
  const auto loaded = LoadModel(io, options.model);
  if (!loaded) return Fail(loaded);
  const Eigen::Vector3d normal = Eigen::Vector3d(std::tan(RadiansFromDegrees(options.lean_deg)),
                                                 std::tan(RadiansFromDegrees(options.tilt_deg)), 1.0)
                                     .normalized();
  const auto girth = GirthInPlane(loaded->body, {normal, normal.z() * options.z_mm});
  if (!girth) return Fail(girth);
  const std::vector<Uncertain> numbers = loaded->body.WithSigmas({girth->perimeter, girth->tape, girth->area});
  if (options.json.empty()) {
    return io.Print(
        fmt::format("section in a plane through z = {:.1f} mm on the axis, front {:g} deg and right {:g} deg "
                    "lower ({:.1f} % measured)\n",
                    options.z_mm, options.tilt_deg, options.lean_deg, 100.0 * girth->knowledge.measured) +
        fmt::format("  perimeter {:10.2f} mm   {}\n", numbers[0].value, HalfWidth95Text(numbers[0], 2)) +
        fmt::format("  tape      {:10.2f} mm   {}\n", numbers[1].value, HalfWidth95Text(numbers[1], 2)) +
        fmt::format("  area      {:10.1f} mm²  {}\n", numbers[2].value, HalfWidth95Text(numbers[2], 1)));
  }
  return io.WriteJson(options.json, {{"z_mm", options.z_mm},
                                     {"tilt_deg", options.tilt_deg},
                                     {"lean_deg", options.lean_deg},
                                     {"perimeter_mm", numbers[0].value},
                                     {"tape_mm", numbers[1].value},
                                     {"area_mm2", numbers[2].value},
                                     {"perimeter_sigma_mm", JsonNumber(numbers[0].sigma)},
                                     {"tape_sigma_mm", JsonNumber(numbers[1].sigma)},
                                     {"area_sigma_mm2", JsonNumber(numbers[2].sigma)},
                                     {"measured_share", girth->knowledge.measured}});
}

Status RunSection(const SectionOptions& options, CommandIo& io) {
  if (!options.IsLevel()) return RunTiltedSection(options, io);
  const auto loaded = LoadModel(io, options.model);
  if (!loaded) return Fail(loaded);
  if (!options.svg.empty()) {  // first: what has gaps can be drawn, though not measured
    const auto svg = SectionSvg(loaded->body, options.z_mm, {});
    if (!svg) return Fail(svg);
    RETURN_IF_ERROR(io.WriteText(options.svg, *svg));
  }
  const auto s = MeasureSection(loaded->body, options.z_mm);
  if (!s) return Fail(s);
  const auto loop = TautLoop(loaded->body, options.z_mm);  // beside what was not seen there is none
  const Uncertain taut = loop ? loaded->body.WithSigma(loop->length) : Uncertain{kNone, kNone};
  const std::string not_one_loop = WhyNotOneLoop(*loaded->model, *s);
  if (options.json.empty()) {
    const std::string note = not_one_loop.empty() ? "" : "  not one visible loop: " + not_one_loop + "\n";
    return io.Print(
        fmt::format("section at z = {:.1f} mm ({:.1f} % measured)\n", s->z, 100.0 * s->measured_share) +
        fmt::format("  perimeter {:10.2f} mm   {}\n", s->perimeter.value, HalfWidth95Text(s->perimeter, 2)) +
        fmt::format("  tape      {:10.2f} mm   {}\n", s->tape.value, HalfWidth95Text(s->tape, 2)) +
        (loop ? fmt::format("  taut tape {:10.2f} mm   {}\n", taut.value, HalfWidth95Text(taut, 2)) : "") +
        fmt::format("  area      {:10.1f} mm²  {}\n", s->area.value, HalfWidth95Text(s->area, 1)) + note);
  }
  return io.WriteJson(options.json, SectionToJson(*loaded->model, *s, taut));
}

struct SlabOptions {
  std::string model;
  double z_min_mm = 0.0;
  double z_max_mm = 0.0;
  std::string json;
};

Status RunSlab(const SlabOptions& options, CommandIo& io) {
  const auto loaded = LoadModel(io, options.model);
  if (!loaded) return Fail(loaded);
  const auto s = MeasureSlab(loaded->body, options.z_min_mm, options.z_max_mm);
  if (!s) return Fail(s);
  if (options.json.empty()) {
    return io.Print(fmt::format("slab from z = {:.1f} to {:.1f} mm ({:.1f} % measured)\n", s->z_min, s->z_max,
                                100.0 * s->measured_share) +
                    fmt::format("  volume {:12.0f} mm³  {}\n", s->volume.value, HalfWidth95Text(s->volume, 0)) +
                    fmt::format("  area   {:12.0f} mm²  {}\n", s->area.value, HalfWidth95Text(s->area, 0)));
  }
  return io.WriteJson(options.json, {{"z_min_mm", s->z_min},
                                     {"z_max_mm", s->z_max},
                                     {"volume_mm3", s->volume.value},
                                     {"area_mm2", s->area.value},
                                     {"volume_sigma_mm3", JsonNumber(s->volume.sigma)},
                                     {"area_sigma_mm2", JsonNumber(s->area.sigma)},
                                     {"measured_share", s->measured_share}});
}

struct MeasureOptions {
  std::string model;
  std::string landmarks;
  std::vector<std::string> out;
  std::string json;
  SheetOptions sheet;
};

/// Writes every file asked for; says what a format could not hold unless stdout is the result's.
Status WriteFiles(const MeasureOptions& options, const MeasuredModel& measured, CommandIo& io) {
  for (const std::string& path : options.out) {
    const auto left_out = WriteMeasurements(io.storage(), path, measured, options.sheet);
    if (!left_out) return Fail(left_out);
    if (options.json == "-") continue;
    for (const NamesOfReason& entry : GatherByReason(*left_out)) {
      RETURN_IF_ERROR(io.Print(path + " leaves out " + entry.names + ": " + entry.reason + "\n"));
    }
  }
  return {};
}

/// The landmarks with those of a file set by hand.
Result<Landmarks> WithFile(const MeasuredSurface& body, const Landmarks& landmarks, const std::string& path,
                           CommandIo& io) {
  const auto text = ReadTextFile(io.storage(), path);
  if (!text) return Fail(text);
  return ApplyLandmarksFile(body, landmarks, *text, path);
}

Status RunMeasure(const MeasureOptions& options, CommandIo& io) {
  for (const std::string& path : options.out) {
    if (const auto format = MeasurementFormatOf(path); !format) {
      io.set_failure_code(2);
      return Fail(format);
    }
  }
  const auto loaded = LoadModel(io, options.model);
  if (!loaded) return Fail(loaded);
  ProgressDisplay display(io.progress_mode());
  TaskContext context;
  context.stop = io.stop();
  context.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  Result<Landmarks> landmarks = FindLandmarks(loaded->body, context);
  if (!options.landmarks.empty()) landmarks = WithFile(loaded->body, *landmarks, options.landmarks, io);
  if (!landmarks) return Fail(landmarks);
  const auto table = MeasureTable(loaded->body, std::move(*landmarks));
  display.Clear();
  if (!table) {
    Error error = table.error();
    error.attempted = "measure " + options.model;
    return tl::unexpected(error);
  }
  RETURN_IF_ERROR(WriteFiles(options, {*table, *loaded->model}, io));
  if (!options.json.empty()) return io.WriteJson(options.json, MeasurementsToJson(*table));
  return options.out.empty() ? io.Print(MeasurementsToText(*table)) : Status{};
}

void AddSheetOptions(CLI::App& command, SheetOptions& sheet) {
  const auto set_language = [&sheet](const std::string& name) {
    sheet.language = name == "ja" ? SheetLanguage::kJapanese : SheetLanguage::kEnglish;
  };
  command.add_option_function<std::string>("--language", set_language, "language of the PDF sheet")
      ->check(CLI::IsMember({"en", "ja"}).description(""))
      ->type_name("en|ja");
  const auto set_unit = [&sheet](const std::string& name) { sheet.unit = *LengthUnitFromName(name); };
  command.add_option_function<std::string>("--units", set_unit, "units of the PDF sheet; inches in eighths")
      ->check(CLI::IsMember({"mm", "cm", "inch"}).description(""))
      ->type_name("mm|cm|inch");
  command.add_option("--subject", sheet.subject, "subject's name or number on the PDF sheet")->type_name("TEXT");
}

}  // namespace

void AddSectionCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<SectionOptions>();
  CLI::App* command = app.add_subcommand("section", "perimeter, tape and area of a section, horizontal or tilted");
  command->add_option("model", options->model, "model")->required();
  command->add_option("--z", options->z_mm, "height of the section, mm")->required()->type_name("MM");
  command->add_option("--tilt", options->tilt_deg, "the plane falls to the front by so many degrees")
      ->check(CLI::Range(-75.0, 75.0))
      ->type_name("DEG");
  command->add_option("--lean", options->lean_deg, "the plane falls to the subject's right by so many degrees")
      ->check(CLI::Range(-75.0, 75.0))
      ->type_name("DEG");
  command->add_option("--svg", options->svg, "picture of the section in true scale")->type_name("F");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus section model.json --z 1050 --svg section.svg --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunSection(*options, io); }; });
}

void AddSlabCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<SlabOptions>();
  CLI::App* command = app.add_subcommand("slab", "volume and skin area between two heights");
  command->add_option("model", options->model, "model")->required();
  command->add_option("--z-min", options->z_min_mm, "lower plane, mm")->required()->type_name("A");
  command->add_option("--z-max", options->z_max_mm, "upper plane, mm")->required()->type_name("B");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus slab model.json --z-min 900 --z-max 1200 --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunSlab(*options, io); }; });
}

void AddMeasureCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<MeasureOptions>();
  CLI::App* command = app.add_subcommand("measure", "the table of measurements, each with its uncertainty");
  command->add_option("model", options->model, "model")->required();
  command->add_option("--landmarks", options->landmarks, "landmarks set by hand: a file of `annulus landmarks`")
      ->type_name("F");
  command
      ->add_option("--out", options->out,
                   "file to write, by its ending: .json .csv .smis .vit .freesewing.json .pdf; may be repeated")
      ->type_name("F");
  AddSheetOptions(*command, options->sheet);
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus measure model.json --out table.csv --out sheet.pdf --language ja");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunMeasure(*options, io); }; });
}

}  // namespace annulus
