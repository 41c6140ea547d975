#include "firmware_iface/usb_sysfs.h"

#include <charconv>
#include <fstream>

namespace annulus {
namespace {

constexpr const char* kMemoryFile = "/module/usbcore/parameters/usbfs_memory_mb";

std::string DeviceFile(const std::string& root, const std::string& port_path, const char* name) {
  return root + "/bus/usb/devices/" + port_path + "/" + name;
}

/// The first line of a file.
std::optional<std::string> ReadLine(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  return line;
}

}  // namespace

std::optional<std::string> UsbSysfs::ReadSerial(const std::string& port_path) const {
  return ReadLine(DeviceFile(root_, port_path, "serial"));
}

Status UsbSysfs::KeepAwake(const std::string& port_path) const {
  const std::string path = DeviceFile(root_, port_path, "power/control");
  if (ReadLine(path) == "on") return {};
  std::ofstream file(path);
  file << "on" << std::flush;
  if (file) return {};
  return Fail("switch off the autosuspend of the device at port " + port_path, path + " cannot be written",
              "install the udev rule of docs/booth.md, or boot with usbcore.autosuspend=-1");
}

std::uint64_t UsbSysfs::ReadTransferMemory() const {
  const std::string line = ReadLine(root_ + kMemoryFile).value_or("0");
  std::uint64_t megabytes = 0;
  const auto parsed = std::from_chars(line.data(), line.data() + line.size(), megabytes);
  if (parsed.ec != std::errc() || megabytes > UINT32_MAX) return 0;
  return megabytes * 1024 * 1024;
}

}  // namespace annulus
