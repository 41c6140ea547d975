#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "firmware_iface/axis_reading.h"
#include "firmware_iface/drive_dialogue.h"
#include "firmware_iface/drive_parameters.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kStateDeadline = std::chrono::seconds(1);  ///< For one step of the power state machine.
constexpr nanoseconds kQuickStopDeadline = std::chrono::milliseconds(500);
/// For the drive's acknowledgement of a target: it comes in the drive's next cycle, not in the reply to the order.
constexpr nanoseconds kAcknowledgeDeadline = std::chrono::milliseconds(50);
constexpr nanoseconds kDriveTime = std::chrono::milliseconds(5);  ///< What a drive needs from request to reply.
constexpr nanoseconds kPollPause = std::chrono::milliseconds(5);
constexpr nanoseconds kFirstPause = std::chrono::milliseconds(50);  ///< Between attempts to open a lost link.
constexpr nanoseconds kLongestPause = std::chrono::seconds(2);
/// A stop is safe to repeat, unlike a move.
constexpr int kStopAttempts = 3;
/// Readings in a row that may fail before that is an error: of a silent drive, of one that says that it is busy.
constexpr int kSilentReadings = 1;
constexpr int kBusyReadings = 3;
/// Between two readings, of a drive that does not tell whether it moves.
constexpr double kStandstillMm = 0.02;
/// So long the position of such a drive must stay within that: it may refresh the register only now and then.
constexpr nanoseconds kStandstillTime = std::chrono::milliseconds(50);

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

/// The drive's bits of a number of its units; nothing if it has no room for it.
std::optional<std::uint32_t> DriveUnits(double value, double units) {
  const double scaled = value * units;
  if (!(std::abs(scaled) <= std::numeric_limits<std::int32_t>::max())) return std::nullopt;
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(scaled)));
}

class ModbusScanAxis final : public ScanAxis {
 public:
  ModbusScanAxis(ModbusLink& link, const AxisRegisterMap& map, Clock& clock, ModbusAxisOptions options)
      : dialogue_(link, map, clock, options),
        map_(map),
        status_block_(map.StatusBlock()),
        reading_(ReadingLayout(map)),
        clock_(clock),
        options_(options) {}

  /// Refuses a line that is too slow for the time that a reply has.
  [[nodiscard]] Status CheckLine() const;
  Status Identify();

  [[nodiscard]] State state() const override { return state_; }
  [[nodiscard]] const AxisIdentity& identity() const override { return parameters_.identity; }
  Status Enable() override;
  Status StartHoming() override;
  Status MoveTo(Millimetres z, MillimetresPerSecond speed) override;
  Result<AxisPosition> Position() override;
  Status Halt() override;
  Status QuickStop() override;
  Status Disable() override;
  Status Reopen(nanoseconds deadline) override;
  Status Verify() override { return CheckParameters(); }
  [[nodiscard]] AxisTrouble trouble() const override { return trouble_; }

 private:
  /// No usable reply.
  tl::unexpected<Error> NoReply(const std::string& attempted, const ModbusFailure& failure) {
    trouble_ = AxisTrouble::kLink;
    return Unanswered(attempted, failure);
  }
  tl::unexpected<Error> FailAs(AxisTrouble trouble, std::string attempted, std::string seen, std::string advice) {
    trouble_ = trouble;
    return Fail(std::move(attempted), std::move(seen), std::move(advice));
  }
  [[nodiscard]] Status Gate(const char* call, State required);
  /// One order. If it fails, no other follows but stops; if it was not answered, nothing at all.
  DriveReply Order(std::uint16_t control);
  /// A stop order, repeated if need be.
  DriveReply StopOrder(std::uint16_t control);
  Status CheckParameters();
  Status GoTo(DriveState wanted, std::uint16_t control);
  Status ResetFault();
  /// After an order that failed or was not taken: the drive stops, or hears nothing more and stops by its heartbeat.
  void Abandon();
  /// Reads until the acknowledge bit is as wanted; if that takes too long, the axis is stopped.
  Status AwaitAcknowledge(DriveReply answer, std::uint16_t wanted, const char* attempted);
  Status StartMotion(std::uint16_t mode, std::uint16_t control, const char* attempted);
  Status CheckMove(Millimetres z, MillimetresPerSecond speed);
  Status AwaitStandstill();
  Status CheckDrive(const DriveAnswer& answer);
  [[nodiscard]] DriveState StateOf(const DriveAnswer& answer) const {
    return DriveStateOf(answer.registers.Word(map_.status_word));
  }
  /// What kind of trouble a drive that does not run is.
  [[nodiscard]] AxisTrouble TroubleOf(const DriveAnswer& answer) const {
    const bool stopped = IsStopInputFault(answer.registers.Word(map_.fault_code));
    return stopped ? AxisTrouble::kStopped : AxisTrouble::kDrive;
  }
  /// Its state, and the code of what keeps it from another, if it gives one.
  [[nodiscard]] std::string DriveText(const DriveAnswer& answer) const {
    const std::uint16_t code = answer.registers.Word(map_.fault_code);
    return std::string("'") + DriveStateText(StateOf(answer)) + "'" + (code != 0 ? ", " + AxisFaultText(code) : "");
  }
  AxisPosition Read(const DriveAnswer& answer);
  void ReadFlags(const DriveAnswer& answer, AxisPosition& position);
  Result<AxisPosition> ReadingFailed(const ModbusFailure& failure);

  DriveDialogue dialogue_;
  AxisRegisterMap map_;
  AxisRegisterMap::Block status_block_;
  AxisReadingDecoder reading_;
  Clock& clock_;
  ModbusAxisOptions options_;
  State state_ = State::kDisabled;
  AxisTrouble trouble_ = AxisTrouble::kNone;
  DriveParameters parameters_;
  AxisPosition last_;
  int failures_ = 0;          ///< Readings in a row without a good reply.
  bool homing_due_ = false;   ///< The link was lost: the drive's own "homed" does not count any more.
  bool homing_ = false;       ///< The last motion ordered was a homing run.
  bool home_sought_ = false;  ///< Of a drive without flags: the homing run is, or was, on its way.
  bool home_seen_ = false;    ///< Of a drive without flags: the homing run ended well.
};

Status ModbusScanAxis::Gate(const char* call, State required) {
  if (state_ == required) return {};
  return FailAs(AxisTrouble::kOrder, call,
                std::string("the axis is ") + StateText(state_) + ", it must be " + StateText(required),
                state_ == State::kDisabled ? "enable the axis first" : "disable the axis and enable it again");
}

DriveReply ModbusScanAxis::Order(std::uint16_t control) {
  // Never repeated: the drive may carry it out yet.
  DriveReply answer = dialogue_.Order(control);
  if (answer) return answer;
  // What spoiled the reply may have come before the order has even arrived: it is reported as failed only when the
  // drive's start window is over.
  clock_.SleepUntil(dialogue_.last_sent() + options_.reply_timeout);
  const bool unanswered = answer.error().fault == ModbusFault::kTimeout;
  if (unanswered) dialogue_.Close();
  if (state_ == State::kDisabled) return answer;
  state_ = State::kFault;
  if (!unanswered) Abandon();
  return answer;
}

DriveReply ModbusScanAxis::StopOrder(std::uint16_t control) {
  DriveReply answer = dialogue_.Order(control);
  for (int attempt = 1; !answer && attempt < kStopAttempts; ++attempt) {
    if (answer.error().fault == ModbusFault::kLinkLost) break;
    answer = dialogue_.Order(control);
  }
  if (!answer) dialogue_.Close();
  return answer;
}

Status ModbusScanAxis::CheckLine() const {
  using Milliseconds = std::chrono::duration<double, std::milli>;
  const nanoseconds needed = dialogue_.LongestWireTime() + kDriveTime;
  if (needed <= options_.reply_timeout) return {};
  return Fail("speak with the axis drive",
              "on this line a transaction takes " + std::to_string(std::lround(Milliseconds(needed).count())) +
                  " ms, more than the " + std::to_string(std::lround(Milliseconds(options_.reply_timeout).count())) +
                  " ms in which a drive must answer",
              "set a higher baud rate in the drive and as [axis] baud (38400 or more for the default register map)");
}

Status ModbusScanAxis::Identify() {
  // The program may have been restarted in mid-transaction: ReadAgain tries once more.
  const DriveReply answer = dialogue_.ReadAgain(map_.IdentityBlock());
  if (!answer) return NoReply("identify the axis drive", answer.error());
  trouble_ = AxisTrouble::kParameters;
  const DriveParameters read = ParseDriveParameters(answer->registers, map_);
  RETURN_IF_ERROR(CheckDriveParameters(read, options_));
  parameters_ = read;  // what is refused is nothing to compare with later
  return {};
}

Status ModbusScanAxis::CheckParameters() {
  const DriveReply answer = dialogue_.ReadAgain(map_.IdentityBlock());
  if (!answer) {
    if (state_ != State::kDisabled) state_ = State::kFault;
    return NoReply("check the axis drive's parameters", answer.error());
  }
  trouble_ = AxisTrouble::kParameters;
  return CheckUnchanged(parameters_, ParseDriveParameters(answer->registers, map_));
}

Status ModbusScanAxis::CheckDrive(const DriveAnswer& answer) {
  if (state_ == State::kDisabled) return {};  // a latched fault waits for Enable
  const DriveState drive = StateOf(answer);
  if (drive == DriveState::kFault || drive == DriveState::kFaultReaction) {
    state_ = State::kFault;
    return FailAs(TroubleOf(answer), "run the axis", AxisFaultText(answer.registers.Word(map_.fault_code)),
                  "clear the cause, then enable and home the axis again");
  }
  if (state_ == State::kEnabled && drive != DriveState::kOperationEnabled) {
    state_ = State::kFault;
    return FailAs(TroubleOf(answer), "run the axis", "the drive is in state " + DriveText(answer),
                  "check the safety chain and the drive's enable line, then enable the axis again");
  }
  return {};
}

Status ModbusScanAxis::GoTo(DriveState wanted, std::uint16_t control) {
  const std::string attempted = std::string("bring the axis drive to '") + DriveStateText(wanted) + "'";
  DriveReply answer = Order(control);
  const nanoseconds deadline = clock_.Now() + kStateDeadline;
  // A drive that is told to reset its fault still reports it until its next cycle.
  const bool resets = control == control_word::kFaultReset;
  while (true) {
    if (!answer) return NoReply(attempted, answer.error());
    const DriveState drive = StateOf(*answer);
    if (drive == wanted) return {};
    if ((drive == DriveState::kFault && !resets) || clock_.Now() >= deadline) {
      return FailAs(TroubleOf(*answer), attempted,
                    drive == DriveState::kFault ? AxisFaultText(answer->registers.Word(map_.fault_code))
                                                : "it stays in " + DriveText(*answer),
                    "check the safety chain and the drive's supply and enable line, then try again");
    }
    clock_.SleepUntil(clock_.Now() + kPollPause);
    answer = dialogue_.ReadAgain(status_block_);
  }
}

Status ModbusScanAxis::ResetFault() {
  const nanoseconds deadline = clock_.Now() + kStateDeadline;
  DriveState drive = DriveState::kFaultReaction;
  while (drive == DriveState::kFaultReaction && clock_.Now() < deadline) {
    const DriveReply answer = dialogue_.ReadAgain(status_block_);
    if (!answer) return NoReply("read the axis drive's state", answer.error());
    drive = StateOf(*answer);
    if (drive == DriveState::kFaultReaction) clock_.SleepUntil(clock_.Now() + kPollPause);
  }
  if (drive != DriveState::kFault) return {};
  // The drive resets on the rising edge of the bit.
  const DriveReply low = Order(control_word::kDisableVoltage);
  if (!low) return NoReply("reset the axis drive's fault", low.error());
  return GoTo(DriveState::kSwitchOnDisabled, control_word::kFaultReset);
}

Status ModbusScanAxis::Enable() {
  RETURN_IF_ERROR(Gate("enable the axis", State::kDisabled));
  RETURN_IF_ERROR(CheckParameters());
  // Never start from an old target: modes and set-points are written anew before the drive may move.
  dialogue_.ClearCommand();
  dialogue_.Set(map_.mode, kModeProfilePosition);
  RETURN_IF_ERROR(ResetFault());
  RETURN_IF_ERROR(GoTo(DriveState::kReadyToSwitchOn, control_word::kShutdown));
  RETURN_IF_ERROR(GoTo(DriveState::kSwitchedOn, control_word::kSwitchOn));
  RETURN_IF_ERROR(GoTo(DriveState::kOperationEnabled, control_word::kEnableOperation));
  state_ = State::kEnabled;
  failures_ = 0;
  return {};
}

void ModbusScanAxis::Abandon() {
  if (state_ != State::kDisabled) state_ = State::kFault;
  static_cast<void>(StopOrder(control_word::kQuickStop));
}

Status ModbusScanAxis::AwaitAcknowledge(DriveReply answer, std::uint16_t wanted, const char* attempted) {
  const nanoseconds deadline = clock_.Now() + kAcknowledgeDeadline;
  while (true) {
    if (!answer) {
      Abandon();
      return NoReply(attempted, answer.error());
    }
    RETURN_IF_ERROR(CheckDrive(*answer));
    if ((answer->registers.Word(map_.status_word) & status_word::kAcknowledge) == wanted) return {};
    if (clock_.Now() >= deadline) break;
    clock_.SleepUntil(clock_.Now() + kPollPause);
    answer = dialogue_.ReadAgain(status_block_);
  }
  Abandon();
  return FailAs(AxisTrouble::kDrive, attempted,
                wanted != 0 ? "the drive does not take the target" : "the drive still acknowledges an earlier target",
                "check the drive's state and limits, then disable the axis and enable it again");
}

Status ModbusScanAxis::StartMotion(std::uint16_t mode, std::uint16_t control, const char* attempted) {
  // The start bit down first: the drive wants to see it rise, and within its start window after a transaction. The mode
  // goes with it: a drive may need a cycle to change it.
  dialogue_.Set(map_.mode, mode);
  DriveReply answer = Order(control_word::kEnableOperation);
  if (!answer) return NoReply(attempted, answer.error());
  RETURN_IF_ERROR(CheckDrive(*answer));
  const bool handshake = mode == kModeProfilePosition;
  // What acknowledged the last target, or told the end of homing, must not be taken for an answer to this order.
  if (handshake) RETURN_IF_ERROR(AwaitAcknowledge(std::move(answer), 0, attempted));
  answer = Order(control);
  if (!answer) return NoReply(attempted, answer.error());
  RETURN_IF_ERROR(CheckDrive(*answer));
  homing_ = mode == kModeHoming;
  if (!handshake) return {};
  RETURN_IF_ERROR(AwaitAcknowledge(std::move(answer), status_word::kAcknowledge, attempted));
  // The set-point handshake: our bit back to 0, so that the next one is an edge again.
  answer = Order(static_cast<std::uint16_t>(control & ~control_word::kStart));
  if (!answer) return NoReply(attempted, answer.error());
  return CheckDrive(*answer);
}

Status ModbusScanAxis::StartHoming() {
  RETURN_IF_ERROR(Gate("home the axis", State::kEnabled));
  RETURN_IF_ERROR(CheckParameters());
  last_.homed = false;
  home_sought_ = home_seen_ = false;
  RETURN_IF_ERROR(StartMotion(kModeHoming, control_word::kEnableOperation | control_word::kStart, "home the axis"));
  homing_due_ = false;
  return {};
}

Status ModbusScanAxis::CheckMove(Millimetres z, MillimetresPerSecond speed) {
  trouble_ = AxisTrouble::kOrder;
  const char* attempted = "move the axis";
  if (!last_.homed) return Fail(attempted, "the axis is not homed", "home the axis first");
  const AxisLimits& limits = parameters_.identity.limits;
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
  return {};
}

Status ModbusScanAxis::MoveTo(Millimetres z, MillimetresPerSecond speed) {
  const char* attempted = "move the axis";
  RETURN_IF_ERROR(Gate(attempted, State::kEnabled));
  RETURN_IF_ERROR(CheckMove(z, speed));
  const auto target = DriveUnits(z.value(), map_.units_per_mm);
  const auto pace = DriveUnits(speed.value(), map_.units_per_mm_s);
  const auto ramp = DriveUnits(parameters_.identity.limits.max_acceleration.value(), map_.units_per_mm_s2);
  if (!target || !pace || !ramp) {
    return Fail(attempted, "in the drive's units the order has more than 32 bits", "correct the scales of the axis");
  }
  RETURN_IF_ERROR(CheckParameters());
  dialogue_.SetLong(map_.target_position, *target);
  dialogue_.SetLong(map_.profile_speed, *pace);
  dialogue_.SetLong(map_.profile_acceleration, *ramp);
  return StartMotion(kModeProfilePosition,
                     control_word::kEnableOperation | control_word::kStart | control_word::kChangeImmediately,
                     attempted);
}

void ModbusScanAxis::ReadFlags(const DriveAnswer& answer, AxisPosition& position) {
  const std::uint16_t word = answer.registers.Word(map_.status_word);
  position.target_reached = (word & status_word::kTargetReached) != 0;
  const DriveState drive = DriveStateOf(word);
  position.powered = drive == DriveState::kSwitchedOn || drive == DriveState::kOperationEnabled ||
                     drive == DriveState::kQuickStopActive;
  const bool faulty = drive == DriveState::kFault || drive == DriveState::kFaultReaction;
  position.fault_code = faulty ? answer.registers.Word(map_.fault_code) : std::uint16_t{0};
  if (map_.flags != kNoRegister) {
    const std::uint16_t flags = answer.registers.Word(map_.flags);
    position.homed = (flags & kAxisFlagHomed) != 0 && !homing_due_;
    position.moving = (flags & kAxisFlagMoving) != 0;
    return;
  }
  // CiA 402, homing mode: bits 10 and 12 together mean that the run ended well.
  const bool attained = position.target_reached && (word & status_word::kAcknowledge) != 0;
  // Both may be left over from a run before: only when they have been away does it count that they are there.
  if (homing_ && !attained) home_sought_ = true;
  if (homing_ && attained && home_sought_) home_seen_ = true;
  position.homed = home_seen_ && !homing_due_;
  const bool carried = std::abs(position.z.value() - last_.z.value()) > kStandstillMm;
  position.moving = carried || (state_ == State::kEnabled && !position.target_reached);
}

AxisPosition ModbusScanAxis::Read(const DriveAnswer& answer) {
  AxisPosition position;
  position.fresh = true;
  const AxisReading reading = reading_.Decode(answer.registers);
  position.z = reading.z;
  position.time = {answer.host_before, reading.drive_time.value_or((answer.host_before + answer.host_after) / 2),
                   answer.host_after};
  ReadFlags(answer, position);
  return position;
}

Result<AxisPosition> ModbusScanAxis::ReadingFailed(const ModbusFailure& failure) {
  ++failures_;
  last_.fresh = false;
  const bool busy = failure.fault == ModbusFault::kException && failure.exception_code == 6;
  if (failure.fault != ModbusFault::kLinkLost && failures_ <= (busy ? kBusyReadings : kSilentReadings)) return last_;
  if (state_ != State::kDisabled) state_ = State::kFault;
  if (failure.fault == ModbusFault::kLinkLost) homing_due_ = true;
  return NoReply("read the axis' position", failure);
}

Result<AxisPosition> ModbusScanAxis::Position() {
  // In kFault the drive may still be on its way, and each reading would keep its heartbeat alive, also one whose reply
  // is spoiled. So it goes out with a stop.
  const DriveReply answer =
      state_ == State::kFault ? dialogue_.Order(control_word::kQuickStop) : dialogue_.Read(status_block_);
  if (!answer) return ReadingFailed(answer.error());
  failures_ = 0;
  last_ = Read(*answer);
  RETURN_IF_ERROR(CheckDrive(*answer));
  if (state_ == State::kEnabled && (answer->registers.Word(map_.status_word) & status_word::kModeError) != 0) {
    return FailAs(AxisTrouble::kDrive, "run the axis", "the drive reports a homing or following error",
                  "look for an obstacle, check the home switch, then home the axis again");
  }
  return last_;
}

Status ModbusScanAxis::AwaitStandstill() {
  const nanoseconds deadline = clock_.Now() + kQuickStopDeadline;
  nanoseconds moved = clock_.Now();
  const nanoseconds rest = map_.flags == kNoRegister ? kStandstillTime : nanoseconds(0);
  while (true) {
    const DriveReply answer = dialogue_.Read(status_block_);
    if (answer) {
      last_ = Read(*answer);
      if (last_.moving) moved = clock_.Now();
      if (!last_.moving && clock_.Now() - moved >= rest) return {};
    }
    if (clock_.Now() >= deadline) {
      trouble_ = answer ? AxisTrouble::kDrive : AxisTrouble::kLink;
      return Fail("stop the axis", answer ? "it still moves" : ModbusFailureText(answer.error()),
                  "press the emergency stop");
    }
    clock_.SleepUntil(clock_.Now() + kPollPause);
  }
}

Status ModbusScanAxis::Halt() {
  RETURN_IF_ERROR(Gate("halt the axis", State::kEnabled));
  const DriveReply answer = Order(control_word::kEnableOperation | control_word::kHalt);
  if (!answer) return NoReply("halt the axis", answer.error());
  return CheckDrive(*answer);
}

Status ModbusScanAxis::QuickStop() {
  const DriveReply answer = StopOrder(control_word::kQuickStop);
  if (state_ != State::kDisabled) state_ = State::kStopped;
  if (!answer)
    return FailAs(AxisTrouble::kLink, "quick-stop the axis", ModbusFailureText(answer.error()),
                  "press the emergency stop");
  return AwaitStandstill();
}

Status ModbusScanAxis::Disable() {
  DriveReply answer = StopOrder(control_word::kDisableVoltage);
  state_ = State::kDisabled;
  const nanoseconds deadline = clock_.Now() + kStateDeadline;
  while (true) {
    if (!answer)
      return FailAs(AxisTrouble::kLink, "disable the axis", ModbusFailureText(answer.error()),
                    "press the emergency stop");
    const DriveState drive = StateOf(*answer);
    if (drive == DriveState::kSwitchOnDisabled || drive == DriveState::kFault || drive == DriveState::kFaultReaction) {
      return {};
    }
    if (clock_.Now() >= deadline) {
      return FailAs(AxisTrouble::kDrive, "disable the axis",
                    std::string("the drive stays in '") + DriveStateText(drive) + "'", "press the emergency stop");
    }
    clock_.SleepUntil(clock_.Now() + kPollPause);
    answer = dialogue_.ReadAgain(status_block_);
  }
}

Status ModbusScanAxis::Reopen(nanoseconds deadline) {
  state_ = State::kDisabled;
  last_ = {};
  homing_due_ = true;
  home_seen_ = false;
  failures_ = 0;
  dialogue_.ClearCommand();
  nanoseconds pause = kFirstPause;
  while (true) {
    Status again;
    if (const auto opened = dialogue_.Reopen(); !opened) {
      again = NoReply("open the link to the axis drive", opened.error());
    } else {
      again = Identify();
      // It may still be enabled, or even move: our questions alone would keep its heartbeat alive.
      if (again) again = Disable();
    }
    if (again || clock_.Now() >= deadline) return again;
    clock_.SleepUntil(std::min(deadline, clock_.Now() + pause));
    pause = std::min(2 * pause, kLongestPause);
  }
}

}  // namespace

Result<std::unique_ptr<ScanAxis>> MakeModbusScanAxis(ModbusLink& link, const AxisRegisterMap& map, Clock& clock,
                                                     ModbusAxisOptions options) {
  RETURN_IF_ERROR(CheckRegisterMap(map));
  auto axis = std::make_unique<ModbusScanAxis>(link, map, clock, options);
  RETURN_IF_ERROR(axis->CheckLine());
  RETURN_IF_ERROR(axis->Identify());
  return axis;
}

}  // namespace annulus
