#include "tests/faults/fault_rig.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <utility>

#include "tests/acquisition/scanner_rig.h"
#include "tests/support/folders.h"

namespace annulus::faults {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

namespace {

/// From the end of one process until the next one has opened its devices.
constexpr milliseconds kProcessStart{150};
/// So that the wall clock may be set back.
constexpr std::chrono::hours kSinceTheClockWasSane{24 * 365 * 20};

}  // namespace

std::string InMs(nanoseconds time) { return std::to_string(time / milliseconds(1)) + " ms"; }

sim::FaultPlan PlanOfRow(const std::string& row) {
  const std::string path = test::SourceFolder() + "/tests/faults/plans/" + row + ".json";
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::stringstream text;
  text << file.rdbuf();
  auto plan = sim::ParseFaultPlan(text.str(), path);
  EXPECT_TRUE(plan) << plan.error().Text();
  return plan ? *plan : sim::FaultPlan{};
}

FaultRigOptions FaultRig::Defaults() {
  FaultRigOptions options;
  options.booth = ScannerRig::Options();
  return options;
}

FaultRigOptions FaultRig::With(const std::string& row) {
  FaultRigOptions options = Defaults();
  options.plan = PlanOfRow(row);
  return options;
}

FaultRigOptions FaultRig::OnCan(const std::string& row) {
  FaultRigOptions options = With(row);
  options.booth.can_buses = 1;
  options.bus = RingBus::kCan;
  return options;
}

std::uint64_t FaultRig::WholeScan() { return ScannerRig::ShortPlan().TotalLevels(); }

FaultRig::FaultRig(FaultRigOptions options)
    : options_(std::move(options)),
      booth_(std::move(options_.booth), clock_),
      injector_(options_.plan, booth_, clock_, {options_.link}) {
  wall_.JumpWall(kSinceTheClockWasSane);
  clock_.Start([this] { Tick(); });
  ticking_ = false;
  opened_ = Open();
  if (options_.opens && !opened_) ADD_FAILURE() << opened_.message();
}

FaultRig::~FaultRig() {
  ticking_ = false;
  watch_.Watch(nullptr);
  EndWorker();
  scanner_.reset();
}

Result<std::unique_ptr<RangeRing>> FaultRig::OpenRing() {
  return options_.bus == RingBus::kUsb ? OpenUsbRangeRing(injector_.usb_host(), {}, worker_clock_)
                                       : MakeCanRangeRing(injector_.can_buses(), {}, worker_clock_);
}

testing::AssertionResult FaultRig::Open() {
  life_ = {};
  injector_.Revive();
  if (!wraps_ports_) {
    wraps_ports_ = true;
    auto& wrap = injector_.usb_host_model().wrap;
    wrap = [inner = wrap](std::unique_ptr<UsbPort> port) -> std::unique_ptr<UsbPort> {
      if (inner) port = inner(std::move(port));
      return std::make_unique<OutsidePort>(std::move(port));
    };
  }
  auto ring = OpenRing();
  if (!ring) return testing::AssertionFailure() << ring.error().Text();
  ring_ = std::move(*ring);
  // A new program opens the port anew; without its adapter it would be started again and again.
  const nanoseconds patience = wall_.Now() + std::chrono::seconds(10);
  while (!watched_link_.Reopen() && wall_.Now() < patience) wall_.SleepUntil(wall_.Now() + milliseconds(100));
  auto axis = MakeModbusScanAxis(watched_link_, {}, worker_clock_);
  if (!axis) return testing::AssertionFailure() << axis.error().Text();
  axis_ = std::move(*axis);
  auto lines = booth_.safety().Request({}, InterlockWiring::Default().Lines());
  if (!lines) return testing::AssertionFailure() << lines.error().Text();
  auto interlock =
      MakeInterlock(std::make_unique<MortalLines>(injector_.WrapLines(std::move(*lines)), life_, watch_), wall_);
  if (!interlock) return testing::AssertionFailure() << interlock.error().Text();
  interlock_ = std::move(*interlock);
  ScannerOptions scanner_options = options_.scanner;
  scanner_options.on_level = [this, told = options_.scanner.on_level](const ScanLevel& level) {
    const ProgramScope scope(ProgramScope::Code::kOther);
    injector_.NoteLevel(levels_[recording_]++);
    if (told) told(level);
  };
  if (!scanner_options.host_checks) {
    scanner_options.host_checks = [this] {
      std::vector<ArmCheck> checks;
      checks.push_back(
          {"temperature", hot_ ? Fail("arm a scan", "the computer is too hot", "let it cool down") : Status{}});
      return checks;
    };
  }
  scanner_ = std::make_unique<Scanner>(ScannerDevices{*ring_, *axis_, *interlock_, worker_clock_},
                                       options_.gate != nullptr ? *options_.gate : gate_, disk_, wall_,
                                       std::move(scanner_options));
  begun_ = scanner_->Begin();
  watch_.Watch(scanner_.get());
  ticking_ = true;
  worker_ = std::make_unique<Baton>([this] { Work(); });
  return testing::AssertionSuccess();
}

// --- time ---

void FaultRig::Tick() {
  const ProgramScope scope(ProgramScope::Code::kOther);
  const nanoseconds now = clock_.Now();
  // After a hang the clock's ticks of meanwhile come all at once; a control loop leaves them out.
  if (now == last_tick_) return;
  last_tick_ = now;
  injector_.NoteState(scanner_ ? ScanStateText(state()) : "SAFE");
  FollowHost();
  if (on_tick) on_tick();
  if (hang_ > nanoseconds(0)) {
    watch_.Interrupted();
    clock_.SleepUntil(now + std::exchange(hang_, nanoseconds(0)));
    watch_.Interrupted();
    last_tick_ = clock_.Now();
  }
  watch_.BeforeTick();
  const bool skipped = skipped_ticks_ > 0 && skipped_ticks_-- > 0;
  if (life_.alive && ticking_ && !skipped && clock_.Now() >= late_until_) {
    {
      const ProgramScope in_the_program(ProgramScope::Code::kProgram);
      scanner_->Tick();
    }
    watch_.AfterTick();
  } else {
    watch_.WithoutTick();
  }
  LookWhetherDone();
}

void FaultRig::FollowHost() {
  sim::HostCondition host = injector_.host();
  if (host.killed && life_.alive) Kill();
  if (host.hangs) watch_.Interrupted();
  for (; host.hangs; host = injector_.host()) clock_.SleepUntil(clock_.Now() + milliseconds(10));
  if (host.late > nanoseconds(0)) DelayTicks(host.late);
  if (host.dead_thread(sim::HostThread::kWorker)) KillWorker();
  if (host.dead_thread(sim::HostThread::kControl)) KillControl();
  hot_ = host.hot;
  if (clock_.Now() > last_tick_) {
    watch_.Interrupted();
    last_tick_ = clock_.Now();
  }
}

std::optional<nanoseconds> FaultRig::fault_time() const {
  for (const sim::FaultEvent& event : injector_.log()) {
    if (event.begins) return event.time;
  }
  return std::nullopt;
}

void FaultRig::Work() {
  mortal_.Begin();
  injector_.SimulateHere();
  try {
    while (life_.alive && life_.worker_alive) {
      {
        const ProgramScope scope(ProgramScope::Code::kProgram);
        scanner_->Step();
      }
      LookWhetherDone();
    }
  } catch (const WorkerEnded&) {
    // Its thread is gone, and so is what it was doing.
  }
  mortal_.End();
}

void FaultRig::EndWorker() {
  life_.worker_alive = false;
  done_ = {};
  if (worker_) worker_->Resume();
  worker_.reset();
}

void FaultRig::LookWhetherDone() {
  if (!done_ || !worker_ || !worker_->IsSecond()) return;
  came_ = done_();
  if (came_ || clock_.Now() >= patience_ends_) worker_->Yield();
}

bool FaultRig::RunUntil(const std::function<bool()>& done, nanoseconds patience) {
  patience_ends_ = clock_.Now() + patience;
  came_ = done();
  if (came_) return true;
  done_ = done;
  if (worker_ && !worker_->ended()) worker_->Resume();
  // Without a worker time goes on all the same.
  while (!came_ && clock_.Now() < patience_ends_) {
    clock_.SleepUntil(clock_.Now() + milliseconds(10));
    came_ = done();
  }
  done_ = {};
  return came_;
}

bool FaultRig::RunUntil(ScanState wanted, nanoseconds patience) {
  return RunUntil([&] { return state() == wanted; }, patience);
}

void FaultRig::Pass(nanoseconds time) {
  const nanoseconds end = clock_.Now() + time;
  static_cast<void>(RunUntil([&] { return clock_.Now() >= end; }, time + seconds(200)));
}

// --- people ---

void FaultRig::PressReset() {
  booth_.safety().PressResetAt(clock_.Now());
  watch_.Note(HumanAct::kReset);
}

Status FaultRig::Home() {
  watch_.Note(HumanAct::kHome);
  return scanner_->OrderHome();
}

ArmRequest FaultRig::Request() {
  ArmRequest request;
  request.plan = ScannerRig::ShortPlan();
  request.out = recording_;
  request.header.station_id = "sim";
  request.header.ring_radius_mm = 600.0;
  request.header.calibration = options_.calibration;
  return request;
}

Status FaultRig::Arm() { return scanner_->OrderArm(Request()); }

Status FaultRig::Start() {
  watch_.Note(HumanAct::kStart);
  return scanner_->OrderStart(scanner_->status().version);
}

Status FaultRig::Acknowledge(CauseRole role) {
  watch_.Note(HumanAct::kAcknowledge);
  return scanner_->Acknowledge(role);
}

Status FaultRig::Jog(Scanner::JogDirection direction) {
  watch_.Note(HumanAct::kJog);
  return scanner_->Jog(direction);
}

/// One thing that an operator does, looking at the status; then nothing for a while.
void FaultRig::Act() {
  if (!life_.alive || clock_.Now() < next_act_) return;
  const ScannerStatus seen = scanner_->status();
  next_act_ = clock_.Now() + milliseconds(50);
  if (!seen.job.empty()) return;
  switch (seen.state) {
    case ScanState::kSafe:
      if (resets_left_ <= 0) return;
      --resets_left_;
      PressReset();
      next_act_ = clock_.Now() + milliseconds(500);
      return;
    case ScanState::kIdle:
      if (levels_[recording_] > 0) return;  // has taken it
      static_cast<void>(seen.homed ? Arm() : Home());
      return;
    case ScanState::kArmed:
      static_cast<void>(Start());
      return;
    default:
      return;
  }
}

bool FaultRig::Operate(const std::function<bool()>& done, nanoseconds patience, int resets) {
  resets_left_ = resets;
  next_act_ = clock_.Now() + milliseconds(50);
  return RunUntil(
      [&] {
        if (done()) return true;
        Act();
        return false;
      },
      patience);
}

bool FaultRig::BringTo(ScanState wanted) {
  const auto there = [&] { return state() == wanted; };
  switch (wanted) {
    case ScanState::kSafe:
      Pass(milliseconds(50));
      return there();
    case ScanState::kIdle:
    case ScanState::kHoming:
    case ScanState::kArmed:
    case ScanState::kScanning:
      return Operate(there);
    case ScanState::kStopping:
      if (!Operate([&] { return levels_[recording_] >= 5; })) return false;
      return Cancel() && RunUntil(wanted, milliseconds(50));
    case ScanState::kFault:
      if (!Operate([&] { return levels_[recording_] >= 5; })) return false;
      booth_.drive().Suffer({sim::AxisMishapKind::kDriveFault, clock_.Now(), nanoseconds::max(), 0.0, 0x7121});
      return RunUntil(wanted, seconds(2)) && RunUntil([&] { return status().job.empty(); }, seconds(2));
    case ScanState::kJog:
      if (!Operate([&] { return state() == ScanState::kIdle && status().homed && status().job.empty(); })) return false;
      return Jog(Scanner::JogDirection::kDown) && RunUntil(wanted, milliseconds(50));
  }
  return false;
}

std::string FaultRig::NextScan() {
  recording_ = "next.mcap";
  levels_[recording_] = 0;
  // Drop-out times of relays, and a worker that still waits for a drive or looks for devices.
  Pass(milliseconds(700));
  if (!RunUntil([&] { return status().job.empty(); }, seconds(10))) return "the job does not end: " + Told();
  const std::uint64_t before = status().scan ? status().scan->number : 0;
  const nanoseconds end = clock_.Now() + seconds(60);
  while (state() == ScanState::kSafe || state() == ScanState::kFault || state() == ScanState::kStopping) {
    if (clock_.Now() >= end) return "the fault could not be ended: " + Told();
    if (state() == ScanState::kFault) static_cast<void>(Acknowledge(CauseRole::kService));
    if (state() == ScanState::kSafe) {
      static_cast<void>(Acknowledge(CauseRole::kService));
      Pass(milliseconds(50));
      PressReset();
    }
    Pass(milliseconds(600));
  }
  const auto ended = [&] {
    const ScannerStatus seen = status();
    return seen.scan && seen.scan->number > before && seen.state != ScanState::kScanning &&
           seen.state != ScanState::kStopping;
  };
  if (!Operate(ended, seconds(60), 0)) return "the next scan did not end: " + Told();
  const ScanResult scan = *status().scan;
  if (!scan.status || !scan.complete) return "the next scan failed: " + Told();
  const auto file = ReadWholeRecording(storage_, recording_);
  if (!file) return file.error().Text();
  if (!file->report.clean() || file->scan.levels.size() != WholeScan()) return "the next scan's file is not whole";
  return "";
}

// --- the host ---

void FaultRig::HangWorkerFirst(nanoseconds time) {
  // The control thread is scheduled a few milliseconds after the worker.
  mortal_.Stall(time, [this, time] {
    watch_.Interrupted();
    late_until_ = clock_.Now() + time + milliseconds(5);
  });
}

void FaultRig::Kill() {
  life_.alive = false;
  was_killed_ = true;
  watch_.Watch(nullptr);
}

testing::AssertionResult FaultRig::Restart() {
  watch_.Watch(nullptr);
  ticking_ = false;
  EndWorker();
  scanner_.reset();
  interlock_.reset();
  axis_.reset();
  ring_.reset();
  clock_.SleepUntil(clock_.Now() + kProcessStart);
  return Open();
}

std::string FaultRig::Told() const {
  const ScannerStatus seen = scanner_->status();
  std::string text =
      std::string(ScanStateText(seen.state)) + ", job '" + seen.job + "', held by '" + seen.held_by + "'";
  for (const ScanCause& cause : seen.causes)
    text += "\n  " + std::string(TraitsOf(cause.code).name) + ": " + cause.text;
  for (const InterlockNotice& notice : seen.chain) text += "\n  chain: " + notice.text;
  for (const ScanWarning& warning : seen.warnings) text += "\n  warning: " + warning.text;
  if (seen.arm) {
    for (const ArmCheck& check : seen.arm->checks) {
      if (!check.result) text += "\n  " + check.name + ": " + check.result.error().Text();
    }
  }
  if (seen.scan && !seen.scan->status) text += "\n  scan: " + seen.scan->status.error().Text();
  return text + watch_.Text();
}

}  // namespace annulus::faults
