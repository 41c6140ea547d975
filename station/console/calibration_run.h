#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"
#include "station/calibration_guide.h"
#include "station/calibration_plan.h"
#include "station/console/console_context.h"
#include "station/guided_calibration.h"

namespace annulus {

/// What a guided calibration is to be made of.
struct CalibrationOrder {
  CalibrationPlan plan;                ///< Placements without scans.
  std::vector<std::string> targets;    ///< The plan's targets as ParseTarget took them.
  std::optional<std::uint32_t> board;  ///< Only this board, which was replaced; needs a calibration in force.
};

/// The guided calibration over the web: one at a time, its scans in a thread of its own, its solve a job.
///
///     idle --Begin--> place --Take--> scanning --> place --Solve--> solving --> done --Accept--> idle
///                       ^                |           |                 |          |
///                       '-- scan failed -'           |                 '--> failed (as place)
///     any --Abandon--> idle                          '<-- Take of a step again ---'
///
/// Scans lie in a scratch folder until the run ends. Borrows the context. Thread-safe.
class CalibrationRun {
 public:
  explicit CalibrationRun(ConsoleContext& context) : context_(context) {}
  ~CalibrationRun();
  CalibrationRun(const CalibrationRun&) = delete;
  CalibrationRun& operator=(const CalibrationRun&) = delete;

  /// Who takes the scans; by default PlacementTakerFor. For tests.
  void UseTaker(std::unique_ptr<PlacementTaker> taker) { taker_ = std::move(taker); }

  Status Begin(CalibrationOrder order);
  /// The target stands: scans step `step` (0 first), which is the next one, or an earlier one again.
  Status Take(std::size_t step);
  /// Starts the solve; its job's id. Needs all steps to be good.
  Result<std::string> Solve(const std::string& owner);
  /// Stores the calibration and puts it in force; its name. Needs one that passed.
  Result<std::string> Accept();
  void Abandon();
  /// Until nothing is being scanned. For tests.
  void WaitForScan();

  /// `run` of docs/console_api.md §11; null when idle.
  [[nodiscard]] nlohmann::ordered_json Report();
  /// A file of the solved calibration's report: "report.html", "report.pdf", "CAL.json".
  [[nodiscard]] Result<std::vector<std::byte>> ReportFile(const std::string& name);

 private:
  enum class State { kIdle, kPlace, kScanning, kSolving, kDone, kFailed };
  struct Step {
    std::optional<TargetScan> reading;
    std::optional<PlacementCheck> check;
    std::optional<double> seconds;
    std::optional<double> predicted_common_mm;  ///< 95 %, with this step and those before.
    std::optional<Error> error;
  };

  [[nodiscard]] static const char* StateName(State state);
  [[nodiscard]] Status Refused(const char* what) const;
  [[nodiscard]] bool InProgress() const { return state_ == State::kScanning || state_ == State::kSolving; }
  [[nodiscard]] std::size_t NextStep() const;
  [[nodiscard]] std::string File(const std::string& name) const { return folder_ + "/" + name; }
  void TakeNow(std::size_t step, const std::stop_token& stop);
  [[nodiscard]] Status ScanStep(std::size_t step, const TaskContext& task);
  void PredictSoFar(std::size_t step, const TaskContext& task);
  void LookAtJob();
  void Forget();
  [[nodiscard]] Result<bool> PutPrevious();
  [[nodiscard]] nlohmann::ordered_json StepJson(std::size_t step) const;

  ConsoleContext& context_;
  mutable std::mutex mutex_;  ///< Of all that follows, but taker_ and guide_, which only the scanning thread uses then.
  State state_ = State::kIdle;
  std::uint64_t number_ = 0;
  CalibrationOrder order_;
  std::optional<CalibrationGuide> guide_;
  std::unique_ptr<PlacementTaker> taker_;
  std::string folder_;
  std::vector<Step> steps_;
  std::size_t scanned_step_ = 0;
  std::string message_;
  std::optional<Error> error_;
  std::string job_id_;
  nlohmann::ordered_json result_;
  std::jthread worker_;  ///< Last: it ends before what it uses.
};

}  // namespace annulus
