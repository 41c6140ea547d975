/// The raw records of a scan, as a replay follows them. Beyond "no crash": the parts of an accepted script are what and
/// where they are said to be, and a replay of it comes to an end, twice the same way.
///
/// Input: records, each with two bytes of size, four of time after the record before (ns, signed), and its bytes; all
/// little endian.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <variant>
#include <vector>

#include "acquisition/replay.h"
#include "acquisition/replay_script.h"
#include "base/ensure.h"

namespace {

using namespace annulus;
using std::chrono::nanoseconds;

std::vector<RawRecord> Records(std::span<const std::uint8_t> input) {
  std::vector<RawRecord> records;
  nanoseconds time = std::chrono::seconds(1);
  std::uint16_t size = 0;
  std::int32_t step = 0;
  while (input.size() >= sizeof(size) + sizeof(step)) {
    std::memcpy(&size, input.data(), sizeof(size));
    std::memcpy(&step, input.data() + sizeof(size), sizeof(step));
    input = input.subspan(sizeof(size) + sizeof(step));
    const auto bytes = std::as_bytes(input.first(std::min<std::size_t>(size, input.size())));
    input = input.subspan(bytes.size());
    time += nanoseconds(step);
    records.push_back({RawChannel::kCall, time, {bytes.begin(), bytes.end()}});
  }
  return records;
}

void CheckParts(const ReplayScript& script, std::size_t records) {
  const auto is = [&](auto sample, std::size_t index) {
    return index < script.entries.size() && std::holds_alternative<decltype(sample)>(script.entries[index].what);
  };
  ENSURE(script.entries.size() + script.unknown == records, "every record is an entry or unknown");
  ENSURE(is(bus_record::RingOpening(), script.opening), "the opening is one");
  ENSURE(script.opening < script.begun && is(bus_record::ScanBegun(), script.begun),
         "the ring is opened before a scan");
  ENSURE(script.ended == script.entries.size() || is(bus_record::ScanEnded(), script.ended), "the end is one");
  ENSURE(script.begun < script.ended, "the end comes last");
}

struct Outcome {
  bool opened = false;
  std::uint64_t steps = 0;
  std::uint64_t levels = 0;
  std::string error;
  bool operator==(const Outcome&) const = default;
};

Outcome Run(const std::vector<RawRecord>& records) {
  Outcome outcome;
  auto replay = Replay::Open(records);
  if (!replay) {
    outcome.error = replay.error().Text();
    return outcome;
  }
  outcome.opened = true;
  while (true) {
    auto step = replay->Next();
    if (!step) outcome.error = step.error().Text();
    if (!step || !*step) break;
    ++outcome.steps;
    ENSURE(replay->done() >= 0.0 && replay->done() <= 1.0, "what is done is a part");
  }
  outcome.levels = replay->levels();
  ENSURE(outcome.levels <= records.size(), "every level needs a record");
  return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<RawRecord> records = Records({data, size});
  const auto script = ReadReplayScript(records);
  if (!script) {
    ENSURE(!script.error().advice.empty(), "a refusal says what to do");
    return 0;
  }
  CheckParts(*script, records.size());
  const Outcome once = Run(records);
  constexpr std::size_t kOneTwiceIn = 16;
  if (size % kOneTwiceIn == 0) ENSURE(Run(records) == once, "a replay is the same every time");
  return 0;
}
