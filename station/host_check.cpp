#include "station/host_check.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "station/devices.h"

namespace annulus {
namespace {

/// Highest priority that the control thread will ask for (SCHED_FIFO).
constexpr rlim_t kRealTimePriority = 80;

std::optional<std::uint64_t> NumberIn(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  return file >> number ? std::optional(number) : std::nullopt;
}

DoctorItem Kernel() {
  utsname name{};
  if (uname(&name) != 0) return {"host", "kernel", DoctorVerdict::kNone, "unknown", ""};
  const bool preempt = NumberIn("/sys/kernel/realtime").value_or(0) == 1;
  return {"host", "kernel", DoctorVerdict::kOk,
          fmt::format("{} {}{}", name.sysname, name.release, preempt ? ", real-time (PREEMPT_RT)" : ""), ""};
}

DoctorItem RealTime(bool real_devices) {
  rlimit limit{};
  const bool told = getrlimit(RLIMIT_RTPRIO, &limit) == 0;
  if (geteuid() == 0 || (told && limit.rlim_cur >= kRealTimePriority)) {
    return {"host", "real-time priority", DoctorVerdict::kOk, "may be asked for", ""};
  }
  return {"host", "real-time priority", real_devices ? DoctorVerdict::kProblem : DoctorVerdict::kNone,
          told ? fmt::format("this user may ask for {} at most", limit.rlim_cur) : std::string("unknown"),
          real_devices ? fmt::format("set 'rtprio {}' for this user in /etc/security/limits.d, and log in again",
                                     kRealTimePriority)
                       : ""};
}

DoctorItem UsbMemory(bool usb_ring) {
  const auto megabytes = NumberIn("/sys/module/usbcore/parameters/usbfs_memory_mb");
  if (!megabytes) {
    return {"host", "USB transfer memory", usb_ring ? DoctorVerdict::kProblem : DoctorVerdict::kNone,
            "the kernel has no USB", usb_ring ? "use a kernel with USB (Debian's linux-image-amd64)" : ""};
  }
  const std::string seen =
      *megabytes == 0 ? "usbfs_memory_mb is 0: no limit" : fmt::format("usbfs_memory_mb is {}", *megabytes);
  // The least there is, 1 MB, holds the ring's transfers; whether others leave enough is seen when it starts.
  return {"host", "USB transfer memory", DoctorVerdict::kOk, seen, ""};
}

}  // namespace

std::vector<DoctorItem> CheckHost(const Config& config) {
  return {Kernel(), RealTime(!AllSimulated(config)), UsbMemory(config.ring.bus == RingBus::kUsb)};
}

bool PathExists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

}  // namespace annulus
