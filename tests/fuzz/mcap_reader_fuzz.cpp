/// The recording reader. Beyond "no crash": nothing is told that no CRC protects, what is accepted has its full shape,
/// and an accepted recording that is written again reads back as the same scan.
#include <cmath>
#include <cstdint>

#include "acquisition/mcap_reader.h"
#include "acquisition/recording.h"
#include "base/ensure.h"
#include "tests/acquisition/scan_fixture.h"
#include "tests/support/test_storage.h"

namespace {

using namespace annulus;

/// Counts what it is told.
class Counter final : public McapListener {
 public:
  void OnMetadata(const McapMetadata& metadata) override { bytes += metadata.name.size(); }
  void OnMessage(const McapChannel&, const McapMessage& message) override {
    ++messages;
    bytes += message.data.size();
  }
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
};

void CheckAccepted(const Recording& recording) {
  const std::size_t sensors = recording.scan.header.calibration.sensors.size();
  ENSURE(sensors >= 1 && !recording.scan.levels.empty(), "a scan has levels and sensors");
  for (const ScanLevel& level : recording.scan.levels) {
    ENSURE(level.readings.size() == sensors, "every level has every sensor");
    for (const RangeReading& reading : level.readings) ENSURE(std::isfinite(reading.z_mm), "heights are finite");
  }
  test::TestStorage storage;
  ENSURE(WriteRecording(storage, "r", recording.scan).has_value(), "an accepted scan can be written");
  const auto again = ReadWholeRecording(storage, "r");
  ENSURE(again.has_value() && again->report.clean(), "what was written is whole");
  ENSURE(test::SameScan(again->scan, recording.scan), "a recording reads back as the same scan");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  Counter counter;
  const auto report = ReadMcap(bytes, "fuzz", counter, {.chunk_bytes = 1U << 20U, .total_bytes = 1U << 22U});
  if (!report) return 0;
  ENSURE(report->messages == counter.messages, "the report counts what was told");
  constexpr std::size_t kOneIn = 16;  // JSON and hashes are slow, and have a target of their own
  if (size % kOneIn != 0) return 0;
  const auto recording = ParseRecording(bytes, "fuzz");
  constexpr std::size_t kOneWrittenIn = 128;  // zstd needs a megabyte to pack
  if (recording && size % kOneWrittenIn == 0) CheckAccepted(*recording);
  return 0;
}
