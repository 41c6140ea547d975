#include "acquisition/scanner.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "acquisition/scanner_state.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr std::chrono::milliseconds kKeyReleased{300};  ///< Without a call for so long a jog key is not held any more.
constexpr std::size_t kMostNotes = 10'000;
constexpr std::size_t kMostWarnings = 20;

}  // namespace

Scanner::State::State(ScannerDevices given, ScanGate& the_gate, Storage& the_storage, Clock& the_clock,
                      ScannerOptions the_options)
    : devices(given),
      gate(the_gate),
      storage(the_storage),
      clock(the_clock),
      options(std::move(the_options)),
      axis(devices.axis, *this, devices.clock),
      ring(devices.ring, *this, devices.clock) {
  devices.clock.OnBeat([this] {
    const std::scoped_lock lock(mutex);
    beat = clock.Now();
  });
}

ScanState Scanner::State::state() const {
  const std::scoped_lock lock(mutex);
  return machine.state();
}

// --- events ---

void Scanner::State::NoteLocked(nanoseconds time, std::string text) {
  if (notes.size() == kMostNotes) notes.pop_front();
  notes.emplace_back(time, std::move(text));
}

void Scanner::State::NoteChangeLocked(const ScanEvent& event, ScanState before, std::size_t causes) {
  for (std::size_t i = causes; i < machine.causes().size(); ++i) {
    const ScanCause& cause = machine.causes()[i];
    NoteLocked(cause.time, std::string("cause ") + TraitsOf(cause.code).name + ": " + cause.text);
  }
  const ScanState after = machine.state();
  if (after == before) return;
  NoteLocked(event.time, std::string(ScanStateText(before)) + " -> " + ScanStateText(after) + " (" +
                             ScanEventText(event.kind) + ")");
}

void Scanner::State::Warn(ScanWarning warning) {
  const std::scoped_lock lock(mutex);
  if (std::find(warnings.begin(), warnings.end(), warning) != warnings.end()) return;
  if (warnings.size() == kMostWarnings) warnings.erase(warnings.begin());
  NoteLocked(clock.Now(), "warning: " + warning.text);
  warnings.push_back(std::move(warning));
}

Status Scanner::State::Handle(const ScanEvent& event) {
  const std::scoped_lock lock(mutex);
  return HandleLocked(event);
}

Status Scanner::State::HandleLocked(const ScanEvent& event) {
  const ScanState before = machine.state();
  const std::size_t causes = machine.causes().size();
  RETURN_IF_ERROR(machine.Handle(event));
  const ScanState after = machine.state();
  if (after != before && !machine.may_move() && after != ScanState::kArmed) job_stop.request_stop();
  try {
    NoteChangeLocked(event, before, causes);
  } catch (const std::bad_alloc&) {
    // The change counts, and whoever asked for it goes on; the log has a gap.
  }
  return {};
}

void Scanner::State::Fault(const ScanCause& cause) {
  ScanEvent event;
  event.kind = ScanEventKind::kFaulted;
  event.time = clock.Now();  // not the worker's: looking at that is a sign of life, and the control thread faults, too
  event.cause = cause;
  const std::scoped_lock lock(mutex);
  switch (cause.code) {
    case CauseCode::kAxisLink:
    case CauseCode::kSensorLost:
    case CauseCode::kSensorBus:
    case CauseCode::kSensorData:
    case CauseCode::kRingIdentity:
      device_lost = true;
      break;
    default:
      break;
  }
  if (ticked) JudgeGapLocked(event.time - *ticked, event.time);
  static_cast<void>(HandleLocked(event));  // a fault is never refused
}

// --- orders ---

const char* Scanner::State::JobText(Job job) {
  switch (job) {
    case Job::kHome:
      return "home";
    case Job::kArm:
      return "arm";
    case Job::kScan:
      return "scan";
    case Job::kJog:
      return "jog";
    case Job::kRecover:
      return "recover";
    case Job::kNone:
      break;
  }
  return "";
}

Status Scanner::State::Order(Job job, const ScanEvent& event) {
  const std::scoped_lock lock(mutex);
  RETURN_IF_ERROR(machine.MayOrder(event.kind));
  if (!relay_tested) return relay_tested;  // nothing stops the machine if the program dies
  if (order != Job::kNone || running != Job::kNone) {
    return Fail(ScanOrderText(event.kind), std::string("the booth still does something: ") + JobText(running),
                "wait a moment, then try again");
  }
  job_stop = std::stop_source();
  RETURN_IF_ERROR(HandleLocked(event));
  order = job;
  return {};
}

Status Scanner::State::OrderArm(ArmRequest the_request) {
  const std::scoped_lock lock(mutex);
  if (machine.state() != ScanState::kIdle && machine.state() != ScanState::kArmed) {
    RETURN_IF_ERROR(machine.MayOrder(ScanEventKind::kArmed));
  }
  if (order != Job::kNone || running != Job::kNone) {
    return Fail("arm a scan", std::string("the booth still does something: ") + JobText(running),
                "wait a moment, then try again");
  }
  job_stop = std::stop_source();
  request = std::move(the_request);
  arm_report.reset();
  order = Job::kArm;
  return {};
}

Status Scanner::State::OrderJog(JogDirection direction) {
  const nanoseconds now = clock.Now();
  {
    const std::scoped_lock lock(mutex);
    const bool held = last_jog_call && now - *last_jog_call < kKeyReleased;
    last_jog_call = now;
    if (held && machine.state() != ScanState::kJog) {
      return Fail("jog the axis", "the key was already held when the axis stopped",
                  "let go of it, then press it again");
    }
    if (machine.state() == ScanState::kJog) {
      if (direction != jog_direction) {
        return Fail("jog the axis", "it moves the other way", "let go of the key first");
      }
      machine.JogBeat(now);
      return {};
    }
    if (machine.state() == ScanState::kIdle && !machine.homed()) {
      return Fail("jog the axis", "it is not homed", "home it first");
    }
    if (order == Job::kNone && running == Job::kNone) jog_direction = direction;
  }
  ScanEvent event;
  event.kind = ScanEventKind::kJogOrdered;
  event.time = now;
  return Order(Job::kJog, event);
}

Status Scanner::State::Cancel(const ScanEvent& event) {
  const std::scoped_lock lock(mutex);
  // The machine is still IDLE while the checks before ARMED are made.
  if (order == Job::kArm || running == Job::kArm) job_stop.request_stop();
  return HandleLocked(event);
}

Status Scanner::State::Acknowledge(CauseRole role) {
  const std::scoped_lock lock(mutex);
  if (machine.state() == ScanState::kSafe && role == CauseRole::kService) {
    chain_acknowledged = true;  // the control thread tells the interlock
    return {};
  }
  ScanEvent event;
  event.kind = ScanEventKind::kAcknowledged;
  event.time = clock.Now();
  event.role = role;
  ScanMachine trial = machine;
  RETURN_IF_ERROR(trial.Handle(event));
  if (order != Job::kNone || running != Job::kNone) {
    return Fail("acknowledge the fault", "the devices are still being looked for", "wait a moment, then try again");
  }
  job_stop = std::stop_source();
  order = Job::kRecover;
  acknowledged_causes = machine.causes().size();
  request.reset();
  return {};
}

// --- status ---

ScannerStatus Scanner::State::Report() const {
  const std::scoped_lock lock(mutex);
  ScannerStatus status;
  status.state = machine.state();
  status.version = machine.version();
  status.homed = machine.homed();
  status.causes = machine.causes();
  status.held_by = reading.held_by;
  status.chain = notices;
  status.lines = last_lines;
  status.warnings = warnings;
  if (reference_lost) status.warnings.push_back(*reference_lost);
  if (far_temperature) status.warnings.push_back(*far_temperature);
  status.job = JobText(running != Job::kNone ? running : order);
  status.stage = stage;
  status.done = done;
  status.total = total;
  status.z_mm = position.z.value();
  status.start_presses = start_presses;
  status.start_agreed = machine.state() == ScanState::kArmed && start_presses > 0 &&
                        start_version == machine.version() && clock.Now() - start_pressed_at <= scan_time::kStartAgreed;
  status.quality = live;
  status.arm = arm_report;
  status.scan = result;
  status.longest_tick = longest_tick;
  return status;
}

// --- the public face ---

Scanner::Scanner(ScannerDevices devices, ScanGate& gate, Storage& storage, Clock& clock, ScannerOptions options)
    : state_(std::make_unique<State>(devices, gate, storage, clock, std::move(options))) {}

Scanner::~Scanner() { state_->devices.clock.OnBeat({}); }

Status Scanner::OrderHome() {
  ScanEvent event;
  event.kind = ScanEventKind::kHomeOrdered;
  event.time = state_->clock.Now();
  return state_->Order(State::Job::kHome, event);
}

Status Scanner::OrderArm(ArmRequest request) { return state_->OrderArm(std::move(request)); }

Status Scanner::OrderStart(std::uint64_t version) {
  ScanEvent event;
  event.kind = ScanEventKind::kStarted;
  event.time = state_->clock.Now();
  event.version = version;
  {
    const std::scoped_lock lock(state_->mutex);
    if (state_->armed_longest > nanoseconds(0)) event.longest = state_->armed_longest;
  }
  return state_->Order(State::Job::kScan, event);
}

Status Scanner::Cancel() {
  ScanEvent event;
  event.kind = ScanEventKind::kCancelled;
  event.time = state_->clock.Now();
  return state_->Cancel(event);
}

Status Scanner::Acknowledge(CauseRole role) { return state_->Acknowledge(role); }
Status Scanner::Jog(JogDirection direction) { return state_->OrderJog(direction); }
ScannerStatus Scanner::status() const { return state_->Report(); }

Status Scanner::Begin() {
  const auto measured = TestWatchdogRelay(state_->devices.interlock, state_->clock);
  Status tested = measured ? Status{} : Fail(measured);
  const std::scoped_lock lock(state_->mutex);
  state_->relay_tested = tested;
  return tested;
}

void Scanner::Tick() {
  try {
    state_->Tick();
  } catch (const std::bad_alloc&) {
    state_->BreakTick(CauseCode::kMemory);
  } catch (const std::exception&) {
    state_->BreakTick(CauseCode::kInternal);
  }
}
void Scanner::Step() { state_->Step(); }

}  // namespace annulus
