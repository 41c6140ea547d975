#include <libusb.h>

#include <array>
#include <cstdio>
#include <deque>
#include <map>
#include <utility>

#include "base/log.h"
#include "firmware_iface/libusb_context.h"
#include "firmware_iface/usb_host.h"
#include "firmware_iface/usb_sysfs.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kLongestSerial = 128;
/// Plug events kept for a program that does not ask for them; then the oldest goes.
constexpr std::size_t kMostEvents = 256;
/// Hub ports from the root on; USB allows seven tiers.
constexpr std::size_t kMostPorts = 7;

/// The devices that libusb knows, for as long as this lives.
class DeviceList {
 public:
  explicit DeviceList(libusb_context* context) : size_(libusb_get_device_list(context, &devices_)) {}
  ~DeviceList() {
    if (size_ >= 0) libusb_free_device_list(devices_, 1);
  }
  DeviceList(const DeviceList&) = delete;
  DeviceList& operator=(const DeviceList&) = delete;

  /// Negative: the error of libusb.
  [[nodiscard]] std::int64_t size() const { return size_; }
  /// The ring boards among them.
  [[nodiscard]] std::vector<libusb_device*> Boards() const {
    std::vector<libusb_device*> boards;
    for (std::int64_t i = 0; i < size_; ++i) {
      libusb_device_descriptor descriptor{};
      if (libusb_get_device_descriptor(devices_[i], &descriptor) != 0) continue;
      if (descriptor.idVendor == kRingBoardVendor && descriptor.idProduct == kRingBoardProduct) {
        boards.push_back(devices_[i]);
      }
    }
    return boards;
  }

 private:
  libusb_device** devices_ = nullptr;
  ssize_t size_;
};

/// "1-4.2": bus and hub ports, as the kernel names devices.
std::string PortPath(libusb_device* device) {
  std::array<std::uint8_t, kMostPorts> ports{};
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string path = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i) path += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  return path;
}

/// The file through which a program talks to the device.
std::string NodePath(libusb_device* device) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "/dev/bus/usb/%03u/%03u", unsigned{libusb_get_bus_number(device)},
                unsigned{libusb_get_device_address(device)});
  return text.data();
}

class LibusbHost final : public UsbHost {
 public:
  explicit LibusbHost(std::unique_ptr<LibusbContext> context) : context_(std::move(context)) {}
  ~LibusbHost() override {
    if (registered_) libusb_hotplug_deregister_callback(context_->get(), hotplug_);
  }
  LibusbHost(const LibusbHost&) = delete;
  LibusbHost& operator=(const LibusbHost&) = delete;

  /// Asks libusb for plug events.
  Status Register();

  UsbResult<std::vector<UsbIdentity>> List() override;
  UsbResult<std::unique_ptr<UsbPort>> Open(const UsbIdentity& identity) override;
  std::optional<UsbHotplug> WaitHotplug(nanoseconds deadline) override;
  [[nodiscard]] std::uint64_t transfer_memory() const override { return sysfs_.ReadTransferMemory(); }

 private:
  static int LIBUSB_CALL OnHotplug(libusb_context*, libusb_device* device, libusb_hotplug_event event, void* self);
  /// Who a device is; its serial number from sysfs or, where that does not say it, from the device itself.
  UsbIdentity Identify(libusb_device* device);
  UsbResult<std::unique_ptr<UsbPort>> OpenDevice(libusb_device* device);

  std::unique_ptr<LibusbContext> context_;
  UsbSysfs sysfs_;
  libusb_hotplug_callback_handle hotplug_{};
  bool registered_ = false;
  std::deque<UsbHotplug> events_;
  std::map<std::string, std::string> serials_;  ///< Port path → serial number last seen there.
};

Status LibusbHost::Register() {
  const int code = libusb_hotplug_register_callback(
      context_->get(), LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0, kRingBoardVendor,
      kRingBoardProduct, LIBUSB_HOTPLUG_MATCH_ANY, &OnHotplug, this, &hotplug_);
  registered_ = code == LIBUSB_SUCCESS;
  if (registered_) return {};
  return Fail("watch the USB bus for boards that come and go", libusb_error_name(code),
              "check that udev runs and that libusb was built with it");
}

/// Runs inside libusb: puts the event away. A request to the device from here would fail or hang.
int LibusbHost::OnHotplug(libusb_context*, libusb_device* device, libusb_hotplug_event event, void* self) {
  auto& host = *static_cast<LibusbHost*>(self);
  UsbHotplug hotplug;
  hotplug.kind = event == LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT ? UsbHotplug::Kind::kLeft : UsbHotplug::Kind::kArrived;
  hotplug.identity = {kRingBoardVendor, kRingBoardProduct, {}, PortPath(device)};
  hotplug.host_time = host.context_->clock().Now();
  if (hotplug.kind == UsbHotplug::Kind::kLeft) hotplug.identity.serial = host.serials_[hotplug.identity.port_path];
  host.events_.push_back(std::move(hotplug));
  if (host.events_.size() > kMostEvents) host.events_.pop_front();
  return 0;  // keep the callback
}

std::optional<UsbHotplug> LibusbHost::WaitHotplug(nanoseconds deadline) {
  while (events_.empty()) {
    context_->HandleEvents(deadline);
    if (events_.empty() && context_->clock().Now() >= deadline) return std::nullopt;
  }
  UsbHotplug hotplug = std::move(events_.front());
  events_.pop_front();
  if (hotplug.kind == UsbHotplug::Kind::kArrived) {
    hotplug.identity.serial = sysfs_.ReadSerial(hotplug.identity.port_path).value_or("");
    serials_[hotplug.identity.port_path] = hotplug.identity.serial;
  }
  return hotplug;
}

UsbIdentity LibusbHost::Identify(libusb_device* device) {
  UsbIdentity identity{kRingBoardVendor, kRingBoardProduct, {}, PortPath(device)};
  if (auto serial = sysfs_.ReadSerial(identity.port_path)) {
    identity.serial = std::move(*serial);
  } else if (libusb_device_handle* handle = nullptr; libusb_open(device, &handle) == 0) {
    libusb_device_descriptor descriptor{};
    std::array<unsigned char, kLongestSerial> text{};
    int length = 0;
    if (libusb_get_device_descriptor(device, &descriptor) == 0) {
      length = libusb_get_string_descriptor_ascii(handle, descriptor.iSerialNumber, text.data(), kLongestSerial);
    }
    for (int i = 0; i < length; ++i) identity.serial += static_cast<char>(text[static_cast<std::size_t>(i)]);
    libusb_close(handle);
  }
  serials_[identity.port_path] = identity.serial;
  return identity;
}

UsbResult<std::vector<UsbIdentity>> LibusbHost::List() {
  const DeviceList devices(context_->get());
  if (devices.size() < 0) {
    return tl::unexpected<UsbFailure>(FailureOf(static_cast<int>(devices.size()), "list the USB devices"));
  }
  std::vector<UsbIdentity> known;
  for (libusb_device* device : devices.Boards()) known.push_back(Identify(device));
  return known;
}

UsbResult<std::unique_ptr<UsbPort>> LibusbHost::Open(const UsbIdentity& identity) {
  const DeviceList devices(context_->get());
  libusb_device* found = nullptr;
  for (libusb_device* device : devices.Boards()) {
    const UsbIdentity candidate = Identify(device);
    const bool here = candidate.port_path == identity.port_path;
    const bool wanted = identity.serial.empty() ? here : candidate.serial == identity.serial;
    // Of two with the same number the one at the known place.
    if (wanted && (found == nullptr || here)) found = device;
  }
  if (found == nullptr) {
    const std::string name = identity.serial.empty() ? DeviceName(identity) : identity.serial;
    return tl::unexpected<UsbFailure>(UsbFailure{UsbStatus::kNoDevice, "no ring board " + name + " is plugged in"});
  }
  return OpenDevice(found);
}

UsbResult<std::unique_ptr<UsbPort>> LibusbHost::OpenDevice(libusb_device* device) {
  const UsbIdentity identity = Identify(device);
  libusb_device_handle* handle = nullptr;
  if (const int code = libusb_open(device, &handle); code != 0) {
    // Just after arrival the node may not be there yet, or not yet belong to us.
    return tl::unexpected<UsbFailure>(FailureOf(code, "open " + NodePath(device)));
  }
  static_cast<void>(libusb_set_auto_detach_kernel_driver(handle, 1));  // not supported everywhere, nor needed
  if (const int code = libusb_claim_interface(handle, kBoardInterface); code != 0) {
    libusb_close(handle);
    return tl::unexpected<UsbFailure>(FailureOf(code, "claim the interface of " + NodePath(device)));
  }
  if (const Status awake = sysfs_.KeepAwake(identity.port_path); !awake) {
    Log(LogLevel::kWarning, awake.error().Text());
  }
  return MakeLibusbPort(*context_, handle, identity, transfer_memory());
}

}  // namespace

Result<std::unique_ptr<UsbHost>> OpenLibusbHost(Clock& clock) {
  auto context = LibusbContext::Make(clock);
  if (!context) return Fail(context);
  auto host = std::make_unique<LibusbHost>(std::move(*context));
  // Boards can be used without; only their coming and going is then seen late.
  if (const Status registered = host->Register(); !registered) Log(LogLevel::kWarning, registered.error().Text());
  return host;
}

}  // namespace annulus
