#include "acquisition/replay.h"

#include <deque>
#include <utility>
#include <variant>

#include "acquisition/bus_record.h"
#include "acquisition/level_pipeline.h"
#include "acquisition/recorded_buses.h"
#include "acquisition/replay_script.h"
#include "base/ensure.h"
#include "firmware_iface/axis_reading.h"
#include "firmware_iface/range_ring.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using namespace bus_record;  // NOLINT(google-build-using-namespace): a replay is about all of it

/// With something between driver and record, an exchange is as recorded if it is not further off than this.
constexpr nanoseconds kUndisturbed = std::chrono::microseconds(100);
constexpr const char* kAttempted = "replay a scan";

}  // namespace

struct Replay::State {
  State(std::shared_ptr<const ReplayScript> replay_script, ReplayOptions replay_options)
      : options(std::move(replay_options)), script(std::move(replay_script)) {}

  Status OpenRing();
  void Load(const ReplayEntry& entry);

  /// Does what a record says was done.
  Status Conduct(const ReplayEntry& entry);
  Status Do(const StartCalled& call);
  Status Do(const NextLevelCalled& call);
  Status Do(const ReadClockCalled& call);
  Status Do(const StopCalled& call);
  Status Do(const PositionCalled& call);
  Status Do(const ModbusExchanged& exchange);
  Status Do(const ScanBegun& scan);
  Status Do(const SweepBegun& sweep);
  Status Do(const SweepEnded& sweep);
  Status Do(const HandedOn& handed);
  Status Do(const ScanEnded& end);
  /// Everything else is loaded into the seams, or of no concern.
  template <class Other>
  Status Do(const Other&) {
    return {};
  }
  /// Compares how a call ended with how it was recorded; false: it failed, or should have, and the scan is over.
  template <class T>
  bool EndsAsRecorded(const char* call, const CallEnd& end, const Result<T>& outcome);
  void Differ(std::string field, std::string recorded, std::string replayed);
  /// Whether the position that is conducted was the scan's last act: something between axis and scan did not like it.
  [[nodiscard]] bool PositionEndedTheScan() const;
  /// What the devices say makes no sense to the pipeline. If the recorded scan ended by that, it is as recorded.
  Status PipelineFailed(const char* field, const Error& error);
  void TakeAll();

  ReplayOptions options;
  std::shared_ptr<const ReplayScript> script;  ///< Shared with the replay that begins anew: it is large.

  // Of the run. What is borrowed stands before what borrows.
  ManualClock clock;
  std::vector<std::unique_ptr<RecordedUsbPort>> ports;
  std::vector<std::unique_ptr<RecordedCanBus>> buses;
  std::unique_ptr<RangeRing> ring;
  std::optional<LevelPipeline> pipeline;
  std::optional<AxisReadingDecoder> decoder;
  std::size_t next = 0;
  nanoseconds now{0};  ///< Of the record that is conducted.
  bool over = false;
  std::optional<RegisterBlock> registers;  ///< Last read.
  std::optional<RingLevel> level;          ///< Last read, not yet in the pipeline.
  RingCounters counters;
  std::deque<ReplayStep> steps;
  std::uint64_t levels_out = 0;    ///< Of the pipeline.
  std::uint64_t levels_given = 0;  ///< By Next.
};

void Replay::State::Load(const ReplayEntry& entry) {
  const auto to = [](auto& seams, std::uint8_t number) {
    return number < seams.size() ? seams[number].get() : nullptr;
  };
  std::visit(
      [&](const auto& record) {
        using Record = std::decay_t<decltype(record)>;
        if constexpr (std::is_same_v<Record, UsbControl> || std::is_same_v<Record, UsbRefused>) {
          if (auto* port = to(ports, record.port)) port->Load(record);
        } else if constexpr (std::is_same_v<Record, UsbEnded>) {
          if (auto* port = to(ports, record.port)) port->Load(entry.time, record);
        } else if constexpr (std::is_same_v<Record, CanLinkRead> || std::is_same_v<Record, CanReceived> ||
                             std::is_same_v<Record, CanFailed> || std::is_same_v<Record, CanOverflows>) {
          if (auto* bus = to(buses, record.bus)) bus->Load(entry.time, record);
        }
      },
      entry.what);
}

Status Replay::State::OpenRing() {
  const auto& ring_opening = std::get<RingOpening>(script->entries[script->opening].what);
  const bool usb = std::holds_alternative<UsbRangeRingOptions>(ring_opening.options);
  std::vector<UsbIdentity> identities(usb ? ring_opening.seams : 0);
  for (std::size_t i = 0; i < script->begun; ++i) {
    const auto* named = std::get_if<UsbPortNamed>(&script->entries[i].what);
    if (named == nullptr) continue;
    // The number of ports that a host lists is known only when it has opened them.
    if (usb && ring_opening.seams == 0 && named->port >= identities.size()) identities.resize(named->port + 1U);
    if (named->port < identities.size()) identities[named->port] = named->identity;
  }
  clock.SleepUntil(script->entries[script->opening].time);
  std::vector<UsbPort*> usb_ports;
  for (const UsbIdentity& identity : identities) {
    ports.push_back(std::make_unique<RecordedUsbPort>(identity, clock));
    usb_ports.push_back(ports.back().get());
  }
  std::vector<CanBus*> can_buses;
  for (std::size_t i = 0; !usb && i < ring_opening.seams; ++i) {
    buses.push_back(std::make_unique<RecordedCanBus>(clock));
    can_buses.push_back(buses.back().get());
  }
  // What passed between the opening and the scan belongs to calls that are not made again.
  for (std::size_t i = script->opening; !std::holds_alternative<RingOpened>(script->entries[i].what); ++i)
    Load(script->entries[i]);
  Result<std::unique_ptr<RangeRing>> opened = Fail(kAttempted, "the ring has no ports", "scan again");
  if (usb && !usb_ports.empty()) {
    if (options.wrap_usb) usb_ports = options.wrap_usb(usb_ports, clock);
    ENSURE(usb_ports.size() == ports.size(), "as many ports come back as were given");
    opened = MakeUsbRangeRing(usb_ports, std::get<UsbRangeRingOptions>(ring_opening.options), clock);
  } else if (!can_buses.empty()) {
    if (options.wrap_can) can_buses = options.wrap_can(can_buses, clock);
    ENSURE(can_buses.size() == buses.size(), "as many buses come back as were given");
    opened = MakeCanRangeRing(can_buses, std::get<CanRangeRingOptions>(ring_opening.options), clock);
  }
  if (!opened) return Fail(opened);
  ring = std::move(*opened);
  for (std::size_t i = script->begun; i < script->entries.size(); ++i) Load(script->entries[i]);
  pipeline.emplace(ring->boards(), script->plan);
  if (script->layout) decoder.emplace(*script->layout);
  next = script->begun;
  return {};
}

void Replay::State::Differ(std::string field, std::string recorded, std::string replayed) {
  ReplayStep step;
  step.time = now;
  step.difference.emplace();
  step.difference->field = std::move(field);
  step.difference->recorded = std::move(recorded);
  step.difference->replayed = std::move(replayed);
  steps.push_back(std::move(step));
}

template <class T>
bool Replay::State::EndsAsRecorded(const char* call, const CallEnd& end, const Result<T>& outcome) {
  const std::string error = outcome ? std::string() : outcome.error().Text();
  if (error != end.error) Differ(std::string("call ") + call, end.error, error);
  if (outcome && !end.error.empty()) over = true;  // nothing of what it might do now was recorded
  // A call that failed as recorded is followed by what was done about it; one that failed now is the end.
  if (!outcome && end.error.empty()) over = true;
  return outcome && !over;
}

Status Replay::State::PipelineFailed(const char* field, const Error& error) {
  if (const ScanEnded* end = script->End(); end != nullptr && end->error.find(error.seen) != std::string::npos)
    return {};
  Differ(field, {}, error.Text());
  over = true;
  return {};
}

bool Replay::State::PositionEndedTheScan() const {
  if (script->End() == nullptr || script->End()->error.empty()) return false;
  for (std::size_t i = next; i < script->ended; ++i) {
    if (std::holds_alternative<StopCalled>(script->entries[i].what)) return true;
    const bool goes_on = std::holds_alternative<NextLevelCalled>(script->entries[i].what) ||
                         std::holds_alternative<ReadClockCalled>(script->entries[i].what) ||
                         std::holds_alternative<PositionCalled>(script->entries[i].what) ||
                         std::holds_alternative<HandedOn>(script->entries[i].what);
    if (goes_on) return false;
  }
  return true;
}

Status Replay::State::Do(const StartCalled& call) {
  // The recorded rate may be damaged: the driver judges it.
  static_cast<void>(EndsAsRecorded("Start", call.end, ring->Start(Hertz(call.level_rate_hz))));
  return {};
}

Status Replay::State::Do(const NextLevelCalled& call) {
  auto read = ring->NextLevel(call.deadline);
  if (EndsAsRecorded("NextLevel", call.end, read)) level = std::move(*read);
  return {};
}

Status Replay::State::Do(const ReadClockCalled& call) {
  if (call.board >= ring->boards().size() + (ring->reference() != nullptr ? 1 : 0)) {
    return Fail(kAttempted,
                "a clock was read of board " + std::to_string(call.board) + ", which the ring does not have",
                "the recording is damaged; use 'annulus recover'");
  }
  auto exchange = ring->ReadClock(call.board);
  if (!EndsAsRecorded("ReadClock", call.end, exchange)) return {};
  const auto disturbed = [](nanoseconds a, nanoseconds b) { return a - b > kUndisturbed || b - a > kUndisturbed; };
  const bool faulty = options.wrap_usb || options.wrap_can;
  // The times of the record count: in real time the driver looked at the clock some microseconds after the tap.
  if (!faulty || (!disturbed(exchange->host_before, call.exchange.host_before) &&
                  !disturbed(exchange->host_after, call.exchange.host_after))) {
    exchange->host_before = call.exchange.host_before;
    exchange->host_after = call.exchange.host_after;
  }
  const Status added = pipeline->AddBoardClock(call.board, *exchange);
  return added ? added : PipelineFailed("clock of a board", added.error());
}

Status Replay::State::Do(const StopCalled& call) {
  counters = ring->counters();
  const auto compare = [&](const char* name, std::uint64_t recorded, std::uint64_t replayed) {
    if (recorded != replayed) Differ(name, std::to_string(recorded), std::to_string(replayed));
  };
  compare("levels", call.counters.levels, counters.levels);
  compare("lost_frames", call.counters.lost_frames, counters.lost_frames);
  compare("duplicate_frames", call.counters.duplicate_frames, counters.duplicate_frames);
  compare("rejected_frames", call.counters.rejected_frames, counters.rejected_frames);
  compare("rejected_bytes", call.counters.rejected_bytes, counters.rejected_bytes);
  compare("overflowed_frames", call.counters.overflowed_frames, counters.overflowed_frames);
  static_cast<void>(EndsAsRecorded("Stop", call.end, ring->Stop()));
  return {};
}

Status Replay::State::Do(const ModbusExchanged& exchange) {
  registers.reset();
  if (!exchange.failure && exchange.request.read_count > 0) {
    registers.emplace(exchange.request.read_address,
                      script->layout ? script->layout->word_order : WordOrder::kHighFirst, exchange.registers);
  }
  return {};
}

Status Replay::State::Do(const PositionCalled& call) {
  if (!call.fresh || PositionEndedTheScan()) return {};
  if (!decoder || !registers || !decoder->Covers(*registers)) {
    Differ("position", "fresh", "the recording holds no registers of it");
    return {};
  }
  const AxisReading reading = decoder->Decode(*registers);
  registers.reset();
  AxisPosition position;
  position.fresh = true;
  position.z = reading.z;
  position.time = {call.host_before, reading.drive_time.value_or((call.host_before + call.host_after) / 2),
                   call.host_after};
  const auto time = pipeline->AddPosition(position);
  if (!time) return PipelineFailed("clock of the axis drive", time.error());
  if (!*time) return {};
  ReplayStep step;
  step.time = now;
  step.axis = AxisPoint{**time, position.z.value()};
  steps.push_back(std::move(step));
  return {};
}

Status Replay::State::Do(const ScanBegun&) {
  if (options.on_begin) options.on_begin();
  return {};
}

Status Replay::State::Do(const SweepBegun& sweep) {
  if (sweep.sweep >= script->plan.sweeps) {
    return Fail(kAttempted, "sweep " + std::to_string(sweep.sweep) + " is not in its plan",
                "the recording is damaged; use 'annulus recover'");
  }
  pipeline->BeginSweep(sweep.sweep);
  return {};
}

Status Replay::State::Do(const SweepEnded&) {
  pipeline->EndSweep();
  return {};
}

void Replay::State::TakeAll() {
  for (ScanLevel& taken : pipeline->Take()) {
    ++levels_out;
    if (options.on_level) options.on_level(taken);
    ReplayStep step;
    step.time = now;
    step.level = std::move(taken);
    steps.push_back(std::move(step));
  }
}

Status Replay::State::Do(const HandedOn& handed) {
  if (handed.with_level && level) {
    const Status added = pipeline->AddLevel(std::move(*level));
    level.reset();
    if (!added) return PipelineFailed("time of a level", added.error());
  }
  TakeAll();
  return {};
}

Status Replay::State::Do(const ScanEnded& end) {
  if (end.levels != levels_out) Differ("levels", std::to_string(end.levels), std::to_string(levels_out));
  over = true;
  return {};
}

Status Replay::State::Conduct(const ReplayEntry& entry) {
  now = entry.time;
  return std::visit(
      [&](const auto& record) {
        if constexpr (requires { record.end.took; }) {
          clock.SleepUntil(entry.time - record.end.took);
        } else if constexpr (std::is_same_v<std::decay_t<decltype(record)>, ScanBegun>) {
          clock.SleepUntil(entry.time);
        }
        Status done = Do(record);
        if constexpr (requires { record.end.took; }) clock.SleepUntil(entry.time);
        return done;
      },
      entry.what);
}

Result<Replay> Replay::Open(std::span<const RawRecord> raw, ReplayOptions options) {
  auto script = ReadReplayScript(raw);
  if (!script) return Fail(script);
  auto state = std::make_unique<State>(std::make_shared<const ReplayScript>(std::move(*script)), std::move(options));
  RETURN_IF_ERROR(state->OpenRing());
  return Replay(std::move(state));
}

Replay::Replay(std::unique_ptr<State> state) : state_(std::move(state)) {}
Replay::Replay(Replay&&) noexcept = default;
Replay& Replay::operator=(Replay&&) noexcept = default;
Replay::~Replay() = default;

Result<std::optional<ReplayStep>> Replay::Next() {
  State& state = *state_;
  while (state.steps.empty() && !state.over && state.next < state.script->entries.size()) {
    RETURN_IF_ERROR(state.Conduct(state.script->entries[state.next++]));
  }
  if (state.steps.empty()) return std::optional<ReplayStep>();
  std::optional<ReplayStep> step(std::move(state.steps.front()));
  state.steps.pop_front();
  if (step->level) ++state.levels_given;
  return step;
}

Status Replay::Seek(std::uint64_t level) {
  if (level < state_->levels_given) {
    // Nothing can be run backwards: from the start, with the same records.
    state_ = std::make_unique<State>(state_->script, state_->options);
    RETURN_IF_ERROR(state_->OpenRing());
  }
  while (state_->levels_given < level) {
    auto step = Next();
    if (!step) return Fail(step);
    if (!*step) {
      return Fail("go to level " + std::to_string(level) + " of a replay",
                  "it has only " + std::to_string(state_->levels_given), "give a smaller number");
    }
  }
  // Steps before the level that are no level belong to those that are not given.
  State& state = *state_;
  while (true) {
    while (!state.steps.empty() && !state.steps.front().level) state.steps.pop_front();
    if (!state.steps.empty()) return {};
    if (state.over || state.next == state.script->entries.size()) break;
    RETURN_IF_ERROR(state.Conduct(state.script->entries[state.next++]));
  }
  return Fail("go to level " + std::to_string(level) + " of a replay",
              "it has only " + std::to_string(state.levels_given), "give a smaller number");
}

std::uint64_t Replay::levels() const { return state_->levels_given; }
double Replay::done() const {
  const auto all = static_cast<double>(state_->script->entries.size() - state_->script->begun);
  return state_->over ? 1.0 : static_cast<double>(state_->next - state_->script->begun) / all;
}
std::uint64_t Replay::unknown_records() const { return state_->script->unknown; }
const RingCounters& Replay::counters() const { return state_->counters; }

}  // namespace annulus
