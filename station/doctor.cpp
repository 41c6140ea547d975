#include "station/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "station/devices.h"
#include "station/host_check.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Collects items of one group.
class Group {
 public:
  Group(std::string name, std::vector<DoctorItem>& items) : name_(std::move(name)), items_(items) {}
  void Ok(std::string what, std::string seen) { Add(std::move(what), DoctorVerdict::kOk, std::move(seen), {}); }
  void None(std::string what, std::string seen) { Add(std::move(what), DoctorVerdict::kNone, std::move(seen), {}); }
  void Problem(std::string what, std::string seen, std::string advice) {
    Add(std::move(what), DoctorVerdict::kProblem, std::move(seen), std::move(advice));
  }
  void Problem(std::string what, const Error& error) { Problem(std::move(what), error.seen, error.advice); }

 private:
  void Add(std::string what, DoctorVerdict verdict, std::string seen, std::string advice) {
    items_.push_back({name_, std::move(what), verdict, std::move(seen), std::move(advice)});
  }
  std::string name_;
  std::vector<DoctorItem>& items_;
};

template <class T>
bool Contains(const std::vector<T>& list, const T& one) {
  return std::find(list.begin(), list.end(), one) != list.end();
}

// --- buses --------------------------------------------------------------------------------------------------------

void CheckUsb(const Config& config, std::vector<DoctorItem>& items) {
  Group group("buses", items);
  const bool needed = config.ring.bus == RingBus::kUsb;
  SystemClock clock;
  const auto host = OpenLibusbHost(clock);
  const auto absent = [&](const std::string& seen, const std::string& advice) {
    needed ? group.Problem("USB", seen, advice) : group.None("USB", seen);
  };
  if (!host) return absent(host.error().seen, host.error().advice);
  const auto boards = (*host)->List();
  if (!boards)
    return absent(UsbStatusText(boards.error().status) + std::string(" ") + boards.error().detail,
                  "check that /dev/bus/usb is there and may be read");
  if (boards->empty()) return absent("no ring board is plugged in", "check the ring's supply, hub and cable");
  for (const UsbIdentity& board : *boards) {
    const std::string name = "USB " + board.port_path;
    const auto port = (*host)->Open(board);
    if (port) {
      group.Ok(name, "ring board " + board.serial);
    } else {
      group.Problem(name, DeviceName(board) + ": " + UsbStatusText(port.error().status) + " " + port.error().detail,
                    "install the udev rules of docs/booth.md, and end other programs that use the ring");
    }
  }
}

std::string LinkText(const CanLink& link) {
  std::string text = CanStateText(link.state);
  if (link.bit_rate) text += fmt::format(", {} kbit/s", *link.bit_rate / 1000);
  if (link.data_bit_rate) text += fmt::format(", data {} kbit/s", *link.data_bit_rate / 1000);
  if (link.restart_ms) text += fmt::format(", restart-ms {}", *link.restart_ms);
  return text + fmt::format(", queue {}{}", link.queue_length, link.fd ? ", FD" : "");
}

void CheckCan(const Config& config, std::vector<DoctorItem>& items) {
  constexpr std::uint32_t kQueue = 128;
  constexpr std::uint32_t kRestartMs = 1000;  // a shorter one makes a bus with a short circuit flap
  Group group("buses", items);
  const bool ring_on_can = config.ring.bus == RingBus::kCan;
  const auto links = ListCanInterfaces();
  std::vector<std::string> found;
  if (links) {
    for (const CanLink& link : *links) {
      found.push_back(link.name);
      const bool needed = ring_on_can && Contains(config.ring.can_interfaces, link.name);
      const std::string name = "CAN " + link.name;
      if (!needed) {
        group.None(name, LinkText(link));
      } else if (link.state == CanState::kDown || link.state == CanState::kBusOff) {
        group.Problem(name, LinkText(link), "set it up as docs/booth.md says, then: ip link set " + link.name + " up");
      } else if (link.restart_ms.value_or(0) > 0 && *link.restart_ms < kRestartMs) {
        group.Problem(name, LinkText(link),
                      fmt::format("ip link set {} type can restart-ms {}", link.name, kRestartMs));
      } else if (link.queue_length < kQueue) {
        group.Problem(name, LinkText(link), fmt::format("ip link set {} txqueuelen {}", link.name, kQueue));
      } else {
        group.Ok(name, LinkText(link));
      }
    }
  }
  if (ring_on_can) {
    for (const std::string& name : config.ring.can_interfaces) {
      if (Contains(found, name)) continue;
      group.Problem("CAN " + name, links ? "there is no such interface" : links.error().seen,
                    links ? "plug in the adapter, load its driver, or correct ring.can" : links.error().advice);
    }
  } else if (found.empty()) {
    group.None("CAN", links ? "no interface" : links.error().seen);
  }
}

void CheckSerial(const Config& config, std::vector<DoctorItem>& items) {
  Group group("buses", items);
  const std::vector<std::string> ports = ListSerialPorts();
  for (const std::string& port : ports) group.Ok("serial", port);
  const auto* serial = std::get_if<ModbusRtuOptions>(&config.axis.link);
  if (serial != nullptr && !Contains(ports, serial->device) && !PathExists(serial->device)) {
    group.Problem("serial", serial->device + " is not there",
                  "plug in the adapter, or take a name of /dev/serial/by-id for axis.link");
  } else if (ports.empty() && serial == nullptr) {
    group.None("serial", "no port in /dev/serial/by-id");
  }
}

void CheckGpio(const Config& config, std::vector<DoctorItem>& items) {
  Group group("buses", items);
  const auto chips = ListGpioChips();
  if (chips) {
    for (const GpioChipInfo& chip : *chips) {
      if (chip.problem.empty()) {
        group.Ok("GPIO " + chip.name, fmt::format("'{}', {} lines", chip.label, chip.lines.size()));
      } else if (config.interlock.simulated) {
        group.None("GPIO " + chip.name, chip.problem);
      } else {
        group.Problem("GPIO " + chip.name, chip.problem, "install the udev rules of docs/booth.md");
      }
    }
    if (!chips->empty()) return;
  }
  const std::string seen = chips ? "no chip" : chips.error().seen;
  if (config.interlock.simulated) {
    group.None("GPIO", seen);
  } else {
    group.Problem("GPIO", seen, chips ? "check that the driver of the I/O board is loaded" : chips.error().advice);
  }
}

// --- devices ------------------------------------------------------------------------------------------------------

/// The board beside the ring: scans go on without it, but not as well.
void CheckReference(const RingConfig& config, RangeRing& ring, Group& group) {
  const ReferenceBoard* reference = ring.reference();
  if (reference == nullptr) return;
  const std::string name = fmt::format("reference board {}", reference->serial);
  const auto time = ring.ReadClock(ring.boards().size());
  if (!time) {
    return group.Problem(name, time.error().seen, "check its cable, supply and number; until then scans do without");
  }
  std::string sensors;
  for (const ReferenceSensor& sensor : config.reference->sensors) {
    sensors += fmt::format("{}{:.0f} mm at {:.0f} deg", sensors.empty() ? "" : ", ", sensor.height_mm,
                           DegreesFromRadians(sensor.theta));
  }
  const RingBoard& board = *reference->board;
  const std::chrono::duration<double, std::milli> round_trip = time->host_after - time->host_before;
  group.Ok(name, fmt::format("sensors at {}; firmware {}, protocol {}, at {}, answers in {:.2f} ms", sensors,
                             board.firmware_version, board.protocol_version, board.port_path, round_trip.count()));
}

void CheckRing(const Config& config, DeviceGround& ground, std::vector<DoctorItem>& items) {
  Group group("ring", items);
  if (config.ring.bus == RingBus::kSimulated) group.None("simulated", "the boards are models in this program");
  auto opened = OpenRing(config.ring, ground);
  if (!opened) return group.Problem("ring", opened.error());
  RangeRing& ring = *opened->ring;
  for (std::size_t i = 0; i < ring.boards().size(); ++i) {
    const RingBoard& board = ring.boards()[i];
    const std::string name = fmt::format("board {}", board.serial);
    const auto time = ring.ReadClock(i);
    if (!time) {
      group.Problem(name, time.error());
      continue;
    }
    const std::chrono::duration<double, std::milli> round_trip = time->host_after - time->host_before;
    group.Ok(name, fmt::format("sensors {}-{}, firmware {}, protocol {}, at {}, answers in {:.2f} ms",
                               board.first_sensor, board.first_sensor + board.sensor_count - 1, board.firmware_version,
                               board.protocol_version, board.port_path, round_trip.count()));
  }
  CheckReference(config.ring, ring, group);
  const RingLimits& limits = ring.limits();
  group.Ok("ring", fmt::format("{} sensors, {:.0f} to {:.0f} levels per second", limits.sensor_count,
                               limits.min_level_rate.value(), limits.max_level_rate.value()));
}

/// What the drive says of itself; a map may not have it.
std::string IdentityText(const AxisConfig& config, const AxisIdentity& identity) {
  const AxisRegisterMap& map = config.register_map;
  std::string text;
  const auto add = [&](const char* what, std::uint16_t address, const std::string& value) {
    text += fmt::format("{} {}, ", what, address == kNoRegister ? std::string("not told") : value);
  };
  add("serial", map.serial, std::to_string(identity.serial));
  add("firmware", map.firmware_version, identity.firmware_version);
  add("protocol", map.protocol_version, std::to_string(identity.protocol_version));
  return text + "on " + config.LinkText();
}

void CheckAxis(const Config& config, DeviceGround& ground, std::vector<DoctorItem>& items) {
  Group group("axis", items);
  if (config.axis.simulated()) group.None("simulated", "the drive is a model in this program");
  auto opened = OpenAxis(config.axis, ground);
  if (!opened) return group.Problem("drive", opened.error());
  const AxisIdentity& identity = opened->axis->identity();
  group.Ok("drive", IdentityText(config.axis, identity));
  group.Ok("limits", fmt::format("{:.1f} to {:.1f} mm, {:.0f} mm/s, {:.0f} mm/s2", identity.limits.z_min.value(),
                                 identity.limits.z_max.value(), identity.limits.max_speed.value(),
                                 identity.limits.max_acceleration.value()));
  const auto position = opened->axis->Position();
  if (!position) return group.Problem("position", position.error());
  if (!position->fresh) return group.Problem("position", "the drive did not answer", "check cable and unit address");
  group.Ok("position", position->homed ? fmt::format("{:.2f} mm", position->z.value()) : "not homed");
  if (position->fault_code != 0) {
    group.Problem("state", AxisFaultText(position->fault_code), "clear the cause; enabling the axis resets the fault");
  } else if (position->moving || position->powered) {
    group.Problem("state", position->moving ? "it moves, and not by us" : "it has power, and not from us",
                  "end whatever else talks to the drive");
  } else {
    group.Ok("state", "at rest, without power");
  }
}

/// Reads for a little longer than the E-stop channels may disagree, so that a lasting disagreement is found.
Result<InterlockReading> ReadForAWhile(Interlock& interlock, Clock& clock) {
  const nanoseconds end = clock.Now() + interlock_time::kDisagreement + std::chrono::milliseconds(200);
  Result<InterlockReading> reading = interlock.Read();
  while (reading && clock.Now() < end) reading = interlock.WaitChange(end);
  return reading;
}

void CheckInterlock(const Config& config, WatchdogTest watchdog, DeviceGround& ground, std::vector<DoctorItem>& items) {
  Group group("interlock", items);
  if (config.interlock.simulated) group.None("simulated", "the safety chain is a model in this program");
  auto opened = OpenInterlock(config.interlock, ground);
  if (!opened) return group.Problem("lines", opened.error());
  const auto reading = ReadForAWhile(**opened, ground.clock());
  if (!reading) return group.Problem("lines", reading.error());
  std::string levels;
  std::string open;
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    const auto input = static_cast<InterlockInput>(i);
    levels += fmt::format("{}{} {}", i == 0 ? "" : ", ", InterlockName(input), (*reading)[input] ? 1 : 0);
    if (IsChainInput(input) && !(*reading)[input]) open.append(open.empty() ? "" : ", ").append(InterlockName(input));
  }
  group.Ok("lines", levels);
  if (open.empty()) {
    group.Ok("chain", "closed");
  } else {
    group.Problem("chain", "open at " + open,
                  "release the E-stop and shut the door; if it stays open, check that wire");
  }
  for (const InterlockNotice& notice : (*opened)->Diagnose()) group.Problem("chain", notice.text, notice.advice);
  if (watchdog == WatchdogTest::kSkip) return;
  const auto drop = TestWatchdogRelay(**opened, ground.clock());
  if (!drop) return group.Problem("watchdog relay", drop.error());
  const std::chrono::duration<double, std::milli> milliseconds = *drop;
  group.Ok("watchdog relay", fmt::format("drops {:.0f} ms after the last beat", milliseconds.count()));
}

}  // namespace

const char* DoctorVerdictText(DoctorVerdict verdict) {
  switch (verdict) {
    case DoctorVerdict::kOk:
      return "ok";
    case DoctorVerdict::kNone:
      return "none";
    case DoctorVerdict::kProblem:
      return "problem";
  }
  return "unknown";
}

bool DoctorReport::healthy() const {
  return std::none_of(items.begin(), items.end(),
                      [](const DoctorItem& item) { return item.verdict == DoctorVerdict::kProblem; });
}

DoctorReport Diagnose(const Config& config, const std::string& config_name, Storage& storage, WatchdogTest watchdog) {
  DoctorReport report{config_name, CheckHost(config)};
  CheckUsb(config, report.items);
  CheckCan(config, report.items);
  CheckSerial(config, report.items);
  CheckGpio(config, report.items);
  auto ground = DeviceGround::Make(config, storage);
  if (!ground) {
    Group("host", report.items).Problem("simulated booth", ground.error());
    return report;
  }
  CheckRing(config, **ground, report.items);
  CheckAxis(config, **ground, report.items);
  CheckInterlock(config, watchdog, **ground, report.items);
  return report;
}

}  // namespace annulus
