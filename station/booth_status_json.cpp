#include <algorithm>
#include <array>
#include <utility>

#include "station/booth_json.h"

namespace annulus {
namespace {

constexpr std::size_t kMaxList = 64;
constexpr std::size_t kMaxPathBytes = 4096;

constexpr std::size_t kMaxValues = 8;
constexpr std::array kFaultNames{"channels_disagree",  "welded_contact",   "brake_open",
                                 "no_enable_feedback", "watchdog_dropped", "output_differs",
                                 "lines_failed",       "reset_stuck",      "lamp_lost"};
static_assert(kFaultNames.size() == kChainFaults);

BoothJson Texts(const std::vector<std::string>& texts) {
  BoothJson list = BoothJson::array();
  for (const std::string& text : texts) {
    if (list.size() == kMaxList) break;
    list.push_back(Clipped(text));
  }
  return list;
}

BoothJson JsonFromStatus(const Status& status) { return status ? BoothJson(nullptr) : JsonFromError(status.error()); }

Status ReadOutcome(FieldReader& fields, const char* key) {
  Status status;
  if (fields.Has(key)) {
    fields.Object(key, [&](FieldReader& error) { status = tl::unexpected(ReadError(error)); });
  }
  return status;
}

BoothJson JsonFromCause(const ScanCause& cause) {
  const CauseTraits& traits = TraitsOf(cause.code);
  return {{"code", traits.name},
          {"role", traits.role == CauseRole::kService ? "service" : "operator"},
          {"text", Clipped(cause.text)},
          {"advice", Clipped(cause.advice)},
          {"time_ns", cause.time.count()}};
}

ScanCause ReadCause(FieldReader& fields) {
  ScanCause cause;
  const std::string name = fields.Words("code");
  // A cause of a newer program keeps its text.
  for (std::size_t code = 0; code < kCauseCodes; ++code) {
    if (name == TraitsOf(static_cast<CauseCode>(code)).name) cause.code = static_cast<CauseCode>(code);
  }
  cause.text = fields.Words("text");
  cause.advice = fields.Words("advice");
  cause.time = std::chrono::nanoseconds(fields.Integer("time_ns"));
  return cause;
}

BoothJson JsonFromWarning(const ScanWarning& warning) {
  return {{"code", WarningName(warning.code)}, {"text", Clipped(warning.text)}, {"values", warning.values}};
}

ScanWarning ReadWarning(FieldReader& fields) {
  ScanWarning warning;
  const std::string name = fields.Words("code");
  for (std::size_t code = 0; code < kWarningCodes; ++code) {
    if (name == WarningName(static_cast<WarningCode>(code))) warning.code = static_cast<WarningCode>(code);
  }
  warning.text = fields.Words("text");
  fields.Array("values", kMaxValues, [&](const BoothJson& value) {
    if (!value.is_number()) return fields.Wrong("values", value, "a list of numbers");
    warning.values.push_back(value.get<double>());
  });
  return warning;
}

BoothJson JsonFromNotice(const InterlockNotice& notice) {
  return {{"fault", ChainFaultName(notice.fault)},
          {"present", notice.present},
          {"text", Clipped(notice.text)},
          {"advice", Clipped(notice.advice)},
          {"since_ns", notice.since.count()}};
}

InterlockNotice ReadNotice(FieldReader& fields) {
  InterlockNotice notice;
  const std::string name = fields.Words("fault");
  const auto found = std::find(kFaultNames.begin(), kFaultNames.end(), name);
  if (found != kFaultNames.end()) notice.fault = static_cast<InterlockFault>(found - kFaultNames.begin());
  notice.present = fields.Flag("present");
  notice.text = fields.Words("text");
  notice.advice = fields.Words("advice");
  notice.since = std::chrono::nanoseconds(fields.Integer("since_ns"));
  return notice;
}

/// {time_ns, inputs: {estop_a: true, …}, outputs: {…}}.
BoothJson JsonFromLines(const SafetyLines& lines) {
  BoothJson inputs = BoothJson::object();
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    inputs[InterlockName(static_cast<InterlockInput>(i))] = lines.input.at(i);
  }
  BoothJson outputs = BoothJson::object();
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
    outputs[InterlockName(static_cast<InterlockOutput>(i))] = lines.output.at(i);
  }
  return {{"time_ns", lines.time.count()}, {"inputs", std::move(inputs)}, {"outputs", std::move(outputs)}};
}

SafetyLines ReadLines(FieldReader& fields) {
  SafetyLines lines;
  lines.time = std::chrono::nanoseconds(fields.Integer("time_ns"));
  fields.Object("inputs", [&](FieldReader& inputs) {
    for (std::size_t i = 0; i < kInterlockInputs; ++i) {
      lines.input.at(i) = inputs.Flag(InterlockName(static_cast<InterlockInput>(i)));
    }
  });
  fields.Object("outputs", [&](FieldReader& outputs) {
    for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
      lines.output.at(i) = outputs.Flag(InterlockName(static_cast<InterlockOutput>(i)));
    }
  });
  return lines;
}

BoothJson JsonFromArm(const ArmReport& arm) {
  BoothJson checks = BoothJson::array();
  for (const ArmCheck& check : arm.checks) {
    if (checks.size() == kMaxList) break;
    checks.push_back({{"name", Clipped(check.name)}, {"error", JsonFromStatus(check.result)}});
  }
  const bool passed =
      std::all_of(arm.checks.begin(), arm.checks.end(), [](const ArmCheck& one) { return one.result.has_value(); });
  return {{"passed", passed}, {"checks", std::move(checks)}, {"plan_adjusted", Texts(arm.plan_adjusted)}};
}

ArmReport ReadArmReport(FieldReader& fields) {
  ArmReport arm;
  fields.Objects("checks", kMaxList, [&](FieldReader& check) {
    std::string name = check.Words("name");
    arm.checks.push_back({std::move(name), ReadOutcome(check, "error")});
  });
  arm.plan_adjusted = fields.Texts("plan_adjusted", kMaxList);
  return arm;
}

BoothJson JsonFromPlan(const ScanPlan& plan) {
  return {{"profile", Clipped(plan.profile)},
          {"z_top_mm", FiniteOrNull(plan.z_top_mm)},
          {"z_bottom_mm", FiniteOrNull(plan.z_bottom_mm)},
          {"pitch_mm", FiniteOrNull(plan.pitch_mm)},
          {"speed_mm_s", FiniteOrNull(plan.speed_mm_s)},
          {"sweeps", plan.sweeps},
          {"level_rate_hz", FiniteOrNull(plan.level_rate_hz)},
          {"dwell_s", FiniteOrNull(plan.dwell_s)}};
}

ScanPlan ReadPlan(FieldReader& fields) {
  ScanPlan plan;
  plan.profile = fields.Words("profile");
  plan.z_top_mm = fields.NumberOrNan("z_top_mm");
  plan.z_bottom_mm = fields.NumberOrNan("z_bottom_mm");
  plan.pitch_mm = fields.NumberOrNan("pitch_mm");
  plan.speed_mm_s = fields.NumberOrNan("speed_mm_s");
  plan.sweeps = static_cast<std::uint32_t>(fields.Count("sweeps", 0xFFFF'FFFFU));
  plan.level_rate_hz = fields.NumberOrNan("level_rate_hz");
  plan.dwell_s = fields.NumberOrNan("dwell_s");
  return plan;
}

BoothJson JsonFromSummary(const ScanSummary& s) {
  return {{"cancelled", s.cancelled},
          {"planned_levels", s.planned_levels},
          {"levels", s.levels},
          {"missing_levels", s.missing_levels},
          {"sweeps", s.sweeps},
          {"start_ns", s.start.count()},
          {"end_ns", s.end.count()},
          {"returns", s.returns},
          {"no_returns", s.no_returns},
          {"worst_clock_bound_us", FiniteOrNull(s.worst_clock_bound_us)},
          {"ring",
           {{"levels", s.ring.levels},
            {"lost_frames", s.ring.lost_frames},
            {"duplicate_frames", s.ring.duplicate_frames},
            {"rejected_frames", s.ring.rejected_frames},
            {"rejected_bytes", s.ring.rejected_bytes},
            {"overflowed_frames", s.ring.overflowed_frames}}}};
}

ScanSummary ReadSummary(FieldReader& fields) {
  ScanSummary s;
  const auto count = [&](const char* key) { return static_cast<std::uint32_t>(fields.Count(key, 0xFFFF'FFFFU)); };
  s.cancelled = fields.Flag("cancelled");
  s.planned_levels = count("planned_levels");
  s.levels = count("levels");
  s.missing_levels = count("missing_levels");
  s.sweeps = count("sweeps");
  s.start = std::chrono::nanoseconds(fields.Integer("start_ns"));
  s.end = std::chrono::nanoseconds(fields.Integer("end_ns"));
  s.returns = fields.Count("returns");
  s.no_returns = fields.Count("no_returns");
  s.worst_clock_bound_us = fields.NumberOrNan("worst_clock_bound_us");
  fields.Object("ring", [&](FieldReader& ring) {
    s.ring.levels = ring.Count("levels");
    s.ring.lost_frames = ring.Count("lost_frames");
    s.ring.duplicate_frames = ring.Count("duplicate_frames");
    s.ring.rejected_frames = ring.Count("rejected_frames");
    s.ring.rejected_bytes = ring.Count("rejected_bytes");
    s.ring.overflowed_frames = ring.Count("overflowed_frames");
  });
  return s;
}

/// The lists of a status, of at most kMaxList elements.
template <class Item, class ToJson>
BoothJson List(const std::vector<Item>& items, ToJson to_json) {
  BoothJson list = BoothJson::array();
  for (const Item& item : items) {
    if (list.size() == kMaxList) break;
    list.push_back(to_json(item));
  }
  return list;
}

ScanState ReadState(FieldReader& fields) {
  const std::string name = fields.Words("state");
  for (std::size_t state = 0; state < kScanStates; ++state) {
    if (name == ScanStateText(static_cast<ScanState>(state))) return static_cast<ScanState>(state);
  }
  // Unlike a cause, a state that is not known cannot be acted on.
  fields.Wrong("state", "no state of the booth");
  return ScanState::kSafe;
}

}  // namespace

const char* ChainFaultName(InterlockFault fault) { return kFaultNames.at(static_cast<std::size_t>(fault)); }

BoothJson JsonFromResult(const ScanResult& result) {
  return {{"number", result.number},
          {"error", JsonFromStatus(result.status)},
          {"plan", JsonFromPlan(result.plan)},
          {"summary", JsonFromSummary(result.summary)},
          {"complete", result.complete},
          {"recorded", result.recorded},
          {"recording", Clipped(result.recording, kMaxPathBytes)},
          {"top_mm", result.top ? FiniteOrNull(result.top->value()) : BoothJson(nullptr)}};
}

ScanResult ReadResult(FieldReader& fields) {
  ScanResult result;
  result.number = fields.Count("number");
  result.status = ReadOutcome(fields, "error");
  fields.Object("plan", [&](FieldReader& plan) { result.plan = ReadPlan(plan); });
  fields.Object("summary", [&](FieldReader& summary) { result.summary = ReadSummary(summary); });
  result.complete = fields.Flag("complete");
  result.recorded = fields.Flag("recorded");
  result.recording = fields.Words("recording");
  if (fields.Has("top_mm")) result.top = Millimetres(fields.NumberOrNan("top_mm"));
  return result;
}

void PutStatus(const StatusMessage& message, BoothJson& json) {
  const ScannerStatus& s = message.scanner;
  json["state"] = ScanStateText(s.state);
  json["version"] = s.version;
  json["homed"] = s.homed;
  json["causes"] = List(s.causes, JsonFromCause);
  json["held_by"] = Clipped(s.held_by);
  json["chain"] = List(s.chain, JsonFromNotice);
  json["lines"] = s.lines ? JsonFromLines(*s.lines) : BoothJson(nullptr);
  json["warnings"] = List(s.warnings, JsonFromWarning);
  json["job"] = Clipped(s.job);
  json["stage"] = Clipped(s.stage);
  json["done"] = FiniteOrNull(s.done);
  json["total"] = FiniteOrNull(s.total);
  json["start_presses"] = s.start_presses;
  json["z_mm"] = FiniteOrNull(s.z_mm);
  json["arm"] = s.arm ? JsonFromArm(*s.arm) : BoothJson(nullptr);
  json["scan"] = s.scan ? JsonFromResult(*s.scan) : BoothJson(nullptr);
  json["longest_tick_ns"] = s.longest_tick.count();
  json["controlled"] = message.controlled;
  json["sessions"] = message.sessions;
}

StatusMessage ReadStatus(FieldReader& fields) {
  StatusMessage message;
  ScannerStatus& s = message.scanner;
  s.state = ReadState(fields);
  s.version = fields.Count("version");
  s.homed = fields.Flag("homed");
  fields.Objects("causes", kMaxList, [&](FieldReader& cause) { s.causes.push_back(ReadCause(cause)); });
  s.held_by = fields.Words("held_by");
  fields.Objects("chain", kMaxList, [&](FieldReader& notice) { s.chain.push_back(ReadNotice(notice)); });
  if (fields.Has("lines")) fields.Object("lines", [&](FieldReader& lines) { s.lines = ReadLines(lines); });
  fields.Objects("warnings", kMaxList, [&](FieldReader& warning) { s.warnings.push_back(ReadWarning(warning)); });
  s.job = fields.Words("job");
  s.stage = fields.Words("stage");
  s.done = fields.NumberOrNan("done");
  s.total = fields.NumberOrNan("total");
  s.start_presses = fields.Count("start_presses");
  s.z_mm = fields.NumberOrNan("z_mm");
  if (fields.Has("arm")) fields.Object("arm", [&](FieldReader& arm) { s.arm = ReadArmReport(arm); });
  if (fields.Has("scan")) fields.Object("scan", [&](FieldReader& scan) { s.scan = ReadResult(scan); });
  s.longest_tick = std::chrono::nanoseconds(fields.Integer("longest_tick_ns"));
  message.controlled = fields.Flag("controlled");
  message.sessions = static_cast<std::uint32_t>(fields.Count("sessions", 0xFFFF'FFFFU));
  return message;
}

}  // namespace annulus
