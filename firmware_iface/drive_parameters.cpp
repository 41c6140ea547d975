#include "firmware_iface/drive_parameters.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace annulus {
namespace {

constexpr double kLongestTravelMm = 5000.0;
constexpr double kHighestSpeedMmS = 2000.0;
constexpr double kHighestAccelerationMmS2 = 20'000.0;

/// A number as messages show it: no zeros behind the last digit.
std::string Shown(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

double WordOr(const RegisterBlock& registers, std::uint16_t address, double declared) {
  return address == kNoRegister ? declared : registers.Word(address);
}

double LongOr(const RegisterBlock& registers, std::uint16_t address, double units, double declared) {
  return address == kNoRegister ? declared : registers.Long(address) / units;
}

double SignedOr(const RegisterBlock& registers, std::uint16_t address, double units, double declared) {
  return address == kNoRegister ? declared : registers.Signed(address) / units;
}

Status CheckHeartbeat(const std::string& attempted, double heartbeat_ms) {
  if (heartbeat_ms > 0.0 && heartbeat_ms <= static_cast<double>(ScanAxis::kHeartbeat.count())) return {};
  return Fail(attempted,
              "its heartbeat time-out is " + (heartbeat_ms > 0.0 ? Shown(heartbeat_ms) + " ms" : std::string("off")),
              "set it to " + std::to_string(ScanAxis::kHeartbeat.count()) +
                  " ms or less: the axis must stop when the host does");
}

Status CheckStartWindow(const std::string& attempted, double window_ms, const ModbusAxisOptions& options) {
  const double reply_ms = std::chrono::duration<double, std::milli>(options.reply_timeout).count();
  if (window_ms > 0.0 && window_ms <= reply_ms) return {};
  return Fail(attempted, "its start window is " + (window_ms > 0.0 ? Shown(window_ms) + " ms" : std::string("off")),
              "set it to " + Shown(reply_ms) + " ms or less: no order may be obeyed after it was given up");
}

}  // namespace

DriveParameters ParseDriveParameters(const RegisterBlock& registers, const AxisRegisterMap& map) {
  DriveParameters parsed;
  AxisIdentity& identity = parsed.identity;
  identity.protocol_version =
      map.protocol_version == kNoRegister ? kAxisProtocolVersion : registers.Word(map.protocol_version);
  if (map.firmware_version != kNoRegister) {
    const std::uint16_t firmware = registers.Word(map.firmware_version);
    identity.firmware_version = std::to_string(firmware >> 8) + "." + std::to_string(firmware & 0xFF);
  }
  if (map.serial != kNoRegister) identity.serial = registers.Long(map.serial);
  identity.limits = {
      Millimetres(SignedOr(registers, map.z_min, map.units_per_mm, map.declared_z_min_mm)),
      Millimetres(SignedOr(registers, map.z_max, map.units_per_mm, map.declared_z_max_mm)),
      MillimetresPerSecond(LongOr(registers, map.max_speed, map.units_per_mm_s, map.declared_max_speed_mm_s)),
      MillimetresPerSecondSquared(
          LongOr(registers, map.max_acceleration, map.units_per_mm_s2, map.declared_max_acceleration_mm_s2))};
  parsed.heartbeat_ms = WordOr(registers, map.heartbeat_timeout, map.declared_heartbeat_ms);
  if (map.start_window != kNoRegister) parsed.start_window_ms = registers.Word(map.start_window);
  if (map.parameter_crc != kNoRegister) parsed.parameter_crc = registers.Long(map.parameter_crc);
  return parsed;
}

Status CheckDriveParameters(const DriveParameters& parameters, const ModbusAxisOptions& options) {
  const std::string attempted = "identify the axis drive";
  const AxisIdentity& identity = parameters.identity;
  if (identity.protocol_version != kAxisProtocolVersion) {
    return Fail(attempted,
                "it speaks protocol " + std::to_string(identity.protocol_version) + ", this program speaks " +
                    std::to_string(kAxisProtocolVersion),
                "update the drive's firmware or the program");
  }
  const AxisLimits& limits = identity.limits;
  if (!(limits.z_min < limits.z_max) || !(limits.max_speed.value() > 0.0) || !(limits.max_acceleration.value() > 0.0)) {
    return Fail(attempted, "its travel, speed and acceleration limits make no sense",
                "set the drive's limits, or declared_… of [axis.register_map] where it does not tell them");
  }
  // No axis that carries a ring over a person is so long or so fast: a wrong order of words, or a wrong unit.
  if ((limits.z_max - limits.z_min).value() > kLongestTravelMm || limits.max_speed.value() > kHighestSpeedMmS ||
      limits.max_acceleration.value() > kHighestAccelerationMmS2) {
    return Fail(attempted,
                "it says " + Shown(limits.z_min.value()) + " to " + Shown(limits.z_max.value()) + " mm, " +
                    Shown(limits.max_speed.value()) + " mm/s, " + Shown(limits.max_acceleration.value()) + " mm/s^2",
                "check word_order and units_per_… of [axis.register_map], then the drive's limits");
  }
  RETURN_IF_ERROR(CheckHeartbeat(attempted, parameters.heartbeat_ms));
  if (!parameters.start_window_ms) return {};
  return CheckStartWindow(attempted, *parameters.start_window_ms, options);
}

Status CheckUnchanged(const DriveParameters& identified, const DriveParameters& now) {
  const auto changed = [](const std::string& what, const std::string& is, const std::string& was) -> Status {
    return Fail("check the axis drive's parameters", what + " is " + is + ", it was " + was + " at first",
                "find out who else writes to the drive, set its parameters right, then open the axis anew");
  };
  const AxisLimits& before = identified.identity.limits;
  const AxisLimits& after = now.identity.limits;
  struct Compared {
    const char* what;
    double was;
    double is;
  };
  const Compared compared[] = {
      {"its serial number", static_cast<double>(identified.identity.serial), static_cast<double>(now.identity.serial)},
      {"its lowest position, mm,", before.z_min.value(), after.z_min.value()},
      {"its highest position, mm,", before.z_max.value(), after.z_max.value()},
      {"its highest speed, mm/s,", before.max_speed.value(), after.max_speed.value()},
      {"its highest acceleration, mm/s^2,", before.max_acceleration.value(), after.max_acceleration.value()},
      {"its heartbeat time-out, ms,", identified.heartbeat_ms, now.heartbeat_ms},
      {"its start window, ms,", identified.start_window_ms.value_or(0.0), now.start_window_ms.value_or(0.0)},
  };
  for (const Compared& value : compared) {
    if (value.was != value.is) return changed(value.what, Shown(value.is), Shown(value.was));
  }
  if (identified.identity.firmware_version != now.identity.firmware_version) {
    return changed("its firmware", now.identity.firmware_version, identified.identity.firmware_version);
  }
  if (identified.parameter_crc != now.parameter_crc) {
    return changed("the checksum of its parameters", std::to_string(now.parameter_crc.value_or(0)),
                   std::to_string(identified.parameter_crc.value_or(0)));
  }
  return {};
}

}  // namespace annulus
