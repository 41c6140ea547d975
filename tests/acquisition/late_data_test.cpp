// Levels that come later than they should: each reading is placed by its time stamp, never by its arrival.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <map>

#include "acquisition/level_stamper.h"
#include "acquisition/scan_run.h"
#include "tests/firmware_iface/forwarding_usb_port.h"
#include "tests/sim/booth_fixture.h"
#include "tests/sim/cone_subject.h"

namespace annulus {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = milliseconds(40);
/// Board k's clock shows 1 s more than board k - 1's; the first one's, and the drive's, are an hour ahead of the host.
constexpr nanoseconds kAhead = std::chrono::hours(1);
constexpr double kSpeedMmS = -125.0;  ///< A power of two fits: heights below are exact.
constexpr double kTopMm = 1800.0;

/// Two boards with one sensor each.
std::vector<RingBoard> TwoBoards() {
  std::vector<RingBoard> boards(2);
  for (std::uint16_t i = 0; i < 2; ++i) boards[i] = {1001U + i, i, 1, 1, "1.0.0", {}};
  return boards;
}

nanoseconds BoardTime(std::size_t board, nanoseconds host) {
  return host + kAhead + std::chrono::seconds(static_cast<std::int64_t>(board));
}

/// What a stamper makes of 40 levels of which board 1's frame of level k arrives delays[k] periods late. Links are
/// symmetric and the clocks run alike, so the truth is known to the last digit: level k of board b was fired at
/// 1 s + k periods + b us, with the carriage at kTopMm + kSpeedMmS · that.
std::vector<ScanLevel> Stamped(const std::map<int, int>& delays) {
  const std::vector<RingBoard> boards = TwoBoards();
  LevelStamper stamper(boards);
  const nanoseconds start = std::chrono::seconds(1);
  const nanoseconds one_way = microseconds(100);
  for (nanoseconds host = start - kPeriod; host <= start + 60 * kPeriod; host += milliseconds(5)) {
    for (std::size_t board = 0; board < boards.size(); ++board) {
      EXPECT_TRUE(stamper.AddBoardClock(board, {host - one_way, BoardTime(board, host), host + one_way}));
    }
    AxisPosition position;
    position.fresh = true;
    position.z = Millimetres(kTopMm + kSpeedMmS * static_cast<double>(host.count()) * 1e-9);
    position.time = {host - one_way, host + kAhead, host + one_way};
    EXPECT_TRUE(stamper.AddPosition(position));
  }
  for (int k = 0; k < 40; ++k) {
    RingLevel level;
    level.sequence = static_cast<std::uint32_t>(k);
    level.range_mm = {400.0, 401.0};
    level.quality = {200, 200};
    for (std::size_t board = 0; board < boards.size(); ++board) {
      const nanoseconds fired = start + k * kPeriod + microseconds(static_cast<std::int64_t>(board));
      const auto late = board == 1 && delays.count(k) != 0 ? delays.at(k) : 0;
      level.boards.push_back({true, BoardTime(board, fired), fired + milliseconds(2) + late * kPeriod, 20.0});
    }
    EXPECT_TRUE(stamper.AddLevel(level));
  }
  return stamper.Take();
}

TEST(LateData, HasNoErrorOfHeightUpToThreeLevelsLate) {
  for (const auto& delays : {std::map<int, int>{}, {{5, 1}, {9, 2}, {20, 3}, {21, 3}, {22, 2}, {23, 1}}}) {
    const std::vector<ScanLevel> levels = Stamped(delays);
    ASSERT_EQ(levels.size(), 40U);
    double worst = 0.0;
    for (std::size_t k = 0; k < levels.size(); ++k) {
      for (std::size_t board = 0; board < 2; ++board) {
        const double fired_s = 1.0 + 0.040 * static_cast<double>(k) + 1e-6 * static_cast<double>(board);
        worst = std::max(worst, std::abs(levels[k].readings[board].z_mm - (kTopMm + kSpeedMmS * fired_s)));
      }
    }
    EXPECT_LE(worst, 1e-9);
  }
}

/// Holds back what one board sends: from the n-th transfer on, each by the delays in turn. The order stays, as on USB.
class LatePort final : public ForwardingUsbPort {
 public:
  LatePort(UsbPort& port, Clock& clock, std::map<std::uint64_t, nanoseconds> delays)
      : ForwardingUsbPort(port), clock_(clock), delays_(std::move(delays)) {}

  std::optional<UsbCompletion> WaitCompletion(nanoseconds deadline) override {
    while (auto completion = ForwardingUsbPort::WaitCompletion(held_.empty() ? deadline : nanoseconds(0))) {
      nanoseconds delay{0};
      const auto found = delays_.upper_bound(seen_++);
      if (found != delays_.begin() && completion->status == UsbStatus::kCompleted) delay = std::prev(found)->second;
      ready_ = std::max(ready_, completion->host_time + delay);
      completion->host_time = ready_;
      held_.push_back(std::move(*completion));
    }
    if (held_.empty()) return std::nullopt;
    if (held_.front().host_time > std::max(clock_.Now(), deadline)) {
      clock_.SleepUntil(deadline);
      return std::nullopt;
    }
    clock_.SleepUntil(held_.front().host_time);
    std::optional<UsbCompletion> first(std::move(held_.front()));
    held_.pop_front();
    return first;
  }
  [[nodiscard]] std::size_t in_flight() const override { return ForwardingUsbPort::in_flight() + held_.size(); }

 private:
  Clock& clock_;
  std::map<std::uint64_t, nanoseconds> delays_;  ///< From this transfer on.
  std::uint64_t seen_ = 0;
  nanoseconds ready_{0};
  std::deque<UsbCompletion> held_;
};

class LevelList final : public ScanSink {
 public:
  Status AppendLevel(const ScanLevel& level) override {
    levels.push_back(level);
    return {};
  }
  Status AppendAxis(nanoseconds, double) override { return {}; }
  Status AppendEvent(nanoseconds, const std::string&) override { return {}; }

  std::vector<ScanLevel> levels;
};

struct LateScan {
  Result<ScanSummary> summary = Fail("scan", "not yet", "scan");
  RingCounters counters;
  std::vector<ScanLevel> levels;
  double worst_mm = 0.0;  ///< Largest error of a height, as the cone tells by the range.
};

/// Scans a cone while board 6 is late as `delays` says, by number of its transfers.
LateScan ScanLate(const std::map<std::uint64_t, nanoseconds>& delays) {
  sim::BoothOptions options;
  options.subject = std::make_unique<sim::ConeSubject>();
  options.beam = sim::ExactBeam();
  sim::Booth booth(std::move(options));
  std::vector<UsbPort*> ports = booth.usb_ports();
  LatePort late(*ports[6], booth.clock(), delays);
  ports[6] = &late;
  auto ring = MakeUsbRangeRing(ports, {}, booth.clock());
  auto axis = MakeModbusScanAxis(booth.axis_link(), {}, booth.clock());
  EXPECT_TRUE(ring && axis);
  ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  plan.z_top_mm = 1700.0;
  plan.z_bottom_mm = 1100.0;
  LevelList sink;
  LateScan scan;
  scan.summary = RunScan(**ring, **axis, plan, sink, booth.clock(), {});
  scan.counters = (*ring)->counters();
  scan.levels = std::move(sink.levels);
  for (const ScanLevel& level : scan.levels) {
    for (const RangeReading& reading : level.readings) {
      if (!std::isfinite(reading.range_mm)) continue;
      scan.worst_mm =
          std::max(scan.worst_mm, std::abs(reading.z_mm - sim::ConeSubject::HeightOf(600.0, reading.range_mm)));
    }
  }
  return scan;
}

constexpr nanoseconds kBodyPeriod = nanoseconds(41'666'667);  ///< 24 levels a second.

TEST(LateData, OfABoardThatComesToBeThreeLevelsLateKeepsItsHeights) {
  const LateScan punctual = ScanLate({});
  ASSERT_TRUE(punctual.summary) << punctual.summary.error().Text();
  // Later by a level at a time, then on time again; the driver waits for two levels beyond the last arrival.
  const LateScan late = ScanLate({{30, kBodyPeriod}, {40, 2 * kBodyPeriod}, {50, 3 * kBodyPeriod}, {70, {}}});
  ASSERT_TRUE(late.summary) << late.summary.error().Text();
  EXPECT_EQ(late.counters.lost_frames, 0U);
  EXPECT_EQ(late.counters.duplicate_frames, 0U);
  // What is left is the clocks' and the straight lines between positions, as without delay.
  EXPECT_LE(late.worst_mm, punctual.worst_mm + 0.005);
  EXPECT_LE(late.worst_mm, 0.06);
  std::printf("worst height error: %.4f mm on time, %.4f mm up to three levels late\n", punctual.worst_mm,
              late.worst_mm);
}

TEST(LateData, LaterThanTheDeadlineStopsTheScanAndPlacesNothingWrong) {
  const LateScan late = ScanLate({{30, 6 * kBodyPeriod}});
  ASSERT_FALSE(late.summary);
  EXPECT_THAT(late.summary.error().Text(), testing::HasSubstr("nothing from ring board 1007"));
  EXPECT_LE(late.worst_mm, 0.06);
}

}  // namespace
}  // namespace annulus
