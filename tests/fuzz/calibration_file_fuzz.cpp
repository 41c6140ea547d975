/// The reader of calibration files. The hash of what comes is put right first, so that more than the hash is tried.
/// Beyond "no crash": what is accepted is finite and in range, is written and read back to the same bytes, and can be
/// asked whether it fits a ring.
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "acquisition/calibration_file.h"
#include "acquisition/calibration_json.h"
#include "base/ensure.h"
#include "base/sha256.h"
#include "tests/support/test_storage.h"

namespace {

using namespace annulus;
using Json = nlohmann::ordered_json;

/// The text with the hash that it ought to have; as it is if it is no object, or nested deeper than any calibration.
std::string WithItsHash(std::string_view text) {
  bool deep = false;
  const auto shallow = [&deep](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > 8;
    return !deep;
  };
  Json json = Json::parse(text.begin(), text.end(), shallow, false);
  if (deep || !json.is_object()) return std::string(text);
  json.erase("hash");
  const std::string content = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  json["hash"] = "sha256:" + Sha256Hex(std::as_bytes(std::span(content)));
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void CheckAccepted(CalibrationFile file) {
  ENSURE(CheckCalibration(file.calibration).has_value(), "numbers are finite and in range");
  for (const auto& covariance : file.sensor_covariance) ENSURE(covariance.allFinite(), "covariances are finite");
  ENSURE(std::isfinite(file.ambient_c), "temperatures are finite");
  for (const CalibrationTarget& target : file.targets) ENSURE(target.radius_mm >= 0.0, "a radius is one");
  static_cast<void>(CheckCalibrationFor(file, file.boards, file.valid_until_ns));
  static_cast<void>(UtcText(file.wall_ns));
  for (std::size_t i = 0; i < file.calibration.sensors.size(); ++i) {
    ENSURE(file.calibration.PointOf(i, 1000.0, 450.0).allFinite(), "points are finite");
  }
  test::TestStorage storage;
  ENSURE(WriteCalibrationFile(storage, "a", file).has_value(), "what is read can be written");
  auto again = ReadCalibrationFile(storage, "a");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(WriteCalibrationFile(storage, "b", *again).has_value(), "and again");
  ENSURE(storage.files["a"] == storage.files["b"], "a calibration reads back as the same bytes");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  static_cast<void>(ParseCalibrationFile(std::string(text), "fuzz"));
  const auto file = ParseCalibrationFile(WithItsHash(text), "fuzz");
  if (!file) {
    ENSURE(file.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  CheckAccepted(*file);
  return 0;
}
