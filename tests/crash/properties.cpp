#include "properties.h"

#include <algorithm>

#include "base/ensure.h"
#include "tests/acquisition/scan_fixture.h"

namespace annulus::test {
namespace {

/// The power goes when everything that will be done is done.
PowerCut CutAtTheEnd(const Trace& trace, std::uint64_t seed) {
  PowerCut cut;
  cut.entries = trace.disk->journal().size();
  cut.time = std::chrono::hours(1);
  cut.seed = seed;
  return cut;
}

/// Whether what is on the disk now holds every acknowledged level.
void CheckAcknowledged(const Trace& trace, const Reader& reader, const std::string& place, Tally& tally) {
  if (trace.acknowledged() == 0) return;
  const CrashDisk::Files files = trace.disk->Live();
  const auto found = files.find(trace.temporary);
  if (found == files.end()) return tally.Violate(tally.unreadable, place + ": the recording is gone");
  const auto read = reader(found->second);
  if (!read) return tally.Violate(tally.unreadable, place + ": " + read.error().Text());
  CheckNothingFalse(*read, trace, place, tally);
  CheckReport(*read, trace, place, tally);
  if (read->scan.levels.size() < trace.acknowledged()) {
    tally.Violate(tally.durable_lost, place + ": " + std::to_string(trace.acknowledged()) + " levels acknowledged, " +
                                          std::to_string(read->scan.levels.size()) + " are there");
  }
}

void CheckFailure(const Trace& trace, const Subject& subject, const std::string& place, Tally& tally) {
  ++tally.states;
  constexpr std::uint64_t kMostCallsAfter = 8;
  if (!trace.failure || trace.finished) tally.Violate(tally.miscounted, place + ": the error was not told");
  if (!trace.failure_repeated) tally.Violate(tally.miscounted, place + ": the error is not final");
  if (trace.promises_after_failure > 0)
    tally.Violate(tally.miscounted, place + ": a sync was believed after one failed");
  if (trace.disk->calls_after_fault() > kMostCallsAfter) tally.Violate(tally.miscounted, place + ": it goes on");
  if (trace.disk->Exists(trace.path)) tally.Violate(tally.miscounted, place + ": it has the name of a whole recording");
  CheckAcknowledged(trace, subject.reader, place, tally);
  Tally cuts;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) CheckPowerCut(trace, CutAtTheEnd(trace, seed), subject.reader, cuts);
  if (!cuts.ok()) tally.Violate(tally.durable_lost, place + ", then " + cuts.first);
}

const char* NameOf(DiskFault fault) {
  constexpr const char* kNames[] = {"ENOSPC", "EIO", "short write", "EIO of sync", "EROFS"};
  return kNames[static_cast<std::size_t>(fault)];
}

/// The bytes of the subject's finished recording.
const std::vector<std::byte> BytesOf(const Trace& trace) {
  const CrashDisk::Files files = trace.disk->Live();
  const auto found = files.find(trace.path);
  return found == files.end() ? std::vector<std::byte>() : found->second;
}

/// The bytes of the finished recording, one string per write.
std::vector<std::vector<std::byte>> WritesOf(const Trace& trace) {
  std::vector<std::vector<std::byte>> writes;
  for (const CrashDisk::Entry& entry : trace.disk->journal()) {
    if (entry.op == CrashDisk::Op::kWrite) writes.push_back(entry.bytes);
  }
  return writes;
}

std::vector<std::byte> Joined(const std::vector<std::vector<std::byte>>& writes) {
  std::vector<std::byte> bytes;
  for (const auto& write : writes) bytes.insert(bytes.end(), write.begin(), write.end());
  return bytes;
}

/// A damaged file: nothing false, not called clean, and at least `least` levels back.
void CheckDamaged(const Trace& trace, const Result<Recording>& read, std::size_t least, const std::string& place,
                  Tally& tally) {
  ++tally.states;
  if (!read) return tally.Violate(tally.unreadable, place + ": " + read.error().Text());
  CheckNothingFalse(*read, trace, place, tally);
  CheckReport(*read, trace, place, tally);
  if (read->report.clean()) tally.Violate(tally.miscounted, place + ": called whole");
  const std::size_t found = read->scan.levels.size();
  if (found < least) {
    tally.Violate(tally.durable_lost,
                  place + ": " + std::to_string(found) + " levels of at least " + std::to_string(least));
  }
  tally.most_lost =
      std::max<std::uint64_t>(tally.most_lost, trace.scan.levels.size() - std::min(found, trace.scan.levels.size()));
}

Trace RecordOne(const Subject& subject, std::uint32_t levels) {
  return Record({.levels = levels, .sealing = subject.sealing, .below = subject.below, .above = subject.above});
}

}  // namespace

Tally FailEveryCall(const Subject& subject, std::uint32_t levels) {
  Tally tally;
  for (const DiskFault fault : {DiskFault::kNoSpace, DiskFault::kIoError, DiskFault::kShortWrite, DiskFault::kSyncError,
                                DiskFault::kReadOnly}) {
    for (std::uint64_t n = 1;; ++n) {
      const Trace trace = Record({.levels = levels,
                                  .sealing = subject.sealing,
                                  .below = subject.below,
                                  .above = subject.above,
                                  .fail_call = n,
                                  .fault = fault});
      if (!trace.disk->fault_hit()) break;
      CheckFailure(trace, subject, std::string(NameOf(fault)) + " at call " + std::to_string(n), tally);
    }
  }
  return tally;
}

Tally CutTheFile(const Subject& subject, std::uint32_t levels, std::size_t step) {
  Tally tally;
  const Trace trace = RecordOne(subject, levels);
  const std::vector<std::byte> whole = BytesOf(trace);
  for (std::size_t cut = 0; cut < whole.size(); cut += step) {
    const std::string place = "cut at byte " + std::to_string(cut);
    const auto before = static_cast<std::size_t>(
        std::upper_bound(trace.level_ends.begin(), trace.level_ends.end(), cut) - trace.level_ends.begin());
    const auto read = subject.reader(std::span(whole).first(cut));
    if (before == 0 && !read) {
      ++tally.states;
      continue;
    }
    CheckDamaged(trace, read, before, place, tally);
    // What ends a write (its index) is no part of the level: the level may be there a few bytes earlier.
    if (read && read->scan.levels.size() > before + 1)
      tally.Violate(tally.false_levels, place + ": more than was written");
  }
  return tally;
}

Tally FlipBits(const Subject& subject, std::uint32_t levels, std::size_t step) {
  Tally tally;
  const Trace trace = RecordOne(subject, levels);
  std::vector<std::byte> bytes = BytesOf(trace);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += step) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    bytes[bit / 8] ^= mask;
    const auto read = subject.reader(bytes);
    bytes[bit / 8] ^= mask;
    constexpr std::size_t kVersionByte = 5;  // a file of another version of MCAP is refused
    if (bit / 8 == kVersionByte && !read) continue;
    CheckDamaged(trace, read, levels - 1, "bit " + std::to_string(bit), tally);
  }
  return tally;
}

Tally RearrangeWrites(const Subject& subject, std::uint32_t levels) {
  Tally tally;
  const Trace trace = RecordOne(subject, levels);
  const auto writes = WritesOf(trace);
  for (std::size_t i = 1; i + 1 < writes.size(); ++i) {
    const std::string place = "write " + std::to_string(i);
    auto missing = writes;
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(i));
    CheckDamaged(trace, subject.reader(Joined(missing)), levels - 1, place + " missing", tally);
    for (std::size_t at = i; at < writes.size(); at += 3) {
      auto twice = writes;
      twice.insert(twice.begin() + static_cast<std::ptrdiff_t>(at), writes[i]);
      CheckDamaged(trace, subject.reader(Joined(twice)), levels, place + " again at " + std::to_string(at), tally);
    }
    if (i + 2 >= writes.size()) continue;
    auto exchanged = writes;
    std::swap(exchanged[i], exchanged[i + 1]);
    CheckDamaged(trace, subject.reader(Joined(exchanged)), levels - 1, place + " exchanged", tally);
  }
  return tally;
}

Tally StartAgain(const Subject& subject, std::uint64_t states) {
  Tally tally;
  const Trace trace = RecordOne(subject, 12);
  for (std::uint64_t seed = 1; seed <= states; ++seed) {
    const PowerCut cut = DrawCut(trace, seed);
    const std::size_t durable = trace.DurableLevels(cut);
    if (durable == 0 || (trace.finished && cut.entries >= *trace.finished)) continue;
    const CrashDisk::Files files = trace.disk->AfterPowerCut(cut);
    if (!files.contains(trace.temporary)) continue;
    ++tally.states;
    const Trace again = Record({.levels = 2,
                                .sealing = subject.sealing,
                                .finish = false,
                                .below = subject.below,
                                .above = subject.above,
                                .existing = files});
    std::size_t most = 0;
    for (const auto& [path, bytes] : again.disk->Live()) {
      if (const auto read = subject.reader(bytes)) most = std::max(most, read->scan.levels.size());
    }
    if (most < durable) {
      tally.Violate(tally.durable_lost, "seed " + std::to_string(seed) + ": the interrupted recording is gone");
    }
  }
  return tally;
}

namespace {

/// One damaged recording, recovered twice.
void CheckRecovery(const Subject& subject, const Trace& trace, const std::vector<std::byte>& damaged,
                   const std::string& place, Tally& tally) {
  const auto before = HonestReader(damaged);
  if (!before) return;
  ++tally.states;
  CrashDisk disk({{"damaged.mcap", damaged}});
  const auto whole = subject.recover(disk, "damaged.mcap", "recovered.mcap");
  if (!whole) return tally.Violate(tally.unreadable, place + ": " + whole.error().Text());
  CrashDisk::Files files = disk.Live();
  if (files["damaged.mcap"] != damaged) tally.Violate(tally.miscounted, place + ": the original was edited");
  const auto after = subject.reader(files["recovered.mcap"]);
  if (!after) return tally.Violate(tally.unreadable, place + ": recovered: " + after.error().Text());
  CheckNothingFalse(*after, trace, place, tally);
  if (!after->report.clean()) tally.Violate(tally.unreadable, place + ": the recovered file is not whole");
  if (!SameLevels(before->scan, after->scan)) tally.Violate(tally.durable_lost, place + ": other levels than before");
  if (*whole && before->report.levels_lost > 0) tally.Violate(tally.miscounted, place + ": a loss was not told");
  const auto again = subject.recover(disk, "recovered.mcap", "again.mcap");
  files = disk.Live();
  const bool same = again && *again && files["again.mcap"] == files["recovered.mcap"];
  if (!same) tally.Violate(tally.miscounted, place + ": recovered again it is not the same");
}

}  // namespace

Tally Recover(const Subject& subject, std::uint64_t states) {
  Tally tally;
  const Trace trace = RecordOne(subject, 12);
  std::vector<std::byte> bytes = BytesOf(trace);
  for (std::uint64_t seed = 1; seed <= states; ++seed) {
    const std::string place = "seed " + std::to_string(seed);
    const CrashDisk::Files files = trace.disk->AfterPowerCut(DrawCut(trace, seed));
    for (const auto& [path, remains] : files) CheckRecovery(subject, trace, remains, place, tally);
    if (bytes.empty()) continue;
    Dice dice(seed);
    const std::uint64_t bit = dice.Below(8 * bytes.size());
    bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    CheckRecovery(subject, trace, bytes, place + ", bit " + std::to_string(bit), tally);
    bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
  }
  return tally;
}

}  // namespace annulus::test
