#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace annulus::sim {

/// What of the booth a fault is in.
enum class FaultTarget {
  kUsb,       ///< The boards' USB ports and bus.
  kCan,       ///< The CAN buses and the boards' controllers.
  kAxisLink,  ///< The Modbus link to the drive.
  kAxis,      ///< The drive and the carriage.
  kSensors,   ///< The boards with their sensors, on any bus.
  kChain,     ///< The hardware of the safety chain, and the people at it.
  kGpio,      ///< The program's lines to the safety chain.
  kStorage,   ///< The disk.
  kHost,      ///< The computer and the program.
};
inline constexpr std::size_t kFaultTargets = 9;

/// What goes wrong. What each does, with which arguments, is said once: in docs/formats.md.
enum class FaultKind {
  // usb
  kUsbUnplug,
  kUsbShort,
  kUsbZero,
  kUsbLong,
  kUsbDamage,
  kUsbTimeout,
  kUsbStall,
  kUsbNoMemory,
  kUsbCancelCompletes,
  kUsbSameSerial,
  kUsbSwapped,
  // can
  kCanLose,
  kCanRepeat,
  kCanDisplace,
  kCanOverflow,
  kCanQueueFull,
  kCanDown,
  kCanGone,
  kCanBusOff,
  kCanErrorStates,
  kCanFlood,
  kCanBoardOff,
  kCanBoardHangs,
  kCanEmergency,
  kCanSameNode,
  // axis_link
  kLinkLoseRequest,
  kLinkLoseReply,
  kLinkLate,
  kLinkRepeat,
  kLinkTruncate,
  kLinkDamage,
  kLinkMerge,
  kLinkException,
  kLinkFreeze,
  kLinkUnplug,
  // axis
  kAxisLag,
  kAxisContact,
  kAxisOverload,
  kAxisSlip,
  kAxisEncoderJump,
  kAxisHomeNever,
  kAxisHomeStuck,
  kAxisLimit,
  kAxisDriveFault,
  kAxisUnorderedMove,
  kAxisScale,
  kAxisOverspeed,
  kAxisIgnoreStops,
  kAxisIgnoreQuickStop,
  kAxisPowerOff,
  kAxisParameter,
  // sensors
  kSensorsStuck,
  kSensorsNoReturn,
  kSensorsSpikes,
  kSensorsDrift,
  kSensorsDead,
  kSensorsSilent,
  kSensorsLate,
  kSensorsClockStuck,
  kSensorsClockJump,
  kSensorsClockWrap,
  kSensorsProtocol,
  kSensorsFirmware,
  kSensorsPlace,
  kSensorsEmitterFault,
  kSensorsSwapped,
  // chain
  kChainEstop,
  kChainOpen,
  kChainWireBreak,
  kChainPress,
  kChainJamBrake,
  kChainWeldStoA,
  kChainWeldWatchdog,
  kChainCutWatchdog,
  kChainBurnOut,
  kChainShort,
  kChainRemoveChip,
  kChainOccupied,
  kChainRenamed,
  // gpio
  kGpioStuck,
  kGpioLoseEdges,
  kGpioChatter,
  kGpioLateEdges,
  kGpioFail,
  kGpioFailWrites,
  kGpioGone,
  // storage
  kStorageNoSpace,
  kStorageIoError,
  kStorageShortWrite,
  kStorageSyncError,
  kStorageSlowSync,
  kStorageReadOnly,
  kStorageLowSpace,
  // host
  kHostKill,
  kHostHang,
  kHostLateTicks,
  kHostThreadDead,
  kHostWallJump,
  kHostHot,
};
inline constexpr std::size_t kFaultKinds = static_cast<std::size_t>(FaultKind::kHostHot) + 1;

/// An argument; its name carries the unit.
enum class FaultArg {
  kBoard,   ///< Of the ring, by its place, 0 first; 12: the reference board.
  kOther,   ///< A second board, or sensor.
  kBus,     ///< CAN bus, 0 first.
  kSensor,  ///< Of the ring, 0 first.
  kSensors,
  kShare,
  kCount,
  kSpreadMs,
  kNotReadyS,
  kEnding,
  kStays,
  kFrames,
  kRateHz,
  kId,
  kErrorState,
  kCode,
  kDelayMs,
  kRegisters,
  kTimeConstantMs,
  kHeightMm,
  kSpeedMmS,
  kJumpMm,
  kEnd,
  kScale,
  kParameter,
  kValue,
  kSizeMm,
  kLevels,
  kJumpMs,
  kInS,
  kVersion,
  kChannel,
  kInput,
  kOutput,
  kLevel,
  kPairs,
  kBytes,
  kThread,
  kJumpS,
};
inline constexpr std::size_t kFaultArgs = static_cast<std::size_t>(FaultArg::kJumpS) + 1;

/// An argument of a kind. Whole numbers and words are numbers, too.
struct FaultArgRule {
  FaultArg arg = FaultArg::kBoard;
  double low = 0.0;
  double high = 0.0;
  enum class Need { kMust, kMay };
  Need need = Need::kMust;
  std::optional<double> fallback = std::nullopt;  ///< What counts if it is not given.
};

/// Whether a fault lasts.
enum class FaultSpan {
  kMoment,  ///< It happens at one time, or cannot be undone.
  kAny,     ///< For a time, or for good.
  kLimited  ///< A time must be given.
};

struct FaultKindTraits {
  FaultKind kind = FaultKind::kHostKill;
  FaultTarget target = FaultTarget::kHost;
  const char* name = "";
  FaultSpan span = FaultSpan::kAny;
  std::vector<FaultArgRule> args;
};
[[nodiscard]] const FaultKindTraits& TraitsOf(FaultKind kind);
/// All kinds, those of one target together.
[[nodiscard]] std::span<const FaultKindTraits> AllFaultKinds();

/// As files call it: "axis_link".
[[nodiscard]] const char* FaultTargetName(FaultTarget target);
/// Whether the target has a seam whose calls can be counted.
[[nodiscard]] bool HasCalls(FaultTarget target);

struct FaultArgTraits {
  const char* name = "";
  enum class Type { kNumber, kWhole, kWord };
  Type type = Type::kNumber;
  std::vector<std::string> words;  ///< kWord; the value is the index.
};
[[nodiscard]] const FaultArgTraits& TraitsOf(FaultArg arg);

}  // namespace annulus::sim
