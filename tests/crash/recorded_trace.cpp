#include "recorded_trace.h"

#include <algorithm>
#include <utility>

#include "forwarding_storage.h"
#include "subject.h"
#include "tests/acquisition/scan_fixture.h"

namespace annulus::test {
namespace {

constexpr char kPath[] = "scans/scan.mcap";
constexpr std::uint32_t kLevelsPerEvent = 5;

/// Writes down what the writer is told: bytes taken and syncs done.
class Witness final : public ForwardingStorage {
 public:
  Witness(Storage& below, Trace& trace) : ForwardingStorage(below), trace_(trace) {}

  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    auto file = below_.Create(path);
    if (!file) return Fail(file);
    bytes_ = 0;
    return std::make_unique<File>(*this, std::move(*file));
  }

  /// Bytes that the file was said to have taken.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  void set_caller(SyncCaller caller) { caller_ = caller; }
  void set_time(std::chrono::nanoseconds time) { time_ = time; }

 private:
  class File final : public ForwardingFile {
   public:
    File(Witness& witness, std::unique_ptr<AppendFile> below) : ForwardingFile(std::move(below)), witness_(witness) {}
    Status Append(std::span<const std::byte> bytes) override {
      Status status = below_->Append(bytes);
      if (status) witness_.bytes_ += bytes.size();
      return status;
    }
    Status Sync() override {
      Status status = below_->Sync();
      if (status && witness_.sync_failed_) ++witness_.trace_.promises_after_failure;
      if (status) {
        witness_.trace_.promises.push_back(
            {witness_.trace_.disk->journal().size(), witness_.time_, witness_.caller_, witness_.bytes_});
      }
      witness_.sync_failed_ = witness_.sync_failed_ || !status;
      return status;
    }

   private:
    Witness& witness_;
  };

  Trace& trace_;
  std::uint64_t bytes_ = 0;
  SyncCaller caller_ = SyncCaller::kWaits;
  std::chrono::nanoseconds time_{0};
  bool sync_failed_ = false;
};

/// Keeps the writer's failures.
void Judge(Trace& trace, const Status& status) {
  if (trace.failure) {
    trace.failure_repeated = trace.failure_repeated && !status && status.error().seen == trace.failure->seen;
  } else if (!status) {
    trace.failure = status.error();
  }
}

void MakeContent(Trace& trace, const TracePlan& plan) {
  trace.scan = MakeScan(plan.levels, plan.sensors);
  const std::int64_t period_ns = 1'000'000'000LL / plan.levels_per_s;
  trace.scan.header.wall_start_ns += plan.content;
  Dice dice(plan.content);
  for (ScanLevel& level : trace.scan.levels) {
    for (RangeReading& reading : level.readings) reading.range_mm += plan.content;
    level.time = std::chrono::nanoseconds(1'000'000'000LL + period_ns * level.index);
    const auto before = level.time - std::chrono::milliseconds(1);
    trace.axis.push_back({before, 1800.0 - 5.0 * level.index});
    for (const RawChannel channel : {RawChannel::kUsb, RawChannel::kModbus}) {
      RawRecord record{channel, before, std::vector<std::byte>(20 + dice.Below(30))};
      for (std::byte& byte : record.bytes) byte = static_cast<std::byte>(dice.Next() >> 56U);
      trace.raw.push_back(std::move(record));
    }
    if (level.index % kLevelsPerEvent != 0) continue;
    trace.events.push_back({level.time, "level " + std::to_string(level.index)});
    SafetyLines lines;
    lines.time = level.time;
    lines.input[level.index % lines.input.size()] = true;
    trace.safety.push_back(lines);
  }
}

/// What goes before a level, and the level.
Status AppendAll(RecordingWriter& writer, const Trace& trace, const ScanLevel& level) {
  const AxisPoint& axis = trace.axis[level.index];
  RETURN_IF_ERROR(writer.AppendAxis(axis.time, axis.z_mm));
  for (const std::size_t i : {0U, 1U}) RETURN_IF_ERROR(writer.AppendRaw(trace.raw[2 * std::size_t{level.index} + i]));
  if (level.index % kLevelsPerEvent == 0) {
    const RecordedEvent& event = trace.events[level.index / kLevelsPerEvent];
    RETURN_IF_ERROR(writer.AppendEvent(event.time, event.text));
    RETURN_IF_ERROR(writer.AppendSafety(trace.safety[level.index / kLevelsPerEvent]));
  }
  return writer.AppendLevel(level);
}

void WriteLevels(RecordingWriter& writer, Witness& witness, Trace& trace) {
  for (const ScanLevel& level : trace.scan.levels) {
    trace.disk->set_time(level.time);
    witness.set_time(level.time);
    const Status status = AppendAll(writer, trace, level);
    Judge(trace, status);
    if (trace.failure) continue;  // the calls after a failure are made, so that it is seen to be repeated
    trace.level_entries.push_back(trace.disk->journal().size());
    trace.level_ends.push_back(witness.bytes());
  }
}

RecordingOptions OptionsFor(const TracePlan& plan) {
  RecordingOptions options;
  options.reserve_bytes = std::uint64_t{1} << 16U;
  if (plan.sealing == Sealing::kSealed) options.keys = &TestKeys();
  return options;
}

}  // namespace

Trace Record(const TracePlan& plan) {
  Trace trace;
  MakeContent(trace, plan);
  trace.path = kPath;
  trace.levels_per_s = plan.levels_per_s;
  trace.disk = std::make_unique<CrashDisk>(plan.existing);
  CrashDisk& disk = *trace.disk;
  if (plan.fail_call > 0) disk.FailCall(plan.fail_call, plan.fault);
  const std::unique_ptr<Storage> below = plan.below ? plan.below(disk, disk) : nullptr;
  Witness witness(below ? *below : static_cast<Storage&>(disk), trace);
  const std::unique_ptr<Storage> above = plan.above ? plan.above(witness, disk) : nullptr;
  auto writer = RecordingWriter::Create(above ? *above : static_cast<Storage&>(witness), kPath, trace.scan.header,
                                        OptionsFor(plan));
  if (!writer) {
    trace.failure = writer.error();
    return trace;
  }
  trace.created = disk.journal().size();
  trace.temporary = writer->temporary_path();
  disk.set_caller(SyncCaller::kGoesOn);
  witness.set_caller(SyncCaller::kGoesOn);
  WriteLevels(*writer, witness, trace);
  disk.set_caller(SyncCaller::kWaits);
  witness.set_caller(SyncCaller::kWaits);
  if (!plan.finish) return trace;
  const Status finished = writer->Finish();
  Judge(trace, finished);
  if (finished) trace.finished = disk.journal().size();
  return trace;
}

std::size_t Trace::DurableLevels(const PowerCut& cut) const {
  std::uint64_t bytes = 0;
  for (const Promise& promise : promises) {
    const bool over = promise.caller == SyncCaller::kWaits || promise.time + cut.sync_takes <= cut.time;
    if (promise.entries <= cut.entries && over) bytes = promise.bytes;
  }
  return static_cast<std::size_t>(std::upper_bound(level_ends.begin(), level_ends.end(), bytes) - level_ends.begin());
}

std::size_t Trace::LevelsGiven(const PowerCut& cut) const {
  const auto whole = static_cast<std::size_t>(
      std::upper_bound(level_entries.begin(), level_entries.end(), cut.entries) - level_entries.begin());
  return std::min(whole + (cut.torn_bytes > 0 ? 1 : 0), scan.levels.size());
}

}  // namespace annulus::test
