#include "firmware_iface/can_ring_boot.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "firmware_iface/can_timing.h"
#include "firmware_iface/ring_boards.h"
#include "firmware_iface/ring_objects.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A board that was off when it was told to reset may be on by now, or have missed the order: it is told again.
constexpr nanoseconds kResetAgain = milliseconds(500);
constexpr nanoseconds kPollPause = milliseconds(5);
/// How much longer than the ring's boards the reference board may take.
constexpr nanoseconds kReferenceGrace = milliseconds(500);
/// How long another node of the same id may take to answer too.
constexpr nanoseconds kSecondAnswerTime = milliseconds(20);
constexpr std::size_t kMostTextBytes = 32;
/// Share of a bus that level frames may fill.
constexpr double kMostLoad = 0.8;

std::string List(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Boards that have a serial number in the configuration but were not found.
std::string MissingSerials(const CanRangeRingOptions& options, const std::set<std::uint32_t>& found) {
  std::vector<std::string> missing;
  for (const auto& [serial, first_sensor] : options.first_sensors) {
    if (found.count(serial) == 0) missing.push_back(std::to_string(serial));
  }
  return missing.empty() ? "" : " (of the configured boards, " + List(missing) + " is missing)";
}

/// A beat alone is not enough: the board may not have heard the order to reset, or not obeyed it yet.
bool HasBooted(const CanNode& node) { return node.boots > 0; }

/// How long the frames of one level of a board occupy its bus, at most.
nanoseconds LevelTime(const CanRingBoard& one, CanBus& bus) {
  CanBitRates rates;
  if (const auto link = bus.ReadLink()) {
    rates.nominal = link->bit_rate.value_or(rates.nominal);
    rates.data = link->data_bit_rate.value_or(rates.data);
  }
  if (one.fd) return LongestFrameTime(EncodeCanFdLevel(one.node, {}), rates);
  nanoseconds time{0};
  for (const CanFrame& frame : EncodeCanLevel(one.node, {})) time += LongestFrameTime(frame, rates);
  return time;
}

/// Boots the nodes of all buses, step by step; what it learns is kept in `boards`.
class Boot {
 public:
  Boot(std::vector<CanRingBus>& buses, const CanRangeRingOptions& options, Clock& clock)
      : buses_(buses), options_(options), clock_(clock) {}

  Status Reset();
  Status AwaitBoot();
  Status CheckNodeIds();
  Status IdentifyAll();
  Status CheckCover();
  /// Awaits the one node `id` that is beside the ring.
  Status AwaitBeside(NodeId id);
  std::vector<CanRingBoard> Take() { return std::move(boards_); }

 private:
  [[nodiscard]] bool AllBooted() const;
  [[nodiscard]] std::string NameOfSilent(NodeId node) const;
  Status ReadSerials();
  Status Identify(CanRingBoard& one);
  Status Configure(const CanRingBoard& one);
  Status PutWhereConfigured(RingBoard& board) const;

  std::vector<CanRingBus>& buses_;
  const CanRangeRingOptions& options_;
  Clock& clock_;
  std::vector<CanRingBoard> boards_;
};

Status Boot::Reset() {
  for (CanRingBus& bus : buses_) {
    // What is still on its way is of the time before.
    bus.CollectAll();
    bus.ForgetNodes();
    bus.Forgive();
    RETURN_IF_ERROR(bus.Send(EncodeNmt({NmtCommand::kResetCommunication, 0}), "reset the boards on " + bus.name()));
  }
  return {};
}

bool Boot::AllBooted() const {
  for (NodeId node = 1; node <= options_.board_count; ++node) {
    if (std::none_of(buses_.begin(), buses_.end(), [&](CanRingBus& bus) { return HasBooted(bus.nodes().at(node)); })) {
      return false;
    }
  }
  return true;
}

Status Boot::AwaitBoot() {
  const nanoseconds deadline = clock_.Now() + options_.boot_deadline;
  nanoseconds reset_again = clock_.Now() + kResetAgain;
  while (!AllBooted() && clock_.Now() < deadline) {
    for (CanRingBus& bus : buses_) {
      bus.CollectUntil(std::min(deadline, clock_.Now() + kPollPause), [&] { return AllBooted(); });
      if (bus.fault()) return Fail(bus.fault()->attempted, bus.fault()->seen, bus.fault()->advice);
    }
    if (clock_.Now() < reset_again || AllBooted()) continue;
    reset_again = clock_.Now() + kResetAgain;
    for (NodeId node = 1; node <= options_.board_count; ++node) {
      for (CanRingBus& bus : buses_) {
        if (HasBooted(bus.nodes().at(node))) continue;
        RETURN_IF_ERROR(bus.Send(EncodeNmt({NmtCommand::kResetCommunication, node}), "reset " + bus.NodeName(node)));
      }
    }
  }
  return {};
}

Status Boot::AwaitBeside(NodeId id) {
  const nanoseconds deadline = clock_.Now() + kReferenceGrace;
  while (true) {
    for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
      if (!HasBooted(buses_[bus].nodes().at(id))) continue;
      boards_.push_back({{}, {}, bus, id, false});
      return {};
    }
    const nanoseconds now = clock_.Now();
    if (now >= deadline) break;
    for (CanRingBus& bus : buses_) bus.Collect(std::min(deadline, now + kPollPause));
  }
  return Fail("boot the reference board", "node " + std::to_string(id) + " says nothing",
              "check its supply, cable, node id and bit rate");
}

/// Each node id must have booted on exactly one bus.
Status Boot::CheckNodeIds() {
  std::vector<std::string> silent;
  for (NodeId node = 1; node <= options_.board_count; ++node) {
    std::vector<std::string> at;
    for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
      if (!HasBooted(buses_[bus].nodes().at(node))) continue;
      at.push_back(buses_[bus].name());
      if (at.size() == 1) boards_.push_back({{}, {}, bus, node, false});
    }
    if (at.empty()) silent.push_back(NameOfSilent(node));
    if (at.size() > 1) {
      return Fail("boot the ring's boards", "node id " + std::to_string(node) + " is used on " + List(at),
                  "give each board of the ring its own node id");
    }
  }
  if (silent.empty()) return {};
  std::set<std::uint32_t> found;
  RETURN_IF_ERROR(ReadSerials());
  for (const CanRingBoard& one : boards_) found.insert(one.board.serial);
  const auto waited_ms = options_.boot_deadline / milliseconds(1);
  return Fail("boot the ring's boards",
              List(silent) + " is not ready: silent for " + std::to_string(waited_ms) + " ms from power-up" +
                  MissingSerials(options_, found),
              "check the supply, cable, node id and bit rate of these boards, then start again");
}

/// The board that had this node id before, or the id alone.
std::string Boot::NameOfSilent(NodeId node) const {
  for (const CanRingBus& bus : buses_) {
    if (bus.KnowsName(node)) return bus.NodeName(node);
  }
  return "node " + std::to_string(node);
}

/// Asks each node for its serial number, then listens whether another board answers under the same node id.
Status Boot::ReadSerials() {
  for (CanRingBoard& one : boards_) {
    const auto serial = ReadNumber<std::uint32_t>(buses_[one.bus], one.node, kObjectSerial, options_.sdo_timeout);
    if (!serial) return Fail(serial);
    one.board.serial = *serial;
  }
  const nanoseconds listened = clock_.Now() + kSecondAnswerTime;
  for (CanRingBus& bus : buses_) bus.Collect(listened);
  for (const CanRingBoard& one : boards_) {
    const auto& serials = buses_[one.bus].nodes().at(one.node).serials;
    if (serials.size() <= 1) continue;
    std::vector<std::string> names;
    names.reserve(serials.size());
    for (const std::uint32_t serial : serials) names.push_back(std::to_string(serial));
    return Fail(
        "boot the ring's boards",
        "boards " + List(names) + " both have node id " + std::to_string(one.node) + " on " + buses_[one.bus].name(),
        "give each board of the ring its own node id");
  }
  return {};
}

Status Boot::IdentifyAll() {
  RETURN_IF_ERROR(ReadSerials());
  for (CanRingBoard& one : boards_) {
    RETURN_IF_ERROR(Identify(one));
    RETURN_IF_ERROR(Configure(one));
    CanRingBus& bus = buses_[one.bus];
    bus.SetNodeName(one.node, BoardName(one.board));
    CanNode& node = bus.nodes().at(one.node);
    node.serial = one.board.serial;
    // Beats are due from here on.
    node.last_heard = clock_.Now();
    node.levels = CanLevelAssembler(one.node, one.board.serial);
  }
  return {};
}

Status Boot::Identify(CanRingBoard& one) {
  CanRingBus& bus = buses_[one.bus];
  const nanoseconds timeout = options_.sdo_timeout;
  const auto version = ReadNumber<std::uint16_t>(bus, one.node, kObjectProtocolVersion, timeout);
  if (!version) return Fail(version);
  const auto count = ReadNumber<std::uint8_t>(bus, one.node, kObjectSensorCount, timeout);
  if (!count) return Fail(count);
  if (*version != kCanRingProtocolVersion || *count != kSensorsPerBoard) {
    return Fail("identify " + bus.NodeName(one.node),
                "board " + std::to_string(one.board.serial) + " speaks protocol " + std::to_string(*version) +
                    " with " + std::to_string(*count) + " sensors; this program speaks " +
                    std::to_string(kCanRingProtocolVersion) + " with " + std::to_string(kSensorsPerBoard),
                "update the board's firmware or the program");
  }
  const auto first = ReadNumber<std::uint16_t>(bus, one.node, kObjectFirstSensor, timeout);
  if (!first) return Fail(first);
  const auto slowest = ReadNumber<std::uint32_t>(bus, one.node, kObjectMinLevelRate, timeout);
  if (!slowest) return Fail(slowest);
  const auto fastest = ReadNumber<std::uint32_t>(bus, one.node, kObjectMaxLevelRate, timeout);
  if (!fastest) return Fail(fastest);
  const auto fd = ReadNumber<std::uint8_t>(bus, one.node, kObjectFdLevels, timeout);
  if (!fd) return Fail(fd);
  const auto text = bus.Upload(one.node, kObjectFirmwareVersion, timeout, kSdoAttempts);
  if (!text) return Fail(text);
  std::string firmware;
  for (std::size_t i = 0; i < std::min(text->size(), kMostTextBytes); ++i) {
    firmware.push_back(static_cast<char>(std::to_integer<unsigned char>((*text)[i])));
  }
  one.board = {one.board.serial,
               *first,
               *count,
               *version,
               std::move(firmware),
               bus.name() + " node " + std::to_string(one.node)};
  one.limits = {0, Hertz(*slowest / 1000.0), Hertz(*fastest / 1000.0)};
  one.fd = *fd == 1;
  return PutWhereConfigured(one.board);
}

Status Boot::PutWhereConfigured(RingBoard& board) const {
  if (options_.first_sensors.empty()) return {};
  const auto mapped = options_.first_sensors.find(board.serial);
  if (mapped == options_.first_sensors.end()) {
    return Fail("identify the ring board at " + board.port_path,
                "board " + std::to_string(board.serial) + " is not in the configuration's list of boards",
                "add it to [ring] boards with its first sensor, or connect the right board");
  }
  board.first_sensor = mapped->second;
  return {};
}

Status Boot::Configure(const CanRingBoard& one) {
  CanRingBus& bus = buses_[one.bus];
  const auto heartbeat_ms = static_cast<std::uint16_t>(options_.heartbeat / milliseconds(1));
  // In this order: 1019h may be written only while the node produces no SYNC.
  RETURN_IF_ERROR(bus.Download(one.node, kObjectSyncId, ObjectBytes(static_cast<std::uint32_t>(CobId::kSync)),
                               options_.sdo_timeout, kSdoAttempts));
  RETURN_IF_ERROR(bus.Download(one.node, kObjectSyncCounterOverflow, ObjectBytes(kSyncCounterOverflow),
                               options_.sdo_timeout, kSdoAttempts));
  return bus.Download(one.node, kObjectHeartbeat, ObjectBytes(heartbeat_ms), options_.sdo_timeout, kSdoAttempts);
}

/// Sorted by first sensor, the boards must follow each other from 0 to the ring's last sensor without gap or overlap.
Status Boot::CheckCover() {
  const std::string attempted = "put the ring's boards together";
  std::sort(boards_.begin(), boards_.end(), [](const CanRingBoard& a, const CanRingBoard& b) {
    return std::pair(a.board.first_sensor, a.board.serial) < std::pair(b.board.first_sensor, b.board.serial);
  });
  std::map<std::uint32_t, std::string> places;
  std::uint32_t next = 0;
  for (const CanRingBoard& one : boards_) {
    const auto [place, is_new] = places.emplace(one.board.serial, one.board.port_path);
    if (!is_new) {
      return Fail(attempted,
                  "two boards have the number " + std::to_string(one.board.serial) + ": " + place->second + " and " +
                      one.board.port_path,
                  "give each board its own number");
    }
    if (one.board.first_sensor != next) {
      return Fail(attempted,
                  BoardName(one.board) + " stands where the board of sensor " + std::to_string(next) + " is expected",
                  "connect the missing board, or correct [ring] boards");
    }
    next += one.board.sensor_count;
  }
  if (next == options_.sensor_count) return {};
  return Fail(attempted,
              std::to_string(next) + " sensors in all; the ring has " + std::to_string(options_.sensor_count),
              "connect the missing boards");
}

}  // namespace

Result<std::vector<CanRingBoard>> BootCanBoards(std::vector<CanRingBus>& buses, const CanRangeRingOptions& options,
                                                Clock& clock) {
  Boot boot(buses, options, clock);
  RETURN_IF_ERROR(boot.Reset());
  RETURN_IF_ERROR(boot.AwaitBoot());
  RETURN_IF_ERROR(boot.CheckNodeIds());
  RETURN_IF_ERROR(boot.IdentifyAll());
  RETURN_IF_ERROR(boot.CheckCover());
  return boot.Take();
}

Result<CanRingBoard> BootReferenceBoard(std::vector<CanRingBus>& buses, const CanRangeRingOptions& options,
                                        Clock& clock) {
  CanRangeRingOptions alone = options;
  alone.first_sensors = {{options.reference->serial, kNotInRing}};
  Boot boot(buses, alone, clock);
  RETURN_IF_ERROR(boot.AwaitBeside(static_cast<NodeId>(options.board_count + 1)));
  RETURN_IF_ERROR(boot.IdentifyAll());
  return boot.Take().front();
}

Result<ClockExchange> AskCanClock(CanRingBus& bus, const CanRingBoard& board, std::uint8_t question,
                                  nanoseconds timeout, Clock& clock) {
  ClockExchange exchange;
  exchange.host_before = clock.Now();
  const auto told = ReadNumber<std::uint32_t>(bus, board.node, {kClockIndex, question}, timeout, 1);
  if (!told) return Fail(told);
  // When the answer came, not when it was collected; but an arrival before the question is a false one.
  const nanoseconds arrival = bus.last_reply_time();
  exchange.host_after = arrival > exchange.host_before ? arrival : clock.Now();
  exchange.device_time = bus.nodes().at(board.node).clock.Unwrap(*told, exchange.host_after);
  return exchange;
}

RingLimits LimitsOf(std::vector<CanRingBus>& buses, const std::vector<CanRingBoard>& boards,
                    const std::optional<CanRingBoard>& beside, std::uint16_t sensor_count) {
  RingLimits limits{sensor_count, Hertz(0.0), Hertz(std::numeric_limits<double>::infinity())};
  std::vector<nanoseconds> level_time(buses.size());
  for (const CanRingBoard& one : boards) {
    limits.min_level_rate = std::max(limits.min_level_rate, one.limits.min_level_rate);
    limits.max_level_rate = std::min(limits.max_level_rate, one.limits.max_level_rate);
    level_time[one.bus] += LevelTime(one, buses[one.bus].bus());
  }
  if (beside) level_time[beside->bus] += LevelTime(*beside, buses[beside->bus].bus());
  for (const nanoseconds time : level_time) {
    if (time.count() == 0) continue;
    limits.max_level_rate = std::min(limits.max_level_rate, Hertz(kMostLoad * 1e9 / static_cast<double>(time.count())));
  }
  return limits;
}

}  // namespace annulus
