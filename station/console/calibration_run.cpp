#include "station/console/calibration_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <span>
#include <utility>

#include "acquisition/calibration_file.h"
#include "base/units.h"
#include "modeling/exchange/base64.h"
#include "station/calibration_job.h"
#include "station/console/calibration_records.h"
#include "station/console/calibration_steps.h"
#include "station/console/job_runner.h"
#include "station/console/route_errors.h"
#include "station/console/scratch_folder.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAttempted = "calibrate the ring";
constexpr double kNormal95 = 1.96;
constexpr int kDidNotPass = 1;  ///< Exit code of `annulus calibrate`.

const char* KindName(CalibrationTarget::Kind kind) {
  constexpr const char* kNames[]{"cylinder", "sphere", "plane", "step"};
  return kNames[static_cast<std::size_t>(kind)];
}

Json NumberOrNull(const std::optional<double>& number) { return number ? Json(*number) : Json(); }

Json PictureJson(const PlannedPlacement& placement, const CalibrationTarget& target) {
  return {{"kind", KindName(target.kind)},
          {"radius_mm", target.radius_mm},
          {"height_mm", target.height_mm},
          {"x_mm", placement.x_mm},
          {"y_mm", placement.y_mm},
          {"tilt_deg", placement.tilt_deg},
          {"tilt_to_deg", placement.tilt_to_deg},
          {"turn_deg", NumberOrNull(placement.turn_deg)},
          {"verify", placement.verify}};
}

}  // namespace

CalibrationRun::~CalibrationRun() {
  worker_ = {};
  const std::lock_guard lock(mutex_);
  Forget();
}

const char* CalibrationRun::StateName(State state) {
  constexpr const char* kNames[]{"idle", "place", "scanning", "solving", "done", "failed"};
  return kNames[static_cast<std::size_t>(state)];
}

Status CalibrationRun::Refused(const char* what) const {
  return Fail(kAttempted, fmt::format("to {} is not possible while the calibration is {}", what, StateName(state_)),
              state_ == State::kIdle ? "begin one" : "wait, or abandon it");
}

/// The first step that is not good; the number of steps if all are.
std::size_t CalibrationRun::NextStep() const {
  const auto open =
      std::find_if(steps_.begin(), steps_.end(), [](const Step& step) { return !step.check || !step.check->good; });
  return static_cast<std::size_t>(open - steps_.begin());
}

Status CalibrationRun::Begin(CalibrationOrder order) {
  const std::lock_guard lock(mutex_);
  LookAtJob();
  if (state_ != State::kIdle) return Refused("begin");
  if (order.plan.placements.empty()) return Fail(kAttempted, "there is no placement to scan", "name a target");
  auto folder = context_.scratch.NewFolder();
  if (!folder) return Fail(folder);
  folder_ = std::move(*folder);
  order_ = std::move(order);
  guide_.emplace(order_.plan, RingCalibration::Ideal(context_.config.ring.radius_mm));
  if (taker_ == nullptr) {
    taker_ =
        PlacementTakerFor(context_.config, context_.booth, context_.storage, context_.clock, context_.station_keys);
  }
  steps_.assign(order_.plan.placements.size(), Step{});
  ++number_;
  state_ = State::kPlace;
  return {};
}

Status CalibrationRun::Take(std::size_t step) {
  const std::lock_guard lock(mutex_);
  LookAtJob();
  if (state_ == State::kIdle || InProgress()) return Refused("scan");
  if (step >= steps_.size() || step > NextStep()) {
    return Fail(kAttempted, fmt::format("step {} is not due", step + 1), "take the steps in their order");
  }
  worker_ = {};  // the one before has ended; its thread is joined
  state_ = State::kScanning;
  scanned_step_ = step;
  error_.reset();
  result_ = nullptr;
  message_ = guide_->Instruction(step);
  worker_ = std::jthread([this, step](const std::stop_token& stop) { TakeNow(step, stop); });
  return {};
}

void CalibrationRun::TakeNow(std::size_t step, const std::stop_token& stop) {
  TaskContext task;
  task.stop = stop;
  task.progress = [this](std::string_view stage, double, double) {
    const std::lock_guard lock(mutex_);
    message_ = stage;
  };
  Status taken;
  try {
    taken = ScanStep(step, task);
    if (taken) PredictSoFar(step, task);
  } catch (const std::exception& mistake) {
    taken = Fail(kAttempted, mistake.what(), "report it: it is a mistake of the program");
  }
  const std::lock_guard lock(mutex_);
  if (state_ != State::kScanning) return;  // abandoned meanwhile
  state_ = State::kPlace;
  message_.clear();
  if (taken) return;
  error_ = taken.error();
  steps_[step].error = taken.error();
  steps_[step].check.reset();
}

Status CalibrationRun::ScanStep(std::size_t step, const TaskContext& task) {
  const std::string file = File(fmt::format("placement-{}.mcap", step + 1));
  if (context_.storage.Exists(file)) RETURN_IF_ERROR(context_.storage.Remove(file));
  const CalibrationPlan& plan = guide_->plan();
  auto taken = taker_->Take(plan, step, file, task);
  if (!taken) return Fail(taken);
  TargetScan reading = TargetScanOf(taken->scan, plan.placements[step], file, plan.ambient_c);
  PlacementCheck check = guide_->Check(step, reading);
  const std::lock_guard lock(mutex_);
  steps_[step] = {std::move(reading), std::move(check), taken->seconds, std::nullopt, std::nullopt};
  return {};
}

/// How well the ring is known from the good steps up to this one.
void CalibrationRun::PredictSoFar(std::size_t step, const TaskContext& task) {
  std::vector<TargetScan> readings;
  {
    const std::lock_guard lock(mutex_);
    if (guide_->plan().placements[step].verify || step >= NextStep()) return;
    for (std::size_t k = 0; k < NextStep(); ++k) readings.push_back(*steps_[k].reading);
  }
  const CalibrationSoFar so_far = guide_->SolveSoFar(readings, task);
  const std::lock_guard lock(mutex_);
  if (so_far.solved) steps_[step].predicted_common_mm = kNormal95 * so_far.common_sigma_mm;
}

void CalibrationRun::WaitForScan() {
  if (worker_.joinable()) worker_.join();
}

/// The calibration in force, copied into the folder; false if there is none that can be read.
Result<bool> CalibrationRun::PutPrevious() {
  const std::string in_force = CalibrationPath(context_.config);
  if (in_force.empty() || !context_.storage.Exists(in_force)) {
    if (!order_.board) return false;
    return Fail(kAttempted, "no calibration is in force that a lone board could join", "calibrate the whole ring");
  }
  const auto text = ReadTextFile(context_.storage, in_force);
  if (!text) return Fail(text);
  if (const auto parsed = ParseCalibrationFile(*text, in_force); !parsed) {
    if (order_.board) return Fail(parsed);
    return false;  // a damaged one is replaced, not compared with
  }
  RETURN_IF_ERROR(WriteFileAtomically(context_.storage, File("previous.json"), *text));
  return true;
}

Result<std::string> CalibrationRun::Solve(const std::string& owner) {
  JobRequest job;
  {
    const std::lock_guard lock(mutex_);
    LookAtJob();
    if (state_ == State::kIdle || InProgress()) return Fail(Refused("solve"));
    if (NextStep() < steps_.size()) {
      return Fail(kAttempted, fmt::format("step {} has not succeeded yet", NextStep() + 1), "scan it first");
    }
    CalibrationPlan plan = order_.plan;
    for (std::size_t k = 0; k < plan.placements.size(); ++k) {
      plan.placements[k].scan = File(fmt::format("placement-{}.mcap", k + 1));
    }
    RETURN_IF_ERROR(
        WriteFileAtomically(context_.storage, File("plan.toml"), CalibrationPlanToml(plan, order_.targets)));
    const auto previous = PutPrevious();
    if (!previous) return Fail(previous);
    std::vector<std::string> arguments{"calibrate", "--target",     File("plan.toml"), "--out", File("CAL.json"),
                                       "--report",  File("report"), "--json",          "-"};
    if (*previous) arguments.insert(arguments.end(), {"--previous", File("previous.json")});
    if (order_.board) arguments.insert(arguments.end(), {"--board", std::to_string(*order_.board)});
    job.kind = "calibration";
    job.owner = owner;
    job.steps = {{"solve for the ring", arguments, kDidNotPass}};
    state_ = State::kSolving;
    error_.reset();
    job_id_.clear();
  }
  // Shared by the two callbacks, which the runner may copy.
  const auto printed = std::make_shared<Json>();
  job.after_step = [printed](std::size_t, const std::string& text) -> Status {
    *printed = Json::parse(text, nullptr, false);
    return printed->is_object() ? Status{} : Fail(kAttempted, "the solver's result is no JSON", "try again");
  };
  job.finish = [this, printed]() -> Result<Json> {
    const std::lock_guard lock(mutex_);
    result_ = CalibrationResultJson(*printed);
    if (state_ == State::kSolving) state_ = State::kDone;
    return result_;
  };
  const std::string id = context_.jobs.Start(std::move(job));
  const std::lock_guard lock(mutex_);
  job_id_ = id;
  LookAtJob();
  return id;
}

/// A solve that did not come to its end leaves the steps as they are.
void CalibrationRun::LookAtJob() {
  if (state_ != State::kSolving || job_id_.empty()) return;
  const auto job = context_.jobs.Get(job_id_);
  if (job && (job->state == JobState::kWaiting || job->state == JobState::kRunning)) return;
  if (job && job->state == JobState::kDone) return;
  state_ = State::kFailed;
  error_ = job && job->error ? *job->error : Error{kAttempted, "the solve was stopped", "start it again"};
}

Result<std::string> CalibrationRun::Accept() {
  const std::lock_guard lock(mutex_);
  if (state_ != State::kDone) return Fail(Refused("accept"));
  if (result_.value("passed", false) != true) {
    return Fail(kAttempted, "the calibration does not keep its limits", "see what is to be mended, and scan again");
  }
  auto name = KeepCalibration(context_, folder_, result_);
  if (!name) return Fail(name);
  Forget();
  return name;
}

void CalibrationRun::Abandon() {
  std::string job;
  {
    const std::lock_guard lock(mutex_);
    job = state_ == State::kSolving ? job_id_ : "";
    state_ = State::kIdle;
  }
  if (!job.empty()) static_cast<void>(context_.jobs.Cancel(job));
  worker_ = {};  // asks the scan to stop, and waits for it
  const std::lock_guard lock(mutex_);
  Forget();
}

/// With the lock held, and nothing running.
void CalibrationRun::Forget() {
  if (!folder_.empty()) context_.scratch.Remove(std::exchange(folder_, std::string()));
  state_ = State::kIdle;
  steps_.clear();
  guide_.reset();
  message_.clear();
  error_.reset();
  job_id_.clear();
  result_ = nullptr;
}

Json CalibrationRun::StepJson(std::size_t step) const {
  const PlannedPlacement& placement = order_.plan.placements[step];
  const Step& one = steps_[step];
  const bool now = state_ == State::kScanning ? step == scanned_step_ : step == NextStep();
  const char* state = "open";
  if (one.check && one.check->good) state = "taken";
  if (one.check && !one.check->good) state = "again";
  if (one.error) state = "failed";
  if (state_ == State::kScanning ? now : now && std::string_view(state) == "open") state = "now";
  Json json{{"what", placement.Instruction(order_.plan.targets[placement.target])},
            {"picture", PictureJson(placement, order_.plan.targets[placement.target])},
            {"state", state},
            {"seconds", NumberOrNull(one.seconds)},
            {"residual_mm", one.check ? Json(one.check->noise_mm) : Json()},
            {"predicted_common_mm", NumberOrNull(one.predicted_common_mm)},
            {"problems", one.check ? Json(one.check->problems) : Json::array()},
            {"found", nullptr}};
  if (one.error) json["problems"].push_back(one.error->seen + ": " + one.error->advice);
  if (one.check && one.check->pose_known) {
    json["found"] = {{"x_mm", one.check->x_mm}, {"y_mm", one.check->y_mm}, {"tilt_deg", one.check->tilt_deg}};
  }
  return json;
}

Json CalibrationRun::Report() {
  const std::lock_guard lock(mutex_);
  LookAtJob();
  if (state_ == State::kIdle) return nullptr;
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  nlohmann::ordered_json predicted;
  for (std::size_t step = 0; step < steps_.size(); ++step) {
    steps.push_back(StepJson(step));
    if (steps_[step].predicted_common_mm) predicted = *steps_[step].predicted_common_mm;
  }
  std::string target;
  for (const std::string& one : order_.targets) target += (target.empty() ? "" : "; ") + one;
  const std::size_t step = state_ == State::kScanning ? scanned_step_ : std::min(NextStep(), steps_.size() - 1);
  return {{"id", "calibration-" + std::to_string(number_)},
          {"state", StateName(state_)},
          {"target", target},
          {"step", step},
          {"steps", std::move(steps)},
          {"predicted_common_mm", std::move(predicted)},
          {"budget_mm", CalibrationLimits().common_mm},
          {"message", message_},
          {"job", job_id_},
          {"error", error_ ? ErrorJson(*error_) : nlohmann::ordered_json()},
          {"result", state_ == State::kDone ? result_ : nlohmann::ordered_json()}};
}

Result<std::vector<std::byte>> CalibrationRun::ReportFile(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (state_ != State::kDone) return Fail("show the calibration's report", "there is none yet", "solve first");
  const std::string file = name == "CAL.json" ? File(name) : File("report/" + name);
  return context_.storage.ReadAll(file, kMaxInputBytes);
}

}  // namespace annulus
