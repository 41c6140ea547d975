#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "acquisition/disk_writer.h"
#include "acquisition/scan.h"
#include "acquisition/scan_sink.h"
#include "acquisition/sealed_file.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// Where the carriage was.
struct AxisPoint {
  std::chrono::nanoseconds time{0};  ///< Host clock.
  double z_mm = 0.0;                 ///< Carriage height, station frame, mm.

  bool operator==(const AxisPoint&) const = default;
};

/// Something worth remembering that happened during a scan.
struct RecordedEvent {
  std::chrono::nanoseconds time{0};  ///< Host clock.
  std::string text;                  ///< Plain words, UTF-8; no customer's name.

  bool operator==(const RecordedEvent&) const = default;
};

/// How a recording is written.
struct RecordingOptions {
  std::uint64_t reserve_bytes = 0;      ///< Disk space taken before the first level; 0 = none.
  std::uint32_t sync_every_levels = 8;  ///< Writes between syncs to the disk; 0 = only header and end.
  std::chrono::nanoseconds sync_every = std::chrono::milliseconds(100);  ///< Time between syncs, if something is new.
  DiskWriterMode disk = DiskWriterMode::kInline;
  /// kThread: most bytes that wait for the disk; 0 = what ten seconds of scanning make, at least 4 MiB.
  std::size_t queue_bytes = 0;
  /// kThread: by which a call of the disk is slow; empty = the system's steady clock. Called from two threads.
  std::function<std::chrono::nanoseconds()> disk_clock = {};
  /// Seals the recording with the key for new recordings; null: plain. Borrowed by Create only.
  const KeySource* keys = nullptr;
};

/// Bytes that a scan of so many levels takes at most, raw bytes, decoded levels, points and track included: what is
/// reserved before it, and by which free space is judged.
[[nodiscard]] std::uint64_t RecordingReserve(std::uint32_t levels, std::size_t sensors);

/// Writes the recording of one scan while it is taken (docs/formats.md). What comes between two levels is collected and
/// written together with the next level, as one chunk, with one write; without levels, once it spans 100 ms of its own
/// times or 64 KiB. The file has a temporary name until Finish(); if the program dies, or the writer goes away
/// unfinished, that file stays and ReadRecording reads it. The first failure is final: later calls repeat it.
/// Thread-bound.
class RecordingWriter final : public ScanSink {
 public:
  /// Creates the temporary file beside `path` and makes `header` durable, with the file's name, before it returns.
  /// Borrows `storage`.
  static Result<RecordingWriter> Create(Storage& storage, const std::string& path, const ScanHeader& header,
                                        const RecordingOptions& options = {});
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;
  ~RecordingWriter() override;

  /// One level and all that came before it, with one write. As many readings as the header has sensors; z must be
  /// finite. kInline: it is with the system when the call returns. kThread: see written_levels().
  Status AppendLevel(const ScanLevel& level) override;
  Status AppendEvent(std::chrono::nanoseconds time, const std::string& text) override;
  Status AppendAxis(std::chrono::nanoseconds time, double z_mm) override;
  Status AppendRaw(RawRecord record) override;
  Status AppendSafety(const SafetyLines& lines) override;
  /// Writes what was collected and asks for a sync. True once all is on the disk.
  Result<bool> Settle() override;
  /// Ends the file (counts, hash of the levels, index), syncs, and gives it its name, replacing an existing file. Waits
  /// for the disk, at most DiskWriterOptions::wait per step.
  Status Finish();
  /// Closes and removes the temporary file; for output that nobody wants half done.
  void Discard();

  /// Where the bytes are until Finish().
  [[nodiscard]] const std::string& temporary_path() const;
  /// Levels appended so far.
  [[nodiscard]] std::uint64_t level_count() const;
  /// Levels that outlive this process.
  [[nodiscard]] std::uint64_t written_levels() const;
  /// Levels that outlive a power cut.
  [[nodiscard]] std::uint64_t durable_levels() const;
  /// What became of the writes.
  [[nodiscard]] DiskState disk_state() const;
  /// What the operator should know of the disk, "" if nothing; see DiskWriter::Note.
  [[nodiscard]] std::string disk_note() const;

 private:
  struct State;
  explicit RecordingWriter(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

/// What is amiss with a recording. Levels that are returned are always as they were written.
struct RecordingReport {
  bool finished = false;                          ///< Finish() was reached.
  bool sealed = false;                            ///< It is encrypted on the disk.
  bool recovered = false;                         ///< `annulus recover` wrote it.
  std::uint64_t frames_lost = 0;                  ///< Of a sealed file: known from gaps in the numbers of its frames.
  std::uint64_t levels_lost = 0;                  ///< Known from gaps in the sequence, and from the end record.
  std::map<std::string, std::uint64_t> messages;  ///< Found, by topic.
  std::map<std::string, std::uint64_t> messages_lost;  ///< The same as levels_lost, for every topic that lost some.
  std::vector<std::string> notes;                      ///< One line per damage, with its place.

  [[nodiscard]] bool clean() const { return finished && levels_lost == 0 && notes.empty(); }
};

/// Everything that a recording holds.
struct Recording {
  Scan scan;
  std::vector<AxisPoint> axis;
  std::vector<RecordedEvent> events;
  std::vector<RawRecord> raw;       ///< In the order in which it passed the buses.
  std::vector<SafetyLines> safety;  ///< In time order.
  RecordingReport report;
};

/// Reads a recording in memory, damaged or unfinished too, sealed or plain. Fails if it is not a recording of ours, if
/// it is sealed and `keys` is null or has no right key, if the header cannot be recovered, or if not one level is left.
/// `name` is what messages call it.
Result<Recording> ParseRecording(std::span<const std::byte> bytes, const std::string& name,
                                 const KeySource* keys = nullptr);

/// Reads a recording file with everything in it.
Result<Recording> ReadWholeRecording(Storage& storage, const std::string& path, const KeySource* keys = nullptr);

/// Reads the scan of a recording file; damage is written to the log as a warning.
Result<Scan> ReadRecording(Storage& storage, const std::string& path, const KeySource* keys = nullptr);

/// Writes `scan` as a recording; the same scan gives the same bytes. On failure nothing is left.
Status WriteRecording(Storage& storage, const std::string& path, const Scan& scan);

/// True if `bytes` begin as every recording (and every other MCAP file, or a sealed file) does.
[[nodiscard]] bool LooksLikeRecording(std::span<const std::byte> bytes);

}  // namespace annulus
