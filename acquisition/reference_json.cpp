#include "acquisition/reference_json.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>

#include "firmware_iface/usb_frame_codec.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMaxLengthMm = 100'000.0;
constexpr double kMaxAngle = 100.0;

/// A number of ReferenceSensor, its key, and the largest magnitude that is believed.
struct SensorField {
  const char* key;
  double ReferenceSensor::*member;
  double limit;
};
constexpr std::array kSensorFields{
    SensorField{"theta_rad", &ReferenceSensor::theta, kMaxAngle},
    SensorField{"distance_mm", &ReferenceSensor::distance_mm, kMaxLengthMm},
    SensorField{"height_mm", &ReferenceSensor::height_mm, kMaxLengthMm},
    SensorField{"aim_rad", &ReferenceSensor::aim, kMaxAngle},
};

tl::unexpected<std::string> Wrong(const std::string& key) {
  return tl::unexpected<std::string>("'" + key + "' is missing or wrong");
}

/// A whole number of at most `most`.
bool IsWhole(const Json& json, const char* key, std::uint64_t most) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number_unsigned() && found->get<std::uint64_t>() <= most;
}

/// The array `key` if each of its `size` elements is what `good` says; null otherwise.
template <class Good>
const Json* ArrayAt(const Json& json, const char* key, std::size_t size, Good good) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() != size) return nullptr;
  for (const Json& one : *found) {
    if (!good(one)) return nullptr;
  }
  return &*found;
}

}  // namespace

Json JsonFromReference(const RecordedReference& reference) {
  Json sensors = Json::array();
  for (const ReferenceSensor& sensor : reference.sensors) {
    Json one{{"channel", sensor.channel}};
    for (const SensorField& field : kSensorFields) one[field.key] = sensor.*field.member;
    sensors.push_back(std::move(one));
  }
  return {
      {"board", reference.board}, {"firmware_version", reference.firmware_version}, {"sensors", std::move(sensors)}};
}

tl::expected<RecordedReference, std::string> ReferenceFromJson(const Json& json) {
  if (!json.is_object() || !IsWhole(json, "board", 0xFFFF'FFFFU)) return Wrong("reference");
  const auto firmware = json.find("firmware_version");
  const auto sensors = json.find("sensors");
  if (firmware == json.end() || !firmware->is_string()) return Wrong("firmware_version");
  if (sensors == json.end() || !sensors->is_array() || sensors->size() > kSensorsPerBoard) return Wrong("sensors");
  RecordedReference reference;
  reference.board = json["board"].get<std::uint32_t>();
  reference.firmware_version = firmware->get<std::string>();
  for (const Json& entry : *sensors) {
    if (!entry.is_object() || !IsWhole(entry, "channel", 255)) return Wrong("channel");
    ReferenceSensor sensor;
    sensor.channel = entry["channel"].get<std::uint8_t>();
    for (const SensorField& field : kSensorFields) {
      const auto number = entry.find(field.key);
      if (number == entry.end() || !number->is_number()) return Wrong(field.key);
      sensor.*field.member = number->get<double>();
    }
    reference.sensors.push_back(sensor);
  }
  return reference;
}

tl::expected<void, std::string> CheckReference(const RecordedReference& reference) {
  if (reference.sensors.empty() || reference.sensors.size() > kSensorsPerBoard) return Wrong("reference");
  std::set<std::uint8_t> channels;
  for (const ReferenceSensor& sensor : reference.sensors) {
    if (sensor.channel >= kSensorsPerBoard || !channels.insert(sensor.channel).second) return Wrong("channel");
    for (const SensorField& field : kSensorFields) {
      if (!(std::abs(sensor.*field.member) <= field.limit)) return Wrong(field.key);
    }
    if (sensor.distance_mm <= 0.0) return Wrong("distance_mm");
  }
  return {};
}

void AppendReferenceJson(const ScanLevel& level, std::string& text) {
  if (level.reference.empty()) return;
  Json ranges = Json::array();
  Json qualities = Json::array();
  for (const RangeReading& reading : level.reference) {
    ranges.push_back(reading.range_mm);  // what is not finite becomes null
    qualities.push_back(reading.quality);
  }
  text += ",\"reference_time_ns\":" + std::to_string(level.reference_time.count()) +
          ",\"reference_range_mm\":" + ranges.dump() + ",\"reference_quality\":" + qualities.dump();
}

tl::expected<void, std::string> TakeReferenceJson(const Json& json, std::size_t count, ScanLevel& level) {
  const auto time = json.find("reference_time_ns");
  const Json* ranges =
      ArrayAt(json, "reference_range_mm", count, [](const Json& one) { return one.is_null() || one.is_number(); });
  const Json* qualities = ArrayAt(json, "reference_quality", count, [](const Json& one) {
    return one.is_number_unsigned() && one.get<std::uint64_t>() <= 255;
  });
  const bool negative = time != json.end() && time->is_number_integer() && !time->is_number_unsigned();
  if (!negative && !IsWhole(json, "reference_time_ns", INT64_MAX)) return Wrong("reference_time_ns");
  if (ranges == nullptr) return Wrong("reference_range_mm");
  if (qualities == nullptr) return Wrong("reference_quality");
  level.reference_time = std::chrono::nanoseconds(time->get<std::int64_t>());
  level.reference.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    if ((*ranges)[i].is_number()) level.reference[i].range_mm = (*ranges)[i].get<double>();
    level.reference[i].quality = (*qualities)[i].get<std::uint8_t>();
  }
  return {};
}

}  // namespace annulus
