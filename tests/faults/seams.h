#pragma once

// What the fault rig puts between the program and the simulated machine.

#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "base/clock.h"
#include "firmware_iface/gpio_lines.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/usb_port.h"
#include "tests/faults/invariant_watch.h"
#include "tests/faults/program_scope.h"

namespace annulus::faults {

/// A clock whose wall time can be set, as by somebody at the console. Borrows the clock.
class SettableClock final : public Clock {
 public:
  explicit SettableClock(Clock& clock) : clock_(clock) {}
  void JumpWall(std::chrono::nanoseconds by) { jump_ += by; }

  [[nodiscard]] std::chrono::nanoseconds Now() const override { return clock_.Now(); }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return clock_.WallNow() + jump_; }
  void SleepUntil(std::chrono::nanoseconds deadline) override { clock_.SleepUntil(deadline); }

 private:
  Clock& clock_;
  std::chrono::nanoseconds jump_{0};
};

/// Whether the program still has its devices: a killed one writes nothing any more, whatever its destructors do.
struct ProcessLife {
  bool alive = true;
  bool worker_alive = true;
};

/// What the worker thread meets when it ends in the middle of something. No std::exception, so that nobody handles it.
struct WorkerEnded {};

/// The worker's clock: ends it as soon as it waits after it was stopped for good. Borrows all.
class MortalClock final : public Clock {
 public:
  MortalClock(Clock& clock, const ProcessLife& life) : clock_(clock), life_(life) {}
  [[nodiscard]] std::chrono::nanoseconds Now() const override { return clock_.Now(); }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return clock_.WallNow(); }
  void SleepUntil(std::chrono::nanoseconds deadline) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    if (stepping_ && stall_.count() > 0) {
      stalls_();
      clock_.SleepUntil(clock_.Now() + std::exchange(stall_, {}));
    }
    clock_.SleepUntil(deadline);
    if (stepping_ && (!life_.alive || !life_.worker_alive)) throw WorkerEnded{};
  }
  /// The worker is at work between the two, and not somebody who takes its things down.
  void Begin() { stepping_ = true; }
  void End() { stepping_ = false; }
  /// At its next wait it stands still for this long; `stalls` is called as it begins.
  void Stall(std::chrono::nanoseconds time, std::function<void()> stalls) {
    stall_ = time;
    stalls_ = std::move(stalls);
  }

 private:
  Clock& clock_;
  const ProcessLife& life_;
  bool stepping_ = false;
  std::chrono::nanoseconds stall_{0};
  std::function<void()> stalls_;
};

/// The program's end of the axis link: tells the watch of requests and answers. Borrows all.
class WatchedLink final : public ModbusLink {
 public:
  WatchedLink(ModbusLink& link, InvariantWatch& watch, const ProcessLife& life)
      : link_(link), watch_(watch), life_(life) {}

  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    if (!life_.alive) return tl::unexpected(ModbusFailure{ModbusFault::kLinkLost, {}, "the program is dead"});
    watch_.BeforeRequest();
    ModbusReply reply = link_.Transact(request, timeout);
    if (reply) watch_.GoodAnswer();
    return reply;
  }
  [[nodiscard]] std::chrono::nanoseconds WireTime(const ModbusRequest& request) const override {
    return link_.WireTime(request);
  }
  void DiscardInput() override {
    if (life_.alive) link_.DiscardInput();
  }
  void Close() override {
    if (life_.alive) link_.Close();
  }
  tl::expected<void, ModbusFailure> Reopen() override { return link_.Reopen(); }

 private:
  ModbusLink& link_;
  InvariantWatch& watch_;
  const ProcessLife& life_;
};

/// The program's GPIO lines. Those of a killed program keep their levels until they are released. Borrows `life`.
class MortalLines final : public GpioLines {
 public:
  MortalLines(std::unique_ptr<GpioLines> lines, const ProcessLife& life) : lines_(std::move(lines)), life_(life) {}

  [[nodiscard]] std::size_t count() const override { return lines_->count(); }
  GpioResult<std::vector<bool>> Read() override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    return lines_->Read();
  }
  GpioResult<void> Write(std::size_t line, bool level) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    if (!life_.alive) return {};
    return lines_->Write(line, level);
  }
  GpioResult<std::optional<GpioEdge>> WaitEdge(std::chrono::nanoseconds deadline) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    return lines_->WaitEdge(deadline);
  }

 private:
  std::unique_ptr<GpioLines> lines_;
  const ProcessLife& life_;
};

/// The program's end of a board's USB port.
class OutsidePort final : public UsbPort {
 public:
  explicit OutsidePort(std::unique_ptr<UsbPort> port) : port_(std::move(port)) {}

  [[nodiscard]] const UsbIdentity& identity() const override { return port_->identity(); }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length,
                                              std::chrono::nanoseconds timeout) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    return port_->ControlIn(request, length, timeout);
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data,
                             std::chrono::nanoseconds timeout) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    return port_->ControlOut(request, data, timeout);
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    return port_->SubmitBulkIn(endpoint, length);
  }
  void Cancel(UsbToken token) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    port_->Cancel(token);
  }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    return port_->ClearHalt(endpoint);
  }
  std::optional<UsbCompletion> WaitCompletion(std::chrono::nanoseconds deadline) override {
    const ProgramScope scope(ProgramScope::Code::kOther);
    return port_->WaitCompletion(deadline);
  }
  [[nodiscard]] std::size_t in_flight() const override { return port_->in_flight(); }

 private:
  std::unique_ptr<UsbPort> port_;
};

}  // namespace annulus::faults
