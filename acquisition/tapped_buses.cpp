#include "acquisition/tapped_buses.h"

#include <limits>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Ports and buses have numbers of one byte.
constexpr std::size_t kMostSeams = std::numeric_limits<std::uint8_t>::max();

template <class Failure, class T>
std::optional<Failure> FailureOf(const tl::expected<T, Failure>& result) {
  return result ? std::nullopt : std::optional<Failure>(result.error());
}

}  // namespace

TappedUsbPort::TappedUsbPort(UsbPort& port, std::uint8_t number, BusTap& tap, Clock& clock)
    : port_(port), number_(number), tap_(tap), clock_(clock) {
  Tell(bus_record::UsbPortNamed{number_, port_.identity()});
}

TappedUsbPort::TappedUsbPort(std::unique_ptr<UsbPort> port, std::uint8_t number, BusTap& tap, Clock& clock)
    : owned_(std::move(port)), port_(*owned_), number_(number), tap_(tap), clock_(clock) {
  Tell(bus_record::UsbPortNamed{number_, port_.identity()});
}

UsbResult<std::vector<std::byte>> TappedUsbPort::ControlIn(UsbRequest request, std::size_t length,
                                                           nanoseconds timeout) {
  const nanoseconds begin = clock_.Now();
  auto reply = port_.ControlIn(request, length, timeout);
  Tell(bus_record::UsbControl{number_, true, request, clock_.Now() - begin, FailureOf(reply),
                              reply ? *reply : std::vector<std::byte>()});
  return reply;
}

UsbResult<void> TappedUsbPort::ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) {
  const nanoseconds begin = clock_.Now();
  auto done = port_.ControlOut(request, data, timeout);
  Tell(bus_record::UsbControl{
      number_, false, request, clock_.Now() - begin, FailureOf(done), {data.begin(), data.end()}});
  return done;
}

UsbResult<UsbToken> TappedUsbPort::SubmitBulkIn(std::uint8_t endpoint, std::size_t length) {
  auto token = port_.SubmitBulkIn(endpoint, length);
  if (!token) {
    Tell(bus_record::UsbRefused{number_, bus_record::UsbRefused::Call::kSubmit, submits_, token.error()});
  }
  ++submits_;
  return token;
}

UsbResult<void> TappedUsbPort::ClearHalt(std::uint8_t endpoint) {
  auto cleared = port_.ClearHalt(endpoint);
  if (!cleared) {
    Tell(bus_record::UsbRefused{number_, bus_record::UsbRefused::Call::kClearHalt, clears_, cleared.error()});
  }
  ++clears_;
  return cleared;
}

std::optional<UsbCompletion> TappedUsbPort::WaitCompletion(nanoseconds deadline) {
  auto completion = port_.WaitCompletion(deadline);
  if (!completion) return completion;
  Tell(bus_record::UsbEnded{number_, completion->status, completion->host_time, completion->data});
  submits_ = clears_ = 0;
  return completion;
}

std::vector<std::unique_ptr<UsbPort>> TapUsbPorts(const std::vector<UsbPort*>& ports, BusTap& tap, Clock& clock) {
  ENSURE(ports.size() <= kMostSeams, "ports have numbers of one byte");
  std::vector<std::unique_ptr<UsbPort>> tapped;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    tapped.push_back(std::make_unique<TappedUsbPort>(*ports[i], static_cast<std::uint8_t>(i), tap, clock));
  }
  return tapped;
}

UsbResult<std::unique_ptr<UsbPort>> TappedUsbHost::Open(const UsbIdentity& identity) {
  auto port = host_.Open(identity);
  if (!port) return port;
  const UsbIdentity& opened = (*port)->identity();
  const std::string name = opened.serial.empty() ? "at " + opened.port_path : opened.serial;
  if (numbers_.count(name) == 0 && numbers_.size() == kMostSeams) return port;  // more than any ring has
  const auto number = numbers_.emplace(name, static_cast<std::uint8_t>(numbers_.size())).first->second;
  return std::make_unique<TappedUsbPort>(std::move(*port), number, tap_, clock_);
}

CanResult<CanLink> TappedCanBus::ReadLink() {
  auto link = bus_.ReadLink();
  Tell(bus_record::CanLinkRead{number_, FailureOf(link), link ? *link : CanLink()});
  return link;
}

CanResult<void> TappedCanBus::TellFailure(bus_record::CanFailed::Call call, std::uint64_t call_number,
                                          CanResult<void> result) {
  if (!result) Tell(bus_record::CanFailed{number_, call, call_number, result.error()});
  return result;
}

CanResult<void> TappedCanBus::Send(const CanFrame& frame) {
  auto sent = bus_.Send(frame);
  if (sent) Tell(bus_record::CanSent{number_, frame});
  return TellFailure(bus_record::CanFailed::Call::kSend, sends_++, std::move(sent));
}

CanResult<std::optional<CanReception>> TappedCanBus::Receive(nanoseconds deadline) {
  auto received = bus_.Receive(deadline);
  if (!received) {
    Tell(bus_record::CanFailed{number_, bus_record::CanFailed::Call::kReceive, 0, received.error()});
  } else if (*received) {
    Tell(bus_record::CanReceived{number_, **received});
    sends_ = 0;
  }
  return received;
}

std::uint64_t TappedCanBus::overflows() const {
  const std::uint64_t count = bus_.overflows();
  if (count != overflows_told_) Tell(bus_record::CanOverflows{number_, count});
  overflows_told_ = count;
  return count;
}

CanResult<void> TappedCanBus::Reopen() { return TellFailure(bus_record::CanFailed::Call::kReopen, 0, bus_.Reopen()); }

CanResult<void> TappedCanBus::Restart() {
  return TellFailure(bus_record::CanFailed::Call::kRestart, 0, bus_.Restart());
}

std::vector<std::unique_ptr<CanBus>> TapCanBuses(const std::vector<CanBus*>& buses, BusTap& tap, Clock& clock) {
  ENSURE(buses.size() <= kMostSeams, "buses have numbers of one byte");
  std::vector<std::unique_ptr<CanBus>> tapped;
  for (std::size_t i = 0; i < buses.size(); ++i) {
    tapped.push_back(std::make_unique<TappedCanBus>(*buses[i], static_cast<std::uint8_t>(i), tap, clock));
  }
  return tapped;
}

ModbusReply TappedModbusLink::Transact(const ModbusRequest& request, nanoseconds timeout) {
  const nanoseconds begin = clock_.Now();
  ModbusReply reply = link_.Transact(request, timeout);
  const nanoseconds end = clock_.Now();
  tap_.Record(EncodeBusRecord(bus_record::ModbusExchanged{request, end - begin, FailureOf(reply),
                                                          reply ? *reply : std::vector<std::uint16_t>()},
                              end));
  return reply;
}

}  // namespace annulus
