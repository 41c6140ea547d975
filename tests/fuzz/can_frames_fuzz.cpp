#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/log.h"
#include "firmware_iface/can_ring_bus.h"
#include "firmware_iface/socket_can_codec.h"

namespace {

using annulus::CanFrame;
using annulus::CanReception;
using annulus::CanResult;
using annulus::LevelFrame;
using annulus::NodeId;
using std::chrono::nanoseconds;

constexpr NodeId kNodes = 2;
constexpr nanoseconds kPeriod = std::chrono::milliseconds(33);

void Require(bool condition) {
  if (!condition) std::abort();
}

/// The input, byte by byte; zeros when it is used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  [[nodiscard]] bool empty() const { return at_ >= size_; }
  std::uint8_t Take() { return empty() ? std::uint8_t{0} : data_[at_++]; }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
};

std::uint32_t SerialOf(NodeId node) { return 1000U + node; }

/// A bus whose every reception the input decides: any bytes that a socket could give, and pieces of levels in any
/// order.
class FuzzedBus final : public annulus::CanBus {
 public:
  FuzzedBus(Bytes& bytes, annulus::ManualClock& clock) : bytes_(bytes), clock_(clock) {}

  CanResult<annulus::CanLink> ReadLink() override { return annulus::CanLink{"can0", {}, true, {}, {}, {}, 10}; }
  CanResult<void> Send(const CanFrame& frame) override {
    Require(annulus::IsCanopenFrame(frame));
    if (bytes_.Take() % 8 != 0) return {};
    return tl::unexpected<annulus::CanFailure>({annulus::CanFault::kQueueFull, {}});
  }
  CanResult<std::optional<CanReception>> Receive(nanoseconds deadline) override {
    if (bytes_.empty()) {
      clock_.SleepUntil(deadline);
      return std::optional<CanReception>();
    }
    clock_.SleepUntil(clock_.Now() + std::chrono::microseconds(100));
    auto what = Next();
    if (!what) return std::optional<CanReception>();
    if (const auto* frame = std::get_if<CanFrame>(&*what)) given_.push_back(*frame);
    return std::optional<CanReception>(CanReception{clock_.Now(), std::move(*what)});
  }
  [[nodiscard]] std::uint64_t overflows() const override { return bytes_.empty() ? 1 : 0; }
  CanResult<void> Reopen() override { return {}; }
  CanResult<void> Restart() override { return {}; }

  /// Frames given out so far.
  [[nodiscard]] const std::vector<CanFrame>& given() const { return given_; }

 private:
  using What = std::variant<CanFrame, annulus::CanReport>;

  std::optional<What> Next() {
    const std::uint8_t kind = bytes_.Take();
    switch (kind % 8) {
      case 0:
        return Raw(16, kind);
      case 1:
        return Raw(72, kind);
      case 2:
        return What(annulus::EncodeHeartbeat({static_cast<NodeId>(kind / 8 % 5 + 1), StateOf(bytes_.Take())}));
      case 3: {
        annulus::Emergency emergency;
        emergency.node = static_cast<NodeId>(kind / 8 % 5 + 1);
        emergency.code = static_cast<std::uint16_t>(bytes_.Take() << 8 | bytes_.Take());
        emergency.serial = SerialOf(bytes_.Take() % 4 == 0 ? kNodes + 1 : emergency.node);
        return What(annulus::EncodeEmergency(emergency));
      }
      case 4:
        clock_.SleepUntil(clock_.Now() + kPeriod * (bytes_.Take() % 20));
        return std::nullopt;
      default:
        return LevelPart(kind);
    }
  }
  std::optional<What> Raw(std::size_t size, std::uint8_t kind) {
    std::vector<std::byte> raw(size);
    for (std::size_t i = 0; i < 16; ++i) raw[i] = static_cast<std::byte>(bytes_.Take());
    // Half of them with an identifier of the predefined set, so that they get beyond the first look.
    if (kind >= 128) raw[1] &= std::byte{0x07};
    if (kind >= 128) raw[2] = raw[3] = std::byte{0};
    return annulus::DecodeSocketCan(raw);
  }
  static annulus::NmtState StateOf(std::uint8_t byte) {
    constexpr annulus::NmtState kStates[] = {annulus::NmtState::kBootUp, annulus::NmtState::kStopped,
                                             annulus::NmtState::kOperational, annulus::NmtState::kPreOperational};
    return kStates[byte % 4];
  }
  /// One frame of a level whose sequence goes on from the last one, or back, or far on.
  std::optional<What> LevelPart(std::uint8_t kind) {
    const std::uint8_t choice = bytes_.Take();
    const auto node = static_cast<NodeId>(kind / 8 % kNodes + 1);
    std::uint32_t& sequence = sequences_[node];
    constexpr std::int32_t kSteps[] = {0, 0, 0, 0, 0, 1, 1, 2, 3, 8, 16, 17, -1, -2, 300, 33'000};
    sequence += static_cast<std::uint32_t>(kSteps[choice / 8 % 16]);
    const std::uint32_t serial = choice >= 252 ? SerialOf(kNodes + 1) : SerialOf(node);
    if (encoded_.sequence != sequence || encoded_.board_serial != serial) {
      encoded_ = LevelOf(serial, sequence);
      parts_ = annulus::EncodeCanLevel(1, encoded_);
    }
    if (kind % 8 == 7) return What(annulus::EncodeCanFdLevel(node, encoded_));
    CanFrame part = parts_[choice % 8 % annulus::kCanFramesPerLevel];
    part.id += node - 1U;
    return What(part);
  }
  static LevelFrame LevelOf(std::uint32_t serial, std::uint32_t sequence) {
    LevelFrame level;
    level.board_serial = serial;
    level.sequence = sequence;
    level.device_time = std::chrono::microseconds(sequence * 33'000ULL % 4'000'000'000ULL);
    for (std::size_t i = 0; i < annulus::kSensorsPerBoard; ++i) {
      level.range_um[i] = (sequence * 16 + static_cast<std::uint32_t>(i)) % 30'000 * annulus::kCanRangeStepUm;
      level.quality[i] = static_cast<std::uint8_t>(17 * (sequence % 15 + 1));
    }
    return level;
  }

  Bytes& bytes_;
  annulus::ManualClock& clock_;
  std::array<std::uint32_t, kNodes + 1> sequences_{};
  std::vector<CanFrame> given_;
  LevelFrame encoded_;  ///< The level of which a part was given out last, and its parts for node 1.
  std::array<CanFrame, annulus::kCanFramesPerLevel> parts_{};
};

/// Every part of a level that came out must have gone in, byte for byte; of qualities only those of returns.
void CheckLevel(NodeId node, LevelFrame level, const std::vector<CanFrame>& given) {
  const auto is_given = [&](const CanFrame& part) {
    return std::find(given.begin(), given.end(), part) != given.end();
  };
  Require(level.board_serial == SerialOf(node));
  const auto parts = annulus::EncodeCanLevel(node, level);
  bool classic = true;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    if (part != 3) classic = classic && is_given(parts[part]);
  }
  if (classic) return;
  const CanFrame whole = annulus::EncodeCanFdLevel(node, level);
  Require(std::any_of(given.begin(), given.end(), [&](const CanFrame& frame) {
    return frame.id == whole.id && frame.fd &&
           std::equal(frame.data.begin(), frame.data.begin() + 44, whole.data.begin());
  }));
}

void CheckNodes(annulus::CanRingBus& bus, const FuzzedBus& fuzzed, std::map<NodeId, std::uint32_t>& next) {
  Require(bus.nodes().size() == kNodes);
  for (auto& [id, node] : bus.nodes()) {
    Require(id >= 1 && id <= kNodes);
    Require(node.state >= annulus::CanNodeState::kSilent && node.state <= annulus::CanNodeState::kLost);
    Require(node.serials.size() <= 4);
    for (; node.levels.has_level(); node.levels.Pop()) {
      const LevelFrame& level = node.levels.front().level;
      Require(level.sequence >= next[id]);
      next[id] = level.sequence + 1;
      Require(node.levels.next() > level.sequence);
      CheckLevel(id, level, fuzzed.given());
    }
  }
}

}  // namespace

// Whatever comes over the bus: no crash, no wait beyond the deadline, the table of nodes keeps its shape, and no
// reading comes out that did not go in for the same sensor and level.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  annulus::SetLogLevel(annulus::LogLevel::kError);
  Bytes bytes(data, std::min<std::size_t>(size, 128));
  annulus::ManualClock clock;
  FuzzedBus fuzzed(bytes, clock);
  annulus::CanRingBus bus(fuzzed, kNodes, clock);
  for (NodeId node = 1; node <= kNodes; ++node) {
    bus.nodes().at(node).serial = SerialOf(node);
    bus.nodes().at(node).levels = annulus::CanLevelAssembler(node, SerialOf(node));
    bus.nodes().at(node).levels.Begin(kPeriod);
  }
  std::map<NodeId, std::uint32_t> next;
  for (int call = 0; call < 64 && !bytes.empty(); ++call) {
    const std::uint8_t what = bytes.Take();
    const nanoseconds before = clock.Now();
    const NodeId node = static_cast<NodeId>(what / 16 % kNodes + 1);
    if (what % 16 == 0) {
      const auto read = bus.Upload(node, {0x2004, 1}, std::chrono::milliseconds(2), 1);
      Require(!read || read->size() <= annulus::kMostSdoBytes);
    } else if (what % 16 == 1) {
      static_cast<void>(bus.Download(node, {0x1017, 0}, std::vector<std::byte>(9), std::chrono::milliseconds(2), 1));
    } else if (what % 16 == 2) {
      bus.WatchHeartbeats(std::chrono::milliseconds(300));
    } else if (what % 16 == 3) {
      static_cast<void>(bus.nodes().at(node).levels.GiveUpOldest());
    } else {
      bus.Collect(clock.Now() + std::chrono::microseconds(50 * what));
    }
    Require(clock.Now() - before < std::chrono::seconds(30));
    CheckNodes(bus, fuzzed, next);
  }
  return 0;
}
