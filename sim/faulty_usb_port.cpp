#include "sim/faulty_usb_port.h"

#include <algorithm>
#include <utility>

#include "sim/world.h"

namespace annulus::sim {
namespace {

constexpr std::uint64_t kMostAddedBytes = 64;

}  // namespace

FaultyUsbPort::FaultyUsbPort(UsbPort& port, const UsbFaultPlan& plan)
    : port_(port), plan_(plan), log_(own_log_), random_(plan.seed), carried_(plan.stale) {}

FaultyUsbPort::FaultyUsbPort(UsbPort& port, const UsbFaultPlan& plan, UsbFaultLog& log)
    : port_(port), plan_(plan), log_(log), random_(plan.seed), carried_(plan.stale) {}

FaultyUsbPort::FaultyUsbPort(std::unique_ptr<UsbPort> port, const UsbFaultPlan& plan, UsbFaultLog& log)
    : owned_(std::move(port)), port_(*owned_), plan_(plan), log_(log), random_(plan.seed), carried_(plan.stale) {}

double FaultyUsbPort::Unit() { return UnitFromBits(random_()); }

UsbResult<UsbToken> FaultyUsbPort::SubmitBulkIn(std::uint8_t endpoint, std::size_t length) {
  Tell(Call::kSubmit);
  if (plan().no_memory_at == log_.submits++ || plan().no_memory) {
    return tl::unexpected<UsbFailure>(UsbFailure{UsbStatus::kNoMemory, "usbfs_memory_mb is used up"});
  }
  return port_.SubmitBulkIn(endpoint, length);
}

UsbResult<void> FaultyUsbPort::ClearHalt(std::uint8_t endpoint) {
  Tell(Call::kOther);
  ++log_.halts_cleared;
  halted_ = halted_ && plan().stall_stays;
  return port_.ClearHalt(endpoint);
}

std::optional<UsbCompletion> FaultyUsbPort::WaitCompletion(std::chrono::nanoseconds deadline) {
  Tell(Call::kOther);
  auto completion = port_.WaitCompletion(deadline);
  if (completion) Spoil(*completion);
  return completion;
}

void FaultyUsbPort::Spoil(UsbCompletion& completion) {
  if (completion.status != UsbStatus::kCompleted) return SpoilEnding(completion);
  if (completion.data.empty()) return;
  completion.data.insert(completion.data.begin(), carried_.begin(), carried_.end());
  carried_.clear();
  last_ = completion.data;
  if (!halted_ && Unit() < plan().stall_share) halted_ = true;
  if (halted_) {
    ++log_.stalls;
    completion.status = UsbStatus::kStall;
    completion.data.clear();
    return;
  }
  SpoilData(completion);
}

void FaultyUsbPort::SpoilData(UsbCompletion& completion) {
  std::vector<std::byte>& data = completion.data;
  const std::uint64_t bits = random_();
  double dice = Unit();
  const auto happens = [&dice](double share) {
    const bool now = dice >= 0.0 && dice < share;
    dice -= share;
    return now;
  };
  const auto cut = static_cast<std::ptrdiff_t>(1 + bits % std::max<std::size_t>(1, data.size() - 1));
  if (happens(plan().short_share) && data.size() > 1) {
    ++log_.shortened;
    log_.kept_bytes += static_cast<std::uint64_t>(cut);
    data.erase(data.begin() + cut, data.end());
  } else if (happens(plan().zero_share)) {
    ++log_.emptied;
    data.clear();
  } else if (happens(plan().long_share)) {
    ++log_.lengthened;
    const std::uint64_t count = 1 + bits % kMostAddedBytes;
    log_.added_bytes += count;
    // No letter of a magic, so that the bytes can not be taken for the beginning of a frame.
    for (std::uint64_t i = 0; i < count; ++i) data.push_back(static_cast<std::byte>(MixSeed(bits, i) % 0x41U));
  } else if (happens(plan().damage_share)) {
    ++log_.damaged;
    data[bits / 8 % data.size()] ^= static_cast<std::byte>(1U << bits % 8);
  } else if (happens(plan().timeout_share) && data.size() > 1) {
    ++log_.timed_out;
    completion.status = UsbStatus::kTimedOut;
    carried_.assign(data.begin() + cut, data.end());
    data.erase(data.begin() + cut, data.end());
  }
}

void FaultyUsbPort::SpoilEnding(UsbCompletion& completion) {
  if (completion.status == UsbStatus::kCancelled && Unit() < plan().cancel_completes_share) {
    ++log_.cancels_completed;
    completion.status = UsbStatus::kCompleted;
    completion.data = last_;
  }
  if (completion.status != UsbStatus::kNoDevice) return;
  UsbFaultPlan::UnplugEnding ending = plan().unplug_ending;
  if (ending == UsbFaultPlan::UnplugEnding::kAny) {
    ending = static_cast<UsbFaultPlan::UnplugEnding>(random_() % 3);
  }
  if (ending == UsbFaultPlan::UnplugEnding::kError) completion.status = UsbStatus::kError;
  if (ending == UsbFaultPlan::UnplugEnding::kCompleted) {
    completion.status = UsbStatus::kCompleted;
    completion.data = last_;
  }
}

}  // namespace annulus::sim
