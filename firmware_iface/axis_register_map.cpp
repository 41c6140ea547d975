#include "firmware_iface/axis_register_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
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
constexpr std::array<FaultText, 12> kFaultTexts{{
    {0x2310, "motor current too high; check that the carriage moves freely"},
    {0x3210, "supply voltage too high; check the braking resistor"},
    {0x3220, "supply voltage too low; check the mains and the drive's fuse"},
    {0x4310, "drive too hot; let it cool and check its fan"},
    {0x5441,
     "the drive's quick-stop input opened; the safety chain or the program asked for a stop, close the chain (E-stop, "
     "door, limits) and press reset"},
    {0x5442,
     "safe torque off: the safety chain is open; close it (E-stop, door, limits) and press reset, if it is closed "
     "check the wires of STO A and B"},
    {0x5443, "the brake is closed though the drive releases it; check the brake, its supply and the safety chain"},
    {0x5444,
     "a limit switch of the drive is open; move the carriage away from its end, if it is not there check the wire"},
    {0x7121, "motor blocked; look for an obstacle before you go on"},
    {0x8130, "heartbeat lost, the drive did not hear from the host; check the cable and the host's load"},
    {0x8611, "following error, the carriage did not keep up; look for an obstacle before you go on"},
    {0x8612, "a target beyond the soft limits; correct the scan plan"},
}};

using Map = AxisRegisterMap;

constexpr std::array<AxisRegisterField, 22> kRegisterFields{{
    {"counter", &Map::counter, 1, true},
    {"control_word", &Map::control_word, 1, true},
    {"mode", &Map::mode, 1, true},
    {"target_position", &Map::target_position, 2, true},
    {"profile_speed", &Map::profile_speed, 2, true},
    {"profile_acceleration", &Map::profile_acceleration, 2, true},
    {"echo", &Map::echo, 1, true},
    {"status_word", &Map::status_word, 1, true},
    {"fault_code", &Map::fault_code, 1, true},
    {"position", &Map::position, 2, true},
    {"drive_time", &Map::drive_time, 2, false},
    {"flags", &Map::flags, 1, false},
    {"protocol_version", &Map::protocol_version, 1, false},
    {"firmware_version", &Map::firmware_version, 1, false},
    {"serial", &Map::serial, 2, false},
    {"z_min", &Map::z_min, 2, false},
    {"z_max", &Map::z_max, 2, false},
    {"max_speed", &Map::max_speed, 2, false},
    {"max_acceleration", &Map::max_acceleration, 2, false},
    {"heartbeat_timeout", &Map::heartbeat_timeout, 1, false},
    {"start_window", &Map::start_window, 1, false},
    {"parameter_crc", &Map::parameter_crc, 2, false},
}};
constexpr std::size_t kFirstStatus = 6;     ///< Index of `echo`.
constexpr std::size_t kFirstIdentity = 12;  ///< Index of `protocol_version`.

constexpr std::array<AxisScaleField, 8> kScaleFields{{
    {"units_per_mm", &Map::units_per_mm},
    {"units_per_mm_s", &Map::units_per_mm_s},
    {"units_per_mm_s2", &Map::units_per_mm_s2},
    {"declared_z_min_mm", &Map::declared_z_min_mm},
    {"declared_z_max_mm", &Map::declared_z_max_mm},
    {"declared_max_speed_mm_s", &Map::declared_max_speed_mm_s},
    {"declared_max_acceleration_mm_s2", &Map::declared_max_acceleration_mm_s2},
    {"declared_heartbeat_ms", &Map::declared_heartbeat_ms},
}};

/// The shortest block that holds the fields that are there.
Map::Block BlockOf(const Map& map, std::initializer_list<std::span<const AxisRegisterField>> groups) {
  int low = kNoRegister;
  int high = -1;
  for (const auto& group : groups) {
    for (const AxisRegisterField& field : group) {
      const int address = map.*field.address;
      if (address == kNoRegister) continue;
      low = std::min(low, address);
      high = std::max(high, address + field.registers - 1);
    }
  }
  if (high < low) return {};
  return {static_cast<std::uint16_t>(low), static_cast<std::uint16_t>(high - low + 1)};
}

std::span<const AxisRegisterField> Fields(std::size_t from, std::size_t to) {
  return std::span(kRegisterFields).subspan(from, to - from);
}

tl::unexpected<Error> Refuse(const std::string& seen, const char* advice) {
  return Fail("check the axis' register map", seen, advice);
}

/// No two fields of the same block share a register; a scratch register may serve as counter and as echo.
Status CheckOverlap(const Map& map, std::span<const AxisRegisterField> fields) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const int first = map.*fields[i].address;
    if (first == kNoRegister) continue;
    for (std::size_t j = i + 1; j < fields.size(); ++j) {
      const int second = map.*fields[j].address;
      if (second == kNoRegister) continue;
      if (first < second + fields[j].registers && second < first + fields[i].registers) {
        return Refuse(std::string(fields[i].name) + " and " + fields[j].name + " share a register",
                      "correct their addresses");
      }
    }
  }
  return {};
}

Status CheckAddresses(const Map& map) {
  for (const AxisRegisterField& field : kRegisterFields) {
    const int address = map.*field.address;
    if (address == kNoRegister && field.required) {
      return Refuse(std::string(field.name) + " has no register", "no axis works without it: name its address");
    }
    if (address != kNoRegister && address + field.registers > kNoRegister) {
      return Refuse(std::string(field.name) + " ends beyond register 65534", "correct its address");
    }
  }
  RETURN_IF_ERROR(CheckOverlap(map, Fields(0, kFirstStatus)));
  return CheckOverlap(map, Fields(kFirstStatus, kRegisterFields.size()));
}

Status CheckScales(const Map& map) {
  for (const AxisScaleField& field : kScaleFields) {
    const double value = map.*field.value;
    if (!std::isfinite(value)) return Refuse(std::string(field.name) + " is no number", "correct it");
  }
  for (const AxisScaleField& field : std::span(kScaleFields).first(3)) {
    if (!(map.*field.value > 0.0)) return Refuse(std::string(field.name) + " is not above 0", "correct it");
  }
  if (map.counter_registers != 1 && map.counter_registers != 2) {
    return Refuse("counter_registers is " + std::to_string(map.counter_registers), "set it to 1 or 2");
  }
  if (map.counter_registers == 2) {
    for (const AxisRegisterField& field : Fields(1, kFirstStatus)) {
      const int behind = map.counter + 1 - map.*field.address;
      if (behind >= 0 && behind < field.registers) {
        return Refuse(std::string(field.name) + " lies in the counter's second register", "correct its address");
      }
    }
  }
  return {};
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

bool IsStopInputFault(std::uint16_t fault_code) {
  return fault_code == 0x5441 || fault_code == 0x5442 || fault_code == 0x5443;
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

std::span<const AxisRegisterField> AxisRegisterFields() { return kRegisterFields; }

std::span<const AxisScaleField> AxisScaleFields() { return kScaleFields; }

AxisRegisterMap::Block AxisRegisterMap::CommandBlock() const {
  Block block = BlockOf(*this, {Fields(0, kFirstStatus)});
  // A reading writes from the counter on: the block holds that, too.
  block.count = static_cast<std::uint16_t>(std::max<int>(block.count, counter + counter_registers - block.address));
  return block;
}

AxisRegisterMap::Block AxisRegisterMap::StatusBlock() const {
  return BlockOf(*this, {Fields(kFirstStatus, kFirstIdentity)});
}

AxisRegisterMap::Block AxisRegisterMap::IdentityBlock() const {
  return BlockOf(*this, {Fields(kFirstStatus, kFirstStatus + 1), Fields(kFirstIdentity, kRegisterFields.size())});
}

Status CheckRegisterMap(const AxisRegisterMap& map) {
  constexpr std::uint16_t kMostWritten = 121;
  constexpr std::uint16_t kMostRead = 125;
  RETURN_IF_ERROR(CheckScales(map));
  RETURN_IF_ERROR(CheckAddresses(map));
  const auto check = [](const char* block, std::uint16_t count, std::uint16_t most) -> Status {
    if (count <= most) return {};
    return Refuse(std::string(block) + " registers span " + std::to_string(count) + ", one transaction carries " +
                      std::to_string(most),
                  "map them closer together in the drive");
  };
  RETURN_IF_ERROR(check("command", map.CommandBlock().count, kMostWritten));
  RETURN_IF_ERROR(check("status", map.StatusBlock().count, kMostRead));
  return check("identity", map.IdentityBlock().count, kMostRead);
}

}  // namespace annulus
