#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware_iface/range_ring.h"
#include "sim/faulty_usb_port.h"
#include "sim/usb_host_model.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::test {

using sim::Booth;
using sim::FaultyUsbPort;
using sim::UsbFaultLog;
using sim::UsbFaultPlan;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

inline constexpr double kTrueRangeMm = 600.0 - sim::kCylinderRadiusMm;
inline constexpr Hertz kRate{50.0};
inline constexpr nanoseconds kPeriod = milliseconds(20);

/// The ring on a bus of which everything can go wrong. Rows of the fault matrix are named in the tests.
class UsbRangeRingFaults : public testing::Test {
 protected:
  explicit UsbRangeRingFaults(sim::BoothOptions options = Options())
      : booth_(std::move(options)),
        host_(booth_.clock()),
        plans_(booth_.board_count()),
        logs_(booth_.board_count()),
        faulty_(booth_.board_count()) {
    for (std::size_t i = 0; i < booth_.board_count(); ++i) {
      host_.Add(booth_.board(i));
      plans_[i].seed = 100 + i;
    }
    host_.wrap = [this](std::unique_ptr<UsbPort> port) {
      const auto board = static_cast<std::size_t>(std::stoul(port->identity().serial.substr(2)) - 1001);
      auto faulty = std::make_unique<FaultyUsbPort>(std::move(port), plans_[board], logs_[board]);
      faulty_[board] = faulty.get();
      return faulty;
    };
  }
  ~UsbRangeRingFaults() override {
    ring_.reset();
    EXPECT_EQ(host_.leaked_transfers(), 0U);
    EXPECT_EQ(host_.open_ports(), 0U);
  }
  static sim::BoothOptions Options() {
    sim::BoothOptions options = sim::CylinderBooth();
    options.axis.start_z_mm = 500.0;
    options.board.split_share = 0.0;  // one transfer is one frame, so that counts can be exact
    return options;
  }
  Status Open(UsbRangeRingOptions options = {}) {
    auto ring = OpenUsbRangeRing(host_, std::move(options), booth_.clock());
    if (!ring) return Fail(ring);
    ring_ = std::move(*ring);
    return {};
  }
  void OpenAndStart() {
    const Status opened = Open();
    ASSERT_TRUE(opened) << opened.error().Text();
    const Status started = ring_->Start(kRate);
    ASSERT_TRUE(started) << started.error().Text();
  }
  [[nodiscard]] nanoseconds Now() { return booth_.clock().Now(); }
  Result<RingLevel> Next() { return ring_->NextLevel(Now() + milliseconds(200)); }
  /// Reads at most `most` levels; every reading that there is must be true.
  Result<RingLevel> Read(int most) {
    Result<RingLevel> level = Fail("read", "nothing yet", "");
    for (int i = 0; i < most; ++i) {
      level = Next();
      if (!level) return level;
      ++levels_;
      for (std::size_t sensor = 0; sensor < 180; ++sensor) {
        const bool present = level->boards[sensor / 15].present;
        if (!present) ++missing_;
        if (present != (std::abs(level->range_mm[sensor] - kTrueRangeMm) < 0.001)) ++false_samples_;
      }
    }
    return level;
  }
  [[nodiscard]] UsbFaultLog Sum() const {
    UsbFaultLog sum;
    for (const UsbFaultLog& log : logs_) {
      sum.shortened += log.shortened;
      sum.emptied += log.emptied;
      sum.damaged += log.damaged;
      sum.lengthened += log.lengthened;
      sum.added_bytes += log.added_bytes;
      sum.kept_bytes += log.kept_bytes;
      sum.timed_out += log.timed_out;
      sum.stalls += log.stalls;
    }
    return sum;
  }

  Booth booth_;
  sim::UsbHostModel host_;
  std::vector<UsbFaultPlan> plans_;
  std::vector<UsbFaultLog> logs_;
  std::vector<FaultyUsbPort*> faulty_;  ///< As long as the ring keeps them open.
  std::unique_ptr<RangeRing> ring_;
  std::uint64_t levels_ = 0;
  std::uint64_t missing_ = 0;        ///< Readings of sensors whose board's frame was lost.
  std::uint64_t false_samples_ = 0;  ///< Readings that are not the truth.
};

}  // namespace annulus::test
