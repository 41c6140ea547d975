#include "station/console/replay_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "acquisition/bus_record.h"
#include "firmware_iface/can_level_codec.h"
#include "firmware_iface/usb_frame_codec.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostFrames = 2000;
constexpr std::size_t kRunUp = 400;  ///< Records before the first that may hold the beginning of its frames.

template <class Bytes>
std::string Hex(const Bytes& bytes, std::size_t count) {
  std::string text;
  for (std::size_t k = 0; k < count; ++k) text += fmt::format("{:02x}", std::to_integer<unsigned>(bytes[k]));
  return text;
}

std::string Hex(const std::vector<std::uint16_t>& registers) {
  std::string text;
  for (const std::uint16_t word : registers) text += fmt::format("{:04x}", word);
  return text;
}

double Milliseconds(std::chrono::nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

std::string LevelText(const LevelFrame& frame) {
  std::string ranges;
  for (const std::uint32_t range : frame.range_um) {
    ranges += ranges.empty() ? "" : ", ";
    ranges += range == kNoReturn ? "-" : fmt::format("{:.3f}", static_cast<double>(range) / 1000.0);
  }
  return fmt::format("level of board {}: SYNC count {}, board clock {:.9f} s, {:.2f} °C{}, ranges in mm: {}",
                     frame.board_serial, frame.sequence, std::chrono::duration<double>(frame.device_time).count(),
                     static_cast<double>(frame.temperature_centi_c) / 100.0,
                     (frame.status & kFrameEmitterFault) != 0 ? ", emitters' power out of its limits" : "", ranges);
}

const char* TransferText(UsbStatus status) {
  constexpr const char* kTexts[]{"completed",   "timed out", "cancelled", "endpoint halted",
                                 "device gone", "overflow",  "no memory", "no access",
                                 "busy",        "error"};
  return kTexts[static_cast<std::size_t>(status)];
}

std::string RequestText(std::uint8_t request) {
  switch (static_cast<BoardRequest>(request)) {
    case BoardRequest::kIdentify:
      return "identify";
    case BoardRequest::kArm:
      return "arm";
    case BoardRequest::kStartSync:
      return "drive SYNC";
    case BoardRequest::kStop:
      return "stop";
    case BoardRequest::kReadClock:
      return "read the clock";
  }
  return fmt::format("request {:02x}h", request);
}

/// What an identifier of CANopen says (CiA 301), and of which node.
std::string CanText(const CanFrame& frame) {
  if (const auto node = LevelNodeOf(frame)) {
    return frame.fd ? fmt::format("level of node {} in one FD frame", *node)
                    : fmt::format("part of a level of node {}", *node);
  }
  const std::uint32_t node = frame.id & 0x7FU;
  switch (frame.id & ~0x7FU) {
    case 0x000:
      return "NMT order";
    case 0x080:
      return node == 0 ? "SYNC" : fmt::format("emergency of node {}", node);
    case 0x100:
      return "time";
    case 0x580:
      return fmt::format("answer of node {} (SDO)", node);
    case 0x600:
      return fmt::format("request to node {} (SDO)", node);
    case 0x700:
      return fmt::format("heartbeat of node {}", node);
    default:
      return fmt::format("frame {:03x}h", frame.id);
  }
}

std::string EndText(const bus_record::CallEnd& end) {
  const std::string took = fmt::format(" (took {:.3f} ms)", Milliseconds(end.took));
  return end.error.empty() ? took : took + ": " + end.error;
}

/// One record as it is shown. Thread-bound.
class FrameWords {
 public:
  /// Empty for what is only passed on.
  Json Of(const bus_record::Any& record) {
    return std::visit([this](const auto& what) { return Words(what); }, record);
  }

 private:
  static Json Row(std::string bus, const char* direction, std::string hex, std::string meaning) {
    return {{"bus", std::move(bus)},
            {"direction", direction},
            {"bytes_hex", std::move(hex)},
            {"meaning", std::move(meaning)}};
  }
  static Json Call(std::string meaning) { return Row("driver", "call", "", std::move(meaning)); }

  Json Words(const bus_record::UsbEnded& ended) {
    std::string meaning;
    for (const LevelFrame& frame : assemblers_[ended.port].Push(ended.data)) {
      meaning += (meaning.empty() ? "" : "; ") + LevelText(frame);
    }
    const std::size_t pending = assemblers_[ended.port].pending_bytes();
    if (pending > 0) meaning += fmt::format("{}{} bytes of a frame that goes on", meaning.empty() ? "" : "; ", pending);
    if (ended.status != UsbStatus::kCompleted) {
      meaning = fmt::format("transfer {}{}{}", TransferText(ended.status), meaning.empty() ? "" : ": ", meaning);
    }
    if (meaning.empty()) meaning = ended.data.empty() ? "nothing came" : "bytes that are no frame";
    return Row(fmt::format("usb{}", ended.port), "in", Hex(ended.data, ended.data.size()), std::move(meaning));
  }
  static Json Words(const bus_record::UsbControl& control) {
    const std::string failed = control.failure ? fmt::format(": {}", TransferText(control.failure->status)) : "";
    return Row(
        fmt::format("usb{}", control.port), control.in ? "in" : "out", Hex(control.data, control.data.size()),
        fmt::format("{} (took {:.3f} ms){}", RequestText(control.request.request), Milliseconds(control.took), failed));
  }
  static Json Words(const bus_record::UsbPortNamed& named) {
    return Row(fmt::format("usb{}", named.port), "in", "", "this is " + DeviceName(named.identity));
  }
  static Json Words(const bus_record::UsbRefused& refused) {
    return Row(fmt::format("usb{}", refused.port), "out", "",
               fmt::format("a call failed at once: {}", TransferText(refused.failure.status)));
  }
  static Json Words(const bus_record::CanReceived& received) {
    const std::string bus = fmt::format("can{}", received.bus);
    if (const auto* const frame = std::get_if<CanFrame>(&received.reception.what)) {
      return Row(bus, "in", Hex(frame->data, frame->size), fmt::format("{:03x}h: {}", frame->id, CanText(*frame)));
    }
    return Row(bus, "in", "", "the controller reports a change of the bus");
  }
  static Json Words(const bus_record::CanSent& sent) {
    return Row(fmt::format("can{}", sent.bus), "out", Hex(sent.frame.data, sent.frame.size),
               fmt::format("{:03x}h: {}", sent.frame.id, CanText(sent.frame)));
  }
  static Json Words(const bus_record::CanFailed& failed) {
    return Row(fmt::format("can{}", failed.bus), "out", "", CanFailureText(failed.failure));
  }
  static Json Words(const bus_record::CanOverflows& overflows) {
    return Row(fmt::format("can{}", overflows.bus), "in", "",
               fmt::format("{} frames lost by the host's queue so far", overflows.count));
  }
  static Json Words(const bus_record::CanLinkRead& link) {
    return Row(fmt::format("can{}", link.bus), "in", "", "set-up of the interface read");
  }
  static Json Words(const bus_record::ModbusExchanged& exchanged) {
    const ModbusRequest& request = exchanged.request;
    std::string meaning;
    if (!request.values.empty()) {
      meaning = fmt::format("{} registers written from {:04x}h on ({})", request.values.size(), request.write_address,
                            Hex(request.values));
    }
    if (request.read_count > 0) {
      meaning += fmt::format("{}{} registers read from {:04x}h on", meaning.empty() ? "" : ", ", request.read_count,
                             request.read_address);
    }
    meaning += fmt::format(" (took {:.3f} ms)", Milliseconds(exchanged.took));
    if (exchanged.failure) meaning += ": " + ModbusFailureText(*exchanged.failure);
    return Row("modbus", request.read_count > 0 ? "in" : "out", Hex(exchanged.registers), std::move(meaning));
  }
  static Json Words(const bus_record::StartCalled& call) {
    return Call(fmt::format("ring: start at {} levels per second", call.level_rate_hz) + EndText(call.end));
  }
  static Json Words(const bus_record::NextLevelCalled& call) { return Call("ring: next level" + EndText(call.end)); }
  static Json Words(const bus_record::ReadClockCalled& call) {
    return Call(fmt::format("ring: clock of board {}", call.board) + EndText(call.end));
  }
  static Json Words(const bus_record::StopCalled& call) { return Call("ring: stop" + EndText(call.end)); }
  static Json Words(const bus_record::ReopenCalled& call) { return Call("ring: open again" + EndText(call.end)); }
  static Json Words(const bus_record::PositionCalled& call) { return Call("axis: where is it" + EndText(call.end)); }
  static Json Words(const bus_record::RingOpening&) { return Call("ring: is being opened"); }
  static Json Words(const bus_record::RingOpened&) { return Call("ring: open"); }
  static Json Words(const bus_record::AxisOpened&) { return Call("axis: open"); }
  static Json Words(const bus_record::ScanBegun&) { return Call("scan begins"); }
  static Json Words(const bus_record::SweepBegun& begun) { return Call(fmt::format("sweep {} begins", begun.sweep)); }
  static Json Words(const bus_record::SweepEnded&) { return Call("sweep ends"); }
  static Json Words(const bus_record::HandedOn& handed) {
    return Call(handed.with_level ? "level handed on" : "rest handed on");
  }
  static Json Words(const bus_record::ScanEnded& ended) {
    return Call(fmt::format("scan over after {} levels", ended.levels) +
                (ended.error.empty() ? "" : ": " + ended.error));
  }
  static Json Words(const bus_record::Unknown&) { return Call("a record of a newer program"); }

  std::map<std::uint8_t, UsbFrameAssembler> assemblers_;
};

}  // namespace

Json FramesJson(std::span<const RawRecord> raw, std::chrono::nanoseconds from, std::chrono::nanoseconds to) {
  const auto before = [](const RawRecord& record, std::chrono::nanoseconds time) { return record.time < time; };
  const auto first = static_cast<std::size_t>(std::lower_bound(raw.begin(), raw.end(), from, before) - raw.begin());
  FrameWords words;
  Json frames = Json::array();
  for (std::size_t k = first > kRunUp ? first - kRunUp : 0; k < raw.size() && frames.size() < kMostFrames; ++k) {
    if (raw[k].time >= to) break;
    const auto record = DecodeBusRecord(raw[k]);
    Json row = record ? words.Of(*record)
                      : Json{{"bus", ""},
                             {"direction", ""},
                             {"bytes_hex", Hex(raw[k].bytes, raw[k].bytes.size())},
                             {"meaning", "cannot be read: " + record.error().seen}};
    if (k < first) continue;
    Json shown{{"time_ns", raw[k].time.count()}};
    shown.update(row);
    frames.push_back(std::move(shown));
  }
  return frames;
}

}  // namespace annulus
