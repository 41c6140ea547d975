#include "acquisition/bus_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace annulus {
namespace {

using bus_record::Any;
using std::chrono::nanoseconds;
using testing::HasSubstr;

constexpr nanoseconds kTime{1'234'567'890'123};

std::vector<std::byte> Bytes(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

template <class Record>
Record ThereAndBack(const Record& record) {
  auto decoded = DecodeBusRecord(EncodeBusRecord(record, kTime));
  EXPECT_TRUE(decoded) << decoded.error().Text();
  return std::get<Record>(*decoded);
}

/// One of each kind, with all that can be in it.
std::vector<Any> OneOfEach() {
  CanRangeRingOptions can;
  can.first_sensors = {{1001, 0}, {1002, 15}};
  CanRangeRingOptions can_reference = can;
  can_reference.reference = ReferenceBoardOptions{1013, {3, 0, 14}};
  UsbRangeRingOptions usb_reference;
  usb_reference.reference = ReferenceBoardOptions{4'294'967'295U, {}};
  CanFrame frame;
  frame.id = 0x181;
  frame.fd = true;
  frame.size = 64;
  frame.data.fill(std::byte{0x5A});
  CanReport report;
  report.state = CanState::kBusOff;
  report.transmit_errors = 255;
  CanLink link;
  link.name = "can0";
  link.bit_rate = 500'000;
  const bus_record::CallEnd failed{nanoseconds(20'000'000), "read level 3: nothing: look"};
  return {bus_record::UsbPortNamed{3, {0x1209, 0xA180, "RB1003", "1-4.2"}},
          bus_record::UsbControl{1, true, {2, 3, 4}, nanoseconds(125'000), {}, Bytes({1, 2, 3})},
          bus_record::UsbControl{1, false, {2, 3, 4}, nanoseconds(5), UsbFailure{UsbStatus::kStall, "no"}, {}},
          bus_record::UsbEnded{11, UsbStatus::kNoDevice, kTime - nanoseconds(1), Bytes({0, 255})},
          bus_record::UsbRefused{2, bus_record::UsbRefused::Call::kClearHalt, 7, {UsbStatus::kNoMemory, ""}},
          bus_record::CanLinkRead{0, {}, link},
          bus_record::CanLinkRead{0, CanFailure{CanFault::kGone, "ENODEV"}, {}},
          bus_record::CanReceived{1, {kTime - nanoseconds(100), frame}},
          bus_record::CanReceived{1, {kTime + nanoseconds(100), report}},
          bus_record::CanSent{2, frame},
          bus_record::CanFailed{0, bus_record::CanFailed::Call::kReceive, 1, {CanFault::kDown, "ENETDOWN"}},
          bus_record::CanOverflows{1, 17},
          bus_record::ModbusExchanged{
              {ModbusFunction::kWriteReadRegisters, 0, {1, 65'535}, 0x100, 2}, nanoseconds(1'000'000), {}, {7, 65'535}},
          bus_record::ModbusExchanged{{}, nanoseconds(1), ModbusFailure{ModbusFault::kException, 6, "busy"}, {}},
          bus_record::RingOpening{bus_record::kFormat, UsbRangeRingOptions(), 12},
          bus_record::RingOpening{bus_record::kFormat, can, 2},
          bus_record::RingOpening{bus_record::kFormat, can_reference, 2},
          bus_record::RingOpening{bus_record::kFormat, usb_reference, 13},
          bus_record::RingOpening{bus_record::kFormatWithoutReference, UsbRangeRingOptions(), 12},
          bus_record::RingOpened{},
          bus_record::AxisOpened{{1, 2, WordOrder::kLowFirst, -0.1}},
          bus_record::StartCalled{failed, 24.0},
          bus_record::NextLevelCalled{failed, kTime + nanoseconds(3)},
          bus_record::ReadClockCalled{{nanoseconds(1), {}}, 11, {kTime - nanoseconds(9), nanoseconds(77), kTime}},
          bus_record::StopCalled{{}, {1, 2, 3, 4, 5, 6}},
          bus_record::ReopenCalled{failed, nanoseconds(0)},
          bus_record::PositionCalled{{}, true, kTime - nanoseconds(5), kTime - nanoseconds(1)},
          bus_record::PositionCalled{failed, false, {}, {}},
          bus_record::ScanBegun{"{}"},
          bus_record::SweepBegun{1},
          bus_record::SweepEnded{},
          bus_record::HandedOn{true},
          bus_record::ScanEnded{360, "why"}};
}

TEST(BusRecord, IsTheSameAfterItsBytes) {
  for (const Any& record : OneOfEach()) {
    const RawRecord once = EncodeBusRecord(record, kTime);
    const auto decoded = DecodeBusRecord(once);
    ASSERT_TRUE(decoded) << decoded.error().Text();
    EXPECT_EQ(decoded->index(), record.index());
    EXPECT_EQ(EncodeBusRecord(*decoded, kTime).bytes, once.bytes) << record.index();
  }
}

TEST(BusRecord, KeepsTheReferenceBoardAndWritesARingWithoutOneAsBefore) {
  CanRangeRingOptions options;
  options.reference = ReferenceBoardOptions{1013, {3, 0, 14}};
  const auto opening = ThereAndBack(bus_record::RingOpening{bus_record::kFormat, options, 2});
  EXPECT_EQ(std::get<CanRangeRingOptions>(opening.options).reference, options.reference);
  // Format 1, twelve ports on USB, 180 sensors, no map, 200 ms as zigzag LEB128, four transfers: by hand.
  const RawRecord plain = EncodeBusRecord(bus_record::RingOpening{1, UsbRangeRingOptions(), 12}, kTime);
  EXPECT_EQ(plain.bytes, Bytes({30, 1, 12, 0, 0xB4, 1, 0, 0x80, 0x88, 0xDE, 0xBE, 1, 4}));
}

TEST(BusRecord, KeepsEveryField) {
  const auto control = ThereAndBack(
      bus_record::UsbControl{1, true, {2, 3, 400}, nanoseconds(-5), UsbFailure{UsbStatus::kStall, "x"}, Bytes({1, 9})});
  EXPECT_EQ(control.port, 1);
  EXPECT_TRUE(control.in);
  EXPECT_EQ(control.request.index, 400);
  EXPECT_EQ(control.took, nanoseconds(-5));
  EXPECT_EQ(control.failure->detail, "x");
  EXPECT_EQ(control.data, Bytes({1, 9}));
  const auto ended = ThereAndBack(bus_record::UsbEnded{200, UsbStatus::kTimedOut, nanoseconds(5), Bytes({7})});
  EXPECT_EQ(ended.host_time, nanoseconds(5));
  EXPECT_EQ(ended.status, UsbStatus::kTimedOut);
  CanFrame frame;
  frame.id = 0x1FFF'FFFF;
  frame.extended = true;
  frame.size = 3;
  frame.data[2] = std::byte{9};
  const auto received = ThereAndBack(bus_record::CanReceived{4, {kTime, frame}});
  EXPECT_EQ(std::get<CanFrame>(received.reception.what), frame);
  const auto call = ThereAndBack(bus_record::StopCalled{{nanoseconds(3), "late"}, {1, 2, 3, 4, 5, 6}});
  EXPECT_EQ(call.end.error, "late");
  EXPECT_EQ(call.counters.rejected_bytes, 5U);
  const auto exchanged = ThereAndBack(bus_record::ModbusExchanged{
      {ModbusFunction::kWriteReadRegisters, 1, {2, 3}, 0x100, 4}, nanoseconds(8), {}, {9, 10, 11, 12}});
  EXPECT_EQ(exchanged.request.read_address, 0x100);
  EXPECT_EQ(exchanged.registers, (std::vector<std::uint16_t>{9, 10, 11, 12}));
}

TEST(BusRecord, NeverReadsBeyondBytesThatAreCut) {
  for (const Any& record : OneOfEach()) {
    const RawRecord whole = EncodeBusRecord(record, kTime);
    for (std::size_t size = 0; size < whole.bytes.size(); ++size) {
      RawRecord cut = whole;
      cut.bytes.resize(size);
      const auto decoded = DecodeBusRecord(cut);
      ASSERT_FALSE(decoded) << record.index() << " of " << size;
      EXPECT_THAT(decoded.error().Text(), HasSubstr("cut short"));
    }
  }
}

TEST(BusRecord, TakesAnyBytes) {
  std::mt19937 random(5);
  int records = 0;
  for (int round = 0; round < 200'000; ++round) {
    RawRecord record{RawChannel::kUsb, nanoseconds(static_cast<std::int64_t>(random())), {}};
    record.bytes.resize(1 + random() % 40);
    for (std::byte& one : record.bytes) one = static_cast<std::byte>(random() & 0xFFU);
    record.bytes[0] = static_cast<std::byte>(random() % 60);
    records += DecodeBusRecord(record) ? 1 : 0;
  }
  EXPECT_GT(records, 0);
}

TEST(BusRecord, SaysThatAKindIsUnknown) {
  const auto decoded = DecodeBusRecord({RawChannel::kCall, kTime, Bytes({99, 1, 2})});
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(std::holds_alternative<bus_record::Unknown>(*decoded));
}

TEST(BusRecord, MayHaveFieldsThatALaterVersionHasAdded) {
  RawRecord record = EncodeBusRecord(bus_record::SweepBegun{3}, kTime);
  record.bytes.push_back(std::byte{1});
  const auto decoded = DecodeBusRecord(record);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(std::get<bus_record::SweepBegun>(*decoded).sweep, 3U);
}

}  // namespace
}  // namespace annulus
