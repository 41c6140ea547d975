#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/ensure.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kStateDeadline = std::chrono::seconds(1);  ///< For one step of the power state machine.
constexpr nanoseconds kQuickStopDeadline = std::chrono::milliseconds(500);
constexpr nanoseconds kPollPause = std::chrono::milliseconds(5);
/// A stop is safe to repeat, unlike a move.
constexpr int kStopAttempts = 3;

/// The registers of one answered transaction, by address.
class RegisterBlock {
 public:
  RegisterBlock(std::uint16_t address, std::vector<std::uint16_t> values)
      : address_(address), values_(std::move(values)) {}

  [[nodiscard]] std::uint16_t Word(std::uint16_t address) const { return values_.at(address - address_); }
  [[nodiscard]] std::uint32_t Long(std::uint16_t address) const {
    return static_cast<std::uint32_t>(Word(address)) << 16 | Word(static_cast<std::uint16_t>(address + 1));
  }
  /// A signed 32-bit value in thousandths.
  [[nodiscard]] double SignedThousandths(std::uint16_t address) const {
    return static_cast<std::int32_t>(Long(address)) / 1000.0;
  }
  [[nodiscard]] double Thousandths(std::uint16_t address) const { return Long(address) / 1000.0; }

 private:
  std::uint16_t address_;
  std::vector<std::uint16_t> values_;
};

struct Answer {
  RegisterBlock registers;
  nanoseconds host_before{0};
  nanoseconds host_after{0};
};

const char* StateText(ScanAxis::State state) {
  switch (state) {
    case ScanAxis::State::kDisabled:
      return "disabled";
    case ScanAxis::State::kEnabled:
      return "enabled";
    case ScanAxis::State::kStopped:
      return "stopped";
    case ScanAxis::State::kFault:
      return "in fault";
  }
  return "unknown";
}

class ModbusScanAxis final : public ScanAxis {
 public:
  ModbusScanAxis(ModbusLink& link, const AxisRegisterMap& map, Clock& clock, ModbusAxisOptions options)
      : link_(link),
        map_(map),
        command_block_(map.CommandBlock()),
        status_block_(map.StatusBlock()),
        clock_(clock),
        options_(options),
        command_(command_block_.count, 0),
        // Not always from 0: a reply to a program that ran a moment ago must not fit by chance.
        counter_(
            static_cast<std::uint16_t>(std::chrono::duration_cast<std::chrono::milliseconds>(clock.Now()).count())) {}

  Status Identify();

  [[nodiscard]] State state() const override { return state_; }
  [[nodiscard]] const AxisIdentity& identity() const override { return identity_; }
  Status Enable() override;
  Status StartHoming() override;
  Status MoveTo(Millimetres z, MillimetresPerSecond speed) override;
  Result<AxisPosition> Position() override;
  Status Halt() override;
  Status QuickStop() override;
  Status Disable() override;
  Status Reopen(nanoseconds deadline) override;

 private:
  [[nodiscard]] Status Gate(const char* call, State required) const;
  /// One FC23: writes the next counter with the given registers, reads a block that begins or ends with the echo.
  /// Only a reply that echoes this counter counts.
  Result<Answer> Exchange(std::uint16_t address, std::vector<std::uint16_t> values, AxisRegisterMap::Block read);
  Result<Answer> Poll();
  Result<Answer> Order(std::uint16_t control);
  void SetCommand(std::uint16_t address, std::uint16_t value);
  void SetCommandLong(std::uint16_t address, std::uint32_t value);
  Status GoTo(DriveState wanted, std::uint16_t control);
  Status ResetFault();
  Status StartMotion(std::uint16_t mode, std::uint16_t control, const char* attempted);
  Status AwaitStandstill();
  Status CheckDrive(const Answer& answer);
  AxisPosition Read(const Answer& answer);

  ModbusLink& link_;
  AxisRegisterMap map_;
  AxisRegisterMap::Block command_block_;
  AxisRegisterMap::Block status_block_;
  Clock& clock_;
  ModbusAxisOptions options_;
  State state_ = State::kDisabled;
  AxisIdentity identity_;
  std::vector<std::uint16_t> command_;  ///< What the drive's command block should hold; [counter] is set per exchange.
  std::uint16_t counter_;
  nanoseconds quiet_until_{0};
  bool quiet_ = false;  ///< An error happened; input is to be thrown away when quiet_until_ is over.
  AxisPosition last_;
  int failures_ = 0;                 ///< Positions in a row without a good reply.
  std::uint64_t drive_time_us_ = 0;  ///< Unwrapped.
};

Status ModbusScanAxis::Gate(const char* call, State required) const {
  if (state_ == required) return {};
  return Fail(call, std::string("the axis is ") + StateText(state_) + ", it must be " + StateText(required),
              state_ == State::kDisabled ? "enable the axis first" : "disable the axis and enable it again");
}

Result<Answer> ModbusScanAxis::Exchange(std::uint16_t address, std::vector<std::uint16_t> values,
                                        AxisRegisterMap::Block read) {
  if (quiet_) {
    clock_.SleepUntil(quiet_until_);
    link_.DiscardInput();
    quiet_ = false;
  }
  ++counter_;
  values.at(map_.counter - address) = counter_;
  const nanoseconds before = clock_.Now();
  ModbusReply reply =
      link_.Transact({ModbusFunction::kWriteReadRegisters, address, std::move(values), read.address, read.count},
                     options_.reply_timeout);
  const nanoseconds after = clock_.Now();

  std::string seen;
  if (!reply) {
    seen = ModbusFailureText(reply.error());
  } else if (reply->size() != read.count) {
    seen = "a reply of " + std::to_string(reply->size()) + " registers instead of " + std::to_string(read.count);
  } else if (const std::uint16_t echo = (*reply)[map_.echo - read.address]; echo != counter_) {
    seen = "a reply to transaction " + std::to_string(echo) + " instead of " + std::to_string(counter_);
  } else {
    return Answer{RegisterBlock(read.address, std::move(*reply)), before, after};
  }
  quiet_ = true;
  quiet_until_ = clock_.Now() + options_.quiet_time;
  return Fail("talk to the axis drive", std::move(seen),
              "check the drive's supply and cable, then home the axis again");
}

Result<Answer> ModbusScanAxis::Poll() { return Exchange(map_.counter, {0}, status_block_); }

Result<Answer> ModbusScanAxis::Order(std::uint16_t control) {
  SetCommand(map_.control_word, control);
  return Exchange(command_block_.address, command_, status_block_);
}

void ModbusScanAxis::SetCommand(std::uint16_t address, std::uint16_t value) {
  command_.at(address - command_block_.address) = value;
}

void ModbusScanAxis::SetCommandLong(std::uint16_t address, std::uint32_t value) {
  SetCommand(address, static_cast<std::uint16_t>(value >> 16));
  SetCommand(static_cast<std::uint16_t>(address + 1), static_cast<std::uint16_t>(value & 0xFFFFU));
}

Status ModbusScanAxis::Identify() {
  auto answer = Exchange(map_.counter, {0}, map_.IdentityBlock());
  // The program may have been restarted in mid-transaction: one more try.
  if (!answer) answer = Exchange(map_.counter, {0}, map_.IdentityBlock());
  if (!answer) return Fail(answer);
  const RegisterBlock& registers = answer->registers;
  identity_.protocol_version = registers.Word(map_.protocol_version);
  identity_.serial = registers.Long(map_.serial);
  const std::uint16_t firmware = registers.Word(map_.firmware_version);
  identity_.firmware_version = std::to_string(firmware >> 8) + "." + std::to_string(firmware & 0xFF);
  identity_.limits = {Millimetres(registers.SignedThousandths(map_.z_min)),
                      Millimetres(registers.SignedThousandths(map_.z_max)),
                      MillimetresPerSecond(registers.Thousandths(map_.max_speed)),
                      MillimetresPerSecondSquared(registers.Thousandths(map_.max_acceleration))};
  const std::string attempted = "identify the axis drive";
  if (identity_.protocol_version != kAxisProtocolVersion) {
    return Fail(attempted,
                "it speaks protocol " + std::to_string(identity_.protocol_version) + ", this program speaks " +
                    std::to_string(kAxisProtocolVersion),
                "update the drive's firmware or the program");
  }
  const AxisLimits& limits = identity_.limits;
  if (limits.z_min >= limits.z_max || limits.max_speed.value() <= 0.0 || limits.max_acceleration.value() <= 0.0) {
    return Fail(attempted, "its travel, speed and acceleration limits make no sense", "set the drive's limits");
  }
  const std::uint16_t heartbeat = registers.Word(map_.heartbeat_timeout);
  if (heartbeat == 0 || heartbeat > kHeartbeat.count()) {
    return Fail(
        attempted, "its heartbeat time-out is " + (heartbeat == 0 ? "off" : std::to_string(heartbeat) + " ms"),
        "set it to " + std::to_string(kHeartbeat.count()) + " ms or less: the axis must stop when the host does");
  }
  return {};
}

Status ModbusScanAxis::CheckDrive(const Answer& answer) {
  const DriveState drive = DriveStateOf(answer.registers.Word(map_.status_word));
  if (drive == DriveState::kFault || drive == DriveState::kFaultReaction) {
    if (state_ != State::kDisabled) state_ = State::kFault;
    return Fail("run the axis", AxisFaultText(answer.registers.Word(map_.fault_code)),
                "clear the cause, then enable and home the axis again");
  }
  if (state_ == State::kEnabled && drive != DriveState::kOperationEnabled) {
    state_ = State::kFault;
    return Fail("run the axis", std::string("the drive is in state '") + DriveStateText(drive) + "'",
                "check the drive's enable line, then enable the axis again");
  }
  return {};
}

Status ModbusScanAxis::GoTo(DriveState wanted, std::uint16_t control) {
  auto answer = Order(control);
  const nanoseconds deadline = clock_.Now() + kStateDeadline;
  while (true) {
    if (!answer) return Fail(answer);
    const DriveState drive = DriveStateOf(answer->registers.Word(map_.status_word));
    if (drive == wanted) return {};
    if (drive == DriveState::kFault || clock_.Now() >= deadline) {
      return Fail(std::string("bring the axis drive to '") + DriveStateText(wanted) + "'",
                  drive == DriveState::kFault ? AxisFaultText(answer->registers.Word(map_.fault_code))
                                              : std::string("it stays in '") + DriveStateText(drive) + "'",
                  "check the drive's supply and enable line, then try again");
    }
    clock_.SleepUntil(clock_.Now() + kPollPause);
    answer = Poll();
  }
}

Status ModbusScanAxis::ResetFault() {
  const nanoseconds deadline = clock_.Now() + kStateDeadline;
  DriveState drive = DriveState::kFaultReaction;
  while (drive == DriveState::kFaultReaction && clock_.Now() < deadline) {
    const auto answer = Poll();
    if (!answer) return Fail(answer);
    drive = DriveStateOf(answer->registers.Word(map_.status_word));
    if (drive == DriveState::kFaultReaction) clock_.SleepUntil(clock_.Now() + kPollPause);
  }
  if (drive != DriveState::kFault) return {};
  // The drive resets on the rising edge of the bit.
  RETURN_IF_ERROR(Order(control_word::kDisableVoltage));
  return GoTo(DriveState::kSwitchOnDisabled, control_word::kFaultReset);
}

Status ModbusScanAxis::Enable() {
  RETURN_IF_ERROR(Gate("enable the axis", State::kDisabled));
  // Never start from an old target: modes and set-points are written anew before the drive may move.
  std::fill(command_.begin(), command_.end(), std::uint16_t{0});
  SetCommand(map_.mode, kModeProfilePosition);
  RETURN_IF_ERROR(ResetFault());
  RETURN_IF_ERROR(GoTo(DriveState::kReadyToSwitchOn, control_word::kShutdown));
  RETURN_IF_ERROR(GoTo(DriveState::kSwitchedOn, control_word::kSwitchOn));
  RETURN_IF_ERROR(GoTo(DriveState::kOperationEnabled, control_word::kEnableOperation));
  state_ = State::kEnabled;
  failures_ = 0;
  return {};
}

Status ModbusScanAxis::StartMotion(std::uint16_t mode, std::uint16_t control, const char* attempted) {
  SetCommand(map_.mode, mode);
  // A failed order is never repeated: the drive may carry it out yet (RELIABILITY.md, finding 2).
  auto answer = Order(control);
  if (!answer) return Fail(attempted, answer.error().seen, answer.error().advice);
  RETURN_IF_ERROR(CheckDrive(*answer));
  const bool acknowledged = (answer->registers.Word(map_.status_word) & status_word::kAcknowledge) != 0;
  if (mode == kModeProfilePosition && !acknowledged) {
    return Fail(attempted, "the drive does not take the target", "check the drive's state and limits");
  }
  if (mode == kModeHoming) return {};
  // The set-point handshake: our bit back to 0, so that the next one is an edge again.
  answer = Order(static_cast<std::uint16_t>(control & ~control_word::kStart));
  if (!answer) return Fail(attempted, answer.error().seen, answer.error().advice);
  return CheckDrive(*answer);
}

Status ModbusScanAxis::StartHoming() {
  RETURN_IF_ERROR(Gate("home the axis", State::kEnabled));
  RETURN_IF_ERROR(Order(control_word::kEnableOperation));
  last_.homed = false;
  return StartMotion(kModeHoming, control_word::kEnableOperation | control_word::kStart, "home the axis");
}

Status ModbusScanAxis::MoveTo(Millimetres z, MillimetresPerSecond speed) {
  const char* attempted = "move the axis";
  RETURN_IF_ERROR(Gate(attempted, State::kEnabled));
  if (!last_.homed) return Fail(attempted, "the axis is not homed", "home the axis first");
  const AxisLimits& limits = identity_.limits;
  if (!(z >= limits.z_min && z <= limits.z_max)) {
    return Fail(attempted,
                "target " + std::to_string(z.value()) + " mm is outside " + std::to_string(limits.z_min.value()) +
                    " to " + std::to_string(limits.z_max.value()) + " mm",
                "correct the scan plan");
  }
  if (!(speed.value() > 0.0 && speed <= limits.max_speed)) {
    return Fail(
        attempted,
        "speed " + std::to_string(speed.value()) + " mm/s is not in 0 to " + std::to_string(limits.max_speed.value()),
        "correct the scan plan");
  }
  // Homing leaves its start bit set; the drive wants to see it rise again.
  RETURN_IF_ERROR(Order(control_word::kEnableOperation));
  const auto thousandths = [](double value) { return std::llround(value * 1000.0); };
  SetCommandLong(map_.target_position, static_cast<std::uint32_t>(static_cast<std::int32_t>(thousandths(z.value()))));
  SetCommandLong(map_.profile_speed, static_cast<std::uint32_t>(thousandths(speed.value())));
  SetCommandLong(map_.profile_acceleration, static_cast<std::uint32_t>(thousandths(limits.max_acceleration.value())));
  return StartMotion(kModeProfilePosition,
                     control_word::kEnableOperation | control_word::kStart | control_word::kChangeImmediately,
                     attempted);
}

AxisPosition ModbusScanAxis::Read(const Answer& answer) {
  const RegisterBlock& registers = answer.registers;
  // The 32-bit microseconds wrap every 71.6 min: what counts is the difference to the last reading.
  drive_time_us_ += static_cast<std::uint32_t>(registers.Long(map_.drive_time) -
                                               static_cast<std::uint32_t>(drive_time_us_ & 0xFFFFFFFFU));
  const std::uint16_t flags = registers.Word(map_.flags);
  AxisPosition position;
  position.fresh = true;
  position.z = Millimetres(registers.SignedThousandths(map_.position));
  position.time = {answer.host_before, std::chrono::microseconds(static_cast<std::int64_t>(drive_time_us_)),
                   answer.host_after};
  position.homed = (flags & kAxisFlagHomed) != 0;
  position.moving = (flags & kAxisFlagMoving) != 0;
  position.target_reached = (registers.Word(map_.status_word) & status_word::kTargetReached) != 0;
  return position;
}

Result<AxisPosition> ModbusScanAxis::Position() {
  const auto answer = Poll();
  if (!answer) {
    if (++failures_ == 1) {
      last_.fresh = false;
      return last_;
    }
    if (state_ != State::kDisabled) state_ = State::kFault;
    return Fail(answer);
  }
  failures_ = 0;
  last_ = Read(*answer);
  RETURN_IF_ERROR(CheckDrive(*answer));
  if (state_ == State::kEnabled && (answer->registers.Word(map_.status_word) & status_word::kModeError) != 0) {
    return Fail("run the axis", "the drive reports a homing or following error",
                "look for an obstacle, check the home switch, then home the axis again");
  }
  return last_;
}

Status ModbusScanAxis::AwaitStandstill() {
  const nanoseconds deadline = clock_.Now() + kQuickStopDeadline;
  while (true) {
    const auto answer = Poll();
    if (answer && !Read(*answer).moving) return {};
    if (clock_.Now() >= deadline) {
      return Fail("stop the axis", answer ? "it still moves" : answer.error().seen, "press the emergency stop");
    }
    clock_.SleepUntil(clock_.Now() + kPollPause);
  }
}

Status ModbusScanAxis::Halt() {
  RETURN_IF_ERROR(Gate("halt the axis", State::kEnabled));
  const auto answer = Order(control_word::kEnableOperation | control_word::kHalt);
  if (!answer) return Fail(answer);
  return CheckDrive(*answer);
}

Status ModbusScanAxis::QuickStop() {
  Result<Answer> answer = Order(control_word::kQuickStop);
  for (int attempt = 1; !answer && attempt < kStopAttempts; ++attempt) answer = Order(control_word::kQuickStop);
  if (state_ != State::kDisabled) state_ = State::kStopped;
  if (!answer) return Fail("quick-stop the axis", answer.error().seen, "press the emergency stop");
  return AwaitStandstill();
}

Status ModbusScanAxis::Disable() {
  Result<Answer> answer = Order(control_word::kDisableVoltage);
  for (int attempt = 1; !answer && attempt < kStopAttempts; ++attempt) answer = Order(control_word::kDisableVoltage);
  state_ = State::kDisabled;
  if (!answer) return Fail("disable the axis", answer.error().seen, "press the emergency stop");
  const DriveState drive = DriveStateOf(answer->registers.Word(map_.status_word));
  if (drive == DriveState::kSwitchOnDisabled || drive == DriveState::kFault || drive == DriveState::kFaultReaction) {
    return {};
  }
  return Fail("disable the axis", std::string("the drive stays in '") + DriveStateText(drive) + "'",
              "press the emergency stop");
}

Status ModbusScanAxis::Reopen(nanoseconds deadline) {
  state_ = State::kDisabled;
  last_ = {};
  nanoseconds pause = std::chrono::milliseconds(50);
  while (true) {
    Status again = Identify();
    if (again || clock_.Now() >= deadline) return again;
    clock_.SleepUntil(std::min(deadline, clock_.Now() + pause));
    pause = std::min<nanoseconds>(2 * pause, std::chrono::seconds(2));
    static_cast<void>(link_.Reopen());
  }
}

}  // namespace

Result<std::unique_ptr<ScanAxis>> MakeModbusScanAxis(ModbusLink& link, const AxisRegisterMap& map, Clock& clock,
                                                     ModbusAxisOptions options) {
  RETURN_IF_ERROR(CheckRegisterMap(map));
  auto axis = std::make_unique<ModbusScanAxis>(link, map, clock, options);
  RETURN_IF_ERROR(axis->Identify());
  return axis;
}

}  // namespace annulus
