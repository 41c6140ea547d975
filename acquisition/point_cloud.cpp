#include "acquisition/point_cloud.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "acquisition/calibrated_return.h"

namespace annulus {
namespace {

static_assert(std::endian::native == std::endian::little, "floats are copied as they lie in memory");

constexpr std::size_t kNumbers = 4;  // x, y, z, intensity
constexpr double kMetresPerMm = 1e-3;

std::string Base64(const std::vector<unsigned char>& bytes) {
  std::string text(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();  // the zero at its end
  return text;
}

}  // namespace

// The number 7 stands for float32 in "foxglove.PackedElementField".
const std::string_view kPointCloudSchema =
    R"({"title":"foxglove.PointCloud","description":"Calibrated points of one level of the ring","type":"object",)"
    R"("properties":{"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer","minimum":0},)"
    R"("nsec":{"type":"integer","minimum":0,"maximum":999999999}}},"frame_id":{"type":"string"},)"
    R"("pose":{"title":"foxglove.Pose","type":"object","properties":{"position":{"title":"foxglove.Vector3",)"
    R"("type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}},)"
    R"("orientation":{"title":"foxglove.Quaternion","type":"object","properties":{"x":{"type":"number"},)"
    R"("y":{"type":"number"},"z":{"type":"number"},"w":{"type":"number"}}}}},)"
    R"("point_stride":{"type":"integer","minimum":0},"fields":{"type":"array","items":)"
    R"({"title":"foxglove.PackedElementField","type":"object","properties":{"name":{"type":"string"},)"
    R"("offset":{"type":"integer","minimum":0},"type":{"title":"foxglove.NumericType","oneOf":[)"
    R"({"title":"UNKNOWN","const":0},{"title":"UINT8","const":1},{"title":"INT8","const":2},)"
    R"({"title":"UINT16","const":3},{"title":"INT16","const":4},{"title":"UINT32","const":5},)"
    R"({"title":"INT32","const":6},{"title":"FLOAT32","const":7},{"title":"FLOAT64","const":8}]}}}},)"
    R"("data":{"type":"string","contentEncoding":"base64"}},)"
    R"("required":["timestamp","frame_id","pose","point_stride","fields","data"]})";

std::string PointCloudJson(const RingCalibration& calibration, const ScanLevel& level) {
  std::vector<unsigned char> bytes;
  bytes.reserve(level.readings.size() * kNumbers * sizeof(float));
  const std::size_t count = std::min(level.readings.size(), calibration.sensors.size());
  for (std::size_t sensor = 0; sensor < count; ++sensor) {
    const auto seen = Calibrate(calibration, sensor, level.readings[sensor]);
    if (!seen) continue;
    const Eigen::Vector3f metres = (kMetresPerMm * seen->point).cast<float>();
    const std::array<float, kNumbers> numbers{metres.x(), metres.y(), metres.z(),
                                              static_cast<float>(level.readings[sensor].quality)};
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof numbers);
    std::memcpy(&bytes[at], numbers.data(), sizeof numbers);
  }
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t time = std::max<std::int64_t>(level.time.count(), 0);
  return "{\"timestamp\":{\"sec\":" + std::to_string(time / kSecond) + ",\"nsec\":" + std::to_string(time % kSecond) +
         R"(},"frame_id":"station","pose":{"position":{"x":0,"y":0,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}},)"
         R"("point_stride":16,"fields":[{"name":"x","offset":0,"type":7},{"name":"y","offset":4,"type":7},)"
         R"({"name":"z","offset":8,"type":7},{"name":"intensity","offset":12,"type":7}],"data":")" +
         Base64(bytes) + "\"}";
}

}  // namespace annulus
