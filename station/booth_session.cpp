#include "station/booth_session.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <unistd.h>

#include <cstring>
#include <utility>

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr int kControlPriority = 80;
constexpr milliseconds kPress{600};  ///< Between two presses of an automatic operator.
constexpr std::chrono::seconds kStopPatience{3};

bool Rests(ScanState state) {
  return state == ScanState::kSafe || state == ScanState::kIdle || state == ScanState::kFault;
}

}  // namespace

Result<std::unique_ptr<BoothSession>> BoothSession::Open(const Config& config, ScanGate& gate, Storage& storage,
                                                         BoothSessionOptions options) {
  std::unique_ptr<BoothSession> session(new BoothSession);
  auto ground = DeviceGround::Make(config, storage, options.pace);
  if (!ground) return Fail(ground);
  session->ground_ = std::move(*ground);
  session->pace_ = session->ground_->virtual_time() == nullptr ? Pace::kRealTime : options.pace;
  // First of all: the lines are for one program only, and a second one must not even look at ring and axis.
  auto interlock = OpenInterlock(config.interlock, *session->ground_);
  if (!interlock) return Fail(interlock);
  session->interlock_ = std::move(*interlock);
  auto ring = OpenRing(config.ring, *session->ground_, &session->tap_);
  if (!ring) return Fail(ring);
  session->ring_ = std::move(*ring);
  auto axis = OpenAxis(config.axis, *session->ground_, &session->tap_);
  if (!axis) return Fail(axis);
  session->axis_ = std::move(*axis);
  session->tap_.EndPrelude();
  if (config.interlock.simulated) session->operator_ = options.sim_operator;
  Storage& disk = session->ground_->faults() == nullptr ? storage : session->ground_->faults()->WrapStorage(storage);
  options.scanner.on_level = [raw = session.get(), told = std::move(options.scanner.on_level)](const ScanLevel& level) {
    if (sim::FaultInjector* faults = raw->ground_->faults()) faults->NoteLevel(raw->levels_++);
    if (told) told(level);
  };
  // In virtual time the disk is waited for: what a recording holds must not depend on how fast the computer is.
  if (session->ground_->virtual_time() == nullptr) options.scanner.recording.disk = DiskWriterMode::kThread;
  session->scanner_ =
      std::make_unique<Scanner>(ScannerDevices{*session->ring_.ring, *session->axis_.axis, *session->interlock_,
                                               session->ground_->worker_clock(), &session->tap_},
                                gate, disk, session->ground_->clock(), std::move(options.scanner));
  // A relay that does not drop is told by the checks before a scan, too: the booth may still be looked at.
  static_cast<void>(session->scanner_->Begin());
  if (InterleavedClock* time = session->ground_->virtual_time()) {
    time->Start([raw = session.get()] { raw->Tick(); });
  }
  session->StartThreads();
  return session;
}

BoothSession::~BoothSession() {
  if (scanner_ == nullptr) return;
  static_cast<void>(scanner_->Cancel());
  static_cast<void>(
      RunUntil([](const ScannerStatus& status) { return Rests(status.state) && status.job.empty(); }, kStopPatience));
  worker_.request_stop();
  if (worker_.joinable()) worker_.join();
  control_.request_stop();
  if (control_.joinable()) control_.join();
  if (InterleavedClock* time = ground_->virtual_time()) time->Start({});
  scanner_.reset();
}

void BoothSession::StartThreads() {
  if (pace_ == Pace::kAsFastAsPossible) return;
  if (pace_ == Pace::kPaced) {
    worker_ = std::jthread([this](const std::stop_token& stop) { RunPaced(stop); });
    return;
  }
  control_ = std::jthread([this](const std::stop_token& stop) { RunControl(stop); });
  worker_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) scanner_->Step();
  });
}

void BoothSession::RunPaced(const std::stop_token& stop) {
  while (!stop.stop_requested() && !killed_) Work();
  // By the plan: as if somebody had, with whoever serves this booth.
  if (killed_) static_cast<void>(kill(getpid(), SIGKILL));
}

void BoothSession::Work() {
  if (!worker_dead_) return scanner_->Step();
  Clock& clock = ground_->clock();
  clock.SleepUntil(clock.Now() + scan_time::kTick);
}

void BoothSession::RunControl(const std::stop_token& stop) {
  sched_param parameters{};
  parameters.sched_priority = kControlPriority;
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); error != 0) {
    const std::scoped_lock lock(note_mutex_);
    scheduling_note_ = std::string("real-time priority: ") + std::strerror(error);
  }
  Clock& clock = ground_->clock();
  nanoseconds next = clock.Now();
  while (!stop.stop_requested()) {
    Tick();
    next += scan_time::kTick;
    // After a gap the beats go on from now: they must not come too fast for the watchdog relay.
    if (const nanoseconds now = clock.Now(); next < now) next = now + scan_time::kTick;
    clock.SleepUntil(next);
  }
}

void BoothSession::Tick() {
  if (sim::FaultInjector* faults = ground_->faults()) {
    faults->NoteState(ScanStateText(scanner_->status().state));
    const sim::HostCondition host = faults->host();
    killed_ = killed_ || host.killed;
    const nanoseconds now = ground_->clock().Now();
    if (host.late > nanoseconds(0)) late_until_ = std::max(late_until_, now + host.late);
    stalled_ = host.hangs || killed_;
    worker_dead_ = stalled_ || host.dead_thread(sim::HostThread::kWorker);
    if (stalled_ || now < late_until_ || host.dead_thread(sim::HostThread::kControl)) return;
  }
  scanner_->Tick();
  if (operator_ == SimOperator::kAutomatic) ActForPeople();
  if (watch_ != nullptr && *watch_) (*watch_)(scanner_->status());
}

void BoothSession::ActForPeople() {
  const nanoseconds now = ground_->clock().Now();
  if (now < next_press_) return;
  const ScannerStatus status = scanner_->status();
  sim::SafetyChain& chain = ground_->booth()->safety();
  const bool armed = status.state == ScanState::kArmed && status.job.empty();
  if (status.state != ScanState::kSafe && !armed) return;
  next_press_ = now + kPress;
  const auto held = ground_->Hold();
  if (!armed) return chain.PressResetAt(now);
  chain.Set(InterlockInput::kStartKey, true);
  chain.SetAt(now + milliseconds(150), InterlockInput::kStartKey, false);
}

bool BoothSession::RunUntil(const std::function<bool(const ScannerStatus&)>& done, nanoseconds patience,
                            const Watch& watch) {
  const bool works = pace_ == Pace::kAsFastAsPossible;
  // In paced time only the thread that works may let time pass.
  SystemClock host;
  Clock& clock = pace_ == Pace::kPaced ? host : ground_->clock();
  const nanoseconds end = clock.Now() + patience;
  if (works) watch_ = &watch;
  bool reached = done(scanner_->status());
  while (!reached && clock.Now() < end) {
    if (killed_) break;  // by the plan: the program is no more
    if (works) {
      Work();
    } else {
      clock.SleepUntil(clock.Now() + scan_time::kTick);
      if (watch) watch(scanner_->status());
    }
    reached = done(scanner_->status());
  }
  if (works) watch_ = nullptr;  // else the control thread looks at it
  return reached;
}

std::string BoothSession::scheduling_note() const {
  const std::scoped_lock lock(note_mutex_);
  return scheduling_note_;
}

}  // namespace annulus
