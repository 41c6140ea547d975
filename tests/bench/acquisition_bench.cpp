#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>

#include "acquisition/csv_scan.h"
#include "acquisition/recording.h"
#include "acquisition/replay.h"
#include "acquisition/scan_run.h"
#include "acquisition/tapped_buses.h"
#include "acquisition/tapped_devices.h"
#include "tests/bench/bench_scan.h"
#include "tests/sim/booth_fixture.h"
#include "tests/support/test_storage.h"

namespace annulus::bench {
namespace {

constexpr std::uint32_t kLevels = 360;

void CountReadings(benchmark::State& state) {
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kLevels * 180);
}

/// Without the disk: what the program itself takes for a scan of 360 levels.
void WriteARecording(benchmark::State& state) {
  const Scan scan = TubeScan(kLevels);
  for (auto unused : state) {
    test::TestStorage storage;
    if (const Status status = WriteRecording(storage, "scan.mcap", scan); !status) {
      state.SkipWithError(status.error().Text().c_str());
    }
    state.counters["bytes"] = static_cast<double>(storage.files["scan.mcap"].size());
  }
  CountReadings(state);
}
BENCHMARK(WriteARecording)->Unit(benchmark::kMillisecond);

void ReadARecording(benchmark::State& state) {
  test::TestStorage storage;
  const Status written = WriteRecording(storage, "scan.mcap", TubeScan(kLevels));
  for (auto unused : state) {
    const Result<Scan> scan = written ? ReadRecording(storage, "scan.mcap") : Fail(written);
    if (!scan) state.SkipWithError(scan.error().Text().c_str());
    benchmark::DoNotOptimize(scan);
  }
  CountReadings(state);
}
BENCHMARK(ReadARecording)->Unit(benchmark::kMillisecond);

void ImportCsv(benchmark::State& state, const std::string& path) {
  test::TestStorage storage;
  const Status written = WriteCsvScan(storage, path, TubeScan(kLevels));
  for (auto unused : state) {
    const Result<Scan> scan = written ? ReadCsvScan(storage, path) : Fail(written);
    if (!scan) state.SkipWithError(scan.error().Text().c_str());
    benchmark::DoNotOptimize(scan);
  }
  CountReadings(state);
}
BENCHMARK_CAPTURE(ImportCsv, plain, "scan.csv")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ImportCsv, gzip, "scan.csv.gz")->Unit(benchmark::kMillisecond);

/// Everything that a tapped scan on USB leaves.
class Tape final : public ScanSink {
 public:
  Status AppendLevel(const ScanLevel& level) override {
    recording.scan.levels.push_back(level);
    return {};
  }
  Status AppendAxis(std::chrono::nanoseconds time, double z_mm) override {
    recording.axis.push_back({time, z_mm});
    return {};
  }
  Status AppendEvent(std::chrono::nanoseconds, const std::string&) override { return {}; }
  Status AppendRaw(RawRecord record) override {
    recording.raw.push_back(std::move(record));
    return {};
  }

  Recording recording;
};

Result<Recording> RecordAScan() {
  sim::Booth booth(sim::CylinderBooth({}));
  Clock& clock = booth.clock();
  BusTap tap;
  const auto ports = TapUsbPorts(booth.usb_ports(), tap, clock);
  std::vector<UsbPort*> tapped;
  for (const auto& port : ports) tapped.push_back(port.get());
  TappedModbusLink link(booth.axis_link(), tap, clock);
  bus_record::RingOpening opening;
  opening.seams = static_cast<std::uint8_t>(tapped.size());
  auto ring = OpenTappedRing({tap, clock}, opening, [&] { return MakeUsbRangeRing(tapped, {}, clock); });
  auto axis = OpenTappedAxis({tap, clock}, {}, [&] { return MakeModbusScanAxis(link, {}, clock); });
  if (!ring) return Fail(ring);
  if (!axis) return Fail(axis);
  tap.EndPrelude();
  ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  plan.pitch_mm = plan.sweep_pitch_mm();
  plan.sweeps = 2;  // of 180 levels
  Tape tape;
  RETURN_IF_ERROR(tap.Attach(tape));
  const auto summary = RunScan(**ring, **axis, plan, tape, clock, {});
  tap.Detach();
  if (!summary) return Fail(summary);
  return std::move(tape.recording);
}

/// From the raw bytes through the drivers to 360 levels, each compared with the recorded one.
void ReplayAScan(benchmark::State& state) {
  const auto recording = RecordAScan();
  for (auto unused : state) {
    const auto compared = recording ? CompareWithRecorded(*recording, {}, {}) : Fail(recording);
    if (!compared || !compared->identical()) {
      state.SkipWithError(compared ? compared->BriefReport().c_str() : compared.error().Text().c_str());
      break;
    }
    state.counters["levels"] = static_cast<double>(compared->identical_levels);
  }
  CountReadings(state);
}
BENCHMARK(ReplayAScan)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus::bench
