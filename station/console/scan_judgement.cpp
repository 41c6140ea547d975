#include "station/console/scan_judgement.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "acquisition/scan_plan.h"
#include "acquisition/scan_quality.h"

namespace annulus {

Result<ScanJudgement> JudgeRecording(std::span<const std::byte> bytes, const std::string& name, const KeySource* keys,
                                     const std::string& ticket) {
  using Json = nlohmann::ordered_json;
  auto recording = ParseRecording(bytes, name, keys);
  if (!recording) return Fail(recording);
  const ScanQuality quality = AssessScan(recording->scan);
  const auto plan = PlanFromJson(recording->scan.header.plan_json);
  Json notices = Json::array();
  for (const QualityNotice& notice : quality.notices) {
    notices.push_back({{"code", NoticeName(notice.code)}, {"text", notice.text}, {"advice", notice.advice}});
  }
  const Json summary{{"ticket", ticket},
                     {"levels", recording->scan.levels.size()},
                     {"planned_levels", plan ? Json(plan->TotalLevels()) : Json(nullptr)},
                     {"coverage", quality.coverage},
                     {"notices", std::move(notices)},
                     {"quality", Json::parse(JsonFromQuality(quality))},
                     {"released", false}};
  ScanJudgement judgement;
  judgement.verdict = VerdictName(quality.verdict);
  judgement.parked = plan && plan->parked();
  judgement.summary_json = summary.dump();
  judgement.header = std::move(recording->scan.header);
  return judgement;
}

}  // namespace annulus
