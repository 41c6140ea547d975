// How large and how fast recordings of whole scans are.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "acquisition/recording.h"
#include "acquisition/recording_recovery.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using test::TestStorage;

/// How many digits the readings have.
enum class Digits {
  kSensor,  ///< Steps of 0.04 mm, as the boards send them; heights with noise in every digit.
  kAll,     ///< Noise in every digit of every number: the worst case.
};

struct Size {
  std::uint64_t bytes = 0;
  double seconds = 0.0;
  double recovery_seconds = 0.0;
};

/// 360 levels of 180 sensors at 24 levels/s, with what the boards send on USB (12 frames of 15 x 3 bytes and 24 more,
/// and noise in them), a drive's transaction per 20 ms and a call per level.
Size RecordScan(Digits digits) {
  constexpr std::size_t kSensors = 180;
  constexpr std::size_t kLevels = 360;
  constexpr std::size_t kBoards = 12;
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 0.5);
  ScanHeader header;
  header.ring_radius_mm = 600.0;
  header.calibration = RingCalibration::Ideal(600.0, kSensors);
  for (SensorCalibration& sensor : header.calibration.sensors) sensor.range_offset_mm = noise(random);
  TestStorage storage;
  const auto start = std::chrono::steady_clock::now();
  auto writer = RecordingWriter::Create(storage, "scan.mcap", header);
  EXPECT_TRUE(writer);
  const auto raw = [&](RawChannel channel, nanoseconds time, std::size_t size) {
    RawRecord record{channel, time, std::vector<std::byte>(size)};
    for (std::byte& byte : record.bytes) byte = static_cast<std::byte>(random() & 255U);
    EXPECT_TRUE(writer->AppendRaw(std::move(record)));
  };
  for (std::uint32_t index = 0; index < kLevels; ++index) {
    const nanoseconds time = std::chrono::microseconds(41'667) * index;
    ScanLevel level{index, 0, time, std::vector<RangeReading>(kSensors)};
    for (std::size_t sensor = 0; sensor < kSensors; ++sensor) {
      double range = 420.0 + 40.0 * std::sin(0.1 * static_cast<double>(sensor)) + noise(random);
      if (digits == Digits::kSensor) range = 0.04 * std::round(range / 0.04);
      level.readings[sensor] = {range, 1800.0 - 5.0 * index + 0.1 * noise(random), 200};
    }
    for (std::size_t board = 0; board < kBoards; ++board) raw(RawChannel::kUsb, time, 24 + 15 * 3);
    for (int i = 0; i < 2; ++i) raw(RawChannel::kModbus, time, 40);
    raw(RawChannel::kCall, time, 16);
    for (int i = 0; i < 2; ++i) EXPECT_TRUE(writer->AppendAxis(time, 1800.0 - 5.0 * index));
    EXPECT_TRUE(writer->AppendLevel(level));
  }
  EXPECT_TRUE(writer->Finish());
  const auto end = std::chrono::steady_clock::now();
  const auto recovered = RecoverRecording(storage, "scan.mcap", "again.mcap");
  EXPECT_TRUE(recovered && recovered->lossless);
  const std::chrono::duration<double> recovery = std::chrono::steady_clock::now() - end;
  EXPECT_EQ(storage.files["again.mcap"], storage.files["scan.mcap"]);
  return {storage.files["scan.mcap"].size(), std::chrono::duration<double>(end - start).count(), recovery.count()};
}

TEST(RecordingSize, OfAWholeScanWithItsRawBytesIsAboutThreeMegabytesAndWithinWhatIsReserved) {
  const Size usual = RecordScan(Digits::kSensor);
  const Size worst = RecordScan(Digits::kAll);
  const auto print = [](const char* what, const Size& size) {
    std::printf("360 levels, %s: %.2f MB, written in %.3f s, recovered in %.3f s\n", what,
                1e-6 * static_cast<double>(size.bytes), size.seconds, size.recovery_seconds);
  };
  print("as the boards send them", usual);
  print("noise in every digit", worst);
  EXPECT_LT(usual.bytes, worst.bytes);
  EXPECT_LT(worst.bytes, RecordingReserve(360, 180));
  EXPECT_LT(usual.bytes, 3'500'000U);
}

}  // namespace
}  // namespace annulus
