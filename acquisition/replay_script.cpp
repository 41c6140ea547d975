#include "acquisition/replay_script.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "firmware_iface/canopen.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_frame_codec.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using namespace bus_record;  // NOLINT(google-build-using-namespace): a script is made of all of it

constexpr const char* kAttempted = "replay a scan";
/// Times that a host's clock can show: 0 … 200 years. Others come from damage, and could not be calculated with.
constexpr nanoseconds kLatest = std::chrono::hours(24 * 365 * 200);
/// What a call may have taken, and how far ahead its deadline may lie: a replay waits for it step by step.
constexpr nanoseconds kLongestCall = std::chrono::minutes(10);
constexpr nanoseconds kLongestWait = std::chrono::minutes(1);
bool IsTime(nanoseconds time) { return time >= nanoseconds(0) && time <= kLatest; }
bool IsDuration(nanoseconds took) { return took >= nanoseconds(0) && took <= kLongestCall; }
bool IsWait(nanoseconds wait) { return wait >= nanoseconds(0) && wait <= kLongestWait; }

bool IsSane(const std::optional<ReferenceBoardOptions>& reference) {
  return !reference || std::all_of(reference->channels.begin(), reference->channels.end(),
                                   [](std::uint8_t channel) { return channel < kSensorsPerBoard; });
}
bool IsSane(const UsbRangeRingOptions& options) {
  constexpr std::size_t kMostTransfers = 1024;
  return IsWait(options.control_timeout) && options.sensor_count > 0 && options.transfers_per_board > 0 &&
         options.transfers_per_board <= kMostTransfers && IsSane(options.reference);
}
bool IsSane(const CanRangeRingOptions& options) {
  const bool heartbeat = options.heartbeat >= std::chrono::milliseconds(1) && options.heartbeat < kLongestWait;
  return IsWait(options.boot_deadline) && heartbeat && IsWait(options.sdo_timeout) && options.sensor_count > 0 &&
         options.board_count > 0 && options.board_count + (options.reference ? 1 : 0) <= kLastNodeId &&
         IsSane(options.reference);
}

/// Whether what a record tells can be calculated with: its checksum does not say who wrote it.
bool IsSane(const ReplayEntry& entry) {
  if (!IsTime(entry.time)) return false;
  const auto judge = [&](const auto& record) {
    using Record = std::decay_t<decltype(record)>;
    bool sane = true;
    if constexpr (requires { record.end.took; }) sane = sane && IsDuration(record.end.took);
    if constexpr (requires { record.deadline; }) {
      sane = sane && IsTime(record.deadline) && record.deadline <= entry.time + kLongestWait;
    }
    if constexpr (requires { record.host_time; }) sane = sane && IsTime(record.host_time);
    if constexpr (std::is_same_v<Record, UsbControl>) sane = sane && IsDuration(record.took);
    if constexpr (std::is_same_v<Record, CanReceived>) sane = sane && IsTime(record.reception.host_time);
    if constexpr (std::is_same_v<Record, PositionCalled>) {
      sane = sane && IsTime(record.host_before) && IsTime(record.host_after);
    }
    if constexpr (std::is_same_v<Record, ReadClockCalled>) {
      sane = sane && IsTime(record.exchange.host_before) && IsTime(record.exchange.host_after);
    }
    if constexpr (std::is_same_v<Record, RingOpening>) {
      sane = sane && std::visit([](const auto& options) { return IsSane(options); }, record.options);
    }
    if constexpr (std::is_same_v<Record, AxisOpened>) {
      sane = sane && std::isfinite(record.layout.units_per_mm) && record.layout.units_per_mm > 0.0;
    }
    return sane;
  };
  return std::visit(judge, entry.what);
}

tl::unexpected<Error> NoRawBytes(const std::string& seen) {
  return Fail(kAttempted, seen,
              "only scans that the booth took with this version of the program, or a later one, can be replayed");
}

/// Finds the parts of a scan.
Status Divide(ReplayScript& script) {
  const auto find = [&](auto sample, std::size_t from) {
    using Record = decltype(sample);
    while (from < script.entries.size() && !std::holds_alternative<Record>(script.entries[from].what)) ++from;
    return from;
  };
  script.opening = find(RingOpening(), 0);
  if (script.opening == script.entries.size()) return NoRawBytes("the recording holds no raw bytes of a ring");
  if (find(RingOpened(), script.opening) == script.entries.size()) {
    return NoRawBytes("the raw bytes end before the ring was open");
  }
  script.begun = find(ScanBegun(), script.opening);
  if (script.begun == script.entries.size()) return NoRawBytes("the raw bytes end before the scan began");
  script.ended = find(ScanEnded(), script.begun);
  auto read = PlanFromJson(std::get<ScanBegun>(script.entries[script.begun].what).plan_json);
  if (!read) return Fail(read);
  script.plan = std::move(*read);
  const std::size_t axis = find(AxisOpened(), 0);
  if (axis < script.begun) script.layout = std::get<AxisOpened>(script.entries[axis].what).layout;
  return {};
}

}  // namespace

Result<ReplayScript> ReadReplayScript(std::span<const RawRecord> raw) {
  if (raw.empty()) return NoRawBytes("the recording holds no raw bytes");
  ReplayScript script;
  script.entries.reserve(raw.size());
  for (const RawRecord& record : raw) {
    auto decoded = DecodeBusRecord(record);
    if (!decoded) return Fail(decoded);
    if (std::holds_alternative<Unknown>(*decoded)) {
      ++script.unknown;
      continue;
    }
    ReplayEntry entry{record.time, std::move(*decoded)};
    if (!IsSane(entry)) {
      return Fail(kAttempted, "a time or a number in the raw bytes cannot be",
                  "use 'annulus recover' to save what is sound of the recording");
    }
    script.entries.push_back(std::move(entry));
  }
  RETURN_IF_ERROR(Divide(script));
  return script;
}

}  // namespace annulus
