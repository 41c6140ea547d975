#include "acquisition/scan_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "tests/sim/booth_fixture.h"
#include "tests/sim/cone_subject.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using testing::HasSubstr;

constexpr double kRingRadiusMm = 600.0;

/// Keeps everything in memory, and does something when a level comes.
class MemorySink final : public ScanSink {
 public:
  Status AppendLevel(const ScanLevel& level) override {
    levels.push_back(level);
    return on_level ? on_level(levels.size()) : Status{};
  }
  Status AppendAxis(nanoseconds time, double z_mm) override {
    axis.emplace_back(time, z_mm);
    return {};
  }
  Status AppendEvent(nanoseconds, const std::string& text) override {
    events.push_back(text);
    return {};
  }

  std::vector<ScanLevel> levels;
  std::vector<std::pair<nanoseconds, double>> axis;
  std::vector<std::string> events;
  std::function<Status(std::size_t count)> on_level;
};

/// Loses the reply of one transaction of an axis link, or everything.
class ForgetfulLink final : public ModbusLink {
 public:
  explicit ForgetfulLink(ModbusLink& link, Clock& clock) : link_(link), clock_(clock) {}
  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    const nanoseconds sent = clock_.Now();
    ++transactions;
    if (on_transaction) on_transaction();
    if (dead) {
      clock_.SleepUntil(sent + timeout);
      return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kTimeout, 0, {}});
    }
    ModbusReply reply = link_.Transact(request, timeout);
    if (forget == 0 || --forget > 0) return reply;
    clock_.SleepUntil(sent + timeout);
    return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kTimeout, 0, {}});
  }
  tl::expected<void, ModbusFailure> Reopen() override { return link_.Reopen(); }
  void DiscardInput() override { link_.DiscardInput(); }
  void Close() override { link_.Close(); }

  std::function<void()> on_transaction;
  int transactions = 0;
  bool dead = false;
  int forget = 0;  ///< Transactions until the one that is lost; 0: none.

 private:
  ModbusLink& link_;
  Clock& clock_;
};

/// A booth with its two devices.
struct Bench {
  explicit Bench(sim::BoothOptions options) : booth(std::move(options)), link(booth.axis_link(), booth.clock()) {
    auto made_ring = MakeUsbRangeRing(booth.usb_ports(), {}, booth.clock());
    EXPECT_TRUE(made_ring) << made_ring.error().Text();
    ring = std::move(*made_ring);
    auto made_axis = MakeModbusScanAxis(link, {}, booth.clock());
    EXPECT_TRUE(made_axis) << made_axis.error().Text();
    axis = std::move(*made_axis);
  }
  Result<ScanSummary> Run(const ScanPlan& plan) {
    return RunScan(*ring, *axis, plan, sink, booth.clock(), {{}, stop.get_token()});
  }
  void ExpectSafe() {
    EXPECT_EQ(axis->state(), ScanAxis::State::kDisabled);
    EXPECT_EQ(booth.drive().state(), DriveState::kSwitchOnDisabled);
    EXPECT_NEAR(booth.drive().TrueSpeed(booth.clock().Now()), 0.0, 0.5);
    EXPECT_EQ(ring->state(), RangeRing::State::kIdle);
    for (UsbPort* port : booth.usb_ports()) EXPECT_EQ(port->in_flight(), 0U);
  }

  sim::Booth booth;
  ForgetfulLink link;
  std::unique_ptr<RangeRing> ring;
  std::unique_ptr<ScanAxis> axis;
  MemorySink sink;
  std::stop_source stop;
};

sim::BoothOptions ConeBooth() {
  sim::BoothOptions options;
  options.subject = std::make_unique<sim::ConeSubject>();
  options.beam = sim::ExactBeam();
  return options;
}

ScanPlan BodyPlan() { return *BuiltInPlan("body", std::nullopt); }

ScanPlan ShortPlan() {
  ScanPlan plan = BodyPlan();
  plan.z_top_mm = 1700.0;
  plan.z_bottom_mm = 1400.0;
  plan.sweeps = 2;
  return plan;
}

/// Largest difference between the height written beside a reading and the height at which its beam was really cast.
double WorstHeightError(const std::vector<ScanLevel>& levels) {
  double worst = 0.0;
  for (const ScanLevel& level : levels) {
    for (const RangeReading& reading : level.readings) {
      const double truth = sim::ConeSubject::HeightOf(kRingRadiusMm, reading.range_mm);
      worst = std::max(worst, std::abs(reading.z_mm - truth));
    }
  }
  return worst;
}

TEST(ScanRun, TakesEveryPlannedLevelOfABodyCloseToItsPlace) {
  Bench bench(sim::CylinderBooth());
  const ScanPlan plan = BodyPlan();
  const auto summary = bench.Run(plan);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_FALSE(summary->cancelled);
  EXPECT_EQ(summary->levels, 720U);
  EXPECT_EQ(summary->missing_levels, 0U) << summary->BriefReport();
  EXPECT_EQ(summary->sweeps, 4U);
  bench.ExpectSafe();
  std::vector<std::uint32_t> next(plan.sweeps, 0);
  nanoseconds before{0};
  for (const ScanLevel& level : bench.sink.levels) {
    ASSERT_EQ(level.index, next[level.sweep]++);
    EXPECT_GT(level.time, before);
    before = level.time;
    // Body: sweeps 1 and 3 are 5 mm lower and run upwards; 180 levels 10 mm apart.
    const double place = level.sweep % 2 == 0 ? 1800.0 - 10.0 * level.index : 5.0 + 10.0 * level.index;
    EXPECT_NEAR(level.readings[0].z_mm, place, 2.5);
  }
}

TEST(ScanRun, InterleavesTheSweepsEvenly) {
  Bench bench(sim::CylinderBooth());
  ASSERT_TRUE(bench.Run(BodyPlan()));
  // Down and up sweeps together have levels 5 mm apart, although the axis follows its set-point late in both
  // directions.
  std::vector<double> heights;
  for (const ScanLevel& level : bench.sink.levels) {
    if (level.sweep < 2) heights.push_back(level.readings[0].z_mm);
  }
  std::sort(heights.begin(), heights.end());
  for (std::size_t k = 1; k < heights.size(); ++k) EXPECT_NEAR(heights[k] - heights[k - 1], 5.0, 0.5);
}

TEST(ScanRun, ReadsARoundCylinderAsTheRingsRadiusLessItsOwn) {
  Bench bench(sim::CylinderBooth());
  ASSERT_TRUE(bench.Run(ShortPlan()));
  for (const ScanLevel& level : bench.sink.levels) {
    ASSERT_EQ(level.readings.size(), 180U);
    for (const RangeReading& reading : level.readings) {
      if (reading.z_mm > sim::kCylinderTopMm + 0.1) {
        EXPECT_TRUE(std::isnan(reading.range_mm));
      } else if (reading.z_mm < sim::kCylinderTopMm - 0.1) {
        EXPECT_NEAR(reading.range_mm, kRingRadiusMm - sim::kCylinderRadiusMm, 0.0006);
      }
    }
  }
}

TEST(ScanRun, KnowsTheHeightOfEachReadingWithin50MicrometresAt300MillimetresPerSecond) {
  double worst = 0.0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    sim::BoothOptions options = ConeBooth();
    options.seed = seed;
    Bench bench(std::move(options));
    ASSERT_TRUE(bench.Run(ShortPlan()));
    worst = std::max(worst, WorstHeightError(bench.sink.levels));
  }
  EXPECT_LE(worst, 0.05);
  RecordProperty("worst_height_error_um", static_cast<int>(std::lround(worst * 1000.0)));
}

TEST(ScanRun, SurvivesOneLostReplyOfTheDriveWithoutALossOfPlace) {
  Bench bench(ConeBooth());
  bench.sink.on_level = [&](std::size_t count) {
    if (count == 10) bench.link.forget = 3;
    return Status{};
  };
  const auto summary = bench.Run(ShortPlan());
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->levels, summary->planned_levels);
  EXPECT_LE(WorstHeightError(bench.sink.levels), 0.05);
}

TEST(ScanRun, GivesTheSameLevelsForTheSameSeedBitForBit) {
  const auto levels = [](std::uint64_t seed) {
    sim::BoothOptions options = sim::CylinderBooth(sim::BeamOptions{});
    options.seed = seed;
    Bench bench(std::move(options));
    EXPECT_TRUE(bench.Run(ShortPlan()));
    std::vector<std::uint64_t> bits;
    for (const ScanLevel& level : bench.sink.levels) {
      bits.push_back(static_cast<std::uint64_t>(level.time.count()));
      for (const RangeReading& reading : level.readings) {
        bits.push_back(std::bit_cast<std::uint64_t>(reading.range_mm));
        bits.push_back(std::bit_cast<std::uint64_t>(reading.z_mm));
        bits.push_back(reading.quality);
      }
    }
    return bits;
  };
  const auto first = levels(7);
  EXPECT_EQ(first, levels(7));
  EXPECT_NE(first, levels(8));
}

TEST(ScanRun, StopsWithinHalfASecondOfARequestAndKeepsWhatItTook) {
  for (const std::size_t at : {1U, 17U, 30U, 31U, 59U}) {
    Bench bench(sim::CylinderBooth());
    nanoseconds requested{0};
    bench.sink.on_level = [&](std::size_t count) {
      if (count != at) return Status{};
      requested = bench.booth.clock().Now();
      bench.stop.request_stop();
      return Status{};
    };
    const auto summary = bench.Run(ShortPlan());
    ASSERT_TRUE(summary) << summary.error().Text();
    EXPECT_TRUE(summary->cancelled);
    EXPECT_GE(summary->levels, at);
    EXPECT_EQ(summary->levels, bench.sink.levels.size());
    EXPECT_LE(summary->end - requested, std::chrono::milliseconds(500));
    bench.ExpectSafe();
  }
}

/// Transactions of a whole short scan.
int CountTransactions() {
  Bench bench(sim::CylinderBooth());
  const int before = bench.link.transactions;
  EXPECT_TRUE(bench.Run(ShortPlan()));
  return bench.link.transactions - before;
}

TEST(ScanRun, StopsSafelyWheneverItIsAskedTo) {
  const int all = CountTransactions();
  for (int at = 1; at < all; at += all / 60) {
    Bench bench(sim::CylinderBooth());
    nanoseconds requested{0};
    bench.link.on_transaction = [&, left = at]() mutable {
      if (--left != 0) return;
      requested = bench.booth.clock().Now();
      bench.stop.request_stop();
    };
    const auto summary = bench.Run(ShortPlan());
    ASSERT_TRUE(summary) << "transaction " << at << ": " << summary.error().Text();
    EXPECT_LE(summary->end - requested, std::chrono::milliseconds(500)) << "transaction " << at;
    bench.ExpectSafe();
  }
}

TEST(ScanRun, LeavesTheAxisAtRestWheneverTheDriveIsLost) {
  const int all = CountTransactions();
  for (int at = 1; at < all; at += all / 60) {
    Bench bench(sim::CylinderBooth());
    nanoseconds lost{0};
    bench.link.on_transaction = [&, left = at]() mutable {
      if (--left != 0) return;
      lost = bench.booth.clock().Now();
      bench.link.dead = true;
    };
    const auto summary = bench.Run(ShortPlan());
    ASSERT_FALSE(summary) << "transaction " << at;
    EXPECT_THAT(summary.error().advice, HasSubstr("emergency stop"));
    bench.booth.clock().SleepUntil(std::max(bench.booth.clock().Now(), lost + std::chrono::milliseconds(500)));
    // 200 ms of heartbeat, 75 ms of ramp, 25 ms of lag.
    EXPECT_NEAR(bench.booth.drive().TrueSpeed(lost + std::chrono::milliseconds(300)), 0.0, 0.5);
    EXPECT_EQ(bench.ring->state(), RangeRing::State::kIdle);
  }
}

TEST(ScanRun, EndsSafelyWheneverABoardIsLost) {
  for (int tenths = 0; tenths < 100; tenths += 3) {
    Bench bench(sim::CylinderBooth());
    const nanoseconds pulled = std::chrono::milliseconds(100 * tenths + 37);
    bench.booth.board(static_cast<std::size_t>(tenths) % sim::Booth::kBoards).UnplugAt(pulled);
    const auto summary = bench.Run(ShortPlan());
    if (summary) {
      EXPECT_LE(summary->end, pulled);
      continue;
    }
    EXPECT_THAT(summary.error().Text(), HasSubstr("ring board 10"));
    bench.ExpectSafe();
  }
}

TEST(ScanRun, DoesNotMoveWhenStoppedBeforeItBegins) {
  Bench bench(sim::CylinderBooth());
  bench.stop.request_stop();
  const auto summary = bench.Run(ShortPlan());
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_TRUE(summary->cancelled);
  EXPECT_TRUE(bench.booth.drive().motion_log().empty());
  bench.ExpectSafe();
}

TEST(ScanRun, NamesTheBoardThatIsUnpluggedAndStopsTheAxis) {
  Bench bench(sim::CylinderBooth());
  nanoseconds pulled{0};
  bench.sink.on_level = [&](std::size_t count) {
    if (count != 20) return Status{};
    pulled = bench.booth.clock().Now() + std::chrono::milliseconds(5);
    bench.booth.board(7).UnplugAt(pulled);
    return Status{};
  };
  const auto summary = bench.Run(ShortPlan());
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().Text(), HasSubstr("ring board 1008 (sensors 105-119, port 1-1.8)"));
  EXPECT_THAT(summary.error().advice, HasSubstr("cable"));
  EXPECT_GE(bench.sink.levels.size(), 20U);
  EXPECT_LE(bench.booth.clock().Now() - pulled, std::chrono::milliseconds(500));
  bench.ExpectSafe();
}

TEST(ScanRun, StopsTheAxisWhenTheRecordingFails) {
  Bench bench(sim::CylinderBooth());
  bench.sink.on_level = [](std::size_t count) {
    return count < 12 ? Status{} : Status(Fail("append a level", "the disk is full", "make room"));
  };
  const auto summary = bench.Run(ShortPlan());
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().seen, "the disk is full");
  bench.ExpectSafe();
}

TEST(ScanRun, SaysSoWhenTheDriveIsGone) {
  Bench bench(sim::CylinderBooth());
  bench.sink.on_level = [&](std::size_t count) {
    if (count == 12) bench.link.dead = true;
    return Status{};
  };
  const auto summary = bench.Run(ShortPlan());
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().Text(), HasSubstr("emergency stop"));
  EXPECT_EQ(bench.ring->state(), RangeRing::State::kIdle);
  // The drive stops by itself: nobody talks to it.
  bench.booth.clock().SleepUntil(bench.booth.clock().Now() + std::chrono::milliseconds(500));
  EXPECT_NEAR(bench.booth.drive().TrueSpeed(bench.booth.clock().Now()), 0.0, 0.5);
  EXPECT_EQ(bench.booth.drive().state(), DriveState::kFault);
}

TEST(ScanRun, RefusesAPlanThatDoesNotFitBeforeAnythingMoves) {
  Bench bench(sim::CylinderBooth());
  ScanPlan plan = ShortPlan();
  plan.speed_mm_s = 400.0;
  const auto summary = bench.Run(plan);
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().Text(), HasSubstr("the machine allows 300 mm/s"));
  EXPECT_TRUE(bench.booth.drive().motion_log().empty());
}

TEST(ScanRun, ScansAHeadInOneMillimetreSteps) {
  Bench bench(sim::CylinderBooth());
  const auto summary = bench.Run(*BuiltInPlan("head", Millimetres(sim::kCylinderTopMm)));
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->levels, 360U);  // 40 mm above to 320 mm below the top
  EXPECT_EQ(summary->missing_levels, 0U);
}

TEST(ScanRun, ParksTheRingForABreath) {
  Bench bench(ConeBooth());
  const auto summary = bench.Run(*BuiltInPlan("breath", std::nullopt));
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->levels, 600U);  // 20 s at 30 per second
  EXPECT_LE(WorstHeightError(bench.sink.levels), 0.05);
  EXPECT_NEAR(bench.sink.levels.front().readings[0].z_mm, 1300.0, 0.05);
}

TEST(ScanRun, FindsTheTopOfTheSubjectWithinOneSearchLevel) {
  Bench bench(sim::CylinderBooth(sim::BeamOptions{}));
  const auto top = FindSubjectTop(*bench.ring, *bench.axis, bench.booth.clock(), {});
  ASSERT_TRUE(top) << top.error().Text();
  EXPECT_LE(top->value(), sim::kCylinderTopMm + 0.05);
  EXPECT_GE(top->value(), sim::kCylinderTopMm - 5.5);
  bench.ExpectSafe();
  // The same devices go on to scan, without homing again.
  ASSERT_TRUE(bench.Run(ShortPlan()));
}

TEST(ScanRun, SaysThatNobodyIsThere) {
  sim::BoothOptions options = sim::CylinderBooth();
  options.subject = std::make_unique<sim::CylinderSubject>(sim::kCylinderRadiusMm, -1.0);
  Bench bench(std::move(options));
  const auto top = FindSubjectTop(*bench.ring, *bench.axis, bench.booth.clock(), {});
  ASSERT_FALSE(top);
  EXPECT_THAT(top.error().Text(), HasSubstr("nothing in the ring"));
  bench.ExpectSafe();
}

}  // namespace
}  // namespace annulus
