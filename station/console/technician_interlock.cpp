#include "station/console/technician_interlock.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/booth_messages.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// What a line says at either level, in the order of the enumerations (docs/booth.md §4).
struct LineWords {
  const char* when_true;
  const char* when_false;
};
constexpr std::array<LineWords, kInterlockInputs> kInputWords{{
    {"no emergency stop on channel A", "emergency stop pressed, or a wire of channel A is broken"},
    {"no emergency stop on channel B", "emergency stop pressed, or a wire of channel B is broken"},
    {"door closed", "door open, or its wire is broken"},
    {"carriage below the upper over-travel switch", "carriage at the upper over-travel switch"},
    {"carriage above the lower over-travel switch", "carriage at the lower over-travel switch"},
    {"reset button pressed", "reset button not pressed"},
    {"start key pressed", "start key not pressed"},
    {"customer calls", "customer does not call"},
    {"enable relay has pulled in", "enable relay has dropped"},
    {"brake released", "brake closed"},
    {"watchdog relay holds", "watchdog relay has dropped"},
    {"a lamp draws current", "no lamp draws current"},
}};
constexpr std::array<LineWords, kInterlockOutputs> kOutputWords{{
    {"enable is asked for", "enable is off"},
    {"watchdog pulses", "watchdog pulses are not shown here"},
    {"drive may run", "quick stop demanded of the drive"},
    {"emitters have their supply", "emitters are off"},
    {"lamp ready on", "lamp ready off"},
    {"lamp running on", "lamp running off"},
    {"lamp fault on", "lamp fault off"},
}};

Json LineJson(const char* name, const char* direction, const std::optional<bool>& level, const LineWords& words) {
  return {{"name", name},
          {"direction", direction},
          {"level", level ? Json(*level) : Json()},
          {"meaning", level ? (*level ? words.when_true : words.when_false) : "not known yet"}};
}

}  // namespace

Json InterlockJson(const ScannerStatus& status) {
  Json lines = Json::array();
  bool closed = status.lines.has_value();
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    const auto input = static_cast<InterlockInput>(i);
    const auto level = status.lines ? std::optional(status.lines->input.at(i)) : std::nullopt;
    Json line = LineJson(InterlockName(input), "in", level, kInputWords.at(i));
    line["stops"] = IsChainInput(input);
    closed = closed && (!IsChainInput(input) || *level);
    lines.push_back(std::move(line));
  }
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
    const auto output = static_cast<InterlockOutput>(i);
    if (output == InterlockOutput::kWatchdog) continue;  // its pulses are left out of what is said
    const auto level = status.lines ? std::optional(status.lines->output.at(i)) : std::nullopt;
    Json line = LineJson(InterlockName(output), "out", level, kOutputWords.at(i));
    line["stops"] = false;
    lines.push_back(std::move(line));
  }
  Json chain = Json::array();
  for (const InterlockNotice& notice : status.chain) {
    chain.push_back({{"fault", ChainFaultName(notice.fault)},
                     {"present", notice.present},
                     {"text", notice.text},
                     {"advice", notice.advice},
                     {"since_ns", notice.since.count()}});
  }
  return {{"lines", std::move(lines)},
          {"changed_ns", status.lines ? Json(status.lines->time.count()) : Json()},
          {"held_by", status.held_by},
          {"chain_closed", closed},
          {"chain", std::move(chain)}};
}

}  // namespace annulus
