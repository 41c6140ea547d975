#include "sim/faulty_modbus_link.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "base/ensure.h"
#include "sim/world.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

/// Long enough for any device model to answer.
constexpr nanoseconds kPatience = std::chrono::milliseconds(50);

tl::unexpected<ModbusFailure> Failure(ModbusFault fault, std::uint8_t exception = 0, const char* detail = "") {
  return tl::unexpected<ModbusFailure>(ModbusFailure{fault, exception, detail});
}

}  // namespace

ModbusFatePlan SeededModbusFates(ModbusFaultRates rates, std::uint64_t seed) {
  const double sum = rates.request_lost + rates.exception + rates.reply_lost + rates.late + rates.repeated +
                     rates.truncated + rates.damaged + rates.merged;
  ENSURE(sum <= 1.0, "no more can go wrong than there are transactions");
  return [rates, engine = std::mt19937_64(seed)]() mutable {
    double draw = UnitFromBits(engine());
    const double share = UnitFromBits(engine());
    const auto meets = [&draw](double rate) {
      const bool met = draw >= 0.0 && draw < rate;
      draw -= rate;
      return met;
    };
    const auto delay = nanoseconds(std::llround(share * static_cast<double>(rates.longest_delay.count())));
    ModbusFate fate;
    if (meets(rates.request_lost)) fate.request_lost = true;
    if (meets(rates.exception)) fate.exception = static_cast<std::uint8_t>(1 + std::min(5.0, std::floor(6.0 * share)));
    if (meets(rates.reply_lost)) fate.copies = 0;
    if (meets(rates.late)) fate.delay = delay;
    if (meets(rates.repeated)) {
      fate.delay = delay;
      fate.copies = 2 + static_cast<int>(engine() % 2);
    }
    if (meets(rates.truncated)) fate.missing = 1 + engine() % 4;
    if (meets(rates.damaged)) fate.damaged = true;
    if (meets(rates.merged)) fate.merged = true;
    return fate;
  };
}

FaultyModbusLink::FaultyModbusLink(ModbusLink& device, Clock& clock, ModbusNumbering numbering, ModbusFatePlan plan)
    : device_(device), clock_(clock), numbering_(numbering), plan_(std::move(plan)) {}

std::size_t FaultyModbusLink::Thaw() {
  frozen_ = false;
  thaw_at_.reset();
  const std::size_t count = held_.size();
  for (const Held& held : std::exchange(held_, {})) {
    ModbusReply reply = device_.Transact(held.request, kPatience);
    if (open_) PutOnWire(clock_.Now(), held.number, std::move(reply));
  }
  return count;
}

void FaultyModbusLink::Unplug() {
  plugged_ = open_ = false;
  wire_.clear();
  stuck_.clear();
}

ModbusReply FaultyModbusLink::Transact(const ModbusRequest& request, nanoseconds timeout) {
  if (hook_) hook_();
  if (!open_) return Failure(ModbusFault::kLinkLost, 0, plugged_ ? "it is closed" : "unplugged");
  const nanoseconds deadline = clock_.Now() + timeout;
  ++transactions_;
  ++number_;
  if (frozen_) {
    held_.push_back({number_, request});
  } else {
    Send(request, timeout);
  }
  return Receive(deadline);
}

void FaultyModbusLink::Send(const ModbusRequest& request, nanoseconds timeout) {
  const ModbusFate fate = plan_ ? plan_() : ModbusFate{};
  if (fate.request_lost) return;
  ModbusReply reply = fate.exception ? ModbusReply(Failure(ModbusFault::kException, *fate.exception))
                                     : device_.Transact(request, timeout);
  if (!reply && reply.error().fault == ModbusFault::kTimeout) return;
  if (reply) reply->resize(reply->size() - std::min(reply->size(), fate.missing));
  if (fate.damaged) reply = Failure(ModbusFault::kBadReply, 0, "Invalid CRC");
  if (fate.merged) {
    stuck_.push_back({nanoseconds(0), number_, std::move(reply)});
    return;
  }
  // What was stuck comes together with this reply, and before it.
  for (OnWire& stuck : std::exchange(stuck_, {})) {
    PutOnWire(clock_.Now() + fate.delay, stuck.number, std::move(stuck.reply));
  }
  for (int copy = 0; copy < fate.copies; ++copy) PutOnWire(clock_.Now() + fate.delay * (copy + 1), number_, reply);
}

void FaultyModbusLink::PutOnWire(nanoseconds arrival, std::uint64_t number, ModbusReply reply) {
  const auto later = std::upper_bound(wire_.begin(), wire_.end(), arrival,
                                      [](nanoseconds time, const OnWire& other) { return time < other.arrival; });
  wire_.insert(later, {arrival, number, std::move(reply)});
}

ModbusReply FaultyModbusLink::Receive(nanoseconds deadline) {
  if (frozen_ && thaw_at_ && *thaw_at_ <= deadline) {
    clock_.SleepUntil(*thaw_at_);
    static_cast<void>(Thaw());
  }
  if (wire_.empty() || wire_.front().arrival > deadline) {
    clock_.SleepUntil(deadline);
    return Failure(ModbusFault::kTimeout);
  }
  OnWire taken = std::move(wire_.front());
  wire_.pop_front();
  clock_.SleepUntil(taken.arrival);
  if (numbering_ == ModbusNumbering::kTransaction && taken.number != number_) {
    return Failure(ModbusFault::kBadReply, 0, "a reply to another transaction");
  }
  return std::move(taken.reply);
}

void FaultyModbusLink::DiscardInput() {
  while (!wire_.empty() && wire_.front().arrival <= clock_.Now()) wire_.pop_front();
}

void FaultyModbusLink::Close() {
  open_ = false;
  if (numbering_ == ModbusNumbering::kNone) return;
  wire_.clear();
  stuck_.clear();
  if (held_.size() > 1) held_.resize(1);
}

tl::expected<void, ModbusFailure> FaultyModbusLink::Reopen() {
  if (hook_) hook_();
  Close();
  if (!plugged_) return Failure(ModbusFault::kLinkLost, 0, "No such file or directory");
  open_ = true;
  return {};
}

}  // namespace annulus::sim
