#include <gtest/gtest.h>

#include <random>

#include "firmware_iface/scan_axis.h"
#include "sim/axis_firmware.h"
#include "sim/faulty_modbus_link.h"
#include "sim/modbus_server.h"
#include "tests/firmware_iface/modbus_rig.h"
#include "tests/firmware_iface/modbus_spies.h"
#include "tests/support/faulty_terminal.h"

namespace annulus {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

struct Tally {
  int fresh = 0;
  int wrong = 0;
};

/// Exchanges until `exchanges` requests have been sent, judged by what the drive had at each.
Tally Exchange(ScanAxis& axis, const HostSpy& host, const DriveSpy& drive, int exchanges) {
  Tally tally;
  while (host.exchanges < exchanges) {
    const auto position = axis.Position();
    if (!position || !position->fresh) continue;
    ++tally.fresh;
    if (!IsTrue(*position, drive.Of(host.counter))) ++tally.wrong;
  }
  return tally;
}

sim::ModbusFaultRates ManyFaults() {
  sim::ModbusFaultRates rates;
  rates.request_lost = rates.reply_lost = rates.truncated = rates.damaged = 0.03;
  rates.exception = 0.02;
  rates.late = 0.08;
  rates.repeated = rates.merged = 0.05;
  rates.longest_delay = 5 * ModbusAxisOptions{}.reply_timeout;
  return rates;
}

class ModbusTruth : public testing::TestWithParam<sim::ModbusNumbering> {};

TEST_P(ModbusTruth, M2_AcceptsNoWrongValueIn100000ExchangesInVirtualTime) {
  ManualClock clock;
  sim::AxisDriveModel drive(ContractDrive(1.0), clock);
  DriveSpy spy(drive);
  sim::FaultyModbusLink line(spy, clock, GetParam());
  HostSpy host(line);
  auto axis = MakeModbusScanAxis(host, {}, clock);
  ASSERT_TRUE(axis) << axis.error().Text();
  line.SetPlan(sim::SeededModbusFates(ManyFaults(), 42));
  const Tally tally = Exchange(**axis, host, spy, 100'000);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GT(tally.fresh, 50'000);
  // The faults did bite: so many replies to other requests came as successes of a line without numbers.
  if (GetParam() == sim::ModbusNumbering::kNone) {
    EXPECT_GT(host.foreign, 5'000);
  } else {
    EXPECT_EQ(host.foreign, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ModbusTruth,
                         testing::Values(sim::ModbusNumbering::kNone, sim::ModbusNumbering::kTransaction),
                         [](const auto& param_info) {
                           return param_info.param == sim::ModbusNumbering::kNone ? "Serial" : "Tcp";
                         });

ByteFate RandomFate(std::mt19937& random, microseconds timeout) {
  ByteFate fate;
  const auto kind = random() % 28;
  const microseconds delay(static_cast<std::int64_t>(random()) % (5 * timeout.count()));
  if (kind == 0 || kind == 1) fate.delay = delay;
  if (kind == 2) fate = {.delay = delay, .copies = 2};
  if (kind == 3) fate.merged = true;
  if (kind == 4) fate.missing = 1 + random() % 20;
  if (kind == 5) fate.damaged = true;
  if (kind == 6) fate.byte_gap = microseconds(random() % 1000);
  return fate;
}

TEST(ModbusTruthOnATerminal, M2_AcceptsNoWrongValueIn2000ExchangesThroughLibmodbus) {
  SystemClock clock;
  sim::AxisDriveOptions options = ContractDrive(1.0);
  options.wire_delay = options.wire_jitter = std::chrono::nanoseconds(0);
  options.start_window = milliseconds(5);
  sim::AxisDriveModel drive(options, clock);
  DriveSpy spy(drive);
  auto server = sim::ModbusServer::Start(spy, {});
  ASSERT_TRUE(server) << server.error().Text();
  constexpr milliseconds kTimeout{5};
  std::mt19937 random(7);
  bool clean = true;
  std::mutex mutex;
  FaultyTerminal terminal((*server)->device_name(), [&] {
    const std::lock_guard lock(mutex);
    return clean ? ByteFate{} : RandomFate(random, kTimeout);
  });
  auto link = OpenModbusRtu({terminal.device_name(), 115'200, 'N'}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  HostSpy host(**link);
  Result<std::unique_ptr<ScanAxis>> axis = Fail("", "", "");
  for (int chance = 0; chance < 20 && !axis; ++chance) {
    axis = MakeModbusScanAxis(host, {}, clock, {kTimeout, milliseconds(15)});
  }
  ASSERT_TRUE(axis) << axis.error().Text();
  {
    const std::lock_guard lock(mutex);
    clean = false;
  }
  host.exchanges = 0;
  struct Reading {
    AxisPosition position;
    std::uint16_t counter;
  };
  std::vector<Reading> readings;
  while (host.exchanges < 2'000) {
    const auto position = (*axis)->Position();
    if (position && position->fresh) readings.push_back({*position, host.counter});
  }
  int wrong = 0;
  (*server)->Inspect([&] {
    for (const Reading& reading : readings) {
      if (!IsTrue(reading.position, spy.Of(reading.counter))) ++wrong;
    }
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(readings.size(), 500U);
  EXPECT_GT(host.foreign, 20);
  RecordProperty("accepted", static_cast<int>(readings.size()));
  RecordProperty("foreign", host.foreign);
}

}  // namespace
}  // namespace annulus
