#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// Who waits for the disk.
enum class DiskWriterMode {
  kInline,  ///< The caller, at once; the time is what the caller says. One thread, always the same: virtual time.
  kThread,  ///< A thread of the writer's own: the caller never waits, except in Sync and Close.
};

struct DiskWriterOptions {
  DiskWriterMode mode = DiskWriterMode::kInline;
  std::chrono::nanoseconds sync_every = std::chrono::milliseconds(100);  ///< From one sync to the next at most.
  std::uint32_t sync_every_blocks = 8;             ///< Or after so many blocks; 0: only when Sync is called.
  std::size_t queue_bytes = std::size_t{4} << 20;  ///< kThread: most bytes that wait for the disk; more is an Error.
  std::chrono::milliseconds wait = std::chrono::seconds(10);  ///< kThread: the longest that Sync and Close wait.
  /// kThread: time by which a call of the disk is too slow; empty: the system's steady clock. Called from two threads.
  std::function<std::chrono::nanoseconds()> now;
};

/// What became of the blocks that a DiskWriter was given.
struct DiskState {
  std::uint64_t appended = 0;  ///< Blocks taken.
  std::uint64_t written = 0;   ///< Blocks with the system: they outlive this process.
  std::uint64_t synced = 0;    ///< Blocks on the disk: they outlive a power cut.
  std::size_t queued_bytes = 0;
  std::chrono::nanoseconds pending{0};       ///< So long the disk has been at the call that it is at; 0: it is at none.
  std::chrono::nanoseconds longest_call{0};  ///< Of those that have ended.
  std::optional<Error> failure;              ///< The first; final.
};

/// A file whose writes and syncs happen in their order, each write as one block, beside the caller or in its stead.
/// A sync that failed is never repeated: the system forgets the error, and a second one would succeed without the data.
/// After any failure nothing more is written. Thread-bound but for state().
///
/// A thread that hangs in the disk is waited for by the destructor, without a limit: it holds the file.
class DiskWriter final : public AppendFile {
 public:
  /// A call of the disk that takes longer is worth a warning.
  static constexpr std::chrono::milliseconds kSlowCall{200};

  DiskWriter(std::unique_ptr<AppendFile> file, DiskWriterOptions options);
  DiskWriter(const DiskWriter&) = delete;
  DiskWriter& operator=(const DiskWriter&) = delete;
  ~DiskWriter() override;

  /// One block. kThread: an Error also if the queue has no room for it; then it is not taken, and none after it.
  Status Append(std::span<const std::byte> bytes) override;
  /// All that was appended to the disk; waits for it, in kThread at most options.wait.
  Status Sync() override;
  /// Before the first block.
  Status Reserve(std::uint64_t bytes) override;
  Status Close() override;

  /// kInline: it is `time` now (the caller's clock); syncs if that is due. kThread: tells the latched failure.
  Status Tick(std::chrono::nanoseconds time);
  /// Asks for a sync and says whether all is synced that was appended before the first of the calls since it last said
  /// so. kThread: does not wait.
  Result<bool> Settle();

  /// Thread-safe.
  [[nodiscard]] DiskState state() const;
  /// What the operator should know: the disk takes long, or the queue fills. Empty: nothing. Thread-safe.
  [[nodiscard]] std::string Note() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace annulus
