#include "station/level_mailbox.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace annulus {

Result<std::unique_ptr<LevelMailbox>> LevelMailbox::Make() {
  const int signal = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (signal < 0) return Fail("prepare for previews", std::strerror(errno), "free file descriptors");
  return std::unique_ptr<LevelMailbox>(new LevelMailbox(signal));
}

LevelMailbox::~LevelMailbox() { ::close(signal_); }

void LevelMailbox::Put(const ScanLevel& level) {
  if (!wanted_.load(std::memory_order_relaxed)) return;
  const std::uint64_t put = put_.load(std::memory_order_relaxed);
  if (put - taken_.load(std::memory_order_acquire) == kSlots) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  slots_[put % kSlots] = level;
  put_.store(put + 1, std::memory_order_release);
  const std::uint64_t one = 1;
  // It fails only when the counter is full: then it is readable anyhow.
  [[maybe_unused]] const auto written = ::write(signal_, &one, sizeof(one));
}

bool LevelMailbox::Take(ScanLevel& level) {
  const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
  if (taken == put_.load(std::memory_order_acquire)) return false;
  level = slots_[taken % kSlots];  // a copy, so that the slot keeps its memory
  taken_.store(taken + 1, std::memory_order_release);
  return true;
}

void LevelMailbox::ClearSignal() {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto read = ::read(signal_, &count, sizeof(count));
}

}  // namespace annulus
