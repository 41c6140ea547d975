#include <set>

#include "firmware_iface/interlock.h"

namespace annulus {
namespace {

constexpr std::array<const char*, kInterlockInputs> kInputNames = {
    "estop_a", "estop_b",         "door",           "upper_limit",       "lower_limit",  "reset", "start_key",
    "call",    "enable_feedback", "brake_feedback", "watchdog_feedback", "lamp_feedback"};
constexpr std::array<const char*, kInterlockOutputs> kOutputNames = {
    "enable", "watchdog", "quick_stop", "emitters", "lamp_ready", "lamp_running", "lamp_fault"};

InterlockInput InputAt(std::size_t index) { return static_cast<InterlockInput>(index); }
InterlockOutput OutputAt(std::size_t index) { return static_cast<InterlockOutput>(index); }

void CheckInput(const GpioLineSpec& spec, const std::string& role, std::vector<std::string>& wrong) {
  if (spec.direction != GpioDirection::kInput) wrong.push_back(role + " must be an input");
  if (!spec.edges) wrong.push_back(role + " must report edges");
}

void CheckOutput(const GpioLineSpec& spec, const std::string& role, std::vector<std::string>& wrong) {
  if (spec.direction != GpioDirection::kOutput) wrong.push_back(role + " must be an output");
  if (spec.initial) wrong.push_back(role + " must be off at first");
}

}  // namespace

const char* InterlockName(InterlockInput input) { return kInputNames.at(static_cast<std::size_t>(input)); }
const char* InterlockName(InterlockOutput output) { return kOutputNames.at(static_cast<std::size_t>(output)); }

bool IsChainInput(InterlockInput input) { return input <= InterlockInput::kLowerLimit; }

InterlockWiring InterlockWiring::Default() {
  InterlockWiring wiring;
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    GpioLineSpec spec;
    spec.name = kInputNames.at(i);
    spec.bias = GpioBias::kPullDown;
    spec.edges = true;
    spec.active_low = InputAt(i) == InterlockInput::kEnableFeedback || InputAt(i) == InterlockInput::kBrakeFeedback;
    wiring.inputs[InputAt(i)] = spec;
  }
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
    GpioLineSpec spec;
    spec.name = kOutputNames.at(i);
    spec.direction = GpioDirection::kOutput;
    wiring.outputs[OutputAt(i)] = spec;
  }
  return wiring;
}

std::vector<GpioLineSpec> InterlockWiring::Lines() const {
  std::vector<GpioLineSpec> lines;
  for (const auto& [input, spec] : inputs) lines.push_back(spec);
  for (const auto& [output, spec] : outputs) lines.push_back(spec);
  return lines;
}

Status InterlockWiring::Validate() const {
  std::vector<std::string> wrong;
  std::map<std::string, std::string> role_of;
  const auto check_name = [&](const GpioLineSpec& spec, const std::string& role) {
    if (spec.name.empty()) {
      wrong.push_back(role + " has no line name");
    } else if (const auto [other, first] = role_of.emplace(spec.name, role); !first) {
      wrong.push_back("line '" + spec.name + "' is both " + other->second + " and " + role);
    }
  };
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    const auto found = inputs.find(InputAt(i));
    if (found == inputs.end()) {
      wrong.push_back(std::string(kInputNames.at(i)) + " is missing");
      continue;
    }
    check_name(found->second, kInputNames.at(i));
    CheckInput(found->second, kInputNames.at(i), wrong);
  }
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
    const auto found = outputs.find(OutputAt(i));
    if (found == outputs.end()) {
      wrong.push_back(std::string(kOutputNames.at(i)) + " is missing");
      continue;
    }
    check_name(found->second, kOutputNames.at(i));
    CheckOutput(found->second, kOutputNames.at(i), wrong);
  }
  if (wrong.empty()) return {};
  std::string seen;
  for (const std::string& text : wrong) seen.append(seen.empty() ? "" : "; ").append(text);
  return Fail("check the wiring of the interlock", seen, "correct [interlock]; docs/booth.md lists the lines");
}

}  // namespace annulus
