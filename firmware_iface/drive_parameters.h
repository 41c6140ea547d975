#pragma once

#include <cstdint>
#include <optional>

#include "base/result.h"
#include "firmware_iface/drive_dialogue.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// What a drive says about itself that must not change while we use it.
struct DriveParameters {
  AxisIdentity identity;
  double heartbeat_ms = 0.0;                             ///< 0: off.
  std::optional<double> start_window_ms = std::nullopt;  ///< Nothing: the drive has no such rule.
  std::optional<std::uint32_t> parameter_crc = std::nullopt;
};

/// Reads them from the identity block; what the drive does not have is what the map declares.
[[nodiscard]] DriveParameters ParseDriveParameters(const RegisterBlock& registers, const AxisRegisterMap& map);

/// Refuses a drive that must not move with us: other protocol version, limits that make no sense, a heartbeat that is
/// off or longer than ScanAxis::kHeartbeat, a start window that is off or longer than we wait for a reply.
Status CheckDriveParameters(const DriveParameters& parameters, const ModbusAxisOptions& options);

/// Refuses a drive whose parameters are no longer those that it was identified with; names the first that changed.
Status CheckUnchanged(const DriveParameters& identified, const DriveParameters& now);

}  // namespace annulus
