#include "acquisition/scan_json.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "acquisition/calibration_json.h"
#include "acquisition/json_text.h"
#include "acquisition/reference_json.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kFormatVersion = 1;
constexpr std::size_t kMaxSensors = 65'536;
constexpr double kMaxLengthMm = 100'000.0;

/// A text of ScanHeader and its key.
struct TextField {
  const char* key;
  std::string ScanHeader::*member;
};
constexpr std::array kTextFields{
    TextField{"station_id", &ScanHeader::station_id},
    TextField{"source", &ScanHeader::source},
    TextField{"subject_id", &ScanHeader::subject_id},
    TextField{"consent_reference", &ScanHeader::consent_reference},
    TextField{"program_version", &ScanHeader::program_version},
    TextField{"profile", &ScanHeader::profile},
    TextField{"plan", &ScanHeader::plan_json},
};

std::string Dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

tl::expected<Json, std::string> ParseObject(std::string_view text) {
  Json json = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!json.is_object()) return tl::unexpected<std::string>("it is not a JSON object");
  return json;
}

tl::unexpected<std::string> Wrong(const std::string& key) {
  return tl::unexpected<std::string>("'" + key + "' is missing or wrong");
}

/// The member `key` if it is an integer that `Integer` can hold.
template <class Integer>
std::optional<Integer> IntegerAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number_integer()) return std::nullopt;
  if (found->is_number_unsigned()) {
    const auto value = found->template get<std::uint64_t>();
    if (value > static_cast<std::uint64_t>(std::numeric_limits<Integer>::max())) return std::nullopt;
    return static_cast<Integer>(value);
  }
  const auto value = found->template get<std::int64_t>();
  if constexpr (std::is_signed_v<Integer>) return static_cast<Integer>(value);
  return std::nullopt;  // nlohmann keeps non-negative numbers as unsigned: this one is negative
}

/// The member `key` if it is a finite number.
std::optional<double> NumberAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<std::string> TextAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

/// The member `key` if it is an array of `size`; null otherwise.
const Json* ArrayAt(const Json& json, const char* key, std::size_t size) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() != size) return nullptr;
  return &*found;
}

/// A number of RecordedMachine and its key.
struct MachineField {
  const char* key;
  double RecordedMachine::*member;
};
constexpr std::array kMachineFields{
    MachineField{"axis_z_min_mm", &RecordedMachine::axis_z_min_mm},
    MachineField{"axis_z_max_mm", &RecordedMachine::axis_z_max_mm},
    MachineField{"axis_max_speed_mm_s", &RecordedMachine::axis_max_speed_mm_s},
    MachineField{"axis_max_acceleration_mm_s2", &RecordedMachine::axis_max_acceleration_mm_s2},
    MachineField{"level_rate_hz", &RecordedMachine::level_rate_hz},
};

constexpr const char* kRingTemperature = "ring_temperature_c";

void PutMachine(JsonText& json, const RecordedMachine& machine) {
  json.Open('{').Key("ring_bus").Text(machine.ring_bus).Key("boards").Open('[');
  for (const RecordedBoard& board : machine.boards) {
    json.Open('{').Key("serial").Unsigned(board.serial).Key("first_sensor").Unsigned(board.first_sensor);
    json.Key("sensor_count").Unsigned(board.sensor_count);
    json.Key("protocol_version").Unsigned(board.protocol_version);
    json.Key("firmware_version").Text(board.firmware_version).Close('}');
  }
  json.Close(']').Key("axis_serial").Unsigned(machine.axis_serial);
  json.Key("axis_protocol_version").Unsigned(machine.axis_protocol_version);
  json.Key("axis_firmware_version").Text(machine.axis_firmware_version);
  for (const MachineField& field : kMachineFields) json.Key(field.key).Number(machine.*field.member);
  if (machine.ring_temperature_c) json.Key(kRingTemperature).Number(*machine.ring_temperature_c);
  json.Close('}');
}

tl::expected<RecordedBoard, std::string> BoardFromJson(const Json& json) {
  if (!json.is_object()) return Wrong("boards");
  const auto serial = IntegerAt<std::uint32_t>(json, "serial");
  const auto first_sensor = IntegerAt<std::uint16_t>(json, "first_sensor");
  const auto sensor_count = IntegerAt<std::uint16_t>(json, "sensor_count");
  const auto protocol_version = IntegerAt<std::uint16_t>(json, "protocol_version");
  auto firmware_version = TextAt(json, "firmware_version");
  if (!serial || !first_sensor || !sensor_count || !protocol_version || !firmware_version) return Wrong("boards");
  return RecordedBoard{*serial, *first_sensor, *sensor_count, *protocol_version, std::move(*firmware_version)};
}

tl::expected<RecordedMachine, std::string> MachineFromJson(const Json& json) {
  RecordedMachine machine;
  auto ring_bus = TextAt(json, "ring_bus");
  const auto axis_serial = IntegerAt<std::uint32_t>(json, "axis_serial");
  const auto axis_protocol = IntegerAt<std::uint16_t>(json, "axis_protocol_version");
  auto axis_firmware = TextAt(json, "axis_firmware_version");
  const auto boards = json.find("boards");
  if (!ring_bus) return Wrong("ring_bus");
  if (!axis_serial) return Wrong("axis_serial");
  if (!axis_protocol) return Wrong("axis_protocol_version");
  if (!axis_firmware) return Wrong("axis_firmware_version");
  if (boards == json.end() || !boards->is_array() || boards->size() > kMaxSensors) return Wrong("boards");
  for (const Json& entry : *boards) {
    auto board = BoardFromJson(entry);
    if (!board) return tl::unexpected<std::string>(board.error());
    machine.boards.push_back(std::move(*board));
  }
  for (const MachineField& field : kMachineFields) {
    const auto number = NumberAt(json, field.key);
    if (!number) return Wrong(field.key);
    machine.*field.member = *number;
  }
  if (json.contains(kRingTemperature)) {
    machine.ring_temperature_c = NumberAt(json, kRingTemperature);
    if (!machine.ring_temperature_c) return Wrong(kRingTemperature);
  }
  machine.ring_bus = std::move(*ring_bus);
  machine.axis_serial = *axis_serial;
  machine.axis_protocol_version = *axis_protocol;
  machine.axis_firmware_version = std::move(*axis_firmware);
  return machine;
}

/// Appends `,"key":[…]` with one element per reading.
template <class Put>
void PutReadings(std::string& out, std::string_view key, const ScanLevel& level, Put put) {
  out.append(",\"").append(key).append("\":[");
  for (const RangeReading& reading : level.readings) {
    put(reading);
    out += ',';
  }
  if (level.readings.empty()) {
    out += ']';
  } else {
    out.back() = ']';
  }
}

}  // namespace

const std::string_view kLevelSchema =
    R"({"type":"object","properties":{"level":{"type":"integer"},"sweep":{"type":"integer"},)"
    R"("time_ns":{"type":"integer"},"range_mm":{"type":"array","items":{"type":["number","null"]}},)"
    R"("z_mm":{"type":"array","items":{"type":"number"}},"quality":{"type":"array","items":{"type":"integer"}}},)"
    R"("required":["level","sweep","time_ns","range_mm","z_mm","quality"]})";
const std::string_view kAxisSchema =
    R"({"type":"object","properties":{"time_ns":{"type":"integer"},"z_mm":{"type":"number"}},)"
    R"("required":["time_ns","z_mm"]})";
const std::string_view kSafetySchema =
    R"({"type":"object","properties":{"time_ns":{"type":"integer"},"input":{"type":"array","items":{"type":"boolean"}},)"
    R"("output":{"type":"array","items":{"type":"boolean"}}},"required":["time_ns","input","output"]})";
const std::string_view kEventSchema =
    R"({"type":"object","properties":{"time_ns":{"type":"integer"},"text":{"type":"string"}},)"
    R"("required":["time_ns","text"]})";

tl::expected<void, std::string> CheckHeader(const ScanHeader& header) {
  if (header.format_version != kFormatVersion) {
    return tl::unexpected<std::string>("its format version is " + std::to_string(header.format_version) +
                                       ", this program knows 1");
  }
  if (!(header.ring_radius_mm > 0.0 && header.ring_radius_mm <= kMaxLengthMm)) return Wrong("ring_radius_mm");
  const auto& sensors = header.calibration.sensors;
  if (sensors.empty() || sensors.size() > kMaxSensors) return Wrong("calibration");
  if (const auto checked = CheckCalibration(header.calibration); !checked) {
    return tl::unexpected<std::string>(checked.error());
  }
  for (const MachineField& field : kMachineFields) {
    if (!std::isfinite(header.machine.*field.member)) return Wrong(field.key);
  }
  if (!std::isfinite(header.machine.ring_temperature_c.value_or(0.0))) return Wrong(kRingTemperature);
  return header.reference ? CheckReference(*header.reference) : tl::expected<void, std::string>();
}

std::string JsonFromHeader(const ScanHeader& header) {
  JsonText json;
  json.Open('{').Key("format_version").Unsigned(header.format_version);
  for (const TextField& field : kTextFields) json.Key(field.key).Text(header.*field.member);
  json.Key("seed").Unsigned(header.seed).Key("wall_start_ns").Integer(header.wall_start_ns);
  json.Key("ring_radius_mm").Number(header.ring_radius_mm);
  json.Key("calibration");
  PutCalibration(json, header.calibration);
  if (header.machine != RecordedMachine{}) {
    json.Key("machine");
    PutMachine(json, header.machine);
  }
  if (header.reference) json.Key("reference").Raw(Dump(JsonFromReference(*header.reference)));
  return json.Close('}').Take();
}

tl::expected<ScanHeader, std::string> HeaderFromJson(std::string_view text) {
  const auto json = ParseObject(text);
  if (!json) return tl::unexpected<std::string>(json.error());
  ScanHeader header;
  const auto version = IntegerAt<std::uint32_t>(*json, "format_version");
  if (version && *version != kFormatVersion) {  // before keys that another version may not have
    header.format_version = *version;
    return tl::unexpected<std::string>(CheckHeader(header).error());
  }
  const auto seed = IntegerAt<std::uint64_t>(*json, "seed");
  const auto wall_start = IntegerAt<std::int64_t>(*json, "wall_start_ns");
  const auto ring_radius = NumberAt(*json, "ring_radius_mm");
  const auto calibration_json = json->find("calibration");
  if (!version) return Wrong("format_version");
  if (!seed) return Wrong("seed");
  if (!wall_start) return Wrong("wall_start_ns");
  if (!ring_radius) return Wrong("ring_radius_mm");
  if (calibration_json == json->end() || !calibration_json->is_object()) return Wrong("calibration");
  for (const TextField& field : kTextFields) {
    auto value = TextAt(*json, field.key);
    if (!value) return Wrong(field.key);
    header.*field.member = std::move(*value);
  }
  auto calibration = CalibrationFromJson(*calibration_json);
  if (!calibration) return tl::unexpected<std::string>(calibration.error());
  if (const auto machine = json->find("machine"); machine != json->end()) {
    auto parsed = machine->is_object() ? MachineFromJson(*machine) : Wrong("machine");
    if (!parsed) return tl::unexpected<std::string>(parsed.error());
    header.machine = std::move(*parsed);
  }
  if (const auto reference = json->find("reference"); reference != json->end()) {
    auto parsed = ReferenceFromJson(*reference);
    if (!parsed) return tl::unexpected<std::string>(parsed.error());
    header.reference = std::move(*parsed);
  }
  header.format_version = *version;
  header.seed = *seed;
  header.wall_start_ns = *wall_start;
  header.ring_radius_mm = *ring_radius;
  header.calibration = std::move(*calibration);
  if (const auto checked = CheckHeader(header); !checked) return tl::unexpected<std::string>(checked.error());
  return header;
}

std::string JsonFromLevel(const ScanLevel& level) {
  std::string out = "{\"level\":" + std::to_string(level.index) + ",\"sweep\":" + std::to_string(level.sweep) +
                    ",\"time_ns\":" + std::to_string(level.time.count());
  PutReadings(out, "range_mm", level, [&](const RangeReading& reading) { PutNumber(out, reading.range_mm); });
  PutReadings(out, "z_mm", level, [&](const RangeReading& reading) { PutNumber(out, reading.z_mm); });
  PutReadings(out, "quality", level, [&](const RangeReading& reading) { out += std::to_string(reading.quality); });
  AppendReferenceJson(level, out);
  return out + '}';
}

tl::expected<ScanLevel, std::string> LevelFromJson(std::string_view text, std::size_t sensor_count,
                                                   std::size_t reference_count) {
  const auto json = ParseObject(text);
  if (!json) return tl::unexpected<std::string>(json.error());
  const auto index = IntegerAt<std::uint32_t>(*json, "level");
  const auto sweep = IntegerAt<std::uint16_t>(*json, "sweep");
  const auto time = IntegerAt<std::int64_t>(*json, "time_ns");
  const Json* ranges = ArrayAt(*json, "range_mm", sensor_count);
  const Json* heights = ArrayAt(*json, "z_mm", sensor_count);
  const Json* qualities = ArrayAt(*json, "quality", sensor_count);
  if (!index) return Wrong("level");
  if (!sweep) return Wrong("sweep");
  if (!time) return Wrong("time_ns");
  if (ranges == nullptr) return Wrong("range_mm");
  if (heights == nullptr) return Wrong("z_mm");
  if (qualities == nullptr) return Wrong("quality");
  ScanLevel level{*index, *sweep, std::chrono::nanoseconds(*time), {}};
  level.readings.resize(sensor_count);
  for (std::size_t i = 0; i < sensor_count; ++i) {
    const Json& range = (*ranges)[i];
    const Json& quality = (*qualities)[i];
    if (!range.is_null() && !range.is_number()) return Wrong("range_mm");
    if (!(*heights)[i].is_number()) return Wrong("z_mm");
    if (!quality.is_number_unsigned() || quality.get<std::uint64_t>() > 255) return Wrong("quality");
    RangeReading& reading = level.readings[i];
    if (range.is_number()) reading.range_mm = range.get<double>();
    reading.z_mm = (*heights)[i].get<double>();
    reading.quality = quality.get<std::uint8_t>();
  }
  if (reference_count == 0) return level;
  if (const auto read = TakeReferenceJson(*json, reference_count, level); !read) {
    return tl::unexpected<std::string>(read.error());
  }
  return level;
}

std::string JsonFromAxisPoint(const AxisPoint& point) {
  std::string out = "{\"time_ns\":" + std::to_string(point.time.count()) + ",\"z_mm\":";
  PutNumber(out, point.z_mm);
  return out + '}';
}

tl::expected<AxisPoint, std::string> AxisPointFromJson(std::string_view text) {
  const auto json = ParseObject(text);
  if (!json) return tl::unexpected<std::string>(json.error());
  const auto time = IntegerAt<std::int64_t>(*json, "time_ns");
  const auto z_mm = NumberAt(*json, "z_mm");
  if (!time) return Wrong("time_ns");
  if (!z_mm) return Wrong("z_mm");
  return AxisPoint{std::chrono::nanoseconds(*time), *z_mm};
}

std::string JsonFromEvent(const RecordedEvent& event) {
  return Dump(Json{{"time_ns", event.time.count()}, {"text", event.text}});
}

tl::expected<RecordedEvent, std::string> EventFromJson(std::string_view text) {
  const auto json = ParseObject(text);
  if (!json) return tl::unexpected<std::string>(json.error());
  const auto time = IntegerAt<std::int64_t>(*json, "time_ns");
  auto words = TextAt(*json, "text");
  if (!time) return Wrong("time_ns");
  if (!words) return Wrong("text");
  return RecordedEvent{std::chrono::nanoseconds(*time), std::move(*words)};
}

std::string JsonFromSafetyLines(const SafetyLines& lines) {
  return Dump(Json{{"time_ns", lines.time.count()}, {"input", lines.input}, {"output", lines.output}});
}

tl::expected<SafetyLines, std::string> SafetyLinesFromJson(std::string_view text) {
  const auto json = ParseObject(text);
  if (!json) return tl::unexpected<std::string>(json.error());
  const auto time = IntegerAt<std::int64_t>(*json, "time_ns");
  if (!time) return Wrong("time_ns");
  SafetyLines lines;
  lines.time = std::chrono::nanoseconds(*time);
  const auto take = [&](const char* key, auto& levels) {
    const Json* array = ArrayAt(*json, key, levels.size());
    if (array == nullptr) return false;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (!(*array)[i].is_boolean()) return false;
      levels[i] = (*array)[i].get<bool>();
    }
    return true;
  };
  if (!take("input", lines.input)) return Wrong("input");
  if (!take("output", lines.output)) return Wrong("output");
  return lines;
}

}  // namespace annulus
