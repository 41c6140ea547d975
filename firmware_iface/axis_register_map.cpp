#include "firmware_iface/axis_register_map.h"

#include <algorithm>
#include <array>
#include <utility>

namespace annulus {
namespace {

/// Status word patterns of CiA 402 (IEC 61800-7-201, table "state coding"): mask, value, state.
struct StatePattern {
  std::uint16_t mask;
  std::uint16_t value;
  DriveState state;
};
constexpr std::array<StatePattern, 8> kStatePatterns{{
    {0x4F, 0x00, DriveState::kNotReady},
    {0x4F, 0x40, DriveState::kSwitchOnDisabled},
    {0x6F, 0x21, DriveState::kReadyToSwitchOn},
    {0x6F, 0x23, DriveState::kSwitchedOn},
    {0x6F, 0x27, DriveState::kOperationEnabled},
    {0x6F, 0x07, DriveState::kQuickStopActive},
    {0x4F, 0x0F, DriveState::kFaultReaction},
    {0x4F, 0x08, DriveState::kFault},
}};

constexpr std::uint16_t kVoltageEnabled = 1U << 4;
constexpr std::uint16_t kRemote = 1U << 9;

struct FaultText {
  std::uint16_t code;
  const char* text;
};
constexpr std::array<FaultText, 7> kFaultTexts{{
    {0x2310, "motor current too high; check that the carriage moves freely"},
    {0x3210, "supply voltage too high; check the braking resistor"},
    {0x3220, "supply voltage too low; check the mains and the drive's fuse"},
    {0x4310, "drive too hot; let it cool and check its fan"},
    {0x8130, "heartbeat lost, the drive did not hear from the host; check the cable and the host's load"},
    {0x8611, "following error, the carriage did not keep up; look for an obstacle before you go on"},
    {0x8612, "a target beyond the soft limits; correct the scan plan"},
}};

std::uint16_t Span(std::pair<std::uint16_t, std::uint16_t> low_high) {
  return static_cast<std::uint16_t>(low_high.second - low_high.first + 1);
}

}  // namespace

DriveState DriveStateOf(std::uint16_t status) {
  for (const StatePattern& pattern : kStatePatterns) {
    if ((status & pattern.mask) == pattern.value) return pattern.state;
  }
  return DriveState::kUnknown;
}

std::uint16_t StatusBitsOf(DriveState state) {
  for (const StatePattern& pattern : kStatePatterns) {
    if (pattern.state == state) return static_cast<std::uint16_t>(pattern.value | kVoltageEnabled | kRemote);
  }
  return kRemote;
}

const char* DriveStateText(DriveState state) {
  switch (state) {
    case DriveState::kNotReady:
      return "not ready to switch on";
    case DriveState::kSwitchOnDisabled:
      return "switch on disabled";
    case DriveState::kReadyToSwitchOn:
      return "ready to switch on";
    case DriveState::kSwitchedOn:
      return "switched on";
    case DriveState::kOperationEnabled:
      return "operation enabled";
    case DriveState::kQuickStopActive:
      return "quick stop active";
    case DriveState::kFaultReaction:
      return "fault reaction active";
    case DriveState::kFault:
      return "fault";
    case DriveState::kUnknown:
      break;
  }
  return "unknown";
}

std::string AxisFaultText(std::uint16_t fault_code) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string text = "fault ";
  for (int shift = 12; shift >= 0; shift -= 4) text += kDigits[(fault_code >> shift) & 0xF];
  text += "h";
  for (const FaultText& known : kFaultTexts) {
    if (known.code == fault_code) return text + ", " + known.text;
  }
  return text + ", see the drive's manual";
}

AxisRegisterMap::Block AxisRegisterMap::CommandBlock() const {
  const auto [low, high] =
      std::minmax({counter, control_word, mode, target_position, static_cast<std::uint16_t>(target_position + 1),
                   profile_speed, static_cast<std::uint16_t>(profile_speed + 1), profile_acceleration,
                   static_cast<std::uint16_t>(profile_acceleration + 1)});
  return {low, Span({low, high})};
}

AxisRegisterMap::Block AxisRegisterMap::StatusBlock() const {
  const auto last = [](std::uint16_t address) { return static_cast<std::uint16_t>(address + 1); };
  const auto [low, high] =
      std::minmax({echo, status_word, fault_code, position, last(position), drive_time, last(drive_time), flags});
  return {low, Span({low, high})};
}

AxisRegisterMap::Block AxisRegisterMap::IdentityBlock() const {
  const auto last = [](std::uint16_t address) { return static_cast<std::uint16_t>(address + 1); };
  const auto [low, high] = std::minmax({echo, protocol_version, firmware_version, serial, last(serial), z_min,
                                        last(z_min), z_max, last(z_max), max_speed, last(max_speed), max_acceleration,
                                        last(max_acceleration), heartbeat_timeout});
  return {low, Span({low, high})};
}

Status CheckRegisterMap(const AxisRegisterMap& map) {
  constexpr std::uint16_t kMostWritten = 121;
  constexpr std::uint16_t kMostRead = 125;
  const auto refuse = [](const char* block, std::uint16_t count, std::uint16_t most) {
    return Fail("check the axis' register map",
                std::string(block) + " registers span " + std::to_string(count) + ", one transaction carries " +
                    std::to_string(most),
                "map them closer together in the drive");
  };
  if (const std::uint16_t count = map.CommandBlock().count; count == 0 || count > kMostWritten) {
    return refuse("command", count, kMostWritten);
  }
  if (const std::uint16_t count = map.StatusBlock().count; count == 0 || count > kMostRead) {
    return refuse("status", count, kMostRead);
  }
  if (const std::uint16_t count = map.IdentityBlock().count; count == 0 || count > kMostRead) {
    return refuse("identity", count, kMostRead);
  }
  return {};
}

}  // namespace annulus
