#include "sim/locked_seams.h"

#include <utility>

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

class LockedUsbPort final : public UsbPort {
 public:
  LockedUsbPort(UsbPort& port, LockedTime& time) : port_(port), mutex_(time.mutex()) {}

  [[nodiscard]] const UsbIdentity& identity() const override { return port_.identity(); }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length, nanoseconds timeout) override {
    const std::scoped_lock lock(mutex_);
    return port_.ControlIn(request, length, timeout);
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) override {
    const std::scoped_lock lock(mutex_);
    return port_.ControlOut(request, data, timeout);
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override {
    const std::scoped_lock lock(mutex_);
    return port_.SubmitBulkIn(endpoint, length);
  }
  void Cancel(UsbToken token) override {
    const std::scoped_lock lock(mutex_);
    port_.Cancel(token);
  }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override {
    const std::scoped_lock lock(mutex_);
    return port_.ClearHalt(endpoint);
  }
  std::optional<UsbCompletion> WaitCompletion(nanoseconds deadline) override {
    const std::scoped_lock lock(mutex_);
    return port_.WaitCompletion(deadline);
  }
  [[nodiscard]] std::size_t in_flight() const override {
    const std::scoped_lock lock(mutex_);
    return port_.in_flight();
  }

 private:
  UsbPort& port_;
  PriorityMutex& mutex_;
};

class LockedCanBus final : public CanBus {
 public:
  LockedCanBus(CanBus& bus, LockedTime& time) : bus_(bus), mutex_(time.mutex()) {}

  CanResult<CanLink> ReadLink() override {
    const std::scoped_lock lock(mutex_);
    return bus_.ReadLink();
  }
  CanResult<void> Send(const CanFrame& frame) override {
    const std::scoped_lock lock(mutex_);
    return bus_.Send(frame);
  }
  CanResult<std::optional<CanReception>> Receive(nanoseconds deadline) override {
    const std::scoped_lock lock(mutex_);
    return bus_.Receive(deadline);
  }
  [[nodiscard]] std::uint64_t overflows() const override {
    const std::scoped_lock lock(mutex_);
    return bus_.overflows();
  }
  CanResult<void> Reopen() override {
    const std::scoped_lock lock(mutex_);
    return bus_.Reopen();
  }
  CanResult<void> Restart() override {
    const std::scoped_lock lock(mutex_);
    return bus_.Restart();
  }

 private:
  CanBus& bus_;
  PriorityMutex& mutex_;
};

class LockedModbusLink final : public ModbusLink {
 public:
  LockedModbusLink(ModbusLink& link, LockedTime& time) : link_(link), mutex_(time.mutex()) {}

  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    const std::scoped_lock lock(mutex_);
    return link_.Transact(request, timeout);
  }
  [[nodiscard]] nanoseconds WireTime(const ModbusRequest& request) const override { return link_.WireTime(request); }
  void DiscardInput() override {
    const std::scoped_lock lock(mutex_);
    link_.DiscardInput();
  }
  void Close() override {
    const std::scoped_lock lock(mutex_);
    link_.Close();
  }
  tl::expected<void, ModbusFailure> Reopen() override {
    const std::scoped_lock lock(mutex_);
    return link_.Reopen();
  }

 private:
  ModbusLink& link_;
  PriorityMutex& mutex_;
};

class LockedGpioLines final : public GpioLines {
 public:
  LockedGpioLines(std::unique_ptr<GpioLines> lines, LockedTime& time)
      : lines_(std::move(lines)), mutex_(time.mutex()) {}
  LockedGpioLines(const LockedGpioLines&) = delete;
  LockedGpioLines& operator=(const LockedGpioLines&) = delete;
  ~LockedGpioLines() override {
    const std::scoped_lock lock(mutex_);
    lines_.reset();
  }

  [[nodiscard]] std::size_t count() const override { return lines_->count(); }
  GpioResult<std::vector<bool>> Read() override {
    const std::scoped_lock lock(mutex_);
    return lines_->Read();
  }
  GpioResult<void> Write(std::size_t line, bool level) override {
    const std::scoped_lock lock(mutex_);
    return lines_->Write(line, level);
  }
  GpioResult<std::optional<GpioEdge>> WaitEdge(nanoseconds deadline) override {
    const std::scoped_lock lock(mutex_);
    return lines_->WaitEdge(deadline);
  }

 private:
  std::unique_ptr<GpioLines> lines_;
  PriorityMutex& mutex_;
};

}  // namespace

std::unique_ptr<UsbPort> MakeLocked(UsbPort& port, LockedTime& time) {
  return std::make_unique<LockedUsbPort>(port, time);
}
std::unique_ptr<CanBus> MakeLocked(CanBus& bus, LockedTime& time) { return std::make_unique<LockedCanBus>(bus, time); }
std::unique_ptr<ModbusLink> MakeLocked(ModbusLink& link, LockedTime& time) {
  return std::make_unique<LockedModbusLink>(link, time);
}
std::unique_ptr<GpioLines> MakeLocked(std::unique_ptr<GpioLines> lines, LockedTime& time) {
  return std::make_unique<LockedGpioLines>(std::move(lines), time);
}

}  // namespace annulus::sim
