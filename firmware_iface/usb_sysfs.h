#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"

namespace annulus {

/// What Linux tells about USB devices in files, without opening them. Devices are named by their port path ("1-4.2").
class UsbSysfs {
 public:
  /// `root` is where sysfs is mounted.
  explicit UsbSysfs(std::string root = "/sys") : root_(std::move(root)) {}

  /// The serial number that the device told the kernel; nothing where sysfs does not say it.
  [[nodiscard]] std::optional<std::string> ReadSerial(const std::string& port_path) const;
  /// Keeps the kernel from putting the device to sleep (a sleeping board may never answer again). An Error where this
  /// is not permitted, unless the device is already kept awake.
  Status KeepAwake(const std::string& port_path) const;
  /// Bytes that all transfers in flight of all programs may use together; 0: no limit, or not known.
  [[nodiscard]] std::uint64_t ReadTransferMemory() const;

 private:
  std::string root_;
};

}  // namespace annulus
