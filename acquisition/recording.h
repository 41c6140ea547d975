#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "acquisition/scan.h"
#include "acquisition/scan_run.h"
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
  std::uint32_t sync_every_levels = 8;  ///< Levels between syncs to the disk; 0 = only header and end.
};

/// Writes the recording of one scan while it is taken (docs/formats.md). The file has a temporary name until Finish();
/// if the program dies, or the writer goes away unfinished, that file stays and ReadRecording reads it. The first
/// failure is final: later calls repeat it. Thread-bound.
class RecordingWriter final : public ScanSink {
 public:
  /// Creates the temporary file beside `path` and makes `header` durable before it returns. Borrows `storage`.
  static Result<RecordingWriter> Create(Storage& storage, const std::string& path, const ScanHeader& header,
                                        const RecordingOptions& options = {});
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;
  ~RecordingWriter() override;

  /// One level, with one write to the file. As many readings as the header has sensors; z must be finite.
  Status AppendLevel(const ScanLevel& level) override;
  Status AppendEvent(std::chrono::nanoseconds time, const std::string& text) override;
  Status AppendAxis(std::chrono::nanoseconds time, double z_mm) override;
  /// Ends the file (count and hash of the levels, index), syncs, and gives it its name, replacing an existing file.
  Status Finish();
  /// Closes and removes the temporary file; for output that nobody wants half done.
  void Discard();

  /// Where the bytes are until Finish().
  [[nodiscard]] const std::string& temporary_path() const;
  /// Levels appended so far.
  [[nodiscard]] std::uint64_t level_count() const;

 private:
  struct State;
  explicit RecordingWriter(std::unique_ptr<State> state);
  Status Start(const ScanHeader& header);

  std::unique_ptr<State> state_;
};

/// What is amiss with a recording. Levels that are returned are always as they were written.
struct RecordingReport {
  bool finished = false;           ///< Finish() was reached.
  std::uint64_t levels_lost = 0;   ///< Known from gaps in the sequence, and from the end record.
  std::vector<std::string> notes;  ///< One line per damage, with its place.

  [[nodiscard]] bool clean() const { return finished && levels_lost == 0 && notes.empty(); }
};

/// Everything that a recording holds.
struct Recording {
  Scan scan;
  std::vector<AxisPoint> axis;
  std::vector<RecordedEvent> events;
  RecordingReport report;
};

/// Reads a recording in memory, damaged or unfinished too. Fails if it is not a recording of ours, if the header
/// cannot be recovered, or if not one level is left. `name` is what messages call it.
Result<Recording> ParseRecording(std::span<const std::byte> bytes, const std::string& name);

/// Reads a recording file with everything in it.
Result<Recording> ReadWholeRecording(Storage& storage, const std::string& path);

/// Reads the scan of a recording file; damage is written to the log as a warning.
Result<Scan> ReadRecording(Storage& storage, const std::string& path);

/// Writes `scan` as a recording; the same scan gives the same bytes. On failure nothing is left.
Status WriteRecording(Storage& storage, const std::string& path, const Scan& scan);

/// True if `bytes` begin as every recording (and every other MCAP file) does.
[[nodiscard]] bool LooksLikeRecording(std::span<const std::byte> bytes);

}  // namespace annulus
