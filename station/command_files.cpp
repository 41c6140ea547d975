// The commands that bring scans in and out: import, export, inspect.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "acquisition/csv_scan.h"
#include "acquisition/hdf5_writer.h"
#include "acquisition/recording.h"
#include "acquisition/recording_recovery.h"
#include "acquisition/reference_returns.h"
#include "acquisition/scan_plan.h"
#include "acquisition/scan_quality.h"
#include "base/log.h"
#include "base/sha256.h"
#include "fitting/paper_model.h"
#include "modeling/exchange/model_json.h"
#include "modeling/glasses/frame_fields.h"
#include "modeling/glasses/frame_json.h"
#include "station/commands.h"
#include "station/files.h"
#include "station/key_file.h"
#include "station/quality_picture.h"

namespace annulus {
namespace {

struct ImportOptions {
  std::string points;
  std::string out;
  bool force = false;
};

Status Import(const ImportOptions& options, CommandIo& io) {
  RETURN_IF_ERROR(CheckReplacing(io.storage(), options.out, options.force ? Replacing::kForce : Replacing::kRefuse));
  const auto scan = ReadCsvScan(io.storage(), options.points);
  if (!scan) return Fail(scan);
  return WriteRecording(io.storage(), options.out, *scan);
}

struct ExportOptions {
  std::string scan;
  std::string out;
  std::string key_file;
};

bool EndsWith(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

/// The whole recording as plain MCAP, packed anew.
Status ExportPlain(const ExportOptions& options, const KeySource* keys, CommandIo& io) {
  const auto summary = RecoverRecording(io.storage(), options.scan, options.out, keys, RecoveredAs::kPlain);
  if (!summary) return Fail(summary);
  if (!summary->lossless || !summary->was_finished) {
    Log(LogLevel::kWarning, options.scan + " is damaged or unfinished: " + summary->BriefReport());
  }
  return {};
}

Status ExportHdf5(const ExportOptions& options, const KeySource* keys, CommandIo& io) {
  const auto recording = ReadWholeRecording(io.storage(), options.scan, keys);
  if (!recording) return Fail(recording);
  if (!recording->report.clean()) Log(LogLevel::kWarning, options.scan + " is damaged or unfinished");
  return WriteHdf5Recording(io.storage(), options.out, *recording);
}

Status Export(const ExportOptions& options, CommandIo& io) {
  const bool table = EndsWith(options.out, ".csv") || EndsWith(options.out, ".csv.gz");
  const bool hdf5 = EndsWith(options.out, ".h5");
  const bool mcap = EndsWith(options.out, ".mcap");
  if (!table && !mcap && !hdf5) {
    return Fail("export to " + options.out, "the format is not known from this name",
                "give a name that ends in .csv, .csv.gz, .mcap or .h5");
  }
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  if (mcap) return ExportPlain(options, keys->get(), io);
  if (hdf5) return ExportHdf5(options, keys->get(), io);
  const auto scan = ReadRecording(io.storage(), options.scan, keys->get());
  if (!scan) return Fail(scan);
  return WriteCsvScan(io.storage(), options.out, *scan);
}

using Json = nlohmann::ordered_json;

Json CountsJson(const std::map<std::string, std::uint64_t>& counts) {
  Json json = Json::object();
  for (const auto& [topic, count] : counts) json[topic] = count;
  return json;
}

/// Null for a scan that no machine of ours took.
Json MachineJson(const RecordedMachine& machine) {
  if (machine == RecordedMachine{}) return nullptr;
  Json boards = Json::array();
  for (const RecordedBoard& board : machine.boards) {
    boards.push_back({{"serial", board.serial},
                      {"first_sensor", board.first_sensor},
                      {"sensor_count", board.sensor_count},
                      {"firmware_version", board.firmware_version}});
  }
  return {{"ring_bus", machine.ring_bus},
          {"level_rate_hz", machine.level_rate_hz},
          {"ring_temperature_c", machine.ring_temperature_c ? Json(*machine.ring_temperature_c) : Json()},
          {"boards", std::move(boards)},
          {"axis_serial", machine.axis_serial},
          {"axis_firmware_version", machine.axis_firmware_version},
          {"axis_z_min_mm", machine.axis_z_min_mm},
          {"axis_z_max_mm", machine.axis_z_max_mm}};
}

/// Null without reference sensors.
Json ReferenceJson(const Scan& scan) {
  if (!scan.header.reference) return nullptr;
  std::size_t levels = 0;
  for (const ScanLevel& level : scan.levels) levels += level.reference_time.count() != 0 ? 1 : 0;
  Json sensors = Json::array();
  for (const ReferenceSensor& sensor : scan.header.reference->sensors) {
    sensors.push_back({{"channel", sensor.channel},
                       {"theta_deg", DegreesFromRadians(sensor.theta)},
                       {"distance_mm", sensor.distance_mm},
                       {"height_mm", sensor.height_mm},
                       {"aim_deg", DegreesFromRadians(sensor.aim)}});
  }
  return {{"board", scan.header.reference->board},
          {"firmware_version", scan.header.reference->firmware_version},
          {"sensors", std::move(sensors)},
          {"levels", levels},
          {"returns", ReferenceReturns(scan).size()}};
}

Json InspectRecording(const Recording& recording, const ScanQuality& quality) {
  const Scan& scan = recording.scan;
  std::size_t returns = 0;
  double z_min = std::numeric_limits<double>::infinity();
  double z_max = -z_min;
  std::uint16_t sweeps = 0;
  for (const ScanLevel& level : scan.levels) {
    sweeps = std::max<std::uint16_t>(sweeps, static_cast<std::uint16_t>(level.sweep + 1));
    for (const RangeReading& reading : level.readings) {
      if (reading.range_mm == reading.range_mm) ++returns;
      z_min = std::min(z_min, reading.z_mm);
      z_max = std::max(z_max, reading.z_mm);
    }
  }
  const auto plan = PlanFromJson(scan.header.plan_json);
  return {{"kind", "recording"},
          {"finished", recording.report.finished},
          {"levels", scan.levels.size()},
          {"planned_levels", plan ? Json(plan->TotalLevels()) : Json()},
          {"sealed", recording.report.sealed},
          {"recovered", recording.report.recovered},
          {"levels_lost", recording.report.levels_lost},
          {"messages", CountsJson(recording.report.messages)},
          {"messages_lost", CountsJson(recording.report.messages_lost)},
          {"notes", recording.report.notes},
          {"sweeps", sweeps},
          {"sensors", scan.header.calibration.sensors.size()},
          {"calibration", scan.header.calibration.certificate},
          {"returns", returns},
          {"z_min_mm", z_min},
          {"z_max_mm", z_max},
          {"ring_radius_mm", scan.header.ring_radius_mm},
          {"profile", scan.header.profile},
          {"station", scan.header.station_id},
          {"source", scan.header.source},
          {"program_version", scan.header.program_version},
          {"seed", scan.header.seed},
          {"machine", MachineJson(scan.header.machine)},
          {"reference", ReferenceJson(scan)},
          {"axis_points", recording.axis.size()},
          {"events", recording.events.size()},
          {"hash", ScanHash(scan)},
          {"verdict", VerdictName(quality.verdict)},
          {"quality", Json::parse(JsonFromQuality(quality))}};
}

/// The paper's parameters and what was chosen beyond them, in the fields' units.
Json InspectFrame(const FrameDesign& design) {
  Json json{{"kind", "frame"}};
  if (!design.style.empty()) json["style"] = design.style;
  for (const FrameField& field : FrameFields()) {
    if (field.unit == FieldUnit::kWord) {
      json[std::string(field.key)] = FormWord(field, design);
    } else if (const auto number = ShownNumber(field, design)) {
      json[std::string(field.key)] = *number;
    }
  }
  return json;
}

Json InspectModel(const SurfaceModel& model) {
  Json surfaces = Json::array();
  for (const SurfaceSegment& segment : model.segments) {
    std::array<std::size_t, 3> cells{};
    for (std::size_t row = 0; row < segment.knowledge.rows(); ++row) {
      for (std::size_t column = 0; column < segment.knowledge.columns(); ++column) {
        ++cells[static_cast<std::size_t>(segment.knowledge.Cell(column, row))];
      }
    }
    surfaces.push_back({{"name", segment.name},
                        {"z_min_mm", segment.surface.z_min()},
                        {"z_max_mm", segment.surface.z_max()},
                        {"coefficients", segment.surface.coefficients().size()},
                        {"has_covariance", segment.normal_matrix.nonZeros() > 0},
                        {"cells_measured", cells[2]},
                        {"cells_inferred", cells[1]},
                        {"cells_unknown", cells[0]}});
    if (segment.paper == nullptr) continue;
    const PaperSurface& paper = segment.paper->surface;
    surfaces.back()["coefficients"] = paper.control().size();  // the tensor form is made when the file is read
    surfaces.back()["theta_knots"] = paper.theta_knots().size();
    surfaces.back()["z_knots"] = paper.z_knots().size();
  }
  return {{"kind", "model"},
          {"surfaces", surfaces},
          {"noise_sigma_mm", model.noise_sigma_mm},
          {"method", model.provenance.method},
          {"recording_hash", model.provenance.recording_hash},
          {"program_version", model.provenance.program_version}};
}

/// "key: value" lines of a flat JSON object, nested values as JSON.
std::string AsText(const Json& json) {
  std::string text;
  for (const auto& [key, value] : json.items()) {
    text += key + ": " + (value.is_string() ? value.get<std::string>() : value.dump()) + "\n";
  }
  return text;
}

struct InspectOptions {
  std::string file;
  std::string picture;
  std::string json;
  std::string key_file;
};

/// What a file says of itself.
struct Inspection {
  Json json;
  std::optional<ScanQuality> quality;  ///< Of a recording.
};

/// A recording, or of a sealed one without its key what stands outside.
Result<Inspection> InspectRecordingBytes(std::span<const std::byte> bytes, const std::string& path,
                                         const KeySource* keys) {
  const std::string content_hash = "sha256:" + Sha256Hex(bytes);
  std::optional<std::string> key_id;
  if (LooksSealed(bytes)) {
    const auto id = SealedKeyId(bytes, path);
    if (!id) return Fail(id);
    key_id = *id;
    if (keys == nullptr) {
      return Inspection{Json{{"kind", "sealed recording"},
                             {"key_id", *key_id},
                             {"bytes", bytes.size()},
                             {"content_hash", content_hash},
                             {"note", "give --key-file to see what it holds"}},
                        {}};
    }
  }
  const auto recording = ParseRecording(bytes, path, keys);
  if (!recording) return Fail(recording);
  ScanQuality quality = AssessScan(recording->scan);
  Json json = InspectRecording(*recording, quality);
  if (key_id) json["key_id"] = *key_id;
  json["bytes"] = bytes.size();
  json["content_hash"] = content_hash;
  return Inspection{std::move(json), std::move(quality)};
}

Result<Inspection> InspectFile(const std::string& path, const KeySource* keys, CommandIo& io) {
  const auto bytes = io.storage().ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  if (LooksLikeRecording(*bytes)) return InspectRecordingBytes(*bytes, path, keys);
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  // Our JSON files say what they are near the beginning.
  const std::string_view head = text.substr(0, 400);
  if (head.find("\"annulus-frame\"") != std::string_view::npos) {
    const auto frame = FrameFromJson(text, path);
    if (!frame) return Fail(frame);
    return Inspection{InspectFrame(frame->design), {}};
  }
  if (head.find("\"annulus-worn\"") != std::string_view::npos) {
    const auto worn = WornFrameFromJson(text, path);
    if (!worn) return Fail(worn);
    return Inspection{Json{{"kind", "worn frame"},
                           {"width_mm", worn->design.parameters.width},
                           {"tilt_deg", DegreesFromRadians(worn->tilt)},
                           {"forward_shift_mm", worn->forward_shift},
                           {"clearance_mm", worn->clearance}},
                      {}};
  }
  if (head.find("\"annulus-model\"") != std::string_view::npos) {
    const auto model = ModelFromJson(text, path);
    if (!model) return Fail(model);
    return Inspection{InspectModel(*model), {}};
  }
  return Fail("inspect " + path, "it is neither a recording nor a model, frame or worn frame of annulus",
              "give a file that annulus wrote; points come in through 'annulus import'");
}

/// For people: the quality in words instead of its JSON.
std::string InspectionText(Inspection inspection) {
  if (!inspection.quality) return AsText(inspection.json);
  inspection.json.erase("quality");
  inspection.json.erase("verdict");
  const Json planned = inspection.json.at("planned_levels");
  const auto levels = inspection.json.at("levels").get<std::uint64_t>();
  if (planned.is_null()) inspection.json.erase("planned_levels");
  std::string text = AsText(inspection.json) + TextFromQuality(*inspection.quality);
  if (planned.is_number() && levels < planned.get<std::uint64_t>()) {
    text += "not the whole scan: " + std::to_string(levels) + " of " + planned.dump() +
            " planned levels; the quality is that of this part\n";
  }
  return text;
}

Status Inspect(const InspectOptions& options, CommandIo& io) {
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  const auto inspection = InspectFile(options.file, keys->get(), io);
  if (!inspection) return Fail(inspection);
  if (!options.picture.empty()) {
    if (!inspection->quality) {
      return Fail("draw " + options.file, "it is not a recording", "give a recording; 'annulus render' draws models");
    }
    const auto picture = DrawQuality(*inspection->quality);
    if (!picture) return Fail(picture);
    RETURN_IF_ERROR(WritePngFile(io.storage(), options.picture, *picture));
  }
  return options.json.empty() ? io.Print(InspectionText(*inspection)) : io.WriteJson(options.json, inspection->json);
}

}  // namespace

void AddImportCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* command = app.add_subcommand("import", "bring a table of ranges (CSV, gzip or not) in as a recording");
  command->add_option("points", options->points, "table with level, z_mm, sensor, theta_deg, range_mm")->required();
  command->add_option("--out", options->out, "recording to write")->required()->type_name("SCAN");
  command->add_flag("--force", options->force, "replace an existing recording");
  command->footer("Example: annulus import points.csv.gz --out scan.mcap");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Import(*options, io); }; });
}

void AddExportCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand(
      "export", "write a recording in another format: table with calibrated points, plain MCAP, HDF5");
  command->add_option("scan", options->scan, "recording")->required();
  command->add_option("--out", options->out, "F.csv, F.csv.gz (tables), F.mcap (plain, packed anew) or F.h5")
      ->required()
      ->type_name("FILE");
  AddKeyFileOption(*command, options->key_file);
  command->footer("Example: annulus export scan.mcap --out points.csv.gz");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Export(*options, io); }; });
}

void AddInspectCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<InspectOptions>();
  CLI::App* command = app.add_subcommand("inspect", "say what is in a recording, model, frame or worn frame");
  command->add_option("file", options->file, "any file of ours")->required();
  AddKeyFileOption(*command, options->key_file);
  command->add_option("--picture", options->picture, "of a recording: what was seen of the body, unrolled")
      ->type_name("F.png");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus inspect scan.mcap");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Inspect(*options, io); }; });
}

}  // namespace annulus
