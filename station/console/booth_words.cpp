#include "station/console/booth_words.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct Both {
  const char* en;
  const char* ja;
  [[nodiscard]] std::string In(SheetLanguage language) const { return language == SheetLanguage::kJapanese ? ja : en; }
};

/// In the order of ScanState.
constexpr std::array<Both, kScanStates> kStates{{
    {"Safe: nothing can move. The reset button has to be pressed.",
     "安全な状態です。何も動きません。リセットボタンを押してください。"},
    {"Waiting.", "待機中です。"},
    {"The ring is moving to its home position.", "リングが原点に戻っています。"},
    {"Ready to scan.", "測定の準備ができました。"},
    {"Scanning: please stand still.", "測定中です。動かないでください。"},
    {"Stopping.", "停止しています。"},
    {"Stopped by a fault.", "異常のため停止しました。"},
    {"The technician is moving the ring.", "技術者がリングを動かしています。"},
}};

constexpr Both kLost{
    "The booth does not answer. Nothing is lost; what runs there is watched by the booth itself. Wait a moment; if "
    "this "
    "does not go away, restart the booth's computer.",
    "装置が応答しません。データは失われていません。動いているものは装置自身が見張っています。少しお待ちください。"
    "直らない場合は装置のコンピューターを再起動してください。"};

/// What a step is called, and what to do if it is not so.
struct StepWords {
  const char* id;
  Both done;
  Both open;
  Both advice;
};
constexpr StepWords kChain{
    "chain",
    {"The emergency stop is out and the door is shut.", "非常停止は解除され、扉は閉まっています。"},
    {"The safety chain was opened.", "安全回路が開きました。"},
    {"Pull the emergency stop out and shut the door.", "非常停止を引き出し、扉を閉めてください。"}};
constexpr StepWords kReset{"reset",
                           {"The reset button was pressed.", "リセットボタンは押されました。"},
                           {"The reset button has to be pressed.", "リセットボタンを押す必要があります。"},
                           {"Look that nobody is inside, then press the reset button beside the door.",
                            "中に人がいないことを見てから、扉のそばのリセットボタンを押してください。"}};
constexpr StepWords kFault{"fault",
                           {"No fault.", "異常はありません。"},
                           {"There was a fault.", "異常がありました。"},
                           {"Read what it was, then press Acknowledge.", "内容を読んでから「確認」を押してください。"}};
constexpr StepWords kHome{
    "home",
    {"The ring has found its home position.", "リングは原点にあります。"},
    {"The ring has to find its home position.", "リングを原点に戻す必要があります。"},
    {"Let nobody into the booth and press Home.", "中に誰もいないことを確かめ、「原点に戻す」を押してください。"}};
constexpr StepWords kSensors{
    "sensors",
    {"The sensors work.", "センサーは正常です。"},
    {"Sensors are missing or see nothing.", "センサーが足りないか、何も捉えていません。"},
    {"Wipe the sensors' windows, then prepare the scan again. If it comes back, call the technician.",
     "センサーの窓を拭き、もう一度準備してください。また出る場合は技術者を呼んでください。"}};
constexpr StepWords kDisk{"disk",
                          {"There is room for the scan.", "記録する空きがあります。"},
                          {"There is not room enough for the scan.", "記録する空きが足りません。"},
                          {"Call the technician or administrator: old recordings have to be moved away.",
                           "技術者か管理者を呼んでください。古い記録を移す必要があります。"}};
constexpr StepWords kCalibration{"calibration",
                                 {"The ring is calibrated.", "校正は有効です。"},
                                 {"The ring has no calibration that is good now.", "有効な校正がありません。"},
                                 {"Call the technician: the ring has to be calibrated or checked.",
                                  "技術者を呼んでください。校正または点検が必要です。"}};
constexpr StepWords kStand{"stand",
                           {"The customer stands on the marks.", "お客様は印の上に立っています。"},
                           {"The customer has to stand on the marks.", "お客様に印の上に立っていただきます。"},
                           {"Ask the customer to stand on the marks and hold still, then prepare the scan.",
                            "印の上に立って動かないようお願いし、測定の準備を押してください。"}};
constexpr StepWords kKey{
    "key",
    {"The start key was pressed.", "スタートキーは押されました。"},
    {"The start key at the booth has to be pressed.", "装置のスタートキーを押す必要があります。"},
    {"Press the start key at the booth: the scan begins.", "装置のスタートキーを押してください。測定が始まります。"}};

PlainStep StepOf(const StepWords& words, bool ok, SheetLanguage language) {
  return {words.id, ok, {(ok ? words.done : words.open).In(language), ok ? "" : words.advice.In(language)}};
}

bool IsOneOf(CauseCode code, std::initializer_list<CauseCode> codes) {
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}
bool IsOfSensors(CauseCode code) {
  return IsOneOf(code, {CauseCode::kSensorLost, CauseCode::kSensorBus, CauseCode::kSensorData, CauseCode::kSensorsDead,
                        CauseCode::kEmitter, CauseCode::kRingIdentity});
}
bool IsOfDisk(CauseCode code) { return IsOneOf(code, {CauseCode::kStorage, CauseCode::kDiskFull}); }

/// Whether the hardware chain holds the booth for something else than a missing reset.
bool ChainOpen(const ScannerStatus& status) {
  const bool demands = std::any_of(status.chain.begin(), status.chain.end(), [](const InterlockNotice& notice) {
    return notice.present && ClassOf(notice.fault) != InterlockFaultClass::kWarning;
  });
  return demands || (status.state == ScanState::kSafe && status.held_by.starts_with("open"));
}

PlainStep ChainStep(const ScannerStatus& status, SheetLanguage language) {
  static constexpr std::array<std::pair<std::string_view, Both>, 4> kInputs{
      {{"estop", {"The emergency stop was pressed.", "非常停止が押されました。"}},
       {"door", {"The door was opened.", "扉が開きました。"}},
       {"upper_limit", {"The ring is at its upper end switch.", "リングが上端のスイッチに達しています。"}},
       {"lower_limit", {"The ring is at its lower end switch.", "リングが下端のスイッチに達しています。"}}}};
  PlainStep step = StepOf(kChain, !ChainOpen(status), language);
  if (step.ok) return step;
  std::string seen;
  for (const auto& [name, words] : kInputs) {
    if (status.held_by.find(name) != std::string::npos) seen += (seen.empty() ? "" : " ") + words.In(language);
  }
  if (!seen.empty()) step.words.text = seen;
  for (const InterlockNotice& notice : status.chain) {
    if (!notice.present || ClassOf(notice.fault) != InterlockFaultClass::kService) continue;
    step.words = WordsOfCause(CauseCode::kInterlock, language);
    step.words.advice = WordsOfCause(CauseCode::kChannelsDiffer, language).advice;
  }
  return step;
}

/// Of the last order to arm; boothd's own words follow ours.
void AddChecks(PlainStep& step, const ScannerStatus& status, const StepWords& words,
               std::initializer_list<std::string_view> names, SheetLanguage language) {
  if (!status.arm) return;
  for (const ArmCheck& check : status.arm->checks) {
    if (check.result || std::find(names.begin(), names.end(), check.name) == names.end()) continue;
    step = StepOf(words, false, language);
    if (language == SheetLanguage::kEnglish) step.words.text += " (" + check.result.error().seen + ")";
  }
}

PlainStep CheckedStep(const ScannerStatus& status, const StepWords& words, bool (*concerns)(CauseCode),
                      std::initializer_list<std::string_view> checks, SheetLanguage language) {
  PlainStep step = StepOf(words, true, language);
  AddChecks(step, status, words, checks, language);
  for (const ScanCause& cause : status.causes) {
    if (!concerns(cause.code)) continue;
    step.ok = false;
    step.words = WordsOfCause(cause.code, language);
    break;
  }
  return step;
}

PlainStep FaultStep(const ScannerStatus& status, SheetLanguage language) {
  PlainStep step = StepOf(kFault, status.causes.empty(), language);
  if (!status.causes.empty()) step.words = WordsOfCause(status.causes.front().code, language);
  return step;
}

std::vector<PlainStep> StepsOf(const ScannerStatus& status, bool start_agreed, SheetLanguage language) {
  const bool armed = status.state == ScanState::kArmed;
  const bool scanning = status.state == ScanState::kScanning;
  std::vector<PlainStep> steps;
  steps.push_back(ChainStep(status, language));
  steps.push_back(StepOf(kReset, status.state != ScanState::kSafe, language));
  steps.push_back(FaultStep(status, language));
  steps.push_back(StepOf(kHome, status.homed, language));
  steps.push_back(CheckedStep(status, kSensors, IsOfSensors, {"ring"}, language));
  steps.push_back(CheckedStep(status, kDisk, IsOfDisk, {"disk", "store"}, language));
  const auto never = [](CauseCode) { return false; };
  steps.push_back(CheckedStep(status, kCalibration, never, {"calibration", "reference"}, language));
  steps.push_back(StepOf(kStand, armed || scanning, language));
  steps.push_back(StepOf(kKey, scanning || (armed && start_agreed), language));
  return steps;
}

}  // namespace

std::string WordsOfState(ScanState state, SheetLanguage language) {
  return kStates.at(static_cast<std::size_t>(state)).In(language);
}

PlainBooth DescribeBooth(const BoothView& view, SheetLanguage language) {
  PlainBooth plain;
  if (view.status == nullptr) {
    plain.lost_text = kLost.In(language);
    return plain;
  }
  const ScannerStatus& status = view.status->scanner;
  plain.state_text = WordsOfState(status.state, language);
  plain.steps = StepsOf(status, view.start_agreed, language);
  for (const ScanCause& cause : status.causes) {
    const CauseTraits& traits = TraitsOf(cause.code);
    plain.causes.push_back({traits.name, traits.role == CauseRole::kService, WordsOfCause(cause.code, language),
                            cause.text + (cause.advice.empty() ? "" : ": " + cause.advice)});
  }
  const auto ok = [&](std::string_view id) {
    return std::any_of(plain.steps.begin(), plain.steps.end(),
                       [&](const PlainStep& step) { return step.id == id && step.ok; });
  };
  plain.ready = ok("chain") && ok("reset") && ok("fault") && ok("home") &&
                (status.state == ScanState::kIdle || status.state == ScanState::kArmed);
  return plain;
}

Json PlainToJson(const PlainBooth& plain) {
  Json steps = Json::array();
  for (const PlainStep& step : plain.steps) {
    steps.push_back({{"id", step.id}, {"ok", step.ok}, {"text", step.words.text}, {"advice", step.words.advice}});
  }
  Json causes = Json::array();
  for (const PlainCause& cause : plain.causes) {
    causes.push_back({{"code", cause.code},
                      {"service", cause.service},
                      {"text", cause.words.text},
                      {"advice", cause.words.advice},
                      {"seen", cause.seen}});
  }
  return {{"ready", plain.ready},
          {"steps", std::move(steps)},
          {"causes", std::move(causes)},
          {"state_text", plain.state_text},
          {"lost_text", plain.lost_text}};
}

SheetLanguage LanguageOf(std::string_view name) {
  return name == "ja" ? SheetLanguage::kJapanese : SheetLanguage::kEnglish;
}

}  // namespace annulus
