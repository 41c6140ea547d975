#include "sim/usb_descriptors.h"

#include <array>
#include <string_view>
#include <utility>

#include "firmware_iface/usb_frame_codec.h"

namespace annulus::sim {
namespace {

constexpr std::uint8_t kInterfaceDescriptor = 4;
constexpr std::uint8_t kEndpointDescriptor = 5;
constexpr std::uint8_t kVendorClass = 0xFF;
constexpr std::uint8_t kBulk = 2;
constexpr std::uint16_t kUsbVersion = 0x0200;
constexpr std::uint16_t kDeviceVersion = 0x0120;
constexpr std::uint16_t kEnglish = 0x0409;
// Indices of the strings.
constexpr std::uint8_t kManufacturer = 1;
constexpr std::uint8_t kProduct = 2;
constexpr std::uint8_t kSerial = 3;

// Of bmRequestType, and bRequest of standard requests.
constexpr std::uint8_t kDirectionIn = 0x80;
constexpr std::uint8_t kTypeMask = 0x60;
constexpr std::uint8_t kStandard = 0x00;
constexpr std::uint8_t kVendor = 0x40;
constexpr std::uint8_t kGetStatus = 0;
constexpr std::uint8_t kClearFeature = 1;
constexpr std::uint8_t kGetDescriptor = 6;

tl::unexpected<UsbFailure> Stall() { return tl::unexpected<UsbFailure>(UsbFailure{UsbStatus::kStall, {}}); }

/// Collects bytes, least significant first.
class Descriptor {
 public:
  Descriptor& Byte(std::uint8_t value) {
    bytes_.push_back(std::byte{value});
    return *this;
  }
  Descriptor& Word(std::uint16_t value) {
    return Byte(static_cast<std::uint8_t>(value & 0xFFU)).Byte(static_cast<std::uint8_t>(value >> 8));
  }
  [[nodiscard]] std::vector<std::byte> Take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

std::vector<std::byte> Device(const UsbIdentity& identity) {
  Descriptor out;
  out.Byte(18).Byte(kDeviceDescriptor).Word(kUsbVersion);
  out.Byte(0).Byte(0).Byte(0);  // class, subclass and protocol stand with the interface
  out.Byte(64);                 // packet of endpoint 0
  out.Word(identity.vendor_id).Word(identity.product_id).Word(kDeviceVersion);
  out.Byte(kManufacturer).Byte(kProduct).Byte(kSerial);
  out.Byte(1);  // configurations
  return out.Take();
}

std::vector<std::byte> Configuration() {
  Descriptor out;
  out.Byte(9).Byte(kConfigurationDescriptor).Word(9 + 9 + 7);
  out.Byte(1).Byte(1).Byte(0);  // interfaces, this configuration's value, no name
  out.Byte(0xC0).Byte(0);       // powered by the ring's supply, nothing from the bus
  out.Byte(9).Byte(kInterfaceDescriptor).Byte(0).Byte(0);
  out.Byte(1);                                     // endpoints
  out.Byte(kVendorClass).Byte(0).Byte(0).Byte(0);  // class, subclass, protocol, no name
  out.Byte(7).Byte(kEndpointDescriptor).Byte(kLevelEndpoint).Byte(kBulk).Word(kBulkPacketBytes).Byte(0);
  return out.Take();
}

std::vector<std::byte> Text(std::string_view text) {
  Descriptor out;
  out.Byte(static_cast<std::uint8_t>(2 + 2 * text.size())).Byte(kStringDescriptor);
  for (const char letter : text) out.Word(static_cast<std::uint8_t>(letter));
  return out.Take();
}

UsbResult<std::vector<std::byte>> AnswerStandard(UsbPort& board, const UsbSetup& setup) {
  if (setup.request == kGetDescriptor) {
    if (auto descriptor = BoardDescriptor(board.identity(), setup.value)) return std::move(*descriptor);
  }
  if (setup.request == kGetStatus) return std::vector<std::byte>(2);
  if (setup.request == kClearFeature && board.ClearHalt(static_cast<std::uint8_t>(setup.index & 0xFFU))) {
    return std::vector<std::byte>{};
  }
  return Stall();
}

}  // namespace

std::optional<std::vector<std::byte>> BoardDescriptor(const UsbIdentity& identity, std::uint16_t value) {
  const auto type = static_cast<std::uint8_t>(value >> 8);
  const auto index = static_cast<std::uint8_t>(value & 0xFFU);
  if (type == kDeviceDescriptor && index == 0) return Device(identity);
  if (type == kConfigurationDescriptor && index == 0) return Configuration();
  if (type != kStringDescriptor) return std::nullopt;
  switch (index) {
    case 0:
      return Descriptor().Byte(4).Byte(kStringDescriptor).Word(kEnglish).Take();
    case kManufacturer:
      return Text("annulus");
    case kProduct:
      return Text("ring board");
    case kSerial:
      return Text(identity.serial);
    default:
      return std::nullopt;
  }
}

UsbResult<std::vector<std::byte>> AnswerSetup(UsbPort& board, const UsbSetup& setup, std::span<const std::byte> data,
                                              std::chrono::nanoseconds timeout) {
  const std::uint8_t type = setup.type & kTypeMask;
  if (type == kStandard) return AnswerStandard(board, setup);
  if (type != kVendor) return Stall();
  const UsbRequest request{setup.request, setup.value, setup.index};
  if ((setup.type & kDirectionIn) != 0) return board.ControlIn(request, setup.length, timeout);
  const auto done = board.ControlOut(request, data, timeout);
  if (!done) return tl::unexpected<UsbFailure>(done.error());
  return std::vector<std::byte>{};
}

}  // namespace annulus::sim
