#include "acquisition/reference_record.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus reference check";
constexpr int kVersion = 1;
constexpr int kDeepest = 4;
constexpr std::size_t kMostBytes = std::size_t{4} << 20;
constexpr std::size_t kLongestText = 500;
constexpr std::size_t kMostTexts = 1000;
constexpr std::size_t kMostSensors = 4096;
constexpr double kLargest = 1e5;

struct TextKey {
  const char* key;
  std::string ReferenceRecord::*member;
};
constexpr std::array kTexts{
    TextKey{"scan_hash", &ReferenceRecord::scan_hash},
    TextKey{"ring_serial", &ReferenceRecord::ring_serial},
    TextKey{"calibration", &ReferenceRecord::calibration},
    TextKey{"target_serial", &ReferenceRecord::target_serial},
    TextKey{"certificate_number", &ReferenceRecord::certificate_number},
};
struct NumberKey {
  const char* key;
  double ReferenceRecord::*member;
};
constexpr std::array kNumbers{
    NumberKey{"target_radius_mm", &ReferenceRecord::target_radius_mm},
    NumberKey{"target_u_mm", &ReferenceRecord::target_u_mm},
    NumberKey{"x_mm", &ReferenceRecord::x_mm},
    NumberKey{"y_mm", &ReferenceRecord::y_mm},
    NumberKey{"tilt_deg", &ReferenceRecord::tilt_deg},
    NumberKey{"common_mm", &ReferenceRecord::common_mm},
    NumberKey{"common_sigma_mm", &ReferenceRecord::common_sigma_mm},
    NumberKey{"moved_mm", &ReferenceRecord::moved_mm},
};
struct ListKey {
  const char* key;
  std::vector<std::string> ReferenceRecord::*member;
};
constexpr std::array kLists{ListKey{"findings", &ReferenceRecord::findings},
                            ListKey{"advice", &ReferenceRecord::advice}};
struct SensorKey {
  const char* key;
  double CheckedSensor::*member;
};
constexpr std::array kSensorKeys{SensorKey{"offset_mm", &CheckedSensor::offset_mm},
                                 SensorKey{"sigma_mm", &CheckedSensor::sigma_mm}};

tl::unexpected<Error> Wrong(const std::string& key) {
  return Fail("read a reference check", "'" + key + "' is missing or wrong",
              "give a file that 'annulus check --json' wrote");
}

Result<std::string> TextAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  const bool good =
      found != json.end() && found->is_string() && found->get_ref<const std::string&>().size() <= kLongestText;
  if (!good) return Wrong(key);
  return found->get<std::string>();
}

bool IsNumber(const Json& json) { return json.is_number() && std::abs(json.get<double>()) <= kLargest; }

Status ReadSensors(const Json& json, ReferenceRecord& record) {
  for (const SensorKey& key : kSensorKeys) {
    const auto found = json.find(key.key);
    if (found == json.end() || !found->is_array() || found->size() > kMostSensors) return Wrong(key.key);
    if (record.sensors.empty()) record.sensors.resize(found->size());
    if (found->size() != record.sensors.size()) return Wrong(key.key);
    for (std::size_t k = 0; k < found->size(); ++k) {
      const Json& entry = (*found)[k];
      if (!entry.is_null() && !IsNumber(entry)) return Wrong(key.key);
      if (!entry.is_null()) record.sensors[k].*key.member = entry.get<double>();
    }
  }
  return {};
}

Status ReadLists(const Json& json, ReferenceRecord& record) {
  for (const ListKey& list : kLists) {
    const auto found = json.find(list.key);
    if (found == json.end() || !found->is_array() || found->size() > kMostTexts) return Wrong(list.key);
    for (const Json& entry : *found) {
      if (!entry.is_string() || entry.get_ref<const std::string&>().size() > kLongestText) return Wrong(list.key);
      (record.*list.member).push_back(entry.get<std::string>());
    }
  }
  return {};
}

}  // namespace

Json JsonFromCheck(const ReferenceRecord& record) {
  Json json{{"format", kFormat},
            {"version", kVersion},
            {"verdict", record.passed ? "pass" : "fail"},
            {"wall_start_ns", record.wall_start_ns}};
  for (const TextKey& text : kTexts) json[text.key] = record.*text.member;
  for (const NumberKey& number : kNumbers) {
    json[number.key] = std::isfinite(record.*number.member) ? Json(record.*number.member) : Json(nullptr);
  }
  for (const ListKey& list : kLists) json[list.key] = record.*list.member;
  for (const SensorKey& key : kSensorKeys) {
    Json numbers = Json::array();
    for (const CheckedSensor& sensor : record.sensors) {
      numbers.push_back(std::isfinite(sensor.*key.member) ? Json(sensor.*key.member) : Json(nullptr));
    }
    json[key.key] = std::move(numbers);
  }
  return json;
}

Result<ReferenceRecord> CheckFromJson(const Json& json) {
  if (!json.is_object()) return Wrong("format");
  const auto format = TextAt(json, "format");
  if (!format || *format != kFormat) return Wrong("format");
  const auto version = json.find("version");
  if (version == json.end() || !version->is_number_unsigned() || version->get<std::uint64_t>() != kVersion) {
    return Wrong("version");
  }
  ReferenceRecord record;
  const auto verdict = TextAt(json, "verdict");
  if (!verdict || (*verdict != "pass" && *verdict != "fail")) return Wrong("verdict");
  record.passed = *verdict == "pass";
  const auto time = json.find("wall_start_ns");
  if (time == json.end() || !time->is_number_unsigned()) return Wrong("wall_start_ns");
  const auto nanoseconds = time->get<std::uint64_t>();
  if (nanoseconds > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) return Wrong("wall_start_ns");
  record.wall_start_ns = static_cast<std::int64_t>(nanoseconds);
  for (const TextKey& text : kTexts) {
    auto read = TextAt(json, text.key);
    if (!read) return Fail(read);
    record.*text.member = std::move(*read);
  }
  for (const NumberKey& number : kNumbers) {
    const auto found = json.find(number.key);
    if (found == json.end() || !IsNumber(*found)) return Wrong(number.key);
    record.*number.member = found->get<double>();
  }
  RETURN_IF_ERROR(ReadLists(json, record));
  RETURN_IF_ERROR(ReadSensors(json, record));
  // A damaged file must not pass a ring.
  if (record.passed != record.findings.empty()) return Wrong("verdict");
  return record;
}

Result<ReferenceRecord> ParseReference(std::string_view text, const std::string& name) {
  bool deep = text.size() > kMostBytes;
  const auto shallow = [&deep](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > kDeepest;
    return !deep;
  };
  const Json json = deep ? Json() : Json::parse(text.begin(), text.end(), shallow, false);
  auto record = CheckFromJson(deep ? Json() : json);
  if (!record) {
    Error error = record.error();
    error.attempted = "read the reference check " + name;
    return tl::unexpected(error);
  }
  return record;
}

Status JudgeReference(const ReferenceRecord& record, const ScanHeader& header, std::int64_t now_ns,
                      std::chrono::hours max_age) {
  const std::string attempted = "rely on the ring's reference check";
  const std::string advice = "scan the reference cylinder and run 'annulus check'";
  if (record.ring_serial != header.calibration.ring_serial) {
    return Fail(attempted,
                "it is of ring '" + record.ring_serial + "', not of '" + header.calibration.ring_serial + "'", advice);
  }
  if (record.calibration != header.calibration.certificate) {
    return Fail(attempted, "the ring was calibrated since", advice);
  }
  if (!record.passed) {
    const std::string seen = record.findings.empty() ? "it failed" : record.findings.front();
    return Fail(attempted, seen, record.advice.empty() ? advice : record.advice.front());
  }
  constexpr std::int64_t kAheadNs = 3'600'000'000'000;  // clocks are set now and then
  const std::int64_t age = now_ns - record.wall_start_ns;
  if (age > std::chrono::nanoseconds(max_age).count() || age < -kAheadNs) {
    return Fail(attempted, "it is " + std::to_string(age / 3'600'000'000'000) + " hours old", advice);
  }
  return {};
}

}  // namespace annulus
