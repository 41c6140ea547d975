#include "sim/fault_plan.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Json = nlohmann::ordered_json;
using Need = FaultArgRule::Need;
using Trigger = FaultTrigger::Kind;

constexpr std::size_t kMostBytes = std::size_t{1} << 20;
constexpr int kDeepest = 8;
constexpr double kLongestS = 1e5;
constexpr double kLargestNumber = 1e9;
constexpr const char* kFormat = "annulus fault plan";
constexpr int kVersion = 1;

/// What is wrong with a plan, and what would be right.
struct Objection {
  std::string seen;
  std::string advice;
};
template <class T>
using Parsed = tl::expected<T, Objection>;

tl::unexpected<Objection> Object(const std::string& place, const std::string& seen, std::string advice) {
  return tl::unexpected<Objection>(Objection{place + ": " + seen, std::move(advice)});
}

std::string Joined(const std::vector<std::string>& words) {
  std::string joined;
  for (const std::string& word : words) joined += (joined.empty() ? "" : ", ") + word;
  return joined.empty() ? "nothing" : joined;
}

std::string Shown(const Json& json) {
  constexpr std::size_t kLongest = 40;
  std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "…";
  return text;
}

/// A number as people write it.
std::string NumberText(double number) { return Json(number).dump(); }
std::string RangeText(double low, double high) {
  const auto text = [](double number) {
    return std::abs(number) < 1e15 && number == std::floor(number) ? std::to_string(static_cast<std::int64_t>(number))
                                                                   : NumberText(number);
  };
  return text(low) + " to " + text(high);
}

/// An object that has no other keys than these.
Parsed<void> CheckKeys(const Json& json, const std::string& place, const std::vector<std::string>& allowed) {
  if (!json.is_object()) return Object(place, Shown(json) + " is not an object", "give " + Joined(allowed));
  for (const auto& [key, value] : json.items()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    return Object(place, "unknown key " + Shown(Json(key)), "allowed are " + Joined(allowed));
  }
  return {};
}

Parsed<double> NumberIn(const Json& json, const std::string& place, double low, double high) {
  const double number = json.is_number() ? json.get<double>() : NAN;
  if (number >= low && number <= high) return number;
  return Object(place, Shown(json) + " is out of range", "give a number, " + RangeText(low, high));
}

Parsed<double> WholeIn(const Json& json, const std::string& place, double low, double high) {
  auto number = NumberIn(json, place, low, high);
  if (!number || *number == std::floor(*number)) return number;
  return Object(place, Shown(json) + " is not whole", "give a whole number, " + RangeText(low, high));
}

Parsed<nanoseconds> SecondsIn(const Json& json, const std::string& place) {
  const auto seconds = NumberIn(json, place, 0.0, kLongestS);
  if (!seconds) return tl::unexpected<Objection>(seconds.error());
  return nanoseconds(std::llround(*seconds * 1e9));
}

Parsed<FaultTrigger> StateTrigger(const Json& json, const std::string& place) {
  if (const auto keys = CheckKeys(json, place, {"state", "after_s"}); !keys) {
    return tl::unexpected<Objection>(keys.error());
  }
  FaultTrigger trigger;
  trigger.kind = Trigger::kState;
  const Json& state = json.at("state");
  const std::vector<std::string> states(kFaultStates.begin(), kFaultStates.end());
  if (!state.is_string() || std::find(states.begin(), states.end(), state.get<std::string>()) == states.end()) {
    return Object(place, Shown(state) + " is not a state of the booth", "give one of " + Joined(states));
  }
  trigger.state = state.get<std::string>();
  if (!json.contains("after_s")) return trigger;
  const auto after = SecondsIn(json.at("after_s"), place + ".after_s");
  if (!after) return tl::unexpected<Objection>(after.error());
  trigger.delay = *after;
  return trigger;
}

Parsed<FaultTrigger> ParseTrigger(const Json& json, const std::string& place) {
  const std::vector<std::string> kinds{"state", "time_s", "level", "call"};
  if (json.is_object() && json.contains("state")) return StateTrigger(json, place);
  if (const auto keys = CheckKeys(json, place, {"time_s", "level", "call"}); !keys) {
    return tl::unexpected<Objection>({keys.error().seen, "give one of " + Joined(kinds)});
  }
  if (json.size() != 1)
    return Object(place, "it has " + std::to_string(json.size()) + " keys", "give one of " + Joined(kinds));
  FaultTrigger trigger;
  const std::string key = json.begin().key();
  if (key == "time_s") {
    const auto delay = SecondsIn(json.begin().value(), place + ".time_s");
    if (!delay) return tl::unexpected<Objection>(delay.error());
    trigger.delay = *delay;
    return trigger;
  }
  trigger.kind = key == "level" ? Trigger::kLevel : Trigger::kCall;
  const auto number = WholeIn(json.begin().value(), place + "." + key, key == "call" ? 1.0 : 0.0, kLargestNumber);
  if (!number) return tl::unexpected<Objection>(number.error());
  trigger.number = static_cast<std::uint64_t>(*number);
  return trigger;
}

Parsed<const FaultKindTraits*> ParseKind(const Json& json, const std::string& place) {
  const auto text = [&](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  std::vector<std::string> targets;
  for (std::size_t i = 0; i < kFaultTargets; ++i) targets.emplace_back(FaultTargetName(static_cast<FaultTarget>(i)));
  const std::string target = text("target");
  if (std::find(targets.begin(), targets.end(), target) == targets.end()) {
    return Object(place, "target is " + (json.contains("target") ? Shown(json.at("target")) : "missing"),
                  "give one of " + Joined(targets));
  }
  std::vector<std::string> kinds;
  const std::string kind = text("kind");
  for (const FaultKindTraits& traits : AllFaultKinds()) {
    if (FaultTargetName(traits.target) != target) continue;
    if (traits.name == kind) return &traits;
    kinds.emplace_back(traits.name);
  }
  return Object(place, "kind is " + (json.contains("kind") ? Shown(json.at("kind")) : "missing"),
                "for target " + target + " give one of " + Joined(kinds));
}

Parsed<double> ParseArg(const Json& json, const std::string& place, const FaultArgRule& rule) {
  const FaultArgTraits& traits = TraitsOf(rule.arg);
  switch (traits.type) {
    case FaultArgTraits::Type::kNumber:
      return NumberIn(json, place, rule.low, rule.high);
    case FaultArgTraits::Type::kWhole:
      return WholeIn(json, place, rule.low, rule.high);
    case FaultArgTraits::Type::kWord:
      break;
  }
  const std::vector<std::string> words(traits.words.begin() + static_cast<std::ptrdiff_t>(rule.low),
                                       traits.words.begin() + static_cast<std::ptrdiff_t>(rule.high) + 1);
  const auto found = json.is_string() ? std::find(words.begin(), words.end(), json.get<std::string>()) : words.end();
  if (found == words.end()) return Object(place, Shown(json) + " is unknown", "give one of " + Joined(words));
  return rule.low + static_cast<double>(found - words.begin());
}

Parsed<FaultArgs> ParseArgs(const Json& fault, const std::string& place, const FaultKindTraits& traits) {
  std::vector<std::string> names;
  for (const FaultArgRule& rule : traits.args) names.emplace_back(TraitsOf(rule.arg).name);
  const Json none = Json::object();
  const Json& given = fault.contains("args") ? fault.at("args") : none;
  if (const auto keys = CheckKeys(given, place, names); !keys) return tl::unexpected<Objection>(keys.error());
  FaultArgs args;
  for (const FaultArgRule& rule : traits.args) {
    const std::string name = TraitsOf(rule.arg).name;
    const auto found = given.find(name);
    if (found == given.end()) {
      if (rule.need == Need::kMay) continue;
      return Object(place, name + " is missing", "give " + name);
    }
    const auto value = ParseArg(*found, (place + ".").append(name), rule);
    if (!value) return tl::unexpected<Objection>(value.error());
    args.Set(rule.arg, *value);
  }
  return args;
}

Parsed<void> ParseSpan(const Json& json, const std::string& place, const FaultKindTraits& traits, Fault& fault) {
  const bool lasts = json.contains("for_s");
  const bool ends = json.contains("until");
  if (lasts && ends) return Object(place, "it has for_s and until", "give one of them");
  if (traits.span == FaultSpan::kMoment && (lasts || ends)) {
    return Object(place, std::string(traits.name) + " happens once and has no end", "leave out for_s and until");
  }
  if (traits.span == FaultSpan::kLimited && !lasts && !ends) {
    return Object(place, std::string(traits.name) + " must end", "give for_s or until");
  }
  if (lasts) {
    const auto time = SecondsIn(json.at("for_s"), place + ".for_s");
    if (!time) return tl::unexpected<Objection>(time.error());
    if (time->count() <= 0) return Object(place + ".for_s", "it lasts no time", "give more than 0 s");
    fault.lasting = *time;
  }
  if (ends) {
    const auto trigger = ParseTrigger(json.at("until"), place + ".until");
    if (!trigger) return tl::unexpected<Objection>(trigger.error());
    if (trigger->kind == Trigger::kCall)
      return Object(place + ".until", "a call ends nothing", "give state, time_s or level");
    fault.until = *trigger;
  }
  return {};
}

Parsed<Fault> ParseFault(const Json& json, const std::string& place) {
  if (const auto keys = CheckKeys(json, place, {"at", "for_s", "until", "target", "kind", "args"}); !keys) {
    return tl::unexpected<Objection>(keys.error());
  }
  const auto traits = ParseKind(json, place);
  if (!traits) return tl::unexpected<Objection>(traits.error());
  Fault fault;
  fault.kind = (*traits)->kind;
  if (!json.contains("at"))
    return Object(place, "at is missing", "give {\"state\": …}, {\"time_s\": …}, {\"level\": …} or {\"call\": …}");
  auto at = ParseTrigger(json.at("at"), place + ".at");
  if (!at) return tl::unexpected<Objection>(at.error());
  if (at->kind == Trigger::kCall && !HasCalls((*traits)->target)) {
    return Object(place + ".at",
                  std::string(FaultTargetName((*traits)->target)) + " has no calls that could be counted",
                  "give state, time_s or level");
  }
  fault.at = std::move(*at);
  if (const auto span = ParseSpan(json, place, **traits, fault); !span) {
    return tl::unexpected<Objection>(span.error());
  }
  const auto args = ParseArgs(json, place + ".args", **traits);
  if (!args) return tl::unexpected<Objection>(args.error());
  fault.args = *args;
  return fault;
}

Parsed<FaultPlan> ParsePlan(const Json& json) {
  if (const auto keys = CheckKeys(json, "plan", {"format", "version", "seed", "faults"}); !keys) {
    return tl::unexpected<Objection>(keys.error());
  }
  if (!json.contains("format") || json.at("format") != kFormat) {
    return Object("plan", "it is no fault plan", std::string("begin with \"format\": \"") + kFormat + "\"");
  }
  if (!json.contains("version") || json.at("version") != kVersion) {
    return Object("plan.version",
                  json.contains("version") ? Shown(json.at("version")) + " is not known" : "it is missing",
                  "give " + std::to_string(kVersion));
  }
  FaultPlan plan;
  if (json.contains("seed")) {
    const Json& seed = json.at("seed");
    if (!seed.is_number_unsigned())
      return Object("plan.seed", Shown(seed) + " is no seed", "give a whole number, not negative");
    plan.seed = seed.get<std::uint64_t>();
  }
  if (!json.contains("faults") || !json.at("faults").is_array())
    return Object("plan", "faults is no list", "give \"faults\": [ … ]");
  const Json& faults = json.at("faults");
  if (faults.size() > FaultPlan::kMostFaults) {
    return Object("plan.faults", std::to_string(faults.size()) + " faults are too many",
                  "give at most " + std::to_string(FaultPlan::kMostFaults));
  }
  for (std::size_t i = 0; i < faults.size(); ++i) {
    auto fault = ParseFault(faults[i], "faults[" + std::to_string(i) + "]");
    if (!fault) return tl::unexpected<Objection>(fault.error());
    plan.faults.push_back(std::move(*fault));
  }
  return plan;
}

double Seconds(nanoseconds time) { return static_cast<double>(time.count()) / 1e9; }

/// Whole numbers without a point.
Json JsonNumber(double number) {
  if (std::abs(number) < 9e15 && number == std::floor(number)) return Json(static_cast<std::int64_t>(number));
  return Json(number);
}

Json JsonFromTrigger(const FaultTrigger& trigger) {
  switch (trigger.kind) {
    case Trigger::kTime:
      return {{"time_s", JsonNumber(Seconds(trigger.delay))}};
    case Trigger::kLevel:
      return {{"level", trigger.number}};
    case Trigger::kCall:
      return {{"call", trigger.number}};
    case Trigger::kState:
      break;
  }
  Json json{{"state", trigger.state}};
  if (trigger.delay.count() > 0) json["after_s"] = JsonNumber(Seconds(trigger.delay));
  return json;
}

Json JsonFromArg(FaultArg arg, double value) {
  const FaultArgTraits& traits = TraitsOf(arg);
  if (traits.type == FaultArgTraits::Type::kWord) return traits.words.at(static_cast<std::size_t>(value));
  return JsonNumber(value);
}

Json JsonFromFault(const Fault& fault) {
  const FaultKindTraits& traits = TraitsOf(fault.kind);
  Json json{{"at", JsonFromTrigger(fault.at)}};
  if (fault.lasting) json["for_s"] = JsonNumber(Seconds(*fault.lasting));
  if (fault.until) json["until"] = JsonFromTrigger(*fault.until);
  json["target"] = FaultTargetName(traits.target);
  json["kind"] = traits.name;
  Json args = Json::object();
  for (const FaultArgRule& rule : traits.args) {
    if (const auto value = fault.args.Get(rule.arg)) args[TraitsOf(rule.arg).name] = JsonFromArg(rule.arg, *value);
  }
  if (!args.empty()) json["args"] = std::move(args);
  return json;
}

}  // namespace

double Fault::Value(FaultArg arg) const {
  if (const auto given = args.Get(arg)) return *given;
  for (const FaultArgRule& rule : TraitsOf(kind).args) {
    if (rule.arg == arg && rule.fallback) return *rule.fallback;
  }
  ENSURE(false, std::string("the fault has no ") + TraitsOf(arg).name);
  return 0.0;
}

std::chrono::nanoseconds Fault::Period() const {
  return std::chrono::nanoseconds(std::llround(1e9 / Value(FaultArg::kRateHz)));
}

std::uint64_t Fault::Whole(FaultArg arg) const { return static_cast<std::uint64_t>(Value(arg)); }

std::optional<std::uint64_t> Fault::Choice(FaultArg arg) const {
  const auto given = args.Get(arg);
  if (!given) return std::nullopt;
  return static_cast<std::uint64_t>(*given);
}

Result<FaultPlan> ParseFaultPlan(std::string_view text, const std::string& name) {
  const std::string attempted = "read fault plan " + name;
  if (text.size() > kMostBytes) return Fail(attempted, "it is longer than 1 MiB", "split it");
  // Deep nesting would use up the stack of whoever walks through it.
  bool deep = false;
  const auto shallow = [&deep](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > kDeepest;
    return depth <= kDeepest;
  };
  const Json json = Json::parse(text.begin(), text.end(), shallow, false);
  if (json.is_discarded() || deep) return Fail(attempted, "it is not JSON", "see docs/formats.md, \"Fault plan\"");
  auto plan = ParsePlan(json);
  if (!plan) return Fail(attempted, plan.error().seen, plan.error().advice);
  return std::move(*plan);
}

std::string WriteFaultPlan(const FaultPlan& plan) {
  std::string text = "{\n  \"format\": " + Json(kFormat).dump() + ",\n  \"version\": " + std::to_string(kVersion) +
                     ",\n  \"seed\": " + std::to_string(plan.seed) + ",\n  \"faults\": [";
  for (std::size_t i = 0; i < plan.faults.size(); ++i) {
    text += (i == 0 ? "\n    " : ",\n    ") + JsonFromFault(plan.faults[i]).dump();
  }
  return text + (plan.faults.empty() ? "]\n}\n" : "\n  ]\n}\n");
}

std::string FaultText(const Fault& fault) {
  const FaultKindTraits& traits = TraitsOf(fault.kind);
  std::string text = std::string(FaultTargetName(traits.target)) + " " + traits.name;
  for (const FaultArgRule& rule : traits.args) {
    const auto value = fault.args.Get(rule.arg);
    if (!value) continue;
    const Json json = JsonFromArg(rule.arg, *value);
    text +=
        std::string(" ") + TraitsOf(rule.arg).name + "=" + (json.is_string() ? json.get<std::string>() : json.dump());
  }
  const auto when = [](const FaultTrigger& trigger) {
    switch (trigger.kind) {
      case Trigger::kTime:
        return NumberText(Seconds(trigger.delay)) + " s";
      case Trigger::kLevel:
        return "level " + std::to_string(trigger.number);
      case Trigger::kCall:
        return "call " + std::to_string(trigger.number);
      case Trigger::kState:
        break;
    }
    return trigger.state + (trigger.delay.count() > 0 ? " + " + NumberText(Seconds(trigger.delay)) + " s" : "");
  };
  text += " at " + when(fault.at);
  if (fault.lasting) text += " for " + NumberText(Seconds(*fault.lasting)) + " s";
  if (fault.until) text += " until " + when(*fault.until);
  return text;
}

}  // namespace annulus::sim
