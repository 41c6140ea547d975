#include "acquisition/clock_sync.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace annulus {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A device whose clock is ahead by an offset and runs fast by a drift, asked over a link with random delays.
struct Device {
  nanoseconds offset{0};
  double drift_ppm = 0.0;
  nanoseconds least_delay = microseconds(60);
  double mean_extra_us = 40.0;
  std::mt19937_64 random{1};

  [[nodiscard]] nanoseconds TimeAt(nanoseconds host) const {
    return offset + host + nanoseconds(std::llround(static_cast<double>(host.count()) * drift_ppm * 1e-6));
  }
  nanoseconds Delay() {
    const double unit = (static_cast<double>(random() >> 11) + 0.5) * 0x1.0p-53;
    return least_delay + nanoseconds(std::llround(-std::log(unit) * mean_extra_us * 1e3));
  }
  ClockExchange Ask(nanoseconds host) {
    const nanoseconds there = Delay();
    return {host, TimeAt(host + there), host + there + Delay()};
  }
};

TEST(ClockSync, RecoversOffsetAndDriftOfADriftingClock) {
  for (const double drift_ppm : {-40.0, -20.0, 0.0, 3.0, 20.0, 40.0}) {
    Device device;
    device.offset = std::chrono::seconds(777);
    device.drift_ppm = drift_ppm;
    ClockSync sync;
    nanoseconds now{0};
    for (int i = 0; i < 60; ++i, now += milliseconds(400)) ASSERT_TRUE(sync.Add(device.Ask(now)));
    EXPECT_NEAR(sync.drift_ppm(), drift_ppm, 2.0);
    // Anywhere in the window and one period beyond.
    for (nanoseconds t{0}; t < now; t += milliseconds(1234)) {
      EXPECT_LE(std::abs((sync.HostTime(device.TimeAt(t)) - t).count()), 20'000)
          << drift_ppm << " ppm at " << t.count();
    }
  }
}

TEST(ClockSync, IsWithinHalfTheFastestRoundTripFromTheFirstExchangeOn) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Device device;
    device.offset = std::chrono::seconds(5);
    device.drift_ppm = 20.0;
    device.random.seed(seed);
    ClockSync sync;
    for (nanoseconds now{0}; now < milliseconds(40); now += milliseconds(5)) {
      ASSERT_TRUE(sync.Add(device.Ask(now)));
      const double error_us = std::abs(static_cast<double>((sync.HostTime(device.TimeAt(now)) - now).count())) * 1e-3;
      EXPECT_LE(error_us, sync.bound_us() + 1.0);
    }
  }
}

TEST(ClockSync, IsHardlyMovedBySlowExchanges) {
  Device device;
  device.drift_ppm = 10.0;
  ClockSync sync;
  nanoseconds now{0};
  for (int i = 0; i < 64; ++i, now += milliseconds(100)) {
    ClockExchange exchange = device.Ask(now);
    if (i % 4 == 3) exchange.host_after += milliseconds(8);  // the answer lay about
    ASSERT_TRUE(sync.Add(exchange));
  }
  EXPECT_LE(std::abs((sync.HostTime(device.TimeAt(now)) - now).count()), 20'000);
}

TEST(ClockSync, IsExactWhenTheLinkTakesNoTime) {
  Device device;
  device.offset = std::chrono::seconds(3);
  device.least_delay = nanoseconds(0);
  device.mean_extra_us = 0.0;
  ClockSync sync;
  ASSERT_TRUE(sync.Add(device.Ask(milliseconds(1))));
  EXPECT_EQ(sync.HostTime(std::chrono::seconds(3) + milliseconds(7)), milliseconds(7));
  EXPECT_EQ(sync.bound_us(), 0.0);
}

TEST(ClockSync, TurnsHostTimeBackIntoDeviceTime) {
  Device device;
  device.drift_ppm = -30.0;
  ClockSync sync;
  for (nanoseconds now{0}; now < std::chrono::seconds(10); now += milliseconds(200)) {
    ASSERT_TRUE(sync.Add(device.Ask(now)));
  }
  for (nanoseconds t{0}; t < std::chrono::seconds(12); t += milliseconds(777)) {
    EXPECT_LE(std::abs((sync.DeviceTime(sync.HostTime(t)) - t).count()), 2);
  }
}

TEST(ClockSync, RefusesAClockThatStandsGoesBackOrJumps) {
  Device device;
  ClockSync sync;
  ASSERT_TRUE(sync.Add(device.Ask(milliseconds(10))));
  ASSERT_TRUE(sync.Add(device.Ask(milliseconds(20))));
  const nanoseconds known = sync.HostTime(milliseconds(15));
  ClockExchange stuck = device.Ask(milliseconds(30));
  stuck.device_time = milliseconds(20);
  EXPECT_FALSE(sync.Add(stuck));
  ClockExchange back = device.Ask(milliseconds(30));
  back.device_time = milliseconds(5);
  EXPECT_FALSE(sync.Add(back));
  ClockExchange jump = device.Ask(milliseconds(30));
  jump.device_time += milliseconds(50);
  EXPECT_FALSE(sync.Add(jump));
  EXPECT_EQ(sync.HostTime(milliseconds(15)), known);
  EXPECT_TRUE(sync.Add(device.Ask(milliseconds(30))));
}

}  // namespace
}  // namespace annulus
