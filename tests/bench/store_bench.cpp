// The store: a scan taken in, a line of the audit, searching among 10,000 customers.

#include <benchmark/benchmark.h>

#include <fstream>
#include <string>

#include "tests/station_store/store_folder.h"

namespace annulus::bench {
namespace {

void AddScanOf2Mb(benchmark::State& state) {
  test::StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  std::string recording(2'000'000, 'r');
  std::size_t round = 0;
  for (auto _ : state) {
    recording.replace(0, 8, std::to_string(10'000'000 + round++));  // the same file is taken in once only
    if (!disk.AddScan(consent, recording)) state.SkipWithError("the scan was refused");
  }
}
BENCHMARK(AddScanOf2Mb)->Unit(benchmark::kMillisecond)->UseRealTime();

void AuditLineSynced(benchmark::State& state) {
  test::StoreOnDisk disk;
  disk.Open();
  AuditLine line;
  line.user = "sato";
  line.action = "arm";
  for (auto _ : state) {
    if (!disk->Audit(line)) state.SkipWithError("the line was refused");
  }
}
BENCHMARK(AuditLineSynced)->Unit(benchmark::kMicrosecond)->UseRealTime();

void FindAmong10000(benchmark::State& state) {
  constexpr int kCustomers = 10'000;
  test::StoreOnDisk disk;
  disk.Open();
  Customer customer;
  for (int i = 0; i < kCustomers; ++i) {
    customer.name = "ヤマダ " + std::to_string(i);
    customer.contact = "customer" + std::to_string(i) + "@example.jp";
    if (!disk->AddCustomer(customer)) state.SkipWithError("a customer was refused");
  }
  disk.Open();
  for (auto _ : state) {
    const auto found = disk->FindCustomers("ﾔﾏﾀﾞ 77", 20);
    benchmark::DoNotOptimize(found);
    if (state.range(0) == 1) {  // names not in memory yet
      state.PauseTiming();
      disk.Open();
      state.ResumeTiming();
    }
  }
}
BENCHMARK(FindAmong10000)->ArgName("first")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace annulus::bench
