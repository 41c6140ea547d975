#include "station/console/scan_judgement.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "acquisition/scan_plan.h"
#include "acquisition/scan_quality.h"
#include "acquisition/sealed_file.h"

namespace annulus {
namespace {

/// Share of the planned levels from which on a scan counts as whole: single ones may be lost.
constexpr double kWhole = 0.98;

}  // namespace

Result<ScanJudgement> JudgeRecording(std::span<const std::byte> bytes, const std::string& name, const KeySource* keys,
                                     const std::string& ticket) {
  using Json = nlohmann::ordered_json;
  Unsealed opened;  // a scan's recording has the same size whatever it is sealed with
  if (LooksSealed(bytes)) {
    auto unsealed = UnsealRecording(bytes, name, keys);
    if (!unsealed) return Fail(unsealed);
    opened = std::move(*unsealed);
    bytes = opened.bytes;
  }
  auto recording = ParseRecording(bytes, name);
  if (!recording) return Fail(recording);
  const ScanQuality quality = AssessScan(recording->scan);
  const auto plan = PlanFromJson(recording->scan.header.plan_json);
  const std::size_t levels = recording->scan.levels.size();
  Json notices = Json::array();
  // The quality is that of the part that was taken.
  const bool whole = !plan || static_cast<double>(levels) >= kWhole * plan->TotalLevels();
  if (!whole) {
    notices.push_back({{"code", kIncompleteNotice},
                       {"text", "not the whole scan: " + std::to_string(levels) + " of " +
                                    std::to_string(plan->TotalLevels()) + " levels were taken"},
                       {"advice", "scan again"}});
  }
  const Json judged = Json::parse(JsonFromQuality(quality));
  for (const Json& notice : judged.at("notices")) notices.push_back(notice);
  const Json summary{{"ticket", ticket},
                     {"levels", levels},
                     {"planned_levels", plan ? Json(plan->TotalLevels()) : Json(nullptr)},
                     {"recording_bytes", bytes.size()},
                     {"coverage", quality.coverage},
                     {"notices", std::move(notices)},
                     {"quality", judged},
                     {"released", false}};
  ScanJudgement judgement;
  judgement.verdict = VerdictName(whole ? quality.verdict : QualityVerdict::kRepeat);
  judgement.parked = plan && plan->parked();
  judgement.summary_json = summary.dump();
  judgement.header = std::move(recording->scan.header);
  return judgement;
}

}  // namespace annulus
