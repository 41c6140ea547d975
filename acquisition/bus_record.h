#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "acquisition/scan_sink.h"
#include "base/result.h"
#include "firmware_iface/axis_reading.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/clock_exchange.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

/// What RawRecords hold: one struct per thing that passes a seam or is asked of a driver. All times are of the host's
/// clock. The bytes are described in docs/formats.md; a record that this program does not know is passed over, one of a
/// newer format is refused.
namespace bus_record {

/// Of the encoding; told by the first record of a recording (RingOpening). A greater number can not be read. Format 2
/// is format 1 with a reference board; a ring without one is written in format 1.
inline constexpr std::uint8_t kFormat = 2;
inline constexpr std::uint8_t kFormatWithoutReference = 1;

// RawChannel::kUsb ----------------------------------------------------------------------------------------------------

/// From now on a port has this number.
struct UsbPortNamed {
  std::uint8_t port = 0;
  UsbIdentity identity;
};
/// A control request and its answer.
struct UsbControl {
  std::uint8_t port = 0;
  bool in = false;  ///< Device to host.
  UsbRequest request;
  std::chrono::nanoseconds took{0};   ///< From the request to RawRecord::time.
  std::optional<UsbFailure> failure;  ///< Nothing: it went well.
  std::vector<std::byte> data;        ///< What came (in) or was sent.
};
/// A bulk transfer that ended; RawRecord::time is when it was collected.
struct UsbEnded {
  std::uint8_t port = 0;
  UsbStatus status = UsbStatus::kCompleted;
  std::chrono::nanoseconds host_time{0};
  std::vector<std::byte> data;
};
/// A call on a port that failed at once.
struct UsbRefused {
  enum class Call : std::uint8_t { kSubmit, kClearHalt };
  std::uint8_t port = 0;
  Call call = Call::kSubmit;
  std::uint64_t number = 0;  ///< Of such calls since a transfer of this port was collected last, 0 first.
  UsbFailure failure;
};

// RawChannel::kCan ----------------------------------------------------------------------------------------------------

/// How an interface is set up, as it was read.
struct CanLinkRead {
  std::uint8_t bus = 0;
  std::optional<CanFailure> failure;
  CanLink link;
};
struct CanReceived {
  std::uint8_t bus = 0;
  CanReception reception;
};
struct CanSent {
  std::uint8_t bus = 0;
  CanFrame frame;
};
/// A call on a bus that failed.
struct CanFailed {
  enum class Call : std::uint8_t { kSend, kReceive, kReopen, kRestart };
  std::uint8_t bus = 0;
  Call call = Call::kSend;
  std::uint64_t number = 0;  ///< kSend: of such calls since something of this bus was received last, 0 first.
  CanFailure failure;
};
/// The number of frames lost by the host's queue has changed.
struct CanOverflows {
  std::uint8_t bus = 0;
  std::uint64_t count = 0;
};

// RawChannel::kModbus -------------------------------------------------------------------------------------------------

/// One register transaction; it ended at RawRecord::time.
struct ModbusExchanged {
  ModbusRequest request;
  std::chrono::nanoseconds took{0};
  std::optional<ModbusFailure> failure;
  std::vector<std::uint16_t> registers;  ///< Read.
};

// RawChannel::kCall ---------------------------------------------------------------------------------------------------

/// The ring is about to be opened.
struct RingOpening {
  std::uint8_t format = kFormatWithoutReference;  ///< OpenTappedRing sets it.
  std::variant<UsbRangeRingOptions, CanRangeRingOptions> options;
  std::uint8_t seams = 0;  ///< USB ports or CAN buses.
};
/// It is open.
struct RingOpened {};
/// The axis is open: where its readings lie in the registers.
struct AxisOpened {
  AxisReadingLayout layout;
};
/// How a call on a device ended: RawRecord::time is when it returned.
struct CallEnd {
  std::chrono::nanoseconds took{0};
  std::string error;  ///< Error::Text(); empty: it went well.
};
struct StartCalled {
  CallEnd end;
  double level_rate_hz = 0.0;
};
struct NextLevelCalled {
  CallEnd end;
  std::chrono::nanoseconds deadline{0};
};
struct ReadClockCalled {
  CallEnd end;
  std::uint8_t board = 0;
  ClockExchange exchange;  ///< The host's times in it count; meaningless after an error.
};
struct StopCalled {
  CallEnd end;
  RingCounters counters;  ///< As they were before the call.
};
struct ReopenCalled {
  CallEnd end;
  std::chrono::nanoseconds deadline{0};
};
/// The axis was asked where it is.
struct PositionCalled {
  CallEnd end;
  bool fresh = false;
  std::chrono::nanoseconds host_before{0};
  std::chrono::nanoseconds host_after{0};
};

/// RunScan begins, with this plan (PlanJson).
struct ScanBegun {
  std::string plan_json;
};
/// Its next sweep begins: levels are collected from here on.
struct SweepBegun {
  std::uint32_t sweep = 0;
};
/// Levels are collected no more.
struct SweepEnded {};
/// The last level that was read goes into the pipeline (`with_level`); what is complete comes out of it.
struct HandedOn {
  bool with_level = false;
};
/// RunScan is over, ring idle, axis disabled.
struct ScanEnded {
  std::uint32_t levels = 0;  ///< Handed to the sink.
  std::string error;         ///< Error::Text(); empty: finished or cancelled.
};

/// A kind that a later version has added.
struct Unknown {};

using Any = std::variant<Unknown, UsbPortNamed, UsbControl, UsbEnded, UsbRefused, CanLinkRead, CanReceived, CanSent,
                         CanFailed, CanOverflows, ModbusExchanged, RingOpening, RingOpened, AxisOpened, StartCalled,
                         NextLevelCalled, ReadClockCalled, StopCalled, ReopenCalled, PositionCalled, ScanBegun,
                         SweepBegun, SweepEnded, HandedOn, ScanEnded>;

}  // namespace bus_record

/// As bytes. `time`: when it was over.
[[nodiscard]] RawRecord EncodeBusRecord(bus_record::Any record, std::chrono::nanoseconds time);
/// Whatever the bytes are: a record, Unknown, or an Error that says what is wrong with them.
Result<bus_record::Any> DecodeBusRecord(const RawRecord& record);

}  // namespace annulus
