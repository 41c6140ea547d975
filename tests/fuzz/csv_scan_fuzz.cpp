/// The table reader, plain and packed. Beyond "no crash": what is accepted is a scan of finite numbers whose export
/// reads back as the same scan.
#include <cmath>
#include <cstdint>

#include "acquisition/csv_scan.h"
#include "acquisition/gzip.h"
#include "base/ensure.h"
#include "tests/acquisition/scan_fixture.h"
#include "tests/support/test_storage.h"

namespace {

using namespace annulus;

void CheckAccepted(const Scan& scan) {
  const std::size_t sensors = scan.header.calibration.sensors.size();
  ENSURE(scan.levels.size() >= 2 && sensors >= 1, "a scan has levels and sensors");
  for (const ScanLevel& level : scan.levels) {
    ENSURE(level.readings.size() == sensors, "every level has every sensor");
    for (const RangeReading& reading : level.readings) {
      ENSURE(std::isfinite(reading.z_mm), "heights are finite");
      ENSURE(std::isnan(reading.range_mm) || (reading.range_mm >= 0.0 && reading.range_mm <= 10'000.0),
             "ranges are in range");
    }
  }
  for (const SurfaceSample& sample : BuildSamples(scan)) ENSURE(std::isfinite(sample.radius), "samples are finite");
}

/// Export and import again, for scans small enough to keep the target fast.
void CheckRoundTrip(Scan scan) {
  constexpr std::size_t kMostCells = 256;
  if (scan.levels.size() * scan.header.calibration.sensors.size() > kMostCells) return;
  test::TestStorage storage;
  ENSURE(WriteCsvScan(storage, "t.csv", scan).has_value(), "an accepted scan can be exported");
  const auto again = ReadCsvScan(storage, "t.csv");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  scan.header.source = again->header.source;  // bytes that are no UTF-8 are replaced in JSON
  scan.header.subject_id.clear();
  scan.header.consent_reference.clear();
  ENSURE(test::SameScan(*again, scan), "an export reads back as the same scan");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  std::string_view text(reinterpret_cast<const char*>(data), size);
  Result<std::string> unpacked;
  if (LooksLikeGzip(bytes)) {
    constexpr std::uint64_t kMostBytes = 1U << 16U;
    unpacked = GunzipText(bytes, "fuzz", kMostBytes);
    if (!unpacked) return 0;
    text = *unpacked;
  }
  const auto scan = ParseCsvScan(text, "fuzz");
  if (!scan) {
    ENSURE(scan.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  CheckAccepted(*scan);
  constexpr std::size_t kOneIn = 16;  // the round trip is a hundred times slower than the reader
  if (size % kOneIn == 0) CheckRoundTrip(*scan);
  return 0;
}
