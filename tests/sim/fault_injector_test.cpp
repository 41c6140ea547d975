#include "sim/fault_injector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "firmware_iface/interlock.h"
#include "firmware_iface/scan_axis.h"
#include "tests/sim/fault_fixture.h"
#include "tests/support/test_storage.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

TEST(FaultSchedule, TellsWhenByStateLevelTimeAndCall) {
  const FaultPlan plan = PlanOf(
      R"({"at": {"state": "SCANNING", "after_s": 0.5}, "for_s": 1, "target": "axis", "kind": "lag",
          "args": {"time_constant_ms": 50}},
         {"at": {"level": 4}, "until": {"state": "FAULT"}, "target": "gpio", "kind": "fail"},
         {"at": {"call": 3}, "target": "axis_link", "kind": "unplug"})");
  FaultSchedule schedule(plan, seconds(10));
  schedule.NoteState("IDLE", seconds(11));
  EXPECT_TRUE(schedule.Take(seconds(11)).empty());
  schedule.NoteState("SCANNING", seconds(12));
  schedule.NoteState("SCANNING", seconds(12) + milliseconds(10));
  // The model is told ahead, at the exact time.
  auto steps = schedule.Take(seconds(12));
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0].time, milliseconds(12'500));
  EXPECT_EQ(steps[0].to, milliseconds(13'500));
  EXPECT_TRUE(schedule.log().empty());
  for (std::uint64_t level = 0; level < 6; ++level) {
    schedule.NoteLevel(level, milliseconds(12'600) + milliseconds(level));
    steps = schedule.Take(milliseconds(12'600) + milliseconds(level));
    EXPECT_EQ(steps.size(), level == 4 ? 1U : 0U);
  }
  for (int call = 0; call < 3; ++call) {
    schedule.NoteCall({FaultTarget::kUsb, 0, false}, seconds(13));
    EXPECT_TRUE(schedule.Take(seconds(13)).empty());
    schedule.NoteCall({FaultTarget::kAxisLink}, seconds(13));
    EXPECT_EQ(schedule.Take(seconds(13)).size(), call == 2 ? 1U : 0U);
  }
  EXPECT_FALSE(schedule.finished());
  schedule.NoteState("FAULT", seconds(14));
  EXPECT_EQ(schedule.Take(seconds(14)).size(), 2U);
  EXPECT_TRUE(schedule.finished());
  std::vector<nanoseconds> times;
  for (const FaultEvent& event : schedule.log()) times.push_back(event.time);
  EXPECT_EQ(times, (std::vector<nanoseconds>{milliseconds(12'500), milliseconds(12'604), seconds(13),
                                             milliseconds(13'500), seconds(14)}));
}

/// What a run with a plan looks like from outside: the log, and what came from the devices.
std::string RunOf(const FaultPlan& plan) {
  FaultyBooth booth(plan);
  std::string seen;
  auto axis = MakeModbusScanAxis(booth.injector().axis_link(), AxisRegisterMap{}, booth.clock());
  auto ring = booth.OpenRing();
  if (axis && ring) {
    static_cast<void>((*axis)->Enable());
    booth.injector().NoteState("SCANNING");
    static_cast<void>((*ring)->Start(Hertz(50.0)));
    for (int level = 0; level < 60; ++level) {
      const auto taken = booth.TakeLevels(**ring, 1);
      if (taken) {
        for (const double range : taken->front().range_mm) seen += std::to_string(range) + " ";
      } else {
        seen += taken.error().Text();
      }
      const auto position = (*axis)->Position();
      seen += position ? std::to_string(position->z.value()) : position.error().Text();
      const HostCondition host = booth.injector().host();
      seen += host.killed ? " killed\n" : "\n";
    }
    static_cast<void>((*ring)->Stop());
  }
  return booth.injector().LogText() + seen;
}

TEST(FaultInjector, TheSamePlanGivesTheSameRun) {
  std::size_t begun = 0;
  for (std::uint64_t number = 0; number < 8; ++number) {
    const FaultPlan plan = RandomFaultPlan(5, number);
    const std::string once = RunOf(plan);
    EXPECT_EQ(once, RunOf(plan)) << WriteFaultPlan(plan);
    begun += once.find("begins") != std::string::npos ? 1 : 0;
  }
  EXPECT_GE(begun, 5U);
}

TEST(FaultInjector, AnEmptyPlanChangesNothing) {
  FaultyBooth faulty{FaultPlan{}};
  auto ring = faulty.OpenRing();
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(50.0)));
  const auto levels = faulty.TakeLevels(**ring, 20);
  ASSERT_TRUE(levels);
  for (const RingLevel& level : *levels) {
    for (const double range : level.range_mm) EXPECT_NEAR(range, FaultyBooth::kTrueRangeMm, 0.001);
  }
  EXPECT_TRUE((*ring)->Stop());
  EXPECT_TRUE(faulty.injector().finished());
  EXPECT_TRUE(faulty.injector().log().empty());
}

ModbusReply Ask(FaultyBooth& booth, nanoseconds timeout = milliseconds(30)) {
  return booth.injector().axis_link().Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0100, 2}, timeout);
}

TEST(LinkFaults, HappenAsOftenAsTheyAreCounted) {
  const auto failures = [](const std::string& kind, const std::string& args) {
    FaultyBooth booth(R"({"at": {"call": 3}, "target": "axis_link", "kind": ")" + kind + R"(", "args": {"count": 2)" +
                      args + "}}");
    std::string pattern;
    for (int i = 0; i < 8; ++i) {
      const ModbusReply reply = Ask(booth);
      pattern += reply ? (reply->size() == 2 ? '.' : 's') : "eTLB"[static_cast<int>(reply.error().fault)];
      if (!reply) {
        booth.Pass(milliseconds(100));
        booth.injector().axis_link().DiscardInput();
      }
    }
    return pattern;
  };
  EXPECT_EQ(failures("lose_request", ""), "..TT....");
  EXPECT_EQ(failures("lose_reply", ""), "..TT....");
  EXPECT_EQ(failures("late", R"(, "delay_ms": 40)"), "..TT....");
  EXPECT_EQ(failures("truncate", ""), "..ss....");
  EXPECT_EQ(failures("damage", ""), "..BB....");
  EXPECT_EQ(failures("exception", R"(, "code": 6)"), "..ee....");
  EXPECT_EQ(failures("repeat", ""), "........");
}

TEST(LinkFaults, AFrozenPeerCarriesOutLaterWhatQueuedUp) {
  FaultyBooth booth(TimeOf("0.1", R"("for_s": 1, "target": "axis_link", "kind": "freeze")"));
  booth.Pass(milliseconds(100));
  const auto write = [&](std::uint16_t value) {
    return booth.injector().axis_link().Transact({ModbusFunction::kWriteRegister, 1, {value}, 0, 0}, milliseconds(30));
  };
  EXPECT_FALSE(write(6));
  EXPECT_FALSE(write(7));
  EXPECT_TRUE(booth.devices().drive().write_log().empty());
  booth.Pass(seconds(1));
  ASSERT_EQ(booth.devices().drive().write_log().size(), 2U);
  EXPECT_GE(booth.devices().drive().write_log()[0].time, milliseconds(1100));
}

TEST(LinkFaults, AnUnpluggedLinkComesBackByOpening) {
  FaultyBooth booth(TimeOf("0.1", R"("for_s": 1, "target": "axis_link", "kind": "unplug")"));
  booth.Pass(milliseconds(200));
  const ModbusReply reply = Ask(booth);
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().fault, ModbusFault::kLinkLost);
  EXPECT_FALSE(booth.injector().axis_link().Reopen());
  booth.Pass(seconds(1));
  EXPECT_FALSE(Ask(booth));
  EXPECT_TRUE(booth.injector().axis_link().Reopen());
  EXPECT_TRUE(Ask(booth));
}

TEST(AxisFaults, ReachTheDriveAtTheirExactTime) {
  FaultyBooth booth(TimeOf("1.2345", R"("target": "axis", "kind": "encoder_jump", "args": {"jump_mm": 50})") + "," +
                    TimeOf("2", R"("target": "axis", "kind": "parameter",
                                   "args": {"parameter": "heartbeat_ms", "value": 5000})") +
                    "," + TimeOf("3", R"("target": "axis", "kind": "limit", "args": {"end": "both"})") + "," +
                    TimeOf("4", R"("until": {"state": "FAULT"}, "target": "axis", "kind": "unordered_move",
                                   "args": {"speed_mm_s": -10})"));
  const auto reading = [&] {
    const auto reply = booth.devices().drive().Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0103, 2}, seconds(1));
    return static_cast<std::int32_t>(static_cast<std::uint32_t>((*reply)[0]) << 16 | (*reply)[1]) / 1000.0;
  };
  booth.clock().SleepUntil(milliseconds(1230));
  EXPECT_NEAR(reading(), 0.0, 0.001);
  booth.clock().SleepUntil(milliseconds(1235));
  EXPECT_NEAR(reading(), 50.0, 0.001);
  booth.Pass(milliseconds(1000));
  static_cast<void>(booth.devices().drive().TrueZ(booth.clock().Now()));
  EXPECT_EQ(booth.devices().drive().options().heartbeat, seconds(5));
  booth.Pass(milliseconds(2765));
  EXPECT_NEAR(booth.devices().drive().TrueSpeed(booth.clock().Now()), -10.0, 0.01);
  booth.injector().NoteState("FAULT");
  booth.Pass(milliseconds(100));
  EXPECT_NEAR(booth.devices().drive().TrueSpeed(booth.clock().Now()), 0.0, 0.01);
  EXPECT_NEAR(booth.devices().drive().TrueZ(booth.clock().Now()), 850.0 - 10.0, 0.2);
}

TEST(ChainFaults, MoveContactsAtTheirExactTime) {
  FaultyBooth booth(TimeOf("0.1234", R"("for_s": 0.5, "target": "chain", "kind": "estop", "args": {"channel": "a"})"));
  SafetyChain& chain = booth.devices().safety();
  booth.Pass(seconds(1));
  EXPECT_FALSE(chain.WasOpen(nanoseconds(0), milliseconds(123)));
  EXPECT_TRUE(chain.WasOpen(milliseconds(123), milliseconds(124)));
  EXPECT_TRUE(chain.WasOpen(milliseconds(400), milliseconds(623)));
  EXPECT_FALSE(chain.WasOpen(milliseconds(624), seconds(1)));
}

/// Lines of the chain as the program has them: inputs first.
class LineFaults : public testing::Test {
 protected:
  void Make(const std::string& faults) {
    booth_ = std::make_unique<FaultyBooth>(faults);
    auto lines = booth_->devices().safety().Request({}, InterlockWiring::Default().Lines());
    ASSERT_TRUE(lines) << lines.error().Text();
    lines_ = booth_->injector().WrapLines(std::move(*lines));
  }
  bool Reads(InterlockInput input) {
    const auto levels = lines_->Read();
    EXPECT_TRUE(levels);
    return levels && (*levels)[static_cast<std::size_t>(input)];
  }

  std::unique_ptr<FaultyBooth> booth_;
  std::unique_ptr<GpioLines> lines_;
};

TEST_F(LineFaults, ABrokenWireReadsAsADemandUntilItIsMended) {
  Make(TimeOf("0.1", R"("for_s": 0.5, "target": "chain", "kind": "wire_break", "args": {"input": "door"})"));
  EXPECT_TRUE(Reads(InterlockInput::kDoor));
  booth_->Pass(milliseconds(200));
  EXPECT_FALSE(Reads(InterlockInput::kDoor));
  EXPECT_TRUE(Reads(InterlockInput::kUpperLimit));
  booth_->Pass(milliseconds(500));
  EXPECT_TRUE(Reads(InterlockInput::kDoor));
}

TEST_F(LineFaults, AHeldButtonAndAStuckFeedbackAreRead) {
  Make(TimeOf("0.1", R"("target": "chain", "kind": "press", "args": {"input": "reset"})") + "," +
       TimeOf("0.1",
              R"("for_s": 0.5, "target": "gpio", "kind": "stuck", "args": {"input": "enable_feedback", "level": 1})"));
  booth_->Pass(milliseconds(200));
  EXPECT_TRUE(Reads(InterlockInput::kReset));
  EXPECT_TRUE(Reads(InterlockInput::kEnableFeedback));
  booth_->Pass(milliseconds(500));
  EXPECT_TRUE(Reads(InterlockInput::kReset));
  EXPECT_FALSE(Reads(InterlockInput::kEnableFeedback));
}

TEST_F(LineFaults, CallsFailForTheirTime) {
  Make(TimeOf("0.1", R"("for_s": 0.1, "target": "gpio", "kind": "fail")") + "," +
       TimeOf("0.3", R"("for_s": 0.1, "target": "gpio", "kind": "fail_writes")") + "," +
       TimeOf("0.5", R"("target": "gpio", "kind": "gone")"));
  std::string reads;
  std::string writes;
  for (int i = 0; i < 6; ++i) {
    booth_->Pass(milliseconds(i == 0 ? 50 : 100));
    const auto read = lines_->Read();
    reads += read ? '.' : read.error().fault == GpioFault::kGone ? 'g' : 'x';
    writes += lines_->Write(kInterlockInputs + 4, true) ? '.' : 'x';
  }
  EXPECT_EQ(reads, ".x...g");
  EXPECT_EQ(writes, ".x.x.x");
}

TEST_F(LineFaults, ChatteringContactsEndAtTheirLevel) {
  Make(TimeOf("0", R"("target": "gpio", "kind": "chatter", "args": {"share": 1, "pairs": 5})"));
  booth_->Pass(milliseconds(10));
  booth_->devices().safety().Set(InterlockInput::kCall, true);
  int edges = 0;
  bool last = false;
  while (const auto edge = lines_->WaitEdge(booth_->clock().Now() + milliseconds(20)).value_or(std::nullopt)) {
    if (edge->line != static_cast<std::size_t>(InterlockInput::kCall)) continue;
    ++edges;
    last = edge->level;
  }
  EXPECT_GE(edges, 3);
  EXPECT_EQ(edges % 2, 1);
  EXPECT_TRUE(last);
}

class StorageFaults : public testing::Test {
 protected:
  /// What comes of five writes, each with a sync: "w" failed to write, "s" to sync.
  std::string Write(const std::string& fault) {
    booth_ = std::make_unique<FaultyBooth>(fault);
    disk_ = std::make_unique<test::TestStorage>();
    Storage& storage = booth_->injector().WrapStorage(*disk_);
    auto file = storage.Create("f");
    if (!file) return "c";
    std::string seen;
    for (int i = 0; i < 5; ++i) {
      const auto bytes = std::vector<std::byte>(10, std::byte{7});
      seen += (*file)->Append(bytes) ? '.' : 'w';
      seen += (*file)->Sync() ? '.' : 's';
      booth_->Pass(milliseconds(100));
    }
    seen += (*file)->Close() ? "" : "c";
    return seen;
  }
  std::unique_ptr<FaultyBooth> booth_;
  std::unique_ptr<test::TestStorage> disk_;
};

TEST_F(StorageFaults, FailTheCallsThatTheyAreAbout) {
  const auto at_call = [](int call, const std::string& rest) {
    return R"({"at": {"call": )" + std::to_string(call) + R"(}, "target": "storage", )" + rest + "}";
  };
  EXPECT_EQ(Write(at_call(1, R"("kind": "no_space")")), "c");
  EXPECT_EQ(Write(at_call(3, R"("kind": "no_space")")), "..w.w.w.w.");
  EXPECT_EQ(disk_->files["f"].size(), 10U);
  EXPECT_EQ(Write(at_call(2, R"("kind": "short_write", "args": {"count": 1})")), "..w.......");
  EXPECT_EQ(disk_->files["f"].size(), 45U);
  EXPECT_EQ(Write(at_call(3, R"("kind": "sync_error")")), ".....s....");
  EXPECT_EQ(Write(at_call(4, R"("kind": "io_error", "args": {"count": 2})")), "..ws......");
  EXPECT_EQ(booth_->injector().log().size(), 1U);
  EXPECT_EQ(Write(TimeOf("0.15", R"("for_s": 0.2, "target": "storage", "kind": "io_error")")), "....wsws..");
  EXPECT_EQ(Write(TimeOf("0.15", R"("target": "storage", "kind": "read_only")")), "....wswsws");
}

TEST_F(StorageFaults, ASlowSyncTakesItsTime) {
  EXPECT_EQ(Write(R"({"at": {"call": 2}, "target": "storage", "kind": "slow_sync",
                      "args": {"count": 1, "delay_ms": 2000}})"),
            "..........");
  EXPECT_EQ(booth_->clock().Now(), milliseconds(2500));
}

TEST_F(StorageFaults, ASlowSyncInAThreadOfItsOwnWaitsUntilTheSimulationHasPassedIt) {
  booth_ = std::make_unique<FaultyBooth>(
      TimeOf("0", R"("target": "storage", "kind": "slow_sync", "args": {"delay_ms": 300})"));
  disk_ = std::make_unique<test::TestStorage>();
  auto file = booth_->injector().WrapStorage(*disk_).Create("f");
  ASSERT_TRUE(file);
  std::atomic<bool> done = false;
  std::jthread writer([&] {
    EXPECT_TRUE((*file)->Sync());
    done = true;
  });
  for (int tick = 0; !done; ++tick) {
    booth_->Pass(milliseconds(10));
    std::this_thread::yield();
  }
  EXPECT_GE(booth_->clock().Now(), milliseconds(290));
}

TEST_F(StorageFaults, AnAlmostFullDiskSaysSo) {
  booth_ = std::make_unique<FaultyBooth>(
      TimeOf("0", R"("for_s": 1, "target": "storage", "kind": "low_space", "args": {"bytes": 4096})"));
  disk_ = std::make_unique<test::TestStorage>();
  Storage& storage = booth_->injector().WrapStorage(*disk_);
  EXPECT_EQ(storage.FreeBytes("f").value_or(0), 4096U);
  booth_->Pass(seconds(2));
  EXPECT_GT(storage.FreeBytes("f").value_or(0), 4096U);
}

TEST(HostFaults, AreToldAtEveryTick) {
  FaultyBooth booth(
      TimeOf("0.1", R"("for_s": 0.2, "target": "host", "kind": "hang")") + "," +
      TimeOf("0.4", R"("target": "host", "kind": "late_ticks", "args": {"count": 2, "delay_ms": 25})") + "," +
      TimeOf("0.5", R"("for_s": 0.1, "target": "host", "kind": "thread_dead", "args": {"thread": "writer"})") + "," +
      TimeOf("0.7", R"("target": "host", "kind": "wall_jump", "args": {"jump_s": 3600})") + "," +
      TimeOf("0.8", R"("for_s": 0.1, "target": "host", "kind": "hot")") + "," +
      R"({"at": {"call": 100}, "target": "host", "kind": "kill"})");
  Clock& wall = booth.injector().WrapClock(booth.clock());
  int hangs = 0;
  int late = 0;
  int dead = 0;
  int hot = 0;
  for (int tick = 1; tick < 100; ++tick) {
    booth.clock().SleepUntil(milliseconds(10 * tick));
    const HostCondition host = booth.injector().host();
    hangs += host.hangs ? 1 : 0;
    late += host.late == milliseconds(25) ? 1 : 0;
    dead += host.dead_thread(HostThread::kWriter) ? 1 : 0;
    hot += host.hot ? 1 : 0;
    EXPECT_FALSE(host.dead_thread(HostThread::kControl));
    EXPECT_FALSE(host.killed);
  }
  EXPECT_EQ(hangs, 20);
  EXPECT_EQ(late, 2);
  EXPECT_EQ(dead, 10);
  EXPECT_EQ(hot, 10);
  EXPECT_EQ(wall.WallNow() - booth.clock().WallNow(), std::chrono::hours(1));
  EXPECT_EQ(wall.Now(), booth.clock().Now());
  EXPECT_TRUE(booth.injector().host().killed);
  booth.injector().Revive();
  EXPECT_FALSE(booth.injector().host().killed);
}

}  // namespace
}  // namespace annulus::sim
