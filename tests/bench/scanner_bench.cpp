// The scanner and what runs beside it: the control tick, a whole simulated day's work, quality, seals, recovery.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "acquisition/recording_recovery.h"
#include "acquisition/scan_quality.h"
#include "acquisition/scanner.h"
#include "sim/booth.h"
#include "tests/bench/bench_scan.h"
#include "tests/sim/booth_fixture.h"
#include "tests/support/test_keys.h"
#include "tests/support/test_storage.h"

namespace annulus::bench {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint32_t kLevels = 360;

/// A wired booth with the scanner on it, somebody who presses its buttons, and the control ticks timed.
class WorkingBooth {
 public:
  WorkingBooth() {
    sim::BoothOptions options = sim::CylinderBooth({});
    options.hardwired = true;
    booth_ = std::make_unique<sim::BoothDevices>(std::move(options), clock_);
    ring_ = *MakeUsbRangeRing(booth_->usb_ports(), {}, worker_clock_);
    axis_ = *MakeModbusScanAxis(booth_->axis_link(), {}, worker_clock_);
    interlock_ = *MakeInterlock(*booth_->safety().Request({}, InterlockWiring::Default().Lines()), clock_);
    scanner_ =
        std::make_unique<Scanner>(ScannerDevices{*ring_, *axis_, *interlock_, worker_clock_}, gate_, storage_, clock_);
    static_cast<void>(scanner_->Begin());
    clock_.Start([this] { Tick(); });
  }

  bool RunUntil(ScanState state) {
    const nanoseconds end = clock_.Now() + std::chrono::minutes(2);
    while (scanner_->status().state != state || !scanner_->status().job.empty()) {
      if (clock_.Now() >= end) return false;
      scanner_->Step();
    }
    return true;
  }
  /// Reset, home, arm, scan. False if anything goes wrong.
  bool ScanOnce(const ScanPlan& plan) {
    booth_->safety().PressResetAt(clock_.Now() + std::chrono::milliseconds(50));
    if (!RunUntil(ScanState::kIdle) || !scanner_->OrderHome()) return false;
    ArmRequest request;
    request.plan = plan;
    request.out = "scan.mcap";
    request.header.station_id = "bench";
    request.header.ring_radius_mm = 600.0;
    request.header.calibration = RingCalibration::Ideal(600.0);
    if (!RunUntil(ScanState::kIdle) || !scanner_->OrderArm(request) || !RunUntil(ScanState::kArmed)) return false;
    if (!scanner_->OrderStart(scanner_->status().version) || !RunUntil(ScanState::kIdle)) return false;
    const auto scan = scanner_->status().scan;
    return scan && scan->complete;
  }
  [[nodiscard]] ScannerStatus status() const { return scanner_->status(); }
  [[nodiscard]] std::vector<double>& tick_us() { return tick_us_; }
  [[nodiscard]] double virtual_seconds() const { return std::chrono::duration<double>(clock_.Now()).count(); }

 private:
  void Tick() {
    const auto begin = std::chrono::steady_clock::now();
    scanner_->Tick();
    tick_us_.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }

  InterleavedClock clock_{scan_time::kTick};
  BeatClock worker_clock_{clock_};
  std::unique_ptr<sim::BoothDevices> booth_;
  test::TestStorage storage_;
  PermissiveGate gate_;
  std::unique_ptr<RangeRing> ring_;
  std::unique_ptr<ScanAxis> axis_;
  std::unique_ptr<Interlock> interlock_;
  std::unique_ptr<Scanner> scanner_;
  std::vector<double> tick_us_;
};

/// From power-up to the recording of 360 levels, simulated; the control tick as it takes in it, with the model of the
/// safety chain behind it.
void WholeSimulatedScan(benchmark::State& state) {
  ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  plan.pitch_mm = plan.sweep_pitch_mm();
  plan.sweeps = 2;  // of 180 levels
  std::vector<double> ticks;
  double simulated = 0.0;
  for (auto unused : state) {
    WorkingBooth booth;
    if (!booth.ScanOnce(plan)) state.SkipWithError("the scan was not complete");
    simulated = booth.virtual_seconds();
    ticks.insert(ticks.end(), booth.tick_us().begin(), booth.tick_us().end());
  }
  if (ticks.empty()) return;
  std::sort(ticks.begin(), ticks.end());
  state.counters["tick_median_us"] = ticks[ticks.size() / 2];
  state.counters["tick_p999_us"] = ticks[ticks.size() * 999 / 1000];
  state.counters["simulated_s"] = simulated;
}
BENCHMARK(WholeSimulatedScan)->Unit(benchmark::kMillisecond);

/// What whoever looks at the booth costs it, after a scan: the control tick waits for the same mutex.
void StatusAfterAScan(benchmark::State& state) {
  ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  plan.pitch_mm = plan.sweep_pitch_mm();
  plan.sweeps = 2;
  WorkingBooth booth;
  if (!booth.ScanOnce(plan)) state.SkipWithError("the scan was not complete");
  for (auto unused : state) benchmark::DoNotOptimize(booth.status());
}
BENCHMARK(StatusAfterAScan)->Unit(benchmark::kMicrosecond);

/// What live quality takes of a level of 180 sensors.
void QualityOfALevel(benchmark::State& state) {
  const Scan scan = TubeScan(kLevels);
  for (auto unused : state) {
    QualityMonitor monitor(scan.header);
    for (const ScanLevel& level : scan.levels) monitor.Add(level);
    benchmark::DoNotOptimize(monitor.live());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kLevels);
}
BENCHMARK(QualityOfALevel)->Unit(benchmark::kMillisecond);

void QualityOfAScan(benchmark::State& state) {
  const Scan scan = TubeScan(kLevels);
  QualityMonitor monitor(scan.header);
  for (const ScanLevel& level : scan.levels) monitor.Add(level);
  for (auto unused : state) benchmark::DoNotOptimize(monitor.Assess());
}
BENCHMARK(QualityOfAScan)->Unit(benchmark::kMillisecond);

void WriteASealedRecording(benchmark::State& state) {
  const Scan scan = TubeScan(kLevels);
  const test::TestKeys keys;
  for (auto unused : state) {
    test::TestStorage storage;
    RecordingOptions options;
    options.keys = &keys;
    auto writer = RecordingWriter::Create(storage, "scan.mcap", scan.header, options);
    Status written = writer ? Status{} : Fail(writer);
    for (std::size_t i = 0; written && i < scan.levels.size(); ++i) written = writer->AppendLevel(scan.levels[i]);
    if (written) written = writer->Finish();
    if (!written) state.SkipWithError(written.error().Text().c_str());
  }
}
BENCHMARK(WriteASealedRecording)->Unit(benchmark::kMillisecond);

void RecoverARecording(benchmark::State& state) {
  test::TestStorage storage;
  Status written = WriteRecording(storage, "scan.mcap", TubeScan(kLevels));
  auto& bytes = storage.files["scan.mcap"];
  bytes.resize(bytes.size() * 9 / 10);
  for (auto unused : state) {
    const auto recovered = written ? RecoverRecording(storage, "scan.mcap", "saved.mcap") : Fail(written);
    if (!recovered) state.SkipWithError(recovered.error().Text().c_str());
    storage.files.erase("saved.mcap");
  }
}
BENCHMARK(RecoverARecording)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus::bench
