#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "sim/booth.h"
#include "sim/fault_plan.h"
#include "sim/fault_schedule.h"
#include "sim/faulty_can_bus.h"
#include "sim/faulty_gpio_lines.h"
#include "sim/faulty_modbus_link.h"
#include "sim/faulty_usb_port.h"
#include "sim/usb_host_model.h"

namespace annulus::sim {

/// What an actor works on. All borrowed.
struct FaultGround {
  BoothDevices& booth;
  Clock& clock;
  std::uint64_t seed = 1;
  std::function<void(const FaultCall&)> on_call;  ///< To be told before every call at a seam.
};

/// Does what the faults of one target say. `number` is the fault's in its plan.
class FaultActor {
 public:
  virtual ~FaultActor() = default;
  /// `to`: when it ends, if that is known; End is called then, too.
  virtual void Begin(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
                     std::chrono::nanoseconds to) = 0;
  virtual void End(std::size_t number, const Fault& fault, std::chrono::nanoseconds time) = 0;
  /// Time has passed.
  virtual void Follow() {}
};

/// Whether the end of a fault is known at its beginning.
[[nodiscard]] bool EndsInTime(const Fault& fault);

/// Faults that hold now, with their numbers.
class HoldingFaults {
 public:
  struct Holding {
    std::size_t number = 0;
    Fault fault;
    std::chrono::nanoseconds from{0};
    std::chrono::nanoseconds to{0};
    std::uint64_t left = 0;  ///< Times that it still happens.
  };
  void Add(std::size_t number, const Fault& fault, std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  void Remove(std::size_t number);
  [[nodiscard]] std::vector<Holding>& all() { return all_; }

 private:
  std::vector<Holding> all_;
};

/// USB ports and the bus.
class UsbFaultActor final : public FaultActor {
 public:
  explicit UsbFaultActor(FaultGround ground);
  void Begin(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
             std::chrono::nanoseconds to) override;
  void End(std::size_t number, const Fault& fault, std::chrono::nanoseconds time) override;
  void Follow() override;

  /// The boards' bus, with plug events; either this or ports() is used.
  [[nodiscard]] UsbHostModel& host();
  [[nodiscard]] std::vector<UsbPort*> ports();
  /// What really went wrong at a board's port, for judging.
  [[nodiscard]] const UsbFaultLog& log(std::size_t board) const { return log_.at(board); }

 private:
  static constexpr std::size_t kMostBoards = BoothDevices::kBoards + 1;
  [[nodiscard]] std::size_t boards() const { return ground_.booth.board_count(); }
  void Unplug(const Fault& fault, std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  void Plug(const Fault& fault, std::chrono::nanoseconds time);
  /// Unplugs what is to be unplugged, now that it is known whether the bus or the ports are used.
  void PullWaitingPlugs();
  void Confuse(const Fault& fault);
  void Rebuild();
  void TakeCall(std::size_t board, FaultyUsbPort::Call call);
  [[nodiscard]] std::size_t BoardOf(const UsbIdentity& identity) const;

  FaultGround ground_;
  HoldingFaults holding_;
  std::array<UsbFaultPlan, kMostBoards> plan_;
  std::array<UsbFaultLog, kMostBoards> log_;
  std::array<UsbIdentity, kMostBoards> identity_;
  std::array<bool, kMostBoards> to_plug_{};
  struct WaitingPlug {
    std::size_t board = 0;
    std::chrono::nanoseconds unplug{0};
    std::chrono::nanoseconds plug{0};
    std::chrono::nanoseconds not_ready{0};
  };
  std::vector<WaitingPlug> waiting_;
  std::unique_ptr<UsbHostModel> host_;
  std::vector<std::unique_ptr<FaultyUsbPort>> ports_;
};

/// What a fault does to one interface of the host, the same before a bus and before a recorded one: lost frames, a full
/// queue, an interface down or gone, reported error states. False: the fault is none of these.
bool BeginOnInterface(FaultyCanBus& bus, const Fault& fault, std::chrono::nanoseconds from,
                      std::chrono::nanoseconds to);

/// CAN buses, and the boards' controllers.
class CanFaultActor final : public FaultActor {
 public:
  CanFaultActor(FaultGround ground, const FaultPlan& plan);
  ~CanFaultActor() override;
  void Begin(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
             std::chrono::nanoseconds to) override;
  void End(std::size_t number, const Fault& fault, std::chrono::nanoseconds time) override;

  [[nodiscard]] const std::vector<CanBus*>& buses() const { return buses_; }
  [[nodiscard]] const FaultyCanBus::Log& log(std::size_t bus) const { return faulty_.at(bus)->log(); }

 private:
  class Babbler;
  void BeginOnBus(std::size_t bus, const Fault& fault, std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  void BeginOnBoard(const Fault& fault, std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  void Rebuild();
  [[nodiscard]] std::vector<std::size_t> BusesOf(const Fault& fault) const;
  [[nodiscard]] std::size_t BusOfBoard(std::size_t board) const;
  /// Whether the board that the fault names is there, and hangs on CAN.
  [[nodiscard]] bool HasBoard(const Fault& fault) const;

  FaultGround ground_;
  HoldingFaults holding_;
  std::uint64_t changes_ = 0;
  std::vector<std::unique_ptr<FaultyCanBus>> faulty_;
  std::vector<CanBus*> buses_;
  std::vector<std::unique_ptr<Babbler>> babblers_;
  std::vector<std::unique_ptr<CanBoardModel>> intruders_;
};

/// The link to the drive.
class LinkFaultActor final : public FaultActor {
 public:
  LinkFaultActor(FaultGround ground, ModbusNumbering numbering);
  void Begin(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
             std::chrono::nanoseconds to) override;
  void End(std::size_t number, const Fault& fault, std::chrono::nanoseconds time) override;

  [[nodiscard]] FaultyModbusLink& link() { return link_; }

 private:
  [[nodiscard]] ModbusFate Fate();

  FaultGround ground_;
  HoldingFaults holding_;
  std::uint64_t drawn_ = 0;
  FaultyModbusLink link_;
};

/// The program's lines to the safety chain.
class GpioFaultActor final : public FaultActor {
 public:
  explicit GpioFaultActor(FaultGround ground);
  void Begin(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
             std::chrono::nanoseconds to) override;
  void End(std::size_t number, const Fault& fault, std::chrono::nanoseconds time) override;

  [[nodiscard]] std::unique_ptr<GpioLines> Wrap(std::unique_ptr<GpioLines> lines);

 private:
  void Rebuild();

  FaultGround ground_;
  HoldingFaults holding_;
  GpioFaultPlan plan_;
};

/// Drive and carriage, boards and sensors, the hardware of the chain: what the models do themselves.
class ModelFaultActor final : public FaultActor {
 public:
  explicit ModelFaultActor(FaultGround ground) : ground_(std::move(ground)) {}
  void Begin(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
             std::chrono::nanoseconds to) override;
  void End(std::size_t number, const Fault& fault, std::chrono::nanoseconds time) override;

 private:
  void BeginOnAxis(const Fault& fault, std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  void BeginOnBoards(std::size_t number, const Fault& fault, std::chrono::nanoseconds from,
                     std::chrono::nanoseconds to);
  /// Puts a fault on a board, on every bus that it hangs on.
  void Damage(std::size_t number, std::size_t board, const BoardFault& fault);
  void SwapSensors(std::size_t number, const Fault& fault, std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  void BeginOnChain(const Fault& fault, std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  void DamageChain(const Fault& fault);
  void EndOnChain(const Fault& fault, std::chrono::nanoseconds time);

  FaultGround ground_;
  struct OnBoard {
    BoardFaults* board = nullptr;
    std::size_t number = 0;
  };
  std::map<std::size_t, std::vector<OnBoard>> on_boards_;  ///< By the fault's number.
};

}  // namespace annulus::sim
