#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/bus_record.h"
#include "acquisition/bus_tap.h"
#include "base/clock.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/usb_host.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

// Seams that pass everything on and tell a tap what passed. They borrow the tap and the clock, which must be that of
// the devices, and are as thread-bound as what they wrap.

/// A board's port.
class TappedUsbPort final : public UsbPort {
 public:
  /// `number`: of this port in the records. Borrows the port.
  TappedUsbPort(UsbPort& port, std::uint8_t number, BusTap& tap, Clock& clock);
  TappedUsbPort(std::unique_ptr<UsbPort> port, std::uint8_t number, BusTap& tap, Clock& clock);

  [[nodiscard]] const UsbIdentity& identity() const override { return port_.identity(); }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length,
                                              std::chrono::nanoseconds timeout) override;
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data,
                             std::chrono::nanoseconds timeout) override;
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override;
  void Cancel(UsbToken token) override { port_.Cancel(token); }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override;
  std::optional<UsbCompletion> WaitCompletion(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::size_t in_flight() const override { return port_.in_flight(); }

 private:
  void Tell(bus_record::Any record) { tap_.Record(EncodeBusRecord(std::move(record), clock_.Now())); }

  std::unique_ptr<UsbPort> owned_;
  UsbPort& port_;
  std::uint8_t number_;
  BusTap& tap_;
  Clock& clock_;
  std::uint64_t submits_ = 0;  ///< Since a transfer was collected.
  std::uint64_t clears_ = 0;   ///< Likewise.
};

/// A tapped port for each of `ports`, in their order. Borrows the ports.
[[nodiscard]] std::vector<std::unique_ptr<UsbPort>> TapUsbPorts(const std::vector<UsbPort*>& ports, BusTap& tap,
                                                                Clock& clock);

/// A host whose ports are tapped; a board that is opened again keeps its number. Borrows the host.
class TappedUsbHost final : public UsbHost {
 public:
  TappedUsbHost(UsbHost& host, BusTap& tap, Clock& clock) : host_(host), tap_(tap), clock_(clock) {}

  UsbResult<std::vector<UsbIdentity>> List() override { return host_.List(); }
  UsbResult<std::unique_ptr<UsbPort>> Open(const UsbIdentity& identity) override;
  std::optional<UsbHotplug> WaitHotplug(std::chrono::nanoseconds deadline) override {
    return host_.WaitHotplug(deadline);
  }
  [[nodiscard]] std::uint64_t transfer_memory() const override { return host_.transfer_memory(); }

 private:
  UsbHost& host_;
  BusTap& tap_;
  Clock& clock_;
  std::map<std::string, std::uint8_t> numbers_;  ///< By serial number, or by place where there is none.
};

/// A CAN bus.
class TappedCanBus final : public CanBus {
 public:
  /// Borrows the bus.
  TappedCanBus(CanBus& bus, std::uint8_t number, BusTap& tap, Clock& clock)
      : bus_(bus), number_(number), tap_(tap), clock_(clock) {}

  CanResult<CanLink> ReadLink() override;
  CanResult<void> Send(const CanFrame& frame) override;
  CanResult<std::optional<CanReception>> Receive(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::uint64_t overflows() const override;
  CanResult<void> Reopen() override;
  CanResult<void> Restart() override;

 private:
  void Tell(bus_record::Any record) const { tap_.Record(EncodeBusRecord(std::move(record), clock_.Now())); }
  CanResult<void> TellFailure(bus_record::CanFailed::Call call, std::uint64_t call_number, CanResult<void> result);

  CanBus& bus_;
  std::uint8_t number_;
  BusTap& tap_;
  Clock& clock_;
  std::uint64_t sends_ = 0;  ///< Since something was received.
  mutable std::uint64_t overflows_told_ = 0;
};

/// A tapped bus for each of `buses`, in their order. Borrows the buses.
[[nodiscard]] std::vector<std::unique_ptr<CanBus>> TapCanBuses(const std::vector<CanBus*>& buses, BusTap& tap,
                                                               Clock& clock);

/// The link to the axis drive.
class TappedModbusLink final : public ModbusLink {
 public:
  /// Borrows the link.
  TappedModbusLink(ModbusLink& link, BusTap& tap, Clock& clock) : link_(link), tap_(tap), clock_(clock) {}

  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override;
  [[nodiscard]] std::chrono::nanoseconds WireTime(const ModbusRequest& request) const override {
    return link_.WireTime(request);
  }
  void DiscardInput() override { link_.DiscardInput(); }
  void Close() override { link_.Close(); }
  tl::expected<void, ModbusFailure> Reopen() override { return link_.Reopen(); }

 private:
  ModbusLink& link_;
  BusTap& tap_;
  Clock& clock_;
};

}  // namespace annulus
