#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "firmware_iface/range_ring.h"
#include "sim/fault_injector.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::sim {

/// A plan of these faults, as a file has them.
inline FaultPlan PlanOf(const std::string& faults, std::uint64_t seed = 7) {
  const auto plan = ParseFaultPlan(R"({"format": "annulus fault plan", "version": 1, "seed": )" + std::to_string(seed) +
                                       R"(, "faults": [)" + faults + "]}",
                                   "test");
  EXPECT_TRUE(plan) << plan.error().Text();
  return plan ? *plan : FaultPlan{};
}

/// A fault at a time, s.
inline std::string TimeOf(const std::string& time_s, const std::string& rest) {
  return R"({"at": {"time_s": )" + time_s + "}, " + rest + "}";
}

/// A booth with the ring at half the height of its cylinder, 450 mm from every sensor, and faults.
class FaultyBooth {
 public:
  static constexpr double kTrueRangeMm = 600.0 - kCylinderRadiusMm;

  explicit FaultyBooth(const FaultPlan& plan, BoothOptions options = CylinderBooth())
      : booth_(AtHalfHeight(std::move(options))), injector_(plan, devices(), booth_.clock()) {}
  explicit FaultyBooth(const std::string& faults) : FaultyBooth(PlanOf(faults)) {}

  [[nodiscard]] BoothDevices& devices() { return booth_.devices(); }
  [[nodiscard]] ManualClock& clock() { return booth_.clock(); }
  [[nodiscard]] FaultInjector& injector() { return injector_; }
  /// Lets time pass with a tick every 10 ms.
  void Pass(std::chrono::nanoseconds time) {
    const auto until = clock().Now() + time;
    while (clock().Now() < until) {
      clock().SleepUntil(std::min(until, clock().Now() + std::chrono::milliseconds(10)));
      injector_.Poll();
    }
  }
  Result<std::unique_ptr<RangeRing>> OpenRing(UsbRangeRingOptions options = {}) {
    return OpenUsbRangeRing(injector_.usb_host(), std::move(options), clock());
  }
  /// Takes levels until there are `count`, or the ring fails. Tells the injector of each.
  Result<std::vector<RingLevel>> TakeLevels(RangeRing& ring, std::size_t count) {
    std::vector<RingLevel> levels;
    while (levels.size() < count) {
      auto level = ring.NextLevel(clock().Now() + std::chrono::milliseconds(200));
      if (!level) return Fail(level);
      levels.push_back(std::move(*level));
      injector_.NoteLevel(taken_++);
    }
    return levels;
  }

 private:
  static BoothOptions AtHalfHeight(BoothOptions options) {
    options.axis.start_z_mm = kCylinderTopMm / 2.0;
    return options;
  }

  struct ClockedBooth {
    explicit ClockedBooth(BoothOptions options) : devices_(std::move(options), clock_) {}
    [[nodiscard]] ManualClock& clock() { return clock_; }
    [[nodiscard]] BoothDevices& devices() { return devices_; }

   private:
    ManualClock clock_;
    BoothDevices devices_;
  };
  ClockedBooth booth_;
  FaultInjector injector_;
  std::uint64_t taken_ = 0;
};

}  // namespace annulus::sim
