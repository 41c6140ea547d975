#include "sim/faulty_storage.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Call = StorageFaultActor::Call;
using Fate = StorageFaultActor::Fate;
using Kind = FaultKind;

/// Longest that a slow sync holds up a thread of its own in real time, if nobody lets the simulated time pass.
constexpr std::chrono::milliseconds kRealPatience{500};

/// What the system says of it.
Status Failure(const std::string& attempted, const Fate& fate) {
  if (!fate.fault) return {};
  switch (*fate.fault) {
    case Kind::kStorageNoSpace:
      return Fail(attempted, "No space left on device", "free space on this disk or choose another");
    case Kind::kStorageReadOnly:
      return Fail(attempted, "Read-only file system", "check the disk; the system made it read-only after errors");
    default:
      return Fail(attempted, "Input/output error", "check the disk and the path");
  }
}

}  // namespace

StorageFaultActor::StorageFaultActor(FaultGround ground, const FaultPlan& plan)
    : ground_(std::move(ground)), simulating_{std::this_thread::get_id()}, now_(ground_.clock.Now()) {
  HoldingFaults times;
  for (std::size_t number = 0; number < plan.faults.size(); ++number) {
    if (TraitsOf(plan.faults[number].kind).target != FaultTarget::kStorage) continue;
    times.Add(number, plan.faults[number], nanoseconds(0), nanoseconds::max());
    entries_.push_back({number, plan.faults[number], false, false, 0, times.all().back().left});
  }
}

StorageFaultActor::~StorageFaultActor() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
  passed_.notify_all();
}

void StorageFaultActor::Begin(std::size_t number, const Fault&, nanoseconds, nanoseconds) {
  const std::lock_guard lock(mutex_);
  for (Entry& entry : entries_) {
    if (entry.number == number && !entry.ended) entry.holds = true;
  }
}

void StorageFaultActor::End(std::size_t number, const Fault&, nanoseconds) {
  const std::lock_guard lock(mutex_);
  for (Entry& entry : entries_) {
    if (entry.number != number) continue;
    entry.holds = false;
    entry.ended = true;
  }
  passed_.notify_all();
}

void StorageFaultActor::SimulateHere() {
  const std::lock_guard lock(mutex_);
  simulating_.insert(std::this_thread::get_id());
}

void StorageFaultActor::Follow() {
  const std::lock_guard lock(mutex_);
  now_ = ground_.clock.Now();
  passed_.notify_all();
}

std::vector<std::size_t> StorageFaultActor::TakeBegun() {
  const std::lock_guard lock(mutex_);
  return std::exchange(begun_, {});
}

bool StorageFaultActor::Concerns(FaultKind kind, Call call) {
  switch (kind) {
    case Kind::kStorageNoSpace:
      return call == Call::kCreate || call == Call::kAppend || call == Call::kReserve;
    case Kind::kStorageIoError:
      return call != Call::kFreeBytes;
    case Kind::kStorageShortWrite:
      return call == Call::kAppend;
    case Kind::kStorageSyncError:
    case Kind::kStorageSlowSync:
      return call == Call::kSync;
    case Kind::kStorageReadOnly:
      return call != Call::kFreeBytes && call != Call::kRead && call != Call::kClose;
    case Kind::kStorageLowSpace:
      return call == Call::kFreeBytes;
    default:
      return false;
  }
}

Fate StorageFaultActor::Meet(Call call) {
  std::unique_lock lock(mutex_);
  Fate fate;
  nanoseconds delay{0};
  for (Entry& entry : entries_) {
    if (!Concerns(entry.fault.kind, call)) continue;
    const FaultTrigger& at = entry.fault.at;
    if (at.kind == FaultTrigger::Kind::kCall && !entry.ended && ++entry.calls == at.number) {
      entry.holds = true;
      begun_.push_back(entry.number);
    }
    if (!entry.holds || entry.left == 0) continue;
    --entry.left;
    if (entry.fault.kind == Kind::kStorageSlowSync) {
      delay = nanoseconds(std::llround(1e6 * entry.fault.Value(FaultArg::kDelayMs)));
    } else if (entry.fault.kind == Kind::kStorageLowSpace) {
      fate.free_bytes = entry.fault.Whole(FaultArg::kBytes);
    } else {
      fate.fault = entry.fault.kind;
      fate.torn = call == Call::kAppend && entry.fault.kind == Kind::kStorageShortWrite;
    }
  }
  if (delay.count() > 0) WaitSlowly(delay, lock);
  return fate;
}

/// In a thread that simulates, time passes by waiting. Another one waits until such a thread has seen it pass.
void StorageFaultActor::WaitSlowly(nanoseconds delay, std::unique_lock<std::mutex>& lock) {
  if (simulating_.contains(std::this_thread::get_id())) {
    lock.unlock();
    ground_.clock.SleepUntil(ground_.clock.Now() + delay);
    return;
  }
  const nanoseconds until = now_ + delay;
  passed_.wait_for(lock, kRealPatience, [&] { return now_ >= until || entries_.empty(); });
}

class FaultyStorage::File final : public AppendFile {
 public:
  File(std::unique_ptr<AppendFile> file, std::string path, StorageFaultActor& faults)
      : file_(std::move(file)), path_(std::move(path)), faults_(faults) {}

  Status Append(std::span<const std::byte> bytes) override {
    const Fate fate = faults_.Meet(Call::kAppend);
    if (fate.torn) RETURN_IF_ERROR(file_->Append(bytes.first(bytes.size() / 2)));
    RETURN_IF_ERROR(Failure("write " + path_, fate));
    return file_->Append(bytes);
  }
  Status Sync() override {
    RETURN_IF_ERROR(Failure("sync " + path_, faults_.Meet(Call::kSync)));
    return file_->Sync();
  }
  Status Reserve(std::uint64_t bytes) override {
    RETURN_IF_ERROR(Failure("reserve space for " + path_, faults_.Meet(Call::kReserve)));
    return file_->Reserve(bytes);
  }
  Status Close() override {
    const Fate fate = faults_.Meet(Call::kClose);
    Status closed = file_->Close();
    RETURN_IF_ERROR(Failure("close " + path_, fate));
    return closed;
  }

 private:
  std::unique_ptr<AppendFile> file_;
  std::string path_;
  StorageFaultActor& faults_;
};

Result<std::unique_ptr<AppendFile>> FaultyStorage::Create(const std::string& path) {
  RETURN_IF_ERROR(Failure("create " + path, faults_.Meet(Call::kCreate)));
  auto file = storage_.Create(path);
  if (!file) return file;
  return std::make_unique<File>(std::move(*file), path, faults_);
}

Result<std::vector<std::byte>> FaultyStorage::ReadAll(const std::string& path, std::uint64_t max_bytes) {
  RETURN_IF_ERROR(Failure("read " + path, faults_.Meet(Call::kRead)));
  return storage_.ReadAll(path, max_bytes);
}

Status FaultyStorage::Rename(const std::string& from, const std::string& to) {
  RETURN_IF_ERROR(Failure("rename " + from, faults_.Meet(Call::kRename)));
  return storage_.Rename(from, to);
}

Status FaultyStorage::Remove(const std::string& path) {
  RETURN_IF_ERROR(Failure("remove " + path, faults_.Meet(Call::kRemove)));
  return storage_.Remove(path);
}

Status FaultyStorage::CreateFolder(const std::string& path) {
  RETURN_IF_ERROR(Failure("create folder " + path, faults_.Meet(Call::kFolder)));
  return storage_.CreateFolder(path);
}

Result<std::uint64_t> FaultyStorage::FreeBytes(const std::string& path) {
  const Fate fate = faults_.Meet(Call::kFreeBytes);
  auto free = storage_.FreeBytes(path);
  if (free && fate.free_bytes) return std::min(*free, *fate.free_bytes);
  return free;
}

}  // namespace annulus::sim
