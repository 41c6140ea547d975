#include "firmware_iface/ring_boards.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace annulus {
namespace {

const char* AdviceFor(UsbStatus status) {
  switch (status) {
    case UsbStatus::kNoMemory:
      return "raise usbfs_memory_mb of the kernel and try again";
    case UsbStatus::kNoAccess:
      return "install the udev rule of docs/booth.md, and let this user's group have the boards";
    case UsbStatus::kBusy:
      return "end the other program that uses the ring";
    case UsbStatus::kNoDevice:
      return "check the board's cable and supply, then start again";
    default:
      return "check the board's cable; power-cycle the ring if it happens again";
  }
}

/// Sorted by first sensor, the boards must follow each other from 0 to `sensor_count` without gap or overlap.
Status CheckCover(const std::vector<IdentifiedBoard>& sorted, std::uint16_t sensor_count) {
  const std::string attempted = "put the ring's boards together";
  std::vector<RingBoard> boards;
  boards.reserve(sorted.size());
  for (const IdentifiedBoard& known : sorted) boards.push_back(known.board);
  const std::string map = "; found: " + BoardMap(boards);
  std::set<std::uint32_t> serials;
  std::uint32_t next = 0;
  for (const IdentifiedBoard& known : sorted) {
    if (!serials.insert(known.board.serial).second) {
      return Fail(attempted, "two boards have the number " + std::to_string(known.board.serial) + map,
                  "give each board its own number");
    }
    if (known.board.first_sensor != next) {
      return Fail(
          attempted,
          BoardName(known.board) + " stands where the board of sensor " + std::to_string(next) + " is expected" + map,
          "plug in the missing board, or correct [ring] boards");
    }
    next += known.board.sensor_count;
  }
  if (next == sensor_count) return {};
  return Fail(attempted, std::to_string(next) + " sensors in all; the ring has " + std::to_string(sensor_count) + map,
              "plug in the missing boards");
}

}  // namespace

UsbRequest RequestTo(BoardRequest request) { return {static_cast<std::uint8_t>(request), 0, 0}; }

std::string BoardName(const RingBoard& board) {
  if (board.first_sensor == kNotInRing) {
    return "reference board " + std::to_string(board.serial) + " (port " + board.port_path + ")";
  }
  return "ring board " + std::to_string(board.serial) + " (sensors " + std::to_string(board.first_sensor) + "-" +
         std::to_string(board.first_sensor + board.sensor_count - 1) + ", port " + board.port_path + ")";
}

std::string BoardMap(const std::vector<RingBoard>& boards) {
  std::string text;
  for (const RingBoard& board : boards) {
    text += (text.empty() ? "" : ", ") + std::to_string(board.serial) + " at port " + board.port_path + " sensors " +
            std::to_string(board.first_sensor) + "-" + std::to_string(board.first_sensor + board.sensor_count - 1);
  }
  return text.empty() ? "no board" : text;
}

tl::unexpected<Error> FailUsb(std::string attempted, const UsbFailure& failure) {
  std::string seen = UsbStatusText(failure.status);
  if (!failure.detail.empty()) seen += " (" + failure.detail + ")";
  return Fail(std::move(attempted), std::move(seen), AdviceFor(failure.status));
}

Result<IdentifiedBoard> IdentifyBoard(UsbPort& port, const UsbRangeRingOptions& options) {
  const std::string attempted = "identify the ring board at port " + port.identity().port_path;
  const auto reply = port.ControlIn(RequestTo(BoardRequest::kIdentify), kBoardIdentityBytes, options.control_timeout);
  if (!reply) return FailUsb(attempted, reply.error());
  const auto identity = DecodeBoardIdentity(*reply);
  if (!identity) return Fail(identity);
  if (identity->protocol_version != kRingProtocolVersion || identity->sensor_count != kSensorsPerBoard) {
    return Fail(attempted,
                "board " + std::to_string(identity->serial) + " speaks protocol " +
                    std::to_string(identity->protocol_version) + " with " + std::to_string(identity->sensor_count) +
                    " sensors; this program speaks " + std::to_string(kRingProtocolVersion) + " with " +
                    std::to_string(kSensorsPerBoard),
                "update the board's firmware or the program");
  }
  IdentifiedBoard known;
  known.port = &port;
  const auto& version = identity->firmware_version;
  known.board = {identity->serial,
                 identity->first_sensor,
                 identity->sensor_count,
                 identity->protocol_version,
                 std::to_string(version[0]) + "." + std::to_string(version[1]) + "." + std::to_string(version[2]),
                 port.identity().port_path};
  known.limits = {0, Hertz(identity->min_level_rate_mhz / 1000.0), Hertz(identity->max_level_rate_mhz / 1000.0)};
  if (options.first_sensors.empty()) return known;
  const auto mapped = options.first_sensors.find(identity->serial);
  if (mapped == options.first_sensors.end()) {
    return Fail(attempted,
                "board " + std::to_string(identity->serial) + " is not in the configuration's list of boards",
                "add it to [ring] boards with its first sensor, or plug in the right board");
  }
  known.board.first_sensor = mapped->second;
  return known;
}

bool IsReference(const UsbIdentity& identity, const UsbRangeRingOptions& options) {
  return options.reference && identity.serial == "RB" + std::to_string(options.reference->serial);
}

Result<std::vector<IdentifiedBoard>> IdentifyBoards(const std::vector<UsbPort*>& ports,
                                                    const UsbRangeRingOptions& options) {
  std::vector<IdentifiedBoard> known;
  for (UsbPort* port : ports) {
    auto introduced = IdentifyBoard(*port, options);
    if (!introduced) return Fail(introduced);
    known.push_back(*introduced);
  }
  std::sort(known.begin(), known.end(), [](const IdentifiedBoard& a, const IdentifiedBoard& b) {
    return std::pair(a.board.first_sensor, a.board.serial) < std::pair(b.board.first_sensor, b.board.serial);
  });
  RETURN_IF_ERROR(CheckCover(known, options.sensor_count));
  return known;
}

Result<IdentifiedBoard> Quieten(UsbPort& port, const UsbRangeRingOptions& options) {
  auto known = IdentifyBoard(port, options);
  if (!known) return known;
  const auto stopped = port.ControlOut(RequestTo(BoardRequest::kStop), {}, options.control_timeout);
  if (!stopped) return FailUsb("stop " + BoardName(known->board), stopped.error());
  return known;
}

RingLimits CommonLimits(const std::vector<IdentifiedBoard>& known, std::uint16_t sensor_count) {
  RingLimits limits{sensor_count, Hertz(0.0), Hertz(std::numeric_limits<double>::infinity())};
  for (const IdentifiedBoard& one : known) {
    limits.min_level_rate = std::max(limits.min_level_rate, one.limits.min_level_rate);
    limits.max_level_rate = std::min(limits.max_level_rate, one.limits.max_level_rate);
  }
  return limits;
}

Status CheckPlaces(const std::vector<RingBoard>& before, const std::vector<RingBoard>& now) {
  for (std::size_t i = 0; i < now.size(); ++i) {
    bool swapped = now[i].serial != before[i].serial || now[i].first_sensor != before[i].first_sensor;
    for (std::size_t j = 0; j < now.size(); ++j) {
      swapped = swapped || (i != j && now[i].port_path == before[j].port_path);
    }
    if (!swapped) continue;
    return Fail("open the ring again",
                "boards have changed places; before: " + BoardMap(before) + "; now: " + BoardMap(now),
                "plug each board in where it was, or correct [ring] boards, and open the ring again");
  }
  return {};
}

Result<std::vector<std::unique_ptr<UsbPort>>> OpenListedBoards(UsbHost& host, const UsbRangeRingOptions& options,
                                                               Clock& clock, std::chrono::nanoseconds deadline) {
  const auto listed = host.List();
  if (!listed) return FailUsb("list the ring's boards", listed.error());
  if (listed->empty()) {
    return Fail("open the ring", "no ring board is plugged in", "check the ring's supply and its USB cable");
  }
  std::set<std::string> serials;
  std::string map;
  std::string repeated;
  for (const UsbIdentity& identity : *listed) {
    map += (map.empty() ? "" : ", ") + DeviceName(identity);
    if (!identity.serial.empty() && !serials.insert(identity.serial).second) repeated = identity.serial;
  }
  if (!repeated.empty()) {
    return Fail("open the ring", "two boards have the serial number " + repeated + "; found: " + map,
                "give each board its own number");
  }
  std::vector<std::unique_ptr<UsbPort>> ports;
  std::optional<UsbIdentity> reference;
  for (const UsbIdentity& identity : *listed) {
    if (IsReference(identity, options)) {
      reference = identity;
      continue;
    }
    auto port = OpenPort(host, identity, clock, deadline);
    if (!port) {
      return FailUsb("open the ring board " + DeviceName(identity), port.error());
    }
    ports.push_back(std::move(*port));
  }
  if (!reference) return ports;
  if (auto port = OpenPort(host, *reference, clock, deadline)) ports.push_back(std::move(*port));
  return ports;
}

ClockReply AskClock(UsbPort& port, std::chrono::nanoseconds timeout, Clock& clock) {
  ClockExchange exchange;
  exchange.host_before = clock.Now();
  auto reply = port.ControlIn(RequestTo(BoardRequest::kReadClock), sizeof(std::uint64_t), timeout);
  exchange.host_after = clock.Now();
  return {exchange, std::move(reply)};
}

}  // namespace annulus
