#include "acquisition/calibration_file.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>
#include <type_traits>
#include <utility>

#include "acquisition/calibration_json.h"
#include "base/sha256.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using Kind = CalibrationTarget::Kind;

constexpr const char* kFormat = "annulus-calibration";
constexpr int kVersion = 1;
constexpr std::size_t kMaxEntries = 65'536;
constexpr double kMostNumber = 1e9;  // of any number in the file
constexpr const char* kTryAgain = "take the last good calibration file, or calibrate the ring again";

constexpr std::array<std::pair<Kind, const char*>, 4> kKinds{
    {{Kind::kCylinder, "cylinder"}, {Kind::kSphere, "sphere"}, {Kind::kPlane, "plane"}, {Kind::kStep, "step"}}};

std::string HashOf(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  Sha256 hash;
  hash.Update(std::as_bytes(std::span(text)));
  return "sha256:" + hash.Hex();
}

Json JsonFromTarget(const CalibrationTarget& target) {
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& entry) { return entry.first == target.kind; });
  return {{"kind", kind->second},
          {"serial", target.serial},
          {"certificate_number", target.certificate_number},
          {"radius_mm", target.radius_mm},
          {"expanded_u_mm", target.expanded_u_mm},
          {"certified_c", target.certified_c},
          {"expansion_per_c", target.expansion_per_c},
          {"height_mm", target.height_mm},
          {"width_mm", target.width_mm},
          {"step_mm", target.step_mm},
          {"edges_mm", target.edges_mm}};
}

/// What is missing or wrong in a file: thrown by the readers below, caught by ParseCalibrationFile.
struct BadFile {
  std::string seen;
};

BadFile Wrong(const std::string& key) { return {"'" + key + "' is missing or wrong"}; }

const Json& At(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) throw Wrong(key);
  return *found;
}

const Json& ObjectOf(const Json& json, const char* of) {
  if (!json.is_object()) throw Wrong(of);
  return json;
}

void Take(const Json& json, const char* key, std::string& value) {
  if (!At(json, key).is_string()) throw Wrong(key);
  value = json.at(key).get<std::string>();
}

void Take(const Json& json, const char* key, bool& value) {
  if (!At(json, key).is_boolean()) throw Wrong(key);
  value = json.at(key).get<bool>();
}

void Take(const Json& json, const char* key, double& value) {
  if (!At(json, key).is_number()) throw Wrong(key);
  value = json.at(key).get<double>();
  if (!(std::abs(value) <= kMostNumber)) throw Wrong(key);
}

template <class Integer>
requires std::is_integral_v<Integer>
void Take(const Json& json, const char* key, Integer& value) {
  const Json& number = At(json, key);
  if (!number.is_number_integer()) throw Wrong(key);
  const bool fits = number.is_number_unsigned() ? std::in_range<Integer>(number.get<std::uint64_t>())
                                                : std::in_range<Integer>(number.get<std::int64_t>());
  if (!fits) throw Wrong(key);
  value = number.get<Integer>();
}

template <class Make>
auto ListOf(const Json& json, const char* key, const Make& make) {
  const Json& list = At(json, key);
  if (!list.is_array() || list.size() > kMaxEntries) throw Wrong(key);
  std::vector<decltype(make(list))> items;
  for (const Json& entry : list) items.push_back(make(entry));
  return items;
}

std::vector<std::string> TextsOf(const Json& json, const char* key) {
  return ListOf(json, key, [&](const Json& entry) {
    if (!entry.is_string()) throw Wrong(key);
    return entry.get<std::string>();
  });
}

std::vector<double> NumbersOf(const Json& json, const char* key) {
  return ListOf(json, key, [&](const Json& entry) {
    if (!entry.is_number() || !(std::abs(entry.get<double>()) <= kMostNumber)) throw Wrong(key);
    return entry.get<double>();
  });
}

CalibrationTarget TargetFromJson(const Json& json) {
  CalibrationTarget target;
  std::string kind_text;
  Take(ObjectOf(json, "targets"), "kind", kind_text);
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& entry) { return entry.second == kind_text; });
  if (kind == kKinds.end()) throw Wrong("kind");
  target.kind = kind->first;
  Take(json, "serial", target.serial);
  Take(json, "certificate_number", target.certificate_number);
  Take(json, "radius_mm", target.radius_mm);
  Take(json, "expanded_u_mm", target.expanded_u_mm);
  Take(json, "certified_c", target.certified_c);
  Take(json, "expansion_per_c", target.expansion_per_c);
  Take(json, "height_mm", target.height_mm);
  Take(json, "width_mm", target.width_mm);
  Take(json, "step_mm", target.step_mm);
  target.edges_mm = NumbersOf(json, "edges_mm");
  if (target.radius_mm < 0.0) throw Wrong("radius_mm");
  if (target.expanded_u_mm < 0.0) throw Wrong("expanded_u_mm");
  return target;
}

RecordedBoard BoardFromJson(const Json& json) {
  RecordedBoard board;
  Take(ObjectOf(json, "boards"), "serial", board.serial);
  Take(json, "first_sensor", board.first_sensor);
  Take(json, "sensor_count", board.sensor_count);
  return board;
}

CalibrationHistoryEntry HistoryFromJson(const Json& json) {
  CalibrationHistoryEntry entry;
  Take(ObjectOf(json, "history"), "hash", entry.hash);
  Take(json, "wall_ns", entry.wall_ns);
  Take(json, "common_shift_mm", entry.common_shift_mm);
  Take(json, "sensor_shift_mm", entry.sensor_shift_mm);
  Take(json, "passed", entry.passed);
  return entry;
}

Json JsonFromFile(const CalibrationFile& file) {
  Json boards = Json::array();
  for (const RecordedBoard& board : file.boards) {
    boards.push_back(
        {{"serial", board.serial}, {"first_sensor", board.first_sensor}, {"sensor_count", board.sensor_count}});
  }
  Json targets = Json::array();
  for (const CalibrationTarget& target : file.targets) targets.push_back(JsonFromTarget(target));
  Json covariance = Json::array();
  for (const auto& matrix : file.sensor_covariance) {
    std::vector<double> lower;
    for (int row = 0; row < 7; ++row) {
      for (int column = 0; column <= row; ++column) lower.push_back(matrix(row, column));
    }
    covariance.push_back(lower);
  }
  Json history = Json::array();
  for (const CalibrationHistoryEntry& entry : file.history) {
    history.push_back({{"hash", entry.hash},
                       {"wall_ns", entry.wall_ns},
                       {"date", UtcText(entry.wall_ns)},
                       {"common_shift_mm", entry.common_shift_mm},
                       {"sensor_shift_mm", entry.sensor_shift_mm},
                       {"passed", entry.passed}});
  }
  RingCalibration calibration = file.calibration;
  calibration.certificate.clear();  // it is the hash of this text
  return {{"format", kFormat},
          {"version", kVersion},
          {"program_version", file.program_version},
          {"date", UtcText(file.wall_ns)},
          {"wall_ns", file.wall_ns},
          {"valid_until", UtcText(file.valid_until_ns)},
          {"valid_until_ns", file.valid_until_ns},
          {"technician", file.technician},
          {"ambient_c", file.ambient_c},
          {"traceable", file.traceable},
          {"passed", file.passed},
          {"boards", std::move(boards)},
          {"targets", std::move(targets)},
          {"recordings", file.recordings},
          {"unobservable", file.unobservable},
          {"history", std::move(history)},
          {"calibration", JsonFromCalibration(calibration)},
          {"sensor_covariance", std::move(covariance)}};
}

Eigen::Matrix<double, 7, 7> CovarianceFromJson(const Json& json) {
  constexpr const char* kKey = "sensor_covariance";
  if (!json.is_array() || json.size() != 28) throw Wrong(kKey);
  Eigen::Matrix<double, 7, 7> matrix;
  std::size_t at = 0;
  for (int row = 0; row < 7; ++row) {
    for (int column = 0; column <= row; ++column) {
      const Json& number = json[at++];
      if (!number.is_number() || !(std::abs(number.get<double>()) <= kMostNumber)) throw Wrong(kKey);
      matrix(row, column) = matrix(column, row) = number.get<double>();
    }
    if (matrix(row, row) < 0.0) throw Wrong(kKey);
  }
  return matrix;
}

CalibrationFile FileFromJson(const Json& json) {
  CalibrationFile file;
  Take(json, "program_version", file.program_version);
  Take(json, "wall_ns", file.wall_ns);
  Take(json, "valid_until_ns", file.valid_until_ns);
  Take(json, "technician", file.technician);
  Take(json, "ambient_c", file.ambient_c);
  Take(json, "traceable", file.traceable);
  Take(json, "passed", file.passed);
  file.boards = ListOf(json, "boards", BoardFromJson);
  file.targets = ListOf(json, "targets", TargetFromJson);
  file.recordings = TextsOf(json, "recordings");
  file.unobservable = TextsOf(json, "unobservable");
  file.history = ListOf(json, "history", HistoryFromJson);
  file.sensor_covariance = ListOf(json, "sensor_covariance", CovarianceFromJson);
  auto calibration = CalibrationFromJson(At(json, "calibration"));
  if (!calibration) throw BadFile{calibration.error()};
  file.calibration = std::move(*calibration);
  if (file.sensor_covariance.size() != file.calibration.sensors.size() && !file.sensor_covariance.empty()) {
    throw BadFile{"it has not one covariance per sensor"};
  }
  return file;
}

/// Nothing if the text is no JSON, or one that no calibration needs: too long, or nested too deep.
Json ParseShallow(const std::string& text) {
  constexpr std::size_t kMostBytes = std::size_t{64} << 20;
  constexpr int kDeepest = 6;
  if (text.size() > kMostBytes) return {};
  bool deep = false;
  const auto shallow = [&deep](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > kDeepest;
    return !deep;
  };
  Json json = Json::parse(text, shallow, false);
  return deep ? Json() : json;
}

}  // namespace

std::string UtcText(std::int64_t wall_ns) {
  using namespace std::chrono;
  const sys_seconds time(floor<seconds>(nanoseconds(wall_ns)));
  const sys_days day = floor<days>(time);
  const year_month_day date(day);
  const hh_mm_ss clock(time - day);
  char text[64];
  std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()));
  return text;
}

std::string RingSerialOf(const std::vector<RecordedBoard>& boards) {
  std::vector<RecordedBoard> sorted = boards;
  std::sort(sorted.begin(), sorted.end(),
            [](const RecordedBoard& a, const RecordedBoard& b) { return a.first_sensor < b.first_sensor; });
  std::string text;
  for (const RecordedBoard& board : sorted) text += std::to_string(board.serial) + ";";
  Sha256 hash;
  hash.Update(std::as_bytes(std::span(text)));
  return "ring-" + hash.Hex().substr(0, 8);
}

Status WriteCalibrationFile(Storage& storage, const std::string& path, CalibrationFile& file) {
  Json json = JsonFromFile(file);
  file.calibration.certificate = HashOf(json);
  json["hash"] = file.calibration.certificate;
  return WriteFileAtomically(storage, path, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

Result<CalibrationFile> ParseCalibrationFile(const std::string& text, const std::string& name) {
  const std::string attempted = "read the calibration " + name;
  Json json = ParseShallow(text);
  if (!json.is_object() || json.value("format", Json()) != Json(kFormat)) {
    return Fail(attempted, "it is not a calibration file of annulus",
                "name the CAL.json that 'annulus calibrate' wrote");
  }
  if (json.value("version", Json()) != Json(kVersion)) {
    return Fail(attempted, "its version is not 1", "read it with the program that wrote it, or calibrate again");
  }
  const Json hash = json.value("hash", Json());
  json.erase("hash");
  if (!hash.is_string() || hash != Json(HashOf(json))) {
    return Fail(attempted, "its hash does not fit its content: it was edited or damaged", kTryAgain);
  }
  try {
    CalibrationFile file = FileFromJson(json);
    file.calibration.certificate = hash.get<std::string>();
    return file;
  } catch (const BadFile& bad) {
    return Fail(attempted, bad.seen, kTryAgain);
  }
}

Result<CalibrationFile> ReadCalibrationFile(Storage& storage, const std::string& path) {
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  return ParseCalibrationFile(*text, path);
}

Status CheckCalibrationFor(const CalibrationFile& file, const std::vector<RecordedBoard>& boards,
                           std::int64_t wall_ns) {
  const std::string attempted = "use the calibration of " + UtcText(file.wall_ns);
  for (const RecordedBoard& board : boards) {
    const auto calibrated = std::find_if(file.boards.begin(), file.boards.end(), [&](const RecordedBoard& one) {
      return one.first_sensor == board.first_sensor;
    });
    const std::string place = "sensors " + std::to_string(board.first_sensor) + " to " +
                              std::to_string(board.first_sensor + board.sensor_count - 1);
    if (calibrated == file.boards.end()) {
      return Fail(attempted, place + " are not in it: it is of another ring", "calibrate this ring");
    }
    if (calibrated->serial != board.serial || calibrated->sensor_count != board.sensor_count) {
      return Fail(attempted,
                  "board " + std::to_string(board.serial) + " (" + place +
                      ") is not the one that was calibrated there (" + std::to_string(calibrated->serial) + ")",
                  "if the board was replaced, calibrate it alone; else put the boards back, or use this ring's own "
                  "calibration");
    }
  }
  if (boards.size() != file.boards.size()) {
    return Fail(attempted,
                "it is of a ring of " + std::to_string(file.boards.size()) + " boards, this one has " +
                    std::to_string(boards.size()),
                "calibrate this ring");
  }
  if (!file.passed) {
    return Fail(attempted, "it did not keep its limits", "calibrate the ring again; the report says what to mend");
  }
  if (wall_ns > file.valid_until_ns) {
    return Fail(attempted, "it was valid until " + UtcText(file.valid_until_ns), "calibrate the ring again");
  }
  return {};
}

}  // namespace annulus
