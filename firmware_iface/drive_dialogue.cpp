#include "firmware_iface/drive_dialogue.h"

#include <algorithm>
#include <utility>

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr int kBusyAttempts = 3;  ///< More, after the first.
constexpr std::uint8_t kBusy = 6;

bool IsBusy(const ModbusFailure& failure) {
  return failure.fault == ModbusFault::kException && failure.exception_code == kBusy;
}

/// What to do about a failed transaction.
const char* Advice(const ModbusFailure& failure) {
  if (failure.fault == ModbusFault::kLinkLost) return "check the cable, then open the axis anew and home it";
  if (failure.fault != ModbusFault::kException) return "check the drive's supply and cable, then home the axis again";
  if (failure.exception_code == 6) return "wait until the drive is ready, then try again";
  if (failure.exception_code == 4) return "look at the drive's own display for the cause";
  return "compare [axis] register_map with the drive's manual";
}

ModbusFailure Unfitting(std::string detail) { return {ModbusFault::kBadReply, 0, std::move(detail)}; }

}  // namespace

tl::unexpected<Error> Unanswered(const std::string& attempted, const ModbusFailure& failure) {
  return Fail(attempted, ModbusFailureText(failure), Advice(failure));
}

DriveDialogue::DriveDialogue(ModbusLink& link, const AxisRegisterMap& map, Clock& clock, ModbusAxisOptions options)
    : link_(link),
      map_(map),
      command_block_(map.CommandBlock()),
      status_block_(map.StatusBlock()),
      clock_(clock),
      options_(options),
      command_(command_block_.count, 0),
      // Not always from 0: a reply to a program that ran a moment ago must not fit by chance.
      counter_(static_cast<std::uint16_t>(std::chrono::duration_cast<std::chrono::milliseconds>(clock.Now()).count())) {
}

DriveReply DriveDialogue::Exchange(std::uint16_t address, std::vector<std::uint16_t> values,
                                   AxisRegisterMap::Block read) {
  if (quiet_) {
    clock_.SleepUntil(quiet_until_);
    link_.DiscardInput();
    quiet_ = false;
  }
  ++counter_;
  values.at(map_.counter - address) = counter_;
  const nanoseconds before = last_sent_ = clock_.Now();
  ModbusReply reply =
      link_.Transact({ModbusFunction::kWriteReadRegisters, address, std::move(values), read.address, read.count},
                     options_.reply_timeout);
  const nanoseconds after = clock_.Now();

  ModbusFailure failure;
  if (!reply) {
    failure = std::move(reply.error());
  } else if (reply->size() != read.count) {
    failure = Unfitting(std::to_string(reply->size()) + " registers instead of " + std::to_string(read.count));
  } else if (const std::uint16_t echo = (*reply)[map_.echo - read.address]; echo != counter_) {
    failure = Unfitting("a reply to transaction " + std::to_string(echo) + " instead of " + std::to_string(counter_));
  } else {
    return DriveAnswer{RegisterBlock(read.address, map_.word_order, std::move(*reply)), before, after};
  }
  quiet_ = true;
  quiet_until_ = clock_.Now() + options_.quiet_time;
  return tl::unexpected<ModbusFailure>(std::move(failure));
}

DriveReply DriveDialogue::Read(AxisRegisterMap::Block block) {
  return Exchange(map_.counter, std::vector<std::uint16_t>(map_.counter_registers, 0), block);
}

DriveReply DriveDialogue::ReadAgain(AxisRegisterMap::Block block) {
  DriveReply reply = Read(block);
  for (int again = 0; !reply; ++again) {
    if (reply.error().fault == ModbusFault::kLinkLost) break;
    if (again >= (IsBusy(reply.error()) ? kBusyAttempts : 1)) break;
    reply = Read(block);
  }
  return reply;
}

DriveReply DriveDialogue::Order(std::uint16_t control) {
  Set(map_.control_word, control);
  return Exchange(command_block_.address, command_, status_block_);
}

nanoseconds DriveDialogue::LongestWireTime() const {
  const auto wire_time = [this](AxisRegisterMap::Block write, AxisRegisterMap::Block read) {
    return link_.WireTime({ModbusFunction::kWriteReadRegisters, write.address,
                           std::vector<std::uint16_t>(write.count, 0), read.address, read.count});
  };
  const AxisRegisterMap::Block counter{map_.counter, map_.counter_registers};
  return std::max(wire_time(command_block_, status_block_), wire_time(counter, map_.IdentityBlock()));
}

void DriveDialogue::Set(std::uint16_t address, std::uint16_t value) {
  command_.at(address - command_block_.address) = value;
}

void DriveDialogue::SetLong(std::uint16_t address, std::uint32_t value) {
  const auto next = static_cast<std::uint16_t>(address + 1);
  const bool high_first = map_.word_order == WordOrder::kHighFirst;
  Set(high_first ? address : next, static_cast<std::uint16_t>(value >> 16));
  Set(high_first ? next : address, static_cast<std::uint16_t>(value & 0xFFFFU));
}

void DriveDialogue::ClearCommand() { std::fill(command_.begin(), command_.end(), std::uint16_t{0}); }

void DriveDialogue::Close() { link_.Close(); }

tl::expected<void, ModbusFailure> DriveDialogue::Reopen() {
  // A serial line may still bring what was asked for before.
  quiet_ = true;
  auto opened = link_.Reopen();
  quiet_until_ = clock_.Now() + options_.quiet_time;
  return opened;
}

}  // namespace annulus
