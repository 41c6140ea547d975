#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "firmware_iface/modbus_link.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// Stands in front of the drive, behind everything that can go wrong: gives each exchange a position of its own and
/// keeps what the drive really answered to the exchange with which counter. Register addresses of
/// docs/wire_protocol.md.
class DriveSpy final : public ModbusLink {
 public:
  struct Truth {
    std::int32_t position_um = 0;
    std::uint32_t drive_time_us = 0;
  };

  explicit DriveSpy(ModbusLink& drive) : drive_(drive) {}

  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override {
    ModbusReply reply = drive_.Transact(request, timeout);
    const bool polls = request.function == ModbusFunction::kWriteReadRegisters && request.write_address == 0x0000 &&
                       request.read_address == 0x0100 && request.read_count == 8;
    if (!polls || !reply) return reply;
    const auto position = static_cast<std::uint32_t>(engine_());
    (*reply)[3] = static_cast<std::uint16_t>(position >> 16);
    (*reply)[4] = static_cast<std::uint16_t>(position);
    truth_[request.values[0]] = {static_cast<std::int32_t>(position),
                                 static_cast<std::uint32_t>((*reply)[5]) << 16 | (*reply)[6]};
    return reply;
  }
  void DiscardInput() override { drive_.DiscardInput(); }
  void Close() override { drive_.Close(); }
  tl::expected<void, ModbusFailure> Reopen() override { return drive_.Reopen(); }

  /// Of the last exchange with this counter that reached the drive.
  [[nodiscard]] std::optional<Truth> Of(std::uint16_t counter) const {
    const auto found = truth_.find(counter);
    return found == truth_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  ModbusLink& drive_;
  std::mt19937 engine_{4711};
  std::map<std::uint16_t, Truth> truth_;
};

/// Stands between axis and link: knows the counter of the last request, and counts replies that came without an error
/// though they answer another one.
class HostSpy final : public ModbusLink {
 public:
  explicit HostSpy(ModbusLink& link) : link_(link) {}

  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override {
    ++exchanges;
    counter = request.values.at(0);
    ModbusReply reply = link_.Transact(request, timeout);
    if (reply && (reply->empty() || (*reply)[0] != counter)) ++foreign;
    return reply;
  }
  void DiscardInput() override { link_.DiscardInput(); }
  void Close() override { link_.Close(); }
  tl::expected<void, ModbusFailure> Reopen() override { return link_.Reopen(); }

  int exchanges = 0;
  int foreign = 0;  ///< Successes of the link that are wrong: what a master without an echo would believe.
  std::uint16_t counter = 0;

 private:
  ModbusLink& link_;
};

/// Whether a fresh reading is what the drive had in that exchange.
inline bool IsTrue(const AxisPosition& position, const std::optional<DriveSpy::Truth>& truth) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(position.time.device_time).count();
  return truth && position.z.value() == truth->position_um / 1000.0 &&
         static_cast<std::uint32_t>(us & 0xFFFFFFFF) == truth->drive_time_us;
}

}  // namespace annulus
