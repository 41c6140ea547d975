// Faults before the record (what the driver saw then is replayed) and behind it (a sound scan meets faults now).

#include "sim/replay_faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <random>

#include "sim/faulty_can_bus.h"
#include "sim/faulty_usb_port.h"
#include "tests/acquisition/replay_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using test::Compare;
using test::ExpectIdentical;
using test::NoisyCone;
using test::RingCase;
using test::ShortPlan;
using test::TapeSink;
using test::TappedBooth;

/// Frames on CAN are many: fewer plans take as long.
int Cases(const RingCase& ring) {
  if (std::getenv("ANNULUS_LONG") != nullptr) return 500;
  return ring.can_buses == 0 ? 50 : 15;
}

/// Faults of all ports or buses, drawn by a seed; keeps what it puts between.
class RandomFaults {
 public:
  explicit RandomFaults(std::uint64_t seed) : random_(seed) {}

  std::vector<UsbPort*> OnUsb(const std::vector<UsbPort*>& ports, Clock&) {
    std::vector<UsbPort*> wrapped;
    for (UsbPort* port : ports) {
      sim::UsbFaultPlan plan;
      plan.seed = random_();
      plan.damage_share = Rate();
      plan.short_share = Rate();
      plan.zero_share = Rate();
      plan.long_share = Rate();
      plan.timeout_share = Rate();
      plan.stall_share = Rate() * 0.2;
      plan.cancel_completes_share = 0.5;
      if (random_() % 40 == 0) plan.no_memory_at = random_() % 300;
      usb_.emplace_back(*port, plan);
      wrapped.push_back(&usb_.back());
    }
    return wrapped;
  }
  std::vector<CanBus*> OnCan(const std::vector<CanBus*>& buses, Clock& clock) {
    std::vector<CanBus*> wrapped;
    for (CanBus* bus : buses) {
      can_.emplace_back(*bus, clock, sim::CanFrameFaults{random_(), Rate() * 0.2, Rate(), Rate(), 4});
      const nanoseconds at = clock.Now() + milliseconds(1'000 + random_() % 30'000);
      switch (random_() % 4) {
        case 0:
          can_.back().BreakBetween(at, at + milliseconds(200), CanFault::kDown);
          break;
        case 1:
          can_.back().RefuseSendsBetween(at, at + milliseconds(15), CanFault::kQueueFull);
          break;
        case 2: {
          CanReport off;
          off.state = CanState::kBusOff;
          can_.back().ReportAt(at, off);
          break;
        }
        default:
          break;
      }
      wrapped.push_back(&can_.back());
    }
    return wrapped;
  }
  [[nodiscard]] TappedBooth::Between BeforeTheRecord() {
    return {[this](const auto& ports, Clock& clock) { return OnUsb(ports, clock); },
            [this](const auto& buses, Clock& clock) { return OnCan(buses, clock); }};
  }
  [[nodiscard]] ReplayOptions BehindTheRecord() {
    ReplayOptions options;
    options.wrap_usb = [this](const auto& ports, Clock& clock) { return OnUsb(ports, clock); };
    options.wrap_can = [this](const auto& buses, Clock& clock) { return OnCan(buses, clock); };
    return options;
  }

 private:
  /// None in half of the cases, else up to 2 %.
  double Rate() { return random_() % 2 == 0 ? 0.0 : 0.02 * static_cast<double>(random_() % 1000) / 1000.0; }

  std::mt19937_64 random_;
  std::deque<sim::FaultyUsbPort> usb_;
  std::deque<sim::FaultyCanBus> can_;
};

class ReplayWithFaults : public testing::TestWithParam<RingCase> {};

TEST_P(ReplayWithFaults, OfARecordedScanComeAgain) {
  int ended_well = 0;
  int lost = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    RandomFaults faults(seed);
    TappedBooth booth(NoisyCone(GetParam()), faults.BeforeTheRecord());
    if (booth.ring == nullptr) continue;  // it did not even boot
    TapeSink tape;
    const auto summary = booth.Scan(ShortPlan(), tape);
    ended_well += summary ? 1 : 0;
    lost += booth.ring->counters().lost_frames > 0 ? 1 : 0;
    SCOPED_TRACE(seed);
    const ReplayComparison compared = Compare(tape.recording);
    EXPECT_TRUE(compared.identical()) << compared.BriefReport();
  }
  std::printf("%s: of 12 scans with faults %d ended well, %d lost frames\n", GetParam().name, ended_well, lost);
}

TEST_P(ReplayWithFaults, PutIntoASoundScanDoTheSameEachTime) {
  TappedBooth booth(NoisyCone(GetParam()));
  TapeSink tape;
  const auto summary = booth.Scan(ShortPlan(), tape);
  ASSERT_TRUE(summary) << summary.error().Text();
  int different = 0;
  for (int seed = 1; seed <= Cases(GetParam()); ++seed) {
    std::string reports[2];
    for (std::string& report : reports) {
      RandomFaults faults(static_cast<std::uint64_t>(seed));
      const auto compared = CompareWithRecorded(tape.recording, faults.BehindTheRecord(), {});
      // A ring that can not be opened among so many faults is an answer, too.
      report = compared ? compared->BriefReport() : compared.error().Text();
    }
    EXPECT_EQ(reports[0], reports[1]) << seed;
    different += reports[0].starts_with("identical") ? 0 : 1;
  }
  EXPECT_GT(different, Cases(GetParam()) / 2);
}

/// A comparison with the faults of a plan behind the record.
struct Replayed {
  ReplayComparison comparison;
  std::vector<sim::FaultEvent> log;
  std::vector<std::string> untouched;
};

Replayed ReplayWith(const Recording& recording, const sim::FaultPlan& plan) {
  sim::ReplayFaults faults(plan);
  ReplayOptions options;
  options.wrap_usb = [&](const auto& ports, Clock& clock) { return faults.WrapUsb(ports, clock); };
  options.wrap_can = [&](const auto& buses, Clock& clock) { return faults.WrapCan(buses, clock); };
  options.on_begin = [&] { faults.NoteScan(); };
  options.on_level = [&](const ScanLevel&) { faults.NoteLevel(); };
  const auto compared = CompareWithRecorded(recording, std::move(options), {});
  Replayed replayed;
  if (compared) {
    replayed.comparison = *compared;
  } else {
    replayed.comparison.first.emplace().replayed = compared.error().Text();
  }
  replayed.log = faults.log();
  replayed.untouched = faults.Untouched();
  return replayed;
}

TEST_P(ReplayWithFaults, OfAnyPlanDoTheSameEachTime) {
  TappedBooth booth(NoisyCone(GetParam()));
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  for (std::uint64_t number = 0; number < static_cast<std::uint64_t>(Cases(GetParam())); ++number) {
    const sim::FaultPlan plan = sim::RandomFaultPlan(11, number);
    const Replayed once = ReplayWith(tape.recording, plan);
    const Replayed again = ReplayWith(tape.recording, plan);
    EXPECT_EQ(once.comparison.BriefReport(), again.comparison.BriefReport()) << sim::WriteFaultPlan(plan);
    EXPECT_EQ(once.log, again.log);
    // What is not of the ring's buses changes nothing.
    if (once.untouched.size() == plan.faults.size()) {
      EXPECT_TRUE(once.comparison.identical()) << once.comparison.BriefReport();
    }
  }
}

TEST(ReplayFaults, PullABoardAtALevelOfASoundScan) {
  TappedBooth booth(NoisyCone());
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  const auto plan = sim::ParseFaultPlan(R"({"format": "annulus fault plan", "version": 1, "faults": [
      {"at": {"level": 20}, "target": "usb", "kind": "unplug", "args": {"board": 4}}]})",
                                        "plan.json");
  ASSERT_TRUE(plan) << plan.error().Text();
  const Replayed replayed = ReplayWith(tape.recording, *plan);
  ASSERT_TRUE(replayed.comparison.first);
  EXPECT_EQ(replayed.comparison.first->field, "call NextLevel");
  EXPECT_THAT(replayed.comparison.first->replayed, testing::HasSubstr("ring board 1005"));
  // Level 20 came out while the next one or two were under way.
  EXPECT_EQ(replayed.comparison.identical_levels, replayed.comparison.replayed_levels);
  EXPECT_GE(replayed.comparison.replayed_levels, 21U);
  EXPECT_LE(replayed.comparison.replayed_levels, 22U);
}

INSTANTIATE_TEST_SUITE_P(Buses, ReplayWithFaults, test::kRingCases, test::RingCaseName);

}  // namespace
}  // namespace annulus
