#include "acquisition/calibration_file.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>

#include "acquisition/calibration_json.h"
#include "base/sha256.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using Kind = CalibrationTarget::Kind;

constexpr const char* kFormat = "annulus-calibration";
constexpr int kVersion = 1;
constexpr std::size_t kMaxEntries = 10'000;
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

/// Takes `key` from an object into `value`; throws nlohmann's exceptions, which ParseCalibrationFile turns into errors.
template <class Value>
void Take(const Json& json, const char* key, Value& value) {
  json.at(key).get_to(value);
}

CalibrationTarget TargetFromJson(const Json& json) {
  CalibrationTarget target;
  const std::string kind_text = json.at("kind");
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& entry) { return entry.second == kind_text; });
  if (kind == kKinds.end()) throw Json::other_error::create(501, "unknown kind of target", &json);
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
  Take(json, "edges_mm", target.edges_mm);
  return target;
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

template <class Item, class Make>
void TakeList(const Json& json, const char* key, std::vector<Item>& items, const Make& make) {
  const Json& list = json.at(key);
  if (!list.is_array() || list.size() > kMaxEntries) throw Json::other_error::create(501, "too many entries", &list);
  for (const Json& entry : list) items.push_back(make(entry));
}

Eigen::Matrix<double, 7, 7> CovarianceFromJson(const Json& json) {
  const auto lower = json.get<std::vector<double>>();
  if (lower.size() != 28) throw Json::other_error::create(501, "a covariance has 28 numbers", &json);
  Eigen::Matrix<double, 7, 7> matrix;
  std::size_t at = 0;
  for (int row = 0; row < 7; ++row) {
    for (int column = 0; column <= row; ++column) matrix(row, column) = matrix(column, row) = lower[at++];
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
  TakeList(json, "boards", file.boards, [](const Json& entry) {
    RecordedBoard board;
    Take(entry, "serial", board.serial);
    Take(entry, "first_sensor", board.first_sensor);
    Take(entry, "sensor_count", board.sensor_count);
    return board;
  });
  TakeList(json, "targets", file.targets, TargetFromJson);
  TakeList(json, "recordings", file.recordings, [](const Json& entry) { return entry.get<std::string>(); });
  TakeList(json, "unobservable", file.unobservable, [](const Json& entry) { return entry.get<std::string>(); });
  TakeList(json, "history", file.history, [](const Json& entry) {
    CalibrationHistoryEntry made;
    Take(entry, "hash", made.hash);
    Take(entry, "wall_ns", made.wall_ns);
    Take(entry, "common_shift_mm", made.common_shift_mm);
    Take(entry, "sensor_shift_mm", made.sensor_shift_mm);
    Take(entry, "passed", made.passed);
    return made;
  });
  TakeList(json, "sensor_covariance", file.sensor_covariance, CovarianceFromJson);
  auto calibration = CalibrationFromJson(json.at("calibration"));
  if (!calibration) throw Json::other_error::create(501, calibration.error(), &json);
  file.calibration = std::move(*calibration);
  return file;
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
  Json json = Json::parse(text, nullptr, false);
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
    if (file.sensor_covariance.size() != file.calibration.sensors.size() && !file.sensor_covariance.empty()) {
      return Fail(attempted, "it has not one covariance per sensor", kTryAgain);
    }
    file.calibration.certificate = hash.get<std::string>();
    return file;
  } catch (const Json::exception& error) {
    return Fail(attempted, std::string("something in it is missing or wrong: ") + error.what(), kTryAgain);
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
  if (wall_ns > file.valid_until_ns) {
    return Fail(attempted, "it was valid until " + UtcText(file.valid_until_ns), "calibrate the ring again");
  }
  return {};
}

}  // namespace annulus
