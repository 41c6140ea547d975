#include "acquisition/disk_writer.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "base/ensure.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

nanoseconds SteadyNow() { return std::chrono::steady_clock::now().time_since_epoch(); }

std::string Milliseconds(nanoseconds time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) + " ms";
}

}  // namespace

struct DiskWriter::State {
  // Of the thread that talks to the disk; in kThread the writer's own from the first block on.
  std::unique_ptr<AppendFile> file;
  DiskWriterOptions options;
  nanoseconds last_sync{0};  ///< kThread: by the steady clock. kInline: by the caller's.

  // Shared.
  mutable std::mutex mutex;
  std::condition_variable_any work;  ///< For the thread: blocks, a wish for a sync, the end.
  std::condition_variable progress;  ///< For the caller: something was written or synced, or failed.
  std::deque<std::vector<std::byte>> queue;
  DiskState disk;
  std::optional<nanoseconds> call_since;  ///< A call of the disk is going on.
  std::optional<Error> overflow;  ///< The queue was full: final for the caller, but what is queued is still written.
  std::optional<std::uint64_t> settling;  ///< Blocks that were appended when somebody began to settle.
  std::uint64_t sync_wish = 0;            ///< Number of the newest wish for a sync.
  std::uint64_t sync_granted = 0;         ///< All wishes up to this one are fulfilled.
  bool closed = false;
  std::optional<nanoseconds> inline_time;  ///< kInline: of the newest Tick.

  std::jthread thread;  ///< Last: ends before the rest goes.

  [[nodiscard]] bool threaded() const { return options.mode == DiskWriterMode::kThread; }
  [[nodiscard]] Status FailureLocked() const {
    if (disk.failure) return tl::unexpected<Error>(*disk.failure);
    if (overflow) return tl::unexpected<Error>(*overflow);
    return {};
  }
  /// One call of the disk, timed; not locked.
  template <class Call>
  Status Timed(Call call);
  void Write(std::span<const std::byte> bytes);
  void SyncNow();
  void Run(const std::stop_token& stop);
  [[nodiscard]] bool SyncDueLocked() const;
  [[nodiscard]] bool OverdueLocked() const;
  template <class Done>
  Status WaitLocked(std::unique_lock<std::mutex>& lock, const std::string& attempted, Done done);
};

template <class Call>
Status DiskWriter::State::Timed(Call call) {
  {
    const std::lock_guard lock(mutex);
    call_since = options.now();
  }
  Status status = call();
  const std::lock_guard lock(mutex);
  disk.longest_call = std::max(disk.longest_call, options.now() - *call_since);
  call_since.reset();
  if (!status && !disk.failure) disk.failure = status.error();
  return status;
}

void DiskWriter::State::Write(std::span<const std::byte> bytes) {
  const Status status = Timed([&] { return file->Append(bytes); });
  const std::lock_guard lock(mutex);
  if (status) ++disk.written;
}

void DiskWriter::State::SyncNow() {
  std::uint64_t written = 0;
  {
    const std::lock_guard lock(mutex);
    written = disk.written;
  }
  const Status status = Timed([&] { return file->Sync(); });
  const std::lock_guard lock(mutex);
  if (status) disk.synced = written;
}

bool DiskWriter::State::SyncDueLocked() const {
  const std::uint64_t unsynced = disk.written - disk.synced;
  if (disk.failure) return false;
  if (sync_wish > sync_granted) return true;
  if (unsynced == 0 || options.sync_every_blocks == 0) return false;
  const nanoseconds now = threaded() ? SteadyNow() : inline_time.value_or(last_sync);
  return unsynced >= options.sync_every_blocks || now - last_sync >= options.sync_every;
}

/// Something written waits too long already: it is synced even if more could be written.
bool DiskWriter::State::OverdueLocked() const {
  return options.sync_every_blocks > 0 && disk.written > disk.synced && SteadyNow() - last_sync >= options.sync_every;
}

/// The writer's own thread: writes what is queued, syncs when that is due, until it is told to end and all is done.
void DiskWriter::State::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex);
  while (true) {
    const auto something = [&] { return !queue.empty() || SyncDueLocked(); };
    const bool unsynced = !disk.failure && options.sync_every_blocks > 0 && disk.written > disk.synced;
    if (unsynced) {
      const auto left = options.sync_every - (SteadyNow() - last_sync);
      work.wait_for(lock, stop, left, something);
    } else {
      work.wait(lock, stop, something);
    }
    if (disk.failure) {  // nothing more is written; blocks that wait are lost, and the caller is told
      queue.clear();
      disk.queued_bytes = 0;
      progress.notify_all();
      if (stop.stop_requested()) return;
      continue;
    }
    if (!queue.empty() && !OverdueLocked()) {
      const std::vector<std::byte> block = std::move(queue.front());
      queue.pop_front();
      lock.unlock();
      Write(block);
      lock.lock();
      disk.queued_bytes -= block.size();
    } else if (SyncDueLocked()) {
      // A wish is for all that was appended before it, and that is written only once nothing is queued.
      const std::uint64_t wish = queue.empty() ? sync_wish : sync_granted;
      lock.unlock();
      SyncNow();
      lock.lock();
      sync_granted = wish;
      last_sync = SteadyNow();
    } else if (stop.stop_requested()) {
      return;
    }
    progress.notify_all();
  }
}

template <class Done>
Status DiskWriter::State::WaitLocked(std::unique_lock<std::mutex>& lock, const std::string& attempted, Done done) {
  if (progress.wait_for(lock, options.wait, [&] { return disk.failure || done(); })) return FailureLocked();
  return Fail(attempted, "the disk has not taken it within " + Milliseconds(options.wait),
              "check the disk; what was written before stays readable");
}

DiskWriter::DiskWriter(std::unique_ptr<AppendFile> file, DiskWriterOptions options)
    : state_(std::make_unique<State>()) {
  ENSURE(file != nullptr, "a disk writer writes a file");
  state_->file = std::move(file);
  state_->options = std::move(options);
  if (!state_->options.now) state_->options.now = SteadyNow;
  if (!state_->threaded()) return;
  state_->last_sync = SteadyNow();
  state_->thread = std::jthread([state = state_.get()](const std::stop_token& stop) { state->Run(stop); });
}

DiskWriter::~DiskWriter() {
  if (!state_->thread.joinable()) return;
  state_->thread.request_stop();
  state_->thread.join();
}

Status DiskWriter::Append(std::span<const std::byte> bytes) {
  std::unique_lock lock(state_->mutex);
  ENSURE(!state_->closed, "a closed file takes no more");
  RETURN_IF_ERROR(state_->FailureLocked());
  DiskState& disk = state_->disk;
  if (!state_->threaded()) {
    ++disk.appended;
    lock.unlock();
    state_->Write(bytes);
    lock.lock();
    return state_->FailureLocked();
  }
  if (disk.queued_bytes + bytes.size() > state_->options.queue_bytes) {
    state_->overflow =
        Error{"record the scan", "the disk is too slow: " + std::to_string(disk.queued_bytes) + " bytes wait for it",
              "check the disk, or use a faster one"};
    return state_->FailureLocked();
  }
  ++disk.appended;
  disk.queued_bytes += bytes.size();
  state_->queue.emplace_back(bytes.begin(), bytes.end());
  state_->work.notify_one();
  return {};
}

Status DiskWriter::Sync() {
  std::unique_lock lock(state_->mutex);
  ENSURE(!state_->closed, "a closed file takes no more");
  RETURN_IF_ERROR(state_->FailureLocked());
  if (!state_->threaded()) {
    lock.unlock();
    state_->SyncNow();
    lock.lock();
    if (state_->inline_time) state_->last_sync = *state_->inline_time;
    return state_->FailureLocked();
  }
  const std::uint64_t wish = ++state_->sync_wish;
  state_->work.notify_one();
  return state_->WaitLocked(lock, "bring the recording to the disk", [&] { return state_->sync_granted >= wish; });
}

Status DiskWriter::Reserve(std::uint64_t bytes) {
  ENSURE(state().appended == 0, "room is reserved before the first block");
  return state_->Timed([&] { return state_->file->Reserve(bytes); });
}

Status DiskWriter::Close() {
  ENSURE(!state_->closed, "a file is closed once");
  Status waited;
  if (state_->threaded()) {
    std::unique_lock lock(state_->mutex);
    waited = state_->WaitLocked(lock, "close the recording",
                                [&] { return state_->disk.written == state_->disk.appended && !state_->call_since; });
    if (state_->call_since) return waited;  // the destructor waits for what hangs
    lock.unlock();
    state_->thread.request_stop();
    state_->thread.join();
  }
  state_->closed = true;
  if (!waited) return waited;
  return state_->Timed([&] { return state_->file->Close(); });
}

Status DiskWriter::Tick(std::chrono::nanoseconds time) {
  std::unique_lock lock(state_->mutex);
  RETURN_IF_ERROR(state_->FailureLocked());
  if (state_->threaded()) return {};
  if (!state_->inline_time) state_->last_sync = time;
  state_->inline_time = std::max(state_->inline_time.value_or(time), time);
  if (!state_->SyncDueLocked()) return {};
  lock.unlock();
  return Sync();
}

Result<bool> DiskWriter::Settle() {
  if (!state_->threaded()) {
    const DiskState disk = state();
    if (disk.failure) return tl::unexpected<Error>(*disk.failure);
    if (disk.synced < disk.appended) RETURN_IF_ERROR(Sync());
    return true;
  }
  const std::lock_guard lock(state_->mutex);
  RETURN_IF_ERROR(state_->FailureLocked());
  // What is appended between the calls does not count: whoever waits goes on recording, and would never have done.
  if (!state_->settling) state_->settling = state_->disk.appended;
  if (state_->disk.synced >= *state_->settling) {
    state_->settling.reset();
    return true;
  }
  // Not while its blocks wait: the sync would be done before the last of them, and again after it.
  if (state_->disk.written >= *state_->settling && state_->sync_wish == state_->sync_granted) {
    ++state_->sync_wish;
    state_->work.notify_one();
  }
  return false;
}

DiskState DiskWriter::state() const {
  const std::lock_guard lock(state_->mutex);
  DiskState disk = state_->disk;
  if (!disk.failure) disk.failure = state_->overflow;
  if (state_->call_since) disk.pending = state_->options.now() - *state_->call_since;
  return disk;
}

std::string DiskWriter::Note() const {
  const DiskState disk = state();
  if (disk.pending > kSlowCall) {
    return "the disk has not answered for " + Milliseconds(disk.pending) + "; " +
           std::to_string(disk.appended - disk.synced) + " blocks are not safe yet";
  }
  if (state_->threaded() && disk.queued_bytes > state_->options.queue_bytes / 2) {
    return "the disk is slow: " + std::to_string(disk.queued_bytes) + " bytes wait for it";
  }
  return {};
}

}  // namespace annulus
