#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>

#include "acquisition/csv_scan.h"
#include "acquisition/recording.h"
#include "tests/bench/bench_scan.h"
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

}  // namespace
}  // namespace annulus::bench
