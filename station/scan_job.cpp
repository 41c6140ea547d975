#include "station/scan_job.h"

#include <functional>
#include <utility>

#include "station/booth_session.h"
#include "station/calibration_gate.h"
#include "station/command_line.h"
#include "station/host_health.h"
#include "station/profile_plan.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr std::chrono::minutes kPeoplePatience{5};
constexpr std::chrono::seconds kHomingPatience{120};
constexpr std::chrono::seconds kArmPatience{30};
constexpr std::chrono::minutes kScanPatience{10};
constexpr std::chrono::seconds kStopPatience{10};

/// Runs one scan on a booth session, state by state.
class ScanJobRun {
 public:
  ScanJobRun(BoothSession& session, const Config& config, const ScanRequest& request,
             const RingCalibration& calibration, const TaskContext& task)
      : session_(session),
        scanner_(session.scanner()),
        config_(config),
        request_(request),
        calibration_(calibration),
        task_(task) {}

  Result<ScanOutcome> Run();

 private:
  /// The plan that was asked for, not yet held against the machine.
  Result<ScanPlan> RequestedPlan();
  Result<Millimetres> FindTop();
  [[nodiscard]] ScanHeader Header() const;
  Status AwaitIdle();
  Status Home();
  /// Arms what is asked for; the reasons why the plan was adjusted are kept.
  Status Arm(ArmRequest request);
  /// Waits for the start key, starts, and waits for the end.
  Result<ScanResult> Take();
  /// Lets the booth work until it has come to `done`; a stop request is passed on as a cancellation, after which
  /// `done` no longer counts, but rest does.
  Status Await(const char* attempted, const std::function<bool(const ScannerStatus&)>& done, nanoseconds patience);
  void Show(const ScannerStatus& status);

  BoothSession& session_;
  Scanner& scanner_;
  const Config& config_;
  const ScanRequest& request_;
  const RingCalibration& calibration_;
  const TaskContext& task_;
  ScanOutcome outcome_;
  std::string waiting_for_;  ///< Whom the booth waits for.
};

bool Rests(const ScannerStatus& status) {
  return (status.state == ScanState::kIdle || status.state == ScanState::kSafe || status.state == ScanState::kFault) &&
         status.job.empty();
}

/// Why the booth does not go on, as an Error; success if it does.
Status Trouble(const char* attempted, const ScannerStatus& status) {
  if (!status.causes.empty()) {
    const ScanCause& cause = status.causes.front();
    return Fail(attempted, cause.text, cause.advice);
  }
  if (status.state == ScanState::kFault) return Fail(attempted, "the booth is in fault", "acknowledge it");
  return {};
}

void ScanJobRun::Show(const ScannerStatus& status) {
  if (!status.stage.empty()) {
    task_.Report(status.stage, status.done, status.total);
  } else if (!waiting_for_.empty()) {
    task_.Report(waiting_for_, 0, 1);
  }
}

Status ScanJobRun::Await(const char* attempted, const std::function<bool(const ScannerStatus&)>& done,
                         nanoseconds patience) {
  const auto watch = [&](const ScannerStatus& status) {
    Show(status);
    if (task_.stop.stop_requested()) static_cast<void>(scanner_.Cancel());
  };
  const bool reached = session_.RunUntil(
      [&](const ScannerStatus& status) { return done(status) || task_.stop.stop_requested(); }, patience, watch);
  if (task_.stop.stop_requested()) {
    static_cast<void>(scanner_.Cancel());
    session_.RunUntil(Rests, kStopPatience);
    return {};
  }
  if (reached) return {};
  const ScannerStatus status = scanner_.status();
  RETURN_IF_ERROR(Trouble(attempted, status));
  if (!status.held_by.empty()) {
    return Fail(attempted, "the safety chain holds the booth: " + status.held_by,
                "pull the emergency stop out, shut the door or leave the limit, then press the reset button");
  }
  return Fail(attempted,
              "the booth is still " + std::string(ScanStateText(status.state)) +
                  (waiting_for_.empty() ? "" : "; nobody did this: " + waiting_for_),
              waiting_for_.empty() ? "look at the booth, then try again" : waiting_for_ + " in time");
}

Status ScanJobRun::AwaitIdle() {
  const char* attempted = "make the booth ready";
  waiting_for_ = "press the reset button";
  RETURN_IF_ERROR(Await(
      attempted, [](const ScannerStatus& status) { return status.state != ScanState::kSafe; }, kPeoplePatience));
  waiting_for_.clear();
  if (task_.stop.stop_requested()) return {};
  return Trouble(attempted, scanner_.status());
}

Status ScanJobRun::Home() {
  if (scanner_.status().homed) return {};
  RETURN_IF_ERROR(scanner_.OrderHome());
  RETURN_IF_ERROR(Await("home the axis", Rests, kHomingPatience));
  if (task_.stop.stop_requested()) return {};
  return Trouble("home the axis", scanner_.status());
}

Status ScanJobRun::Arm(ArmRequest request) {
  RETURN_IF_ERROR(scanner_.OrderArm(std::move(request)));
  RETURN_IF_ERROR(Await(
      "arm the scan",
      [](const ScannerStatus& status) {
        return (status.arm && status.job.empty()) || status.state == ScanState::kFault ||
               status.state == ScanState::kSafe;
      },
      kArmPatience));
  if (task_.stop.stop_requested()) return {};
  const ScannerStatus status = scanner_.status();
  RETURN_IF_ERROR(Trouble("arm the scan", status));
  if (!status.arm) {
    return Fail("arm the scan", "the booth is " + std::string(ScanStateText(status.state)) + " " + status.held_by,
                "look at the booth, then try again");
  }
  for (const ArmCheck& check : status.arm->checks) {
    // What is wrong with the plan is for whoever wrote the profile.
    if (!check.result && check.name == "plan") {
      return Fail("plan a scan with profile '" + request_.profile + "'", check.result.error().seen,
                  "change [profile." + request_.profile + "] of the configuration");
    }
    if (!check.result) return check.result;
  }
  if (!status.arm->plan_adjusted.empty()) outcome_.adjusted = status.arm->plan_adjusted;
  return {};
}

Result<ScanResult> ScanJobRun::Take() {
  const ScannerStatus before = scanner_.status();
  waiting_for_ = "press the start key at the booth";
  RETURN_IF_ERROR(Await(
      "start the scan",
      [&](const ScannerStatus& status) {
        return status.start_presses != before.start_presses || status.state != ScanState::kArmed;
      },
      scan_time::kArmedFor + std::chrono::seconds(1)));
  waiting_for_.clear();
  const std::uint64_t number = before.scan ? before.scan->number : 0;
  if (task_.stop.stop_requested()) return ScanResult{};
  const Status started = scanner_.OrderStart(before.version);
  if (!started) {
    RETURN_IF_ERROR(Trouble("start the scan", scanner_.status()));
    return Fail(started);
  }
  const auto ended = [&](const ScannerStatus& status) {
    return status.scan && status.scan->number > number && Rests(status);
  };
  RETURN_IF_ERROR(Await("scan", ended, kScanPatience));
  // After a stop request too there is a result: of what was taken until then.
  if (!ended(scanner_.status())) session_.RunUntil(ended, kStopPatience);
  const ScannerStatus status = scanner_.status();
  if (!ended(status)) return Fail("scan", "the booth does not come to an end", "press the emergency stop; report this");
  return *status.scan;
}

Result<Millimetres> ScanJobRun::FindTop() {
  ArmRequest search;
  search.search = true;
  search.header = Header();
  RETURN_IF_ERROR(Arm(std::move(search)));
  if (task_.stop.stop_requested()) return tl::unexpected<Error>(Error{"find the subject's top", "interrupted", ""});
  const auto found = Take();
  if (!found) return Fail(found);
  if (!found->status) return Fail(found->status);
  if (!found->top) return Fail("find the subject's top", "stopped on request", "start again");
  return *found->top;
}

Result<ScanPlan> ScanJobRun::RequestedPlan() {
  std::optional<Millimetres> height;
  if (NeedsTop(config_, request_.profile)) {
    const auto top = FindTop();
    if (!top) return Fail(top);
    height = *top;
  }
  return PlanOfProfile(config_, request_.profile, height);
}

ScanHeader ScanJobRun::Header() const {
  ScanHeader header;
  header.station_id = config_.station_id;
  if (sim::BoothDevices* booth = session_.ground().booth()) {
    header.source = booth->subject().name();
    header.seed = config_.sim.seed;
  }
  header.subject_id = request_.subject_id;
  header.consent_reference = request_.consent_reference;
  header.program_version = ProgramVersion();
  header.ring_radius_mm = config_.ring.radius_mm;
  header.calibration = calibration_;
  header.profile = request_.profile;
  header.reference = RecordedReferenceOf(config_.ring);
  header.machine.ring_bus = RingBusText(config_.ring.bus);
  return header;
}

Result<ScanOutcome> ScanJobRun::Run() {
  RETURN_IF_ERROR(AwaitIdle());
  if (!task_.stop.stop_requested()) RETURN_IF_ERROR(Home());
  outcome_.summary.cancelled = true;
  if (task_.stop.stop_requested()) return outcome_;
  const auto plan = RequestedPlan();
  if (task_.stop.stop_requested()) return outcome_;
  if (!plan) return Fail(plan);
  ArmRequest request;
  request.plan = *plan;
  request.out = request_.out;
  request.header = Header();
  RETURN_IF_ERROR(Arm(std::move(request)));
  if (task_.stop.stop_requested()) return outcome_;
  const auto taken = Take();
  if (!taken) return Fail(taken);
  if (!taken->status) {
    Error error = taken->status.error();
    if (taken->recorded) {
      error.advice +=
          "; the " + std::to_string(taken->summary.levels) + " levels taken before are in " + taken->recording;
    }
    return tl::unexpected<Error>(error);
  }
  outcome_.plan = taken->plan;
  outcome_.summary = taken->summary;
  if (taken->number == 0) outcome_.summary.cancelled = true;  // stopped before it was started
  outcome_.recorded = taken->recorded;
  if (taken->quality) outcome_.quality = *taken->quality;
  return outcome_;
}

}  // namespace

Result<ScanOutcome> RunScanJob(const Config& config, const ScanRequest& request, Storage& storage,
                               const TaskContext& task) {
  CalibrationGate gate(config, storage);
  BoothSessionOptions options;
  options.scanner.recording.keys = request.keys;
  if (!AllSimulated(config)) options.scanner.host_checks = [] { return CheckHostHealth(); };
  auto calibration = CalibrationInForce(config, request.profile, storage);
  if (!calibration) return Fail(calibration);
  auto session = BoothSession::Open(config, gate, storage, std::move(options));
  if (!session) return Fail(session);
  gate.UseClock((*session)->clock());
  return ScanJobRun(**session, config, request, *calibration, task).Run();
}

}  // namespace annulus
