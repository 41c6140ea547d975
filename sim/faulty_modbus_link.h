#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/modbus_link.h"

namespace annulus::sim {

/// What happens to one transaction on its way. As it stands: nothing.
struct ModbusFate {
  bool request_lost = false;                             ///< The device never sees it.
  std::optional<std::uint8_t> exception = std::nullopt;  ///< The device answers this instead of doing anything.
  std::chrono::nanoseconds delay{0};                     ///< Of the reply, and between its copies.
  int copies = 1;                                        ///< Of the reply; 0: lost.
  std::size_t missing = 0;                               ///< Registers cut off the end of the reply.
  bool damaged = false;                                  ///< The reply's checksum is wrong.
  bool merged = false;  ///< The reply sticks until the next one comes, then both are there.
};

/// Says what happens to the next transaction.
using ModbusFatePlan = std::function<ModbusFate()>;

/// Shares of transactions that a fault meets, one at most each; together at most 1.
struct ModbusFaultRates {
  double request_lost = 0.0;
  double exception = 0.0;  ///< 1 to 6 alike.
  double reply_lost = 0.0;
  double late = 0.0;
  double repeated = 0.0;  ///< Two or three copies, each as late as the one before it was.
  double truncated = 0.0;
  double damaged = 0.0;
  double merged = 0.0;
  std::chrono::nanoseconds longest_delay = std::chrono::milliseconds(150);  ///< Delays are uniform up to this.
};
/// The same rates and seed give the same fates.
[[nodiscard]] ModbusFatePlan SeededModbusFates(ModbusFaultRates rates, std::uint64_t seed);

/// Whether replies carry the number of their transaction, as Modbus TCP's do and a serial line's do not.
enum class ModbusNumbering { kNone, kTransaction };

/// A Modbus link on which things happen. Without transaction numbers whatever reply comes first is taken for the
/// answer; with them, a reply to another transaction is a bad reply, and the next one waits behind it. Borrows device
/// and clock.
class FaultyModbusLink final : public ModbusLink {
 public:
  FaultyModbusLink(ModbusLink& device, Clock& clock, ModbusNumbering numbering = ModbusNumbering::kNone,
                   ModbusFatePlan plan = {});

  void SetPlan(ModbusFatePlan plan) { plan_ = std::move(plan); }
  /// Told before every transaction and every opening.
  void OnCall(std::function<void()> hook) { hook_ = std::move(hook); }
  /// From now on the peer stands still: requests queue up in front of it, and nothing is answered.
  void Freeze() { frozen_ = true; }
  /// The same until `time`, if somebody waits for a reply then; otherwise until Thaw.
  void FreezeUntil(std::chrono::nanoseconds time) {
    frozen_ = true;
    thaw_at_ = time;
  }
  /// The peer goes on and carries out at once all that has queued up. Returns how much that was.
  std::size_t Thaw();
  /// The cable or adapter is gone: everything fails, opening again too, until Plug.
  void Unplug();
  void Plug() { plugged_ = true; }

  /// Requests that were sent, whatever became of them.
  [[nodiscard]] int transactions() const { return transactions_; }

  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override;
  [[nodiscard]] std::chrono::nanoseconds WireTime(const ModbusRequest& request) const override {
    return device_.WireTime(request);
  }
  void DiscardInput() override;
  /// With transaction numbers by reset: of what has queued up in front of a frozen peer, the first still gets through.
  void Close() override;
  tl::expected<void, ModbusFailure> Reopen() override;

 private:
  struct OnWire {
    std::chrono::nanoseconds arrival{0};
    std::uint64_t number = 0;
    ModbusReply reply;
  };
  struct Held {
    std::uint64_t number = 0;
    ModbusRequest request;
  };
  void Send(const ModbusRequest& request, std::chrono::nanoseconds timeout);
  void PutOnWire(std::chrono::nanoseconds arrival, std::uint64_t number, ModbusReply reply);
  ModbusReply Receive(std::chrono::nanoseconds deadline);

  ModbusLink& device_;
  Clock& clock_;
  ModbusNumbering numbering_;
  ModbusFatePlan plan_;
  std::function<void()> hook_;
  bool frozen_ = false;
  bool plugged_ = true;
  bool open_ = true;
  int transactions_ = 0;
  std::uint64_t number_ = 0;
  std::deque<OnWire> wire_;  ///< By arrival.
  std::vector<OnWire> stuck_;
  std::vector<Held> held_;
  std::optional<std::chrono::nanoseconds> thaw_at_;
};

}  // namespace annulus::sim
