// Row H4: an allocation of the program fails, any of those of a whole cycle. A program of its own, because it replaces
// operator new.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/faults/judge.h"

namespace {

/// Allocations of the program until the one that fails; not positive: none does.
std::atomic<std::int64_t> allocations_left{0};
std::atomic<std::int64_t> allocations{0};

void* Allocate(std::size_t size) {
  if (annulus::faults::in_program) {
    ++allocations;
    if (allocations_left > 0 && --allocations_left == 0) throw std::bad_alloc();
  }
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return Allocate(size); }
void* operator new[](std::size_t size) { return Allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace annulus::faults {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

bool RunCycle(FaultRig& rig) {
  return rig.Operate(
      [&] {
        const ScannerStatus seen = rig.status();
        const bool over = seen.scan && seen.state == ScanState::kIdle && seen.job.empty();
        const bool broken = !seen.causes.empty() && (seen.state == ScanState::kSafe || seen.state == ScanState::kFault);
        return over || broken || rig.Now() > seconds(40);
      },
      seconds(60));
}

/// How many allocations the program makes in a cycle from power-up to the end of a scan.
std::int64_t AllocationsOfACycle() {
  FaultRig rig;
  allocations = 0;
  EXPECT_TRUE(RunCycle(rig)) << rig.Told();
  return allocations;
}

TEST(FaultMatrix, H4_AnAllocationThatFailsIsACleanFaultAndTheNextScanPasses) {
  const std::int64_t all = AllocationsOfACycle();
  ASSERT_GT(all, 1000);
  const std::int64_t tries = std::getenv("ANNULUS_LONG") != nullptr ? 4000 : 250;
  // Every one of the first, then spread over the cycle.
  std::int64_t n = 0;
  int stopped = 0;
  int tried = 0;
  int wrong = 0;
  nanoseconds longest{0};
  while (n < all && wrong < 5) {
    n += n < tries / 4 ? 1 : std::max<std::int64_t>(1, all * 4 / (tries * 3));
    FaultRig rig;
    allocations_left = n;
    std::optional<nanoseconds> failed;
    rig.on_tick = [&] {
      if (!failed && allocations_left == 0) failed = rig.Now();
    };
    ASSERT_TRUE(RunCycle(rig)) << n << rig.Told();
    allocations_left = 0;
    rig.on_tick = {};
    ++tried;
    const bool stops = !rig.watch().shown().empty();
    stopped += stops ? 1 : 0;
    if (stops && failed) longest = std::max(longest, TimeToSafe(rig, *failed));
    const std::string judged = JudgeRun(rig, stops ? Expected{{CauseCode::kMemory}} : Expected{});
    EXPECT_EQ(judged, "") << "allocation " << n << " of " << all;
    if (!judged.empty()) ++wrong;
  }
  EXPECT_LE(longest, std::chrono::milliseconds(500));
  ReportTimeToSafe(longest);
  ReportNote(std::to_string(tried) + " of " + std::to_string(all) + " allocations failed, " + std::to_string(stopped) +
             " of them stopped the booth");
}

}  // namespace
}  // namespace annulus::faults
