#include "acquisition/bus_record.h"

#include <utility>

#include "acquisition/record_bytes.h"

namespace annulus {
namespace {

using namespace bus_record;  // NOLINT(google-build-using-namespace): this file describes all of it

// The fields of each record, in the order of the bytes. `Codec` is a RecordWriter or a RecordReader.

template <class Codec>
void Describe(Codec& codec, UsbIdentity& identity) {
  codec.Number(identity.vendor_id);
  codec.Number(identity.product_id);
  codec.Text(identity.serial);
  codec.Text(identity.port_path);
}

template <class Codec>
void Describe(Codec& codec, UsbFailure& failure) {
  codec.Choice(failure.status, UsbStatus::kError);
  codec.Text(failure.detail);
}

template <class Codec>
void Describe(Codec& codec, CanFailure& failure) {
  codec.Choice(failure.fault, CanFault::kError);
  codec.Text(failure.detail);
}

template <class Codec>
void Describe(Codec& codec, ModbusFailure& failure) {
  codec.Choice(failure.fault, ModbusFault::kBadReply);
  codec.Number(failure.exception_code);
  codec.Text(failure.detail);
}

template <class Codec, class Value, class DescribeValue>
void Optional(Codec& codec, std::optional<Value>& value, DescribeValue describe) {
  bool there = value.has_value();
  codec.Flag(there);
  if (!there) return value.reset();
  if (!value) value.emplace();
  describe(*value);
}

template <class Codec, class Failure>
void OptionalFailure(Codec& codec, std::optional<Failure>& failure) {
  Optional(codec, failure, [&](Failure& one) { Describe(codec, one); });
}

template <class Codec>
void Describe(Codec& codec, UsbPortNamed& record) {
  codec.Number(record.port);
  Describe(codec, record.identity);
}

template <class Codec>
void Describe(Codec& codec, UsbControl& record) {
  codec.Number(record.port);
  codec.Flag(record.in);
  codec.Number(record.request.request);
  codec.Number(record.request.value);
  codec.Number(record.request.index);
  codec.Span(record.took);
  OptionalFailure(codec, record.failure);
  codec.Bytes(record.data);
}

template <class Codec>
void Describe(Codec& codec, UsbEnded& record) {
  codec.Number(record.port);
  codec.Choice(record.status, UsbStatus::kError);
  codec.Time(record.host_time);
  codec.Bytes(record.data);
}

template <class Codec>
void Describe(Codec& codec, UsbRefused& record) {
  codec.Number(record.port);
  codec.Choice(record.call, UsbRefused::Call::kClearHalt);
  codec.Number(record.number);
  Describe(codec, record.failure);
}

template <class Codec>
void Describe(Codec& codec, CanLinkRead& record) {
  codec.Number(record.bus);
  OptionalFailure(codec, record.failure);
  if (record.failure) return;
  const auto number = [&](std::uint32_t& value) { codec.Number(value); };
  codec.Text(record.link.name);
  codec.Choice(record.link.state, CanState::kDown);
  codec.Flag(record.link.fd);
  Optional(codec, record.link.bit_rate, number);
  Optional(codec, record.link.data_bit_rate, number);
  Optional(codec, record.link.restart_ms, number);
  codec.Number(record.link.queue_length);
}

template <class Codec>
void Describe(Codec& codec, CanFrame& frame) {
  codec.Number(frame.id);
  codec.Flag(frame.extended);
  codec.Flag(frame.remote);
  codec.Flag(frame.fd);
  codec.Flag(frame.bit_rate_switch);
  codec.Number(frame.size);
  // A remote frame has a size but no data; a size beyond the frame's room can only come from spoiled bytes.
  codec.Raw(std::span(frame.data).first(std::min<std::size_t>(frame.size, frame.data.size())));
}

template <class Codec>
void Describe(Codec& codec, CanReport& report) {
  Optional(codec, report.state, [&](CanState& state) { codec.Choice(state, CanState::kDown); });
  codec.Flag(report.restarted);
  codec.Flag(report.receive_overflow);
  codec.Flag(report.transmit_overflow);
  codec.Flag(report.no_acknowledge);
  codec.Flag(report.protocol_error);
  codec.Flag(report.lost_arbitration);
  codec.Number(report.transmit_errors);
  codec.Number(report.receive_errors);
}

template <class Codec>
void Describe(Codec& codec, CanReceived& record) {
  codec.Number(record.bus);
  codec.Time(record.reception.host_time);
  bool is_report = std::holds_alternative<CanReport>(record.reception.what);
  codec.Flag(is_report);
  if (is_report != std::holds_alternative<CanReport>(record.reception.what)) record.reception.what = CanReport();
  std::visit([&](auto& what) { Describe(codec, what); }, record.reception.what);
}

template <class Codec>
void Describe(Codec& codec, CanSent& record) {
  codec.Number(record.bus);
  Describe(codec, record.frame);
}

template <class Codec>
void Describe(Codec& codec, CanFailed& record) {
  codec.Number(record.bus);
  codec.Choice(record.call, CanFailed::Call::kRestart);
  codec.Number(record.number);
  Describe(codec, record.failure);
}

template <class Codec>
void Describe(Codec& codec, CanOverflows& record) {
  codec.Number(record.bus);
  codec.Number(record.count);
}

template <class Codec>
void Registers(Codec& codec, std::vector<std::uint16_t>& registers) {
  codec.Count(registers);
  for (std::uint16_t& one : registers) codec.Number(one);
}

template <class Codec>
void Describe(Codec& codec, ModbusExchanged& record) {
  codec.Choice(record.request.function, ModbusFunction::kWriteReadRegisters);
  codec.Number(record.request.write_address);
  Registers(codec, record.request.values);
  codec.Number(record.request.read_address);
  codec.Number(record.request.read_count);
  codec.Span(record.took);
  OptionalFailure(codec, record.failure);
  Registers(codec, record.registers);
}

template <class Codec>
void Describe(Codec& codec, std::map<std::uint32_t, std::uint16_t>& first_sensors) {
  std::vector<std::pair<std::uint32_t, std::uint16_t>> pairs(first_sensors.begin(), first_sensors.end());
  codec.Count(pairs);
  for (auto& [serial, first] : pairs) {
    codec.Number(serial);
    codec.Number(first);
  }
  first_sensors = {pairs.begin(), pairs.end()};
}

template <class Codec>
void Describe(Codec& codec, std::size_t& count) {
  std::uint64_t number = count;
  codec.Number(number);
  count = static_cast<std::size_t>(number);
}

template <class Codec>
void Describe(Codec& codec, ReferenceBoardOptions& reference) {
  codec.Number(reference.serial);
  codec.Count(reference.channels);
  for (std::uint8_t& channel : reference.channels) codec.Number(channel);
}

template <class Codec>
void Describe(Codec& codec, UsbRangeRingOptions& options) {
  codec.Number(options.sensor_count);
  Describe(codec, options.first_sensors);
  codec.Span(options.control_timeout);
  Describe(codec, options.transfers_per_board);
}

template <class Codec>
void Describe(Codec& codec, CanRangeRingOptions& options) {
  codec.Number(options.sensor_count);
  Describe(codec, options.first_sensors);
  Describe(codec, options.board_count);
  codec.Span(options.boot_deadline);
  codec.Span(options.heartbeat);
  codec.Span(options.sdo_timeout);
}

template <class Codec>
void Describe(Codec& codec, RingOpening& record) {
  codec.Number(record.format);
  if (record.format > kFormat) return;  // what follows is not known
  codec.Number(record.seams);
  bool can = std::holds_alternative<CanRangeRingOptions>(record.options);
  codec.Flag(can);
  if (can != std::holds_alternative<CanRangeRingOptions>(record.options)) record.options = CanRangeRingOptions();
  std::visit([&](auto& options) { Describe(codec, options); }, record.options);
  if (record.format == kFormatWithoutReference) return;
  std::visit(
      [&](auto& options) {
        Optional(codec, options.reference, [&](ReferenceBoardOptions& reference) { Describe(codec, reference); });
      },
      record.options);
}

template <class Codec>
void Describe(Codec& codec, AxisOpened& record) {
  codec.Number(record.layout.position);
  codec.Number(record.layout.drive_time);
  codec.Choice(record.layout.word_order, WordOrder::kLowFirst);
  codec.Real(record.layout.units_per_mm);
}

template <class Codec>
void Describe(Codec& codec, CallEnd& end) {
  codec.Span(end.took);
  codec.Text(end.error);
}

template <class Codec>
void Describe(Codec& codec, StartCalled& record) {
  Describe(codec, record.end);
  codec.Real(record.level_rate_hz);
}

template <class Codec>
void Describe(Codec& codec, NextLevelCalled& record) {
  Describe(codec, record.end);
  codec.Time(record.deadline);
}

template <class Codec>
void Describe(Codec& codec, ReadClockCalled& record) {
  Describe(codec, record.end);
  codec.Number(record.board);
  if (!record.end.error.empty()) return;
  codec.Time(record.exchange.host_before);
  codec.Span(record.exchange.device_time);
  codec.Time(record.exchange.host_after);
}

template <class Codec>
void Describe(Codec& codec, StopCalled& record) {
  Describe(codec, record.end);
  codec.Number(record.counters.levels);
  codec.Number(record.counters.lost_frames);
  codec.Number(record.counters.duplicate_frames);
  codec.Number(record.counters.rejected_frames);
  codec.Number(record.counters.rejected_bytes);
  codec.Number(record.counters.overflowed_frames);
}

template <class Codec>
void Describe(Codec& codec, ReopenCalled& record) {
  Describe(codec, record.end);
  codec.Time(record.deadline);
}

template <class Codec>
void Describe(Codec& codec, PositionCalled& record) {
  Describe(codec, record.end);
  codec.Flag(record.fresh);
  if (!record.fresh) return;
  codec.Time(record.host_before);
  codec.Time(record.host_after);
}

template <class Codec>
void Describe(Codec& codec, ScanBegun& record) {
  codec.Text(record.plan_json);
}

template <class Codec>
void Describe(Codec& codec, SweepBegun& record) {
  codec.Number(record.sweep);
}

template <class Codec>
void Describe(Codec& codec, HandedOn& record) {
  codec.Flag(record.with_level);
}

template <class Codec>
void Describe(Codec& codec, ScanEnded& record) {
  codec.Number(record.levels);
  codec.Text(record.error);
}

// Without fields.
template <class Codec>
void Describe(Codec&, Unknown&) {}
template <class Codec>
void Describe(Codec&, RingOpened&) {}
template <class Codec>
void Describe(Codec&, SweepEnded&) {}

/// The first byte of a record: what it is. Numbers are never used again for something else.
template <class Record>
constexpr std::uint8_t kKind = 0;
template <>
constexpr std::uint8_t kKind<UsbPortNamed> = 1;
template <>
constexpr std::uint8_t kKind<UsbControl> = 2;
template <>
constexpr std::uint8_t kKind<UsbEnded> = 3;
template <>
constexpr std::uint8_t kKind<UsbRefused> = 4;
template <>
constexpr std::uint8_t kKind<CanLinkRead> = 10;
template <>
constexpr std::uint8_t kKind<CanReceived> = 11;
template <>
constexpr std::uint8_t kKind<CanSent> = 12;
template <>
constexpr std::uint8_t kKind<CanFailed> = 13;
template <>
constexpr std::uint8_t kKind<CanOverflows> = 14;
template <>
constexpr std::uint8_t kKind<ModbusExchanged> = 20;
template <>
constexpr std::uint8_t kKind<RingOpening> = 30;
template <>
constexpr std::uint8_t kKind<RingOpened> = 31;
template <>
constexpr std::uint8_t kKind<AxisOpened> = 32;
template <>
constexpr std::uint8_t kKind<StartCalled> = 40;
template <>
constexpr std::uint8_t kKind<NextLevelCalled> = 41;
template <>
constexpr std::uint8_t kKind<ReadClockCalled> = 42;
template <>
constexpr std::uint8_t kKind<StopCalled> = 43;
template <>
constexpr std::uint8_t kKind<ReopenCalled> = 44;
template <>
constexpr std::uint8_t kKind<PositionCalled> = 45;
template <>
constexpr std::uint8_t kKind<ScanBegun> = 50;
template <>
constexpr std::uint8_t kKind<SweepBegun> = 51;
template <>
constexpr std::uint8_t kKind<SweepEnded> = 52;
template <>
constexpr std::uint8_t kKind<HandedOn> = 53;
template <>
constexpr std::uint8_t kKind<ScanEnded> = 54;

RawChannel ChannelOf(std::uint8_t kind) {
  if (kind < kKind<CanLinkRead>) return RawChannel::kUsb;
  if (kind < kKind<ModbusExchanged>) return RawChannel::kCan;
  return kind < kKind<RingOpening> ? RawChannel::kModbus : RawChannel::kCall;
}

/// Tries the kinds one after the other, beginning with alternative I.
template <std::size_t I = 1>
Any Read(std::uint8_t kind, RecordReader& reader) {
  if constexpr (I < std::variant_size_v<Any>) {
    using Record = std::variant_alternative_t<I, Any>;
    if (kind != kKind<Record>) return Read<I + 1>(kind, reader);
    Record record;
    Describe(reader, record);
    return record;
  } else {
    return Unknown{};
  }
}

}  // namespace

RawRecord EncodeBusRecord(Any record, std::chrono::nanoseconds time) {
  return std::visit(
      [&](auto& one) {
        RecordWriter writer(time);
        constexpr std::uint8_t kind = kKind<std::remove_reference_t<decltype(one)>>;
        writer.Number(kind);
        Describe(writer, one);
        return RawRecord{ChannelOf(kind), time, writer.Take()};
      },
      record);
}

Result<Any> DecodeBusRecord(const RawRecord& record) {
  RecordReader reader(record.bytes, record.time);
  std::uint8_t kind = 0;
  reader.Number(kind);
  Any decoded = Read(kind, reader);
  if (const auto* opening = std::get_if<RingOpening>(&decoded); opening != nullptr && opening->format > kFormat) {
    return Fail("read the raw bytes of a recording",
                "they are of format " + std::to_string(opening->format) + ", this program reads up to " +
                    std::to_string(kFormat),
                "use the version of the program that made the recording, or a later one");
  }
  if (reader.ok()) return decoded;
  return Fail("read the raw bytes of a recording",
              "a record of kind " + std::to_string(kind) + " with " + std::to_string(record.bytes.size()) +
                  " bytes is cut short or holds an impossible value",
              "use 'annulus inspect' to see what is sound of the recording");
}

}  // namespace annulus
