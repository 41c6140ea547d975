#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "firmware_iface/usb_port.h"

namespace annulus::sim {

/// What goes wrong on a USB port. Shares are of the transfers that bring data, 0 … 1; at most one of the five happens
/// to a transfer.
struct UsbFaultPlan {
  std::uint64_t seed = 1;
  double short_share = 0.0;    ///< The end of the data is lost (at least one byte, and one is left).
  double zero_share = 0.0;     ///< All data is lost.
  double long_share = 0.0;     ///< Up to 64 bytes that belong to nothing follow the data.
  double damage_share = 0.0;   ///< One bit is turned over.
  double timeout_share = 0.0;  ///< Ends kTimedOut with part of the data; the rest comes with the next transfer.
  double stall_share = 0.0;    ///< The endpoint halts and loses the data: all transfers end kStall until ClearHalt.
  bool stall_stays = false;    ///< ClearHalt succeeds, and does not help.
  std::optional<std::uint64_t> no_memory_at;  ///< Number of the submit that fails with kNoMemory, 0 first.
  bool no_memory = false;                     ///< They all do.
  double cancel_completes_share = 0.0;        ///< Cancelled transfers that end kCompleted with what came last.
  std::vector<std::byte> stale;               ///< Comes before the first data: left over in the board's controller.
  /// How transfers end at an unplug: as the system may do it (HIL.md names all three).
  enum class UnplugEnding { kNoDevice, kError, kCompleted, kAny };
  UnplugEnding unplug_ending = UnplugEnding::kNoDevice;
};

/// What really went wrong, for judging.
struct UsbFaultLog {
  std::uint64_t submits = 0;
  std::uint64_t shortened = 0;
  std::uint64_t kept_bytes = 0;  ///< Of the shortened.
  std::uint64_t emptied = 0;
  std::uint64_t lengthened = 0;
  std::uint64_t added_bytes = 0;
  std::uint64_t damaged = 0;
  std::uint64_t timed_out = 0;
  std::uint64_t stalls = 0;
  std::uint64_t halts_cleared = 0;
  std::uint64_t cancels_completed = 0;
};

/// Passes everything on to a port, and spoils it by a plan. The same plan over the same port gives the same faults.
class FaultyUsbPort final : public UsbPort {
 public:
  /// Borrows the port.
  FaultyUsbPort(UsbPort& port, const UsbFaultPlan& plan);
  /// Borrows the port. `log` is borrowed and outlives it.
  FaultyUsbPort(UsbPort& port, const UsbFaultPlan& plan, UsbFaultLog& log);
  /// Owns the port. `log` is borrowed and outlives it.
  FaultyUsbPort(std::unique_ptr<UsbPort> port, const UsbFaultPlan& plan, UsbFaultLog& log);

  /// Changes what goes wrong from now on.
  void SetPlan(const UsbFaultPlan& plan) { plan_ = plan; }
  /// From now on what goes wrong is what `plan`, which is borrowed, says at the time. Its seed is not looked at again.
  void FollowPlan(const UsbFaultPlan& plan) { followed_ = &plan; }
  /// Told before every call but in_flight.
  enum class Call { kSubmit, kOther };
  void OnCall(std::function<void(Call)> hook) { hook_ = std::move(hook); }
  [[nodiscard]] const UsbFaultLog& log() const { return log_; }

  [[nodiscard]] const UsbIdentity& identity() const override { return port_.identity(); }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length,
                                              std::chrono::nanoseconds timeout) override {
    Tell(Call::kOther);
    return port_.ControlIn(request, length, timeout);
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data,
                             std::chrono::nanoseconds timeout) override {
    Tell(Call::kOther);
    return port_.ControlOut(request, data, timeout);
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override;
  void Cancel(UsbToken token) override {
    Tell(Call::kOther);
    port_.Cancel(token);
  }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override;
  std::optional<UsbCompletion> WaitCompletion(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::size_t in_flight() const override { return port_.in_flight(); }

 private:
  [[nodiscard]] const UsbFaultPlan& plan() const { return followed_ != nullptr ? *followed_ : plan_; }
  void Tell(Call call) const {
    if (hook_) hook_(call);
  }
  [[nodiscard]] double Unit();
  void Spoil(UsbCompletion& completion);
  void SpoilData(UsbCompletion& completion);
  void SpoilEnding(UsbCompletion& completion);

  std::unique_ptr<UsbPort> owned_;
  UsbPort& port_;
  UsbFaultPlan plan_;
  const UsbFaultPlan* followed_ = nullptr;  ///< Null: plan_ counts.
  std::function<void(Call)> hook_;
  UsbFaultLog own_log_;
  UsbFaultLog& log_;
  std::mt19937_64 random_;
  bool halted_ = false;
  std::vector<std::byte> carried_;  ///< Came too late for a transfer that timed out.
  std::vector<std::byte> last_;     ///< What the last good transfer brought.
};

}  // namespace annulus::sim
