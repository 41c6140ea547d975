#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/axis_register_map.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/register_block.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// A reply that is certainly the one to our request, and the host's clock around it.
struct DriveAnswer {
  RegisterBlock registers;
  std::chrono::nanoseconds host_before{0};
  std::chrono::nanoseconds host_after{0};
};
using DriveReply = tl::expected<DriveAnswer, ModbusFailure>;

/// The error of a transaction that failed, with what to do about it.
[[nodiscard]] tl::unexpected<Error> Unanswered(const std::string& attempted, const ModbusFailure& failure);

/// What we say to a drive and what it answers, such that a late, repeated or foreign reply is never taken for the
/// answer: each transaction (FC23) writes the next counter and reads a block that holds the drive's echo of it. After
/// any failure the dialogue is silent for the quiet time and then throws away what came. It keeps the command block
/// that the drive should have. Thread-bound; borrows link and clock.
class DriveDialogue {
 public:
  DriveDialogue(ModbusLink& link, const AxisRegisterMap& map, Clock& clock, ModbusAxisOptions options);

  /// Reads a block that holds the echo; writes the counter only. One transaction, never repeated.
  DriveReply Read(AxisRegisterMap::Block block);
  /// The same, once more after a failure; up to three times more where the drive says that it is busy.
  DriveReply ReadAgain(AxisRegisterMap::Block block);
  /// Writes the command block with this control word and reads the status block. One transaction, never repeated.
  DriveReply Order(std::uint16_t control);

  /// How long the longest of these transactions takes on the line.
  [[nodiscard]] std::chrono::nanoseconds LongestWireTime() const;

  /// When the last request was sent.
  [[nodiscard]] std::chrono::nanoseconds last_sent() const { return last_sent_; }

  /// Command registers to go out with the next Order.
  void Set(std::uint16_t address, std::uint16_t value);
  void SetLong(std::uint16_t address, std::uint32_t value);
  /// All command registers 0: nothing of an earlier order goes out again.
  void ClearCommand();

  /// Closes the link at once. Everything fails until Reopen.
  void Close();
  tl::expected<void, ModbusFailure> Reopen();

 private:
  DriveReply Exchange(std::uint16_t address, std::vector<std::uint16_t> values, AxisRegisterMap::Block read);

  ModbusLink& link_;
  AxisRegisterMap map_;
  AxisRegisterMap::Block command_block_;
  AxisRegisterMap::Block status_block_;
  Clock& clock_;
  ModbusAxisOptions options_;
  std::vector<std::uint16_t> command_;  ///< What the drive's command block should hold; [counter] is set per exchange.
  std::uint16_t counter_;
  bool quiet_ = false;  ///< An error happened; input is to be thrown away when quiet_until_ is over.
  std::chrono::nanoseconds quiet_until_{0};
  std::chrono::nanoseconds last_sent_{0};
};

}  // namespace annulus
