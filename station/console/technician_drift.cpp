#include "station/console/technician_drift.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "acquisition/drift_alarm.h"
#include "acquisition/recording.h"
#include "base/units.h"
#include "station/calibration_gate.h"
#include "station/console/job_folder.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kJobKind = "drift";
constexpr const char* kHistorySetting = "drift_history";
constexpr const char* kScansSetting = "drift_scans";  ///< Ids of scans that were looked at.
constexpr std::size_t kScansAtOnce = 20;
constexpr std::size_t kScansLookedFor = 2000;
constexpr std::size_t kShownRecords = 120;
constexpr double kNsPerMs = 1e6;
constexpr const char* kAdvice = "clean these sensors' windows, check the ring with a reference, calibrate if it stays";

Json NumberOrNull(double number) { return std::isfinite(number) ? Json(number) : Json(); }

Result<std::set<std::string>> KnownScans(Store& store) {
  const auto text = store.Setting(kScansSetting);
  if (!text) return Fail(text);
  std::set<std::string> known;
  const Json ids = Json::parse(text->value_or("[]"), nullptr, false);
  for (const Json& id : ids) {
    if (id.is_string()) known.insert(id.get<std::string>());
  }
  return known;
}

/// Scans of people that were not looked at yet, oldest first.
Result<std::vector<std::string>> NewScans(Store& store, const std::set<std::string>& known) {
  const auto latest = store.LatestScans(kScansLookedFor);
  if (!latest) return Fail(latest);
  std::vector<std::string> ids;
  for (auto scan = latest->rbegin(); scan != latest->rend() && ids.size() < kScansAtOnce; ++scan) {
    const bool of_person = !IsTargetProfile(scan->profile) && scan->profile != "check";
    if (of_person && !scan->recording.empty() && !scan->recording_missing && !known.contains(scan->id)) {
      ids.push_back(scan->id);
    }
  }
  return ids;
}

Json AlarmJson(const DriftAlarm& alarm) {
  return {{"text", alarm.Text()},
          {"advice", kAdvice},
          {"sensor", alarm.sensor},
          {"count", alarm.count},
          {"drift_mm", alarm.drift_mm},
          {"sigma_mm", NumberOrNull(alarm.sigma_mm)},
          {"since", DriftSinceName(alarm.since)}};
}

Json CheckJson(const DriftHistory& history) {
  if (history.checks().empty()) return {};
  const ReferenceRecord& check = history.checks().back();
  return {{"time_ms", static_cast<double>(check.wall_start_ns) / kNsPerMs},
          {"passed", check.passed},
          {"common_mm", check.common_mm},
          {"common_sigma_mm", check.common_sigma_mm},
          {"findings", check.findings},
          {"advice", check.advice}};
}

/// What one scan shows of one sensor.
struct SensorFigures {
  double returns_share = 0.0;
  double mean_mm = std::nan("");
  double noise_mm = std::nan("");
};

/// The sd of noise from second differences along the height, robustly: bodies are smooth over three levels.
double NoiseOf(std::vector<double>& second_differences) {
  constexpr std::size_t kFewest = 20;
  if (second_differences.size() < kFewest) return std::nan("");
  const auto middle = second_differences.begin() + static_cast<std::ptrdiff_t>(second_differences.size() / 2);
  std::nth_element(second_differences.begin(), middle, second_differences.end());
  constexpr double kSdOverMedian = 1.4826;  // of a normal distribution's magnitudes
  return kSdOverMedian * *middle / std::sqrt(6.0);
}

SensorFigures FiguresOf(const Scan& scan, std::size_t sensor) {
  SensorFigures figures;
  std::vector<double> differences;
  double sum = 0.0;
  std::size_t count = 0;
  const auto range = [&](std::size_t level) { return scan.levels[level].readings[sensor].range_mm; };
  for (std::size_t level = 0; level < scan.levels.size(); ++level) {
    if (!std::isfinite(range(level))) continue;
    sum += range(level);
    ++count;
    if (level < 2 || scan.levels[level - 2].sweep != scan.levels[level].sweep) continue;
    const double difference = range(level - 2) - 2.0 * range(level - 1) + range(level);
    if (std::isfinite(difference)) differences.push_back(std::abs(difference));
  }
  if (scan.levels.empty()) return figures;
  figures.returns_share = static_cast<double>(count) / static_cast<double>(scan.levels.size());
  if (count > 0) figures.mean_mm = sum / static_cast<double>(count);
  figures.noise_mm = NoiseOf(differences);
  return figures;
}

/// The newest scan whose recording can be read.
Result<std::optional<std::pair<ScanRow, Scan>>> NewestScan(Store& store) {
  const auto latest = store.LatestScans(kScansAtOnce);
  if (!latest) return Fail(latest);
  for (const ScanRow& row : *latest) {
    if (row.recording.empty() || row.recording_missing) continue;
    const auto bytes = store.ReadRecording(row.id);
    if (!bytes) continue;  // the next older one will do
    auto recording = ParseRecording(*bytes, row.id);
    if (recording) return std::optional(std::pair(row, std::move(recording->scan)));
  }
  return std::optional<std::pair<ScanRow, Scan>>();
}

Json BoardOf(const std::vector<RecordedBoard>& boards, std::size_t sensor) {
  for (const RecordedBoard& board : boards) {
    if (sensor >= board.first_sensor && sensor < std::size_t{board.first_sensor} + board.sensor_count) {
      return board.serial;
    }
  }
  return {};
}

std::vector<bool> Alarmed(const DriftState& state, std::size_t sensors) {
  std::vector<bool> alarmed(sensors, false);
  for (const DriftAlarm& alarm : state.alarms) {
    for (std::size_t k = 0; k < alarm.count && sensors > 0; ++k) alarmed[(alarm.sensor + k) % sensors] = true;
  }
  return alarmed;
}

/// One update, as its job goes on: on the history as it is when its turn has come. Borrows the context.
class DriftUpdate {
 public:
  DriftUpdate(ConsoleContext& context, std::string folder) : context_(context), folder_(std::move(folder)) {}

  /// Lays out history and scans; no step if other updates have taken them meanwhile.
  Result<std::vector<JobStep>> Plan() {
    auto known = KnownScans(context_.store);
    if (!known) return Fail(known);
    known_ = std::move(*known);
    const auto scans = NewScans(context_.store, known_);
    if (!scans) return Fail(scans);
    if (scans->empty()) return std::vector<JobStep>();
    const auto history = context_.store.Setting(kHistorySetting);
    if (!history) return Fail(history);
    if (*history) RETURN_IF_ERROR(WriteFileAtomically(context_.storage, History(), **history));
    JobStep step{"look for drift", {"drift"}};
    for (const std::string& scan : *scans) {
      const auto recording = context_.store.ReadRecording(scan);
      if (!recording) return Fail(recording);
      step.arguments.push_back(folder_ + "/" + scan + ".mcap");
      RETURN_IF_ERROR(WriteFileAtomically(context_.storage, step.arguments.back(), *recording));
      known_.insert(scan);
    }
    step.arguments.insert(step.arguments.end(), {"--history", History(), "--json", "-"});
    return std::vector<JobStep>{std::move(step)};
  }

  Status TakeReport(const std::string& printed) {
    report_ = Json::parse(printed, nullptr, false);
    return report_.is_object() ? Status{} : Fail("look for drift", "what it printed is no JSON", "try again");
  }

  Result<Json> Keep() {
    if (report_.is_null()) return Json{{"scans_added", 0}};
    const auto text = ReadTextFile(context_.storage, History());
    if (!text) return Fail(text);
    RETURN_IF_ERROR(context_.store.SetSetting(kHistorySetting, *text));
    RETURN_IF_ERROR(context_.store.SetSetting(kScansSetting, Json(known_).dump()));
    return report_;
  }

 private:
  [[nodiscard]] std::string History() const { return folder_ + "/history.json"; }

  ConsoleContext& context_;
  const std::string folder_;
  std::set<std::string> known_;
  Json report_;
};

/// {state, error} of the last update that has ended since the console was started; null if there was none.
Json LastUpdateJson(const JobRunner& jobs) {
  Json last;
  for (const JobStatus& job : jobs.All()) {
    if (job.kind != kJobKind || job.state == JobState::kWaiting || job.state == JobState::kRunning) continue;
    const Json json = JobJson(job);
    last = {{"state", json.at("state")}, {"error", json.at("error")}};
  }
  return last;
}

}  // namespace

Result<DriftHistory> KeptDriftHistory(Store& store) {
  const auto text = store.Setting(kHistorySetting);
  if (!text) return Fail(text);
  if (!*text) return DriftHistory();
  return DriftHistory::FromJson(**text, "the drift history in the store");
}

Result<std::optional<std::string>> StartDriftUpdate(ConsoleContext& context, const std::string& owner) {
  const auto known = KnownScans(context.store);
  if (!known) return Fail(known);
  const auto scans = NewScans(context.store, *known);
  if (!scans) return Fail(scans);
  if (scans->empty()) return std::optional<std::string>();
  auto folder = JobFolder::Make(context);
  if (!folder) return Fail(folder);
  // Shared by the callbacks, which the runner may copy.
  const auto update = std::make_shared<DriftUpdate>(context, folder->path());
  JobRequest job;
  job.kind = kJobKind;
  job.owner = owner;
  job.lane = kJobKind;
  job.plan = [update] { return update->Plan(); };
  job.after_step = [update](std::size_t, const std::string& printed) { return update->TakeReport(printed); };
  job.finish = [update] { return update->Keep(); };
  return std::optional(folder->Start(std::move(job)));
}

Result<Json> DriftAnswer(ConsoleContext& context) {
  const auto history = KeptDriftHistory(context.store);
  if (!history) return Fail(history);
  const std::vector<DriftRecord>& records = history->records();
  const std::size_t first = records.size() > kShownRecords ? records.size() - kShownRecords : 0;
  Json sensors = Json::array();
  for (std::size_t sensor = 0; sensor < history->sensors(); ++sensor) {
    Json points = Json::array();
    for (std::size_t k = first; k < records.size(); ++k) {
      const DriftRecord& record = records[k];
      if (!std::isfinite(record.offset_mm[sensor])) continue;
      points.push_back({static_cast<double>(record.wall_start_ns) / kNsPerMs, record.offset_mm[sensor],
                        NumberOrNull(record.sigma_mm[sensor])});
    }
    sensors.push_back({{"index", sensor}, {"points", std::move(points)}});
  }
  const DriftState state = JudgeDrift(*history);
  Json alarms = Json::array();
  for (const DriftAlarm& alarm : state.alarms) alarms.push_back(AlarmJson(alarm));
  return Json{{"sensors", std::move(sensors)},
              {"alarms", std::move(alarms)},
              {"scans", state.scans},
              {"baseline_ready", state.baseline_ready},
              {"reference_check", CheckJson(*history)},
              {"update", LastUpdateJson(context.jobs)}};
}

Result<Json> SensorsAnswer(ConsoleContext& context) {
  const auto newest = NewestScan(context.store);
  if (!newest) return Fail(newest);
  const auto history = KeptDriftHistory(context.store);
  if (!history) return Fail(history);
  Json answer{{"scan_id", nullptr}, {"taken_ms", nullptr}, {"sensors", Json::array()}};
  if (!*newest) return answer;
  const auto& [row, scan] = **newest;
  answer["scan_id"] = row.id;
  answer["taken_ms"] = row.taken.count();
  const std::vector<RecordedBoard>& boards = scan.header.machine.boards;
  const std::size_t count = scan.header.calibration.sensors.size();
  const DriftState state = JudgeDrift(*history, boards);
  const std::vector<bool> alarmed = Alarmed(state, count);
  for (std::size_t sensor = 0; sensor < count; ++sensor) {
    const SensorFigures figures = FiguresOf(scan, sensor);
    const bool drifts = sensor < state.sensors.size();
    const double drift = drifts ? state.sensors[sensor].offset_mm : std::nan("");
    answer["sensors"].push_back({{"index", sensor},
                                 {"board", BoardOf(boards, sensor)},
                                 {"angle_deg", 360.0 * static_cast<double>(sensor) / static_cast<double>(count)},
                                 {"returns_share", figures.returns_share},
                                 {"mean_mm", NumberOrNull(figures.mean_mm)},
                                 {"noise_mm", NumberOrNull(figures.noise_mm)},
                                 {"drift_mm", NumberOrNull(drift)},
                                 {"alarm", static_cast<bool>(alarmed[sensor])}});
  }
  return answer;
}

}  // namespace annulus
