#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "base/result.h"

namespace annulus {

/// Address of a value that a drive does not have.
inline constexpr std::uint16_t kNoRegister = 0xFFFF;

/// Which half of a 32-bit value lies at the lower address.
enum class WordOrder { kHighFirst, kLowFirst };

/// Where a drive keeps what we need: holding register addresses. Defaults: the simulated drive (docs/wire_protocol.md).
/// The command registers must lie in one block, the status registers in another, because each is written or read in one
/// transaction. Lengths, speeds and accelerations are whole numbers of the drive's units.
///
/// A drive that has no registers of ours: let `counter` be any register that it stores and never uses, and `echo` the
/// same one in a block that it reads after writing. Without such a register it is refused when it is first spoken to.
struct AxisRegisterMap {
  // Command block.
  std::uint16_t counter = 0x0000;               ///< u16; we add one per transaction, the drive watches that it changes.
  std::uint16_t control_word = 0x0001;          ///< u16; CiA 402 6040h.
  std::uint16_t mode = 0x0002;                  ///< i16; CiA 402 6060h: 1 profile position, 6 homing.
  std::uint16_t target_position = 0x0003;       ///< i32, um; 607Ah.
  std::uint16_t profile_speed = 0x0005;         ///< u32, um/s; 6081h.
  std::uint16_t profile_acceleration = 0x0007;  ///< u32, um/s^2; 6083h.

  // Status block, cyclic part.
  std::uint16_t echo = 0x0100;         ///< u16; the counter written last.
  std::uint16_t status_word = 0x0101;  ///< u16; 6041h.
  std::uint16_t fault_code = 0x0102;   ///< u16; 603Fh.
  std::uint16_t position = 0x0103;     ///< i32, um; 6064h.
  std::uint16_t drive_time = 0x0105;   ///< u32, us; the drive's clock when it latched `position`; wraps. Or none.
  std::uint16_t flags = 0x0107;        ///< u16; bit 0 homed, bit 1 moving. None: told from the status word.

  // Status block, identity part. Each may be none: then the value below is taken, without a check.
  std::uint16_t protocol_version = 0x0108;   ///< u16.
  std::uint16_t firmware_version = 0x0109;   ///< u16; major in the high byte.
  std::uint16_t serial = 0x010A;             ///< u32.
  std::uint16_t z_min = 0x010C;              ///< i32, um; 607Dh 1.
  std::uint16_t z_max = 0x010E;              ///< i32, um; 607Dh 2.
  std::uint16_t max_speed = 0x0110;          ///< u32, um/s; 607Fh.
  std::uint16_t max_acceleration = 0x0112;   ///< u32, um/s^2; 60C5h.
  std::uint16_t heartbeat_timeout = 0x0114;  ///< u16, ms; 0 is off.
  std::uint16_t start_window = 0x0115;       ///< u16, ms; an order to move counts only so soon after the one before it.
  std::uint16_t parameter_crc = 0x0116;      ///< u32; of everything that shapes a motion.

  WordOrder word_order = WordOrder::kHighFirst;
  /// Registers that a reading writes from `counter` on, the others as 0: 2 where a drive takes whole 32-bit objects.
  std::uint16_t counter_registers = 1;
  double units_per_mm = 1000.0;     ///< Of target, position and limits.
  double units_per_mm_s = 1000.0;   ///< Of speeds.
  double units_per_mm_s2 = 1000.0;  ///< Of accelerations.

  // What the configuration says where the drive has no register for it.
  double declared_z_min_mm = 0.0;
  double declared_z_max_mm = 0.0;
  double declared_max_speed_mm_s = 0.0;
  double declared_max_acceleration_mm_s2 = 0.0;
  double declared_heartbeat_ms = 0.0;  ///< After how long the drive stops without us, as measured; 0: it does not.

  /// Registers address … address + count - 1.
  struct Block {
    std::uint16_t address = 0;
    std::uint16_t count = 0;
  };
  /// The shortest block that holds all command registers.
  [[nodiscard]] Block CommandBlock() const;
  /// The shortest block that holds the echo and the cyclic status registers.
  [[nodiscard]] Block StatusBlock() const;
  /// The shortest block that holds the echo and the identity registers.
  [[nodiscard]] Block IdentityBlock() const;
};

/// One address of the map as configuration files and messages call it.
struct AxisRegisterField {
  const char* name;
  std::uint16_t AxisRegisterMap::*address;
  int registers;  ///< 1 or 2.
  bool required;  ///< False: may be kNoRegister.
};
/// All addresses, in the order of the map.
[[nodiscard]] std::span<const AxisRegisterField> AxisRegisterFields();

/// One number of the map that is no address, as configuration files call it.
struct AxisScaleField {
  const char* name;
  double AxisRegisterMap::*value;
};
[[nodiscard]] std::span<const AxisScaleField> AxisScaleFields();

/// Bits of AxisRegisterMap::flags.
inline constexpr std::uint16_t kAxisFlagHomed = 1U << 0;
inline constexpr std::uint16_t kAxisFlagMoving = 1U << 1;

inline constexpr std::uint16_t kAxisProtocolVersion = 1;

/// CiA 402 control word (6040h).
namespace control_word {
inline constexpr std::uint16_t kShutdown = 0x0006;
inline constexpr std::uint16_t kSwitchOn = 0x0007;
inline constexpr std::uint16_t kEnableOperation = 0x000F;
inline constexpr std::uint16_t kQuickStop = 0x0002;
inline constexpr std::uint16_t kDisableVoltage = 0x0000;
inline constexpr std::uint16_t kFaultReset = 0x0080;
inline constexpr std::uint16_t kStart = 0x0010;  ///< New set-point, or start homing; on the rising edge.
inline constexpr std::uint16_t kChangeImmediately = 0x0020;
inline constexpr std::uint16_t kHalt = 0x0100;
}  // namespace control_word

/// CiA 402 operation modes (6060h).
inline constexpr std::uint16_t kModeProfilePosition = 1;
inline constexpr std::uint16_t kModeHoming = 6;

/// CiA 402 status word (6041h), single bits.
namespace status_word {
inline constexpr std::uint16_t kTargetReached = 1U << 10;
inline constexpr std::uint16_t kAcknowledge = 1U << 12;  ///< Set-point taken (mode 1), homing attained (mode 6).
inline constexpr std::uint16_t kModeError = 1U << 13;    ///< Following error (mode 1), homing error (mode 6).
}  // namespace status_word

/// The power states of CiA 402.
enum class DriveState {
  kNotReady,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReaction,
  kFault,
  kUnknown,  ///< A bit pattern that the standard does not know.
};

/// Decodes the state bits 0–3, 5 and 6 of a status word.
[[nodiscard]] DriveState DriveStateOf(std::uint16_t status_word);
/// The bits that announce a state; also voltage enabled (4) and remote (9). Not for kUnknown.
[[nodiscard]] std::uint16_t StatusBitsOf(DriveState state);
/// Plain words, as in the standard.
[[nodiscard]] const char* DriveStateText(DriveState state);
/// What a fault code (603Fh) means and what to do about it, one line.
[[nodiscard]] std::string AxisFaultText(std::uint16_t fault_code);
/// Whether the fault is that an input of the drive, or its brake, stopped it: the safety chain's doing, or the
/// program's.
[[nodiscard]] bool IsStopInputFault(std::uint16_t fault_code);

/// Checks that nothing overlaps, that what is needed is there, that scales are above 0, and that command and status
/// registers form blocks that one transaction can carry (121 and 125 registers). The error names the field.
Status CheckRegisterMap(const AxisRegisterMap& map);

}  // namespace annulus
