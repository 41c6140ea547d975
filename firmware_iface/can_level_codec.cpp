#include "firmware_iface/can_level_codec.h"

#include <algorithm>

#include "firmware_iface/little_endian.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using Bytes = std::span<const std::byte>;

// The frames of a level, by identifier. The two beside the four TPDOs of the predefined set use the identifiers of
// receive PDOs, which no board has.
constexpr std::array<std::uint16_t, kCanFramesPerLevel> kPartIds{0x180, 0x200, 0x280, 0x300, 0x380, 0x480};
constexpr std::size_t kHeaderPart = 1;
constexpr std::size_t kQualityPart = 3;
constexpr std::size_t kLastRangePart = 5;
/// Index of the first sensor of each part that carries ranges.
constexpr std::array<std::size_t, kCanFramesPerLevel> kFirstSensor{0, 0, 4, 0, 8, 12};
constexpr std::size_t kRangesPerFrame = 4;
constexpr std::uint8_t kAllParts = (1U << kCanFramesPerLevel) - 1;
constexpr std::uint16_t kNoRange = 0x7FFF;
constexpr std::uint16_t kNoFdRange = 0xFFFF;
constexpr unsigned kQualityStep = 17;

// Offsets in the FD frame.
constexpr std::size_t kFdBytes = 64;
constexpr std::size_t kFdSequenceAt = 4;
constexpr std::size_t kFdStatusAt = 6;
constexpr std::size_t kFdVersionAt = 7;
constexpr std::size_t kFdTimeAt = 8;
constexpr std::size_t kFdTemperatureAt = 12;
constexpr std::size_t kFdRangesAt = 14;
constexpr std::size_t kFdQualitiesAt = kFdRangesAt + 2 * kSensorsPerBoard;
constexpr std::size_t kFdSpareAt = kFdQualitiesAt + kSensorsPerBoard;

/// Levels that wait for a host which collects frames but takes no levels.
constexpr std::size_t kMostWhole = 128;
/// Frames of one level come within this many level periods of each other.
constexpr int kStalePeriods = 8;

std::uint32_t MicrosecondsOf(nanoseconds time) { return static_cast<std::uint32_t>(time.count() / 1000); }

std::uint16_t RangeWord(std::uint32_t range_um, std::uint32_t step_um, std::uint16_t none) {
  if (range_um == kNoReturn) return none;
  const std::uint64_t steps = (std::uint64_t{range_um} + step_um / 2) / step_um;
  return steps < none ? static_cast<std::uint16_t>(steps) : none;
}

std::uint8_t QualityNibble(std::uint8_t quality) {
  if (quality == 0) return 0;
  return static_cast<std::uint8_t>(std::max(1U, (quality + kQualityStep / 2) / kQualityStep));
}

CanFrame RangeFrame(NodeId node, const LevelFrame& level, std::size_t part) {
  std::array<std::byte, 8> bytes{};
  for (std::size_t i = 0; i < kRangesPerFrame; ++i) {
    const std::size_t sensor = kFirstSensor[part] + i;
    std::uint16_t word = 0;
    if (sensor < kSensorsPerBoard) {
      word = RangeWord(level.range_um[sensor], kCanRangeStepUm, kNoRange);
    } else {
      word = static_cast<std::uint16_t>((level.status & 0x7FU) | (level.board_serial & 0xFFU) << 7);
    }
    const auto sequence_bit = static_cast<std::uint16_t>((level.sequence >> i & 1U) << 15);
    PutLittleEndian(std::span<std::byte>(bytes).subspan(2 * i), static_cast<std::uint16_t>(word | sequence_bit));
  }
  return ClassicFrame(kPartIds[part] + std::uint32_t{node}, bytes);
}

CanFrame HeaderFrame(NodeId node, const LevelFrame& level) {
  std::array<std::byte, 8> bytes{};
  const std::span<std::byte> out(bytes);
  PutLittleEndian(out, MicrosecondsOf(level.device_time));
  PutLittleEndian(out.subspan(4), static_cast<std::uint16_t>(level.sequence));
  PutLittleEndian(out.subspan(6), static_cast<std::uint16_t>(level.temperature_centi_c));
  return ClassicFrame(kPartIds[kHeaderPart] + std::uint32_t{node}, bytes);
}

CanFrame QualityFrame(NodeId node, const LevelFrame& level) {
  std::uint64_t nibbles = level.sequence & 0xFU;
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    nibbles |= static_cast<std::uint64_t>(QualityNibble(level.quality[i])) << (4 * (i + 1));
  }
  std::array<std::byte, 8> bytes{};
  PutLittleEndian(std::span<std::byte>(bytes), nibbles);
  return ClassicFrame(kPartIds[kQualityPart] + std::uint32_t{node}, bytes);
}

/// The four low bits of the sequence: one in the highest bit of each word.
std::uint8_t SequenceBitsOf(Bytes ranges) {
  std::uint8_t bits = 0;
  for (std::size_t i = 0; i < kRangesPerFrame; ++i) {
    bits = static_cast<std::uint8_t>(bits | (std::to_integer<unsigned>(ranges[2 * i + 1]) >> 7) << i);
  }
  return bits;
}

std::uint16_t WordAt(Bytes bytes, std::size_t at) { return GetLittleEndian<std::uint16_t>(bytes.subspan(at)); }

void TakeRanges(Bytes bytes, std::size_t part, LevelFrame& level) {
  for (std::size_t i = 0; i < kRangesPerFrame && kFirstSensor[part] + i < kSensorsPerBoard; ++i) {
    const std::uint32_t steps = WordAt(bytes, 2 * i) & 0x7FFFU;
    level.range_um[kFirstSensor[part] + i] = steps == kNoRange ? kNoReturn : steps * kCanRangeStepUm;
  }
  if (part == kLastRangePart) level.status = static_cast<std::uint8_t>(WordAt(bytes, 6) & 0x7FU);
}

void TakeHeader(Bytes bytes, LevelFrame& level) {
  level.device_time = std::chrono::microseconds(GetLittleEndian<std::uint32_t>(bytes));
  level.temperature_centi_c = static_cast<std::int16_t>(WordAt(bytes, 6));
}

void TakeQualities(std::uint64_t nibbles, LevelFrame& level) {
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    level.quality[i] = static_cast<std::uint8_t>((nibbles >> (4 * (i + 1)) & 0xFU) * kQualityStep);
  }
}

/// What no return says of quality: nothing.
void ForgetQualitiesWithoutReturn(LevelFrame& level) {
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    if (level.range_um[i] == kNoReturn) level.quality[i] = 0;
  }
}

std::optional<std::size_t> PartOf(std::uint32_t id) {
  for (std::size_t part = 0; part < kCanFramesPerLevel; ++part) {
    if (id > kPartIds[part] && id <= kPartIds[part] + std::uint32_t{kLastNodeId}) return part;
  }
  return std::nullopt;
}

}  // namespace

std::array<CanFrame, kCanFramesPerLevel> EncodeCanLevel(NodeId node, const LevelFrame& level) {
  std::array<CanFrame, kCanFramesPerLevel> frames;
  for (std::size_t part = 0; part < kCanFramesPerLevel; ++part) frames[part] = RangeFrame(node, level, part);
  frames[kHeaderPart] = HeaderFrame(node, level);
  frames[kQualityPart] = QualityFrame(node, level);
  return frames;
}

CanFrame EncodeCanFdLevel(NodeId node, const LevelFrame& level) {
  CanFrame frame;
  frame.id = kPartIds[0] + std::uint32_t{node};
  frame.fd = true;
  frame.bit_rate_switch = true;
  frame.size = kFdBytes;
  const std::span<std::byte> out(frame.data);
  PutLittleEndian(out, level.board_serial);
  PutLittleEndian(out.subspan(kFdSequenceAt), static_cast<std::uint16_t>(level.sequence));
  frame.data[kFdStatusAt] = std::byte{level.status};
  frame.data[kFdVersionAt] = static_cast<std::byte>(kCanLevelVersion);
  PutLittleEndian(out.subspan(kFdTimeAt), MicrosecondsOf(level.device_time));
  PutLittleEndian(out.subspan(kFdTemperatureAt), static_cast<std::uint16_t>(level.temperature_centi_c));
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    PutLittleEndian(out.subspan(kFdRangesAt + 2 * i), RangeWord(level.range_um[i], kCanFdRangeStepUm, kNoFdRange));
    frame.data[kFdQualitiesAt + i] = std::byte{level.quality[i]};
  }
  return frame;
}

std::optional<NodeId> LevelNodeOf(const CanFrame& frame) {
  if (!IsCanopenFrame(frame)) return std::nullopt;
  const auto part = PartOf(frame.id);
  if (!part) return std::nullopt;
  return static_cast<NodeId>(frame.id - kPartIds[*part]);
}

void CanLevelAssembler::Begin(nanoseconds level_period) {
  const NodeId node = node_;
  const std::uint32_t serial = serial_;
  *this = CanLevelAssembler(node, serial);
  level_period_ = level_period;
  running_ = true;
}

void CanLevelAssembler::Push(const CanFrame& frame, nanoseconds host_time) {
  if (!running_ || LevelNodeOf(frame) != node_) return;
  const std::size_t part = *PartOf(frame.id);
  if (frame.fd && part == 0 && frame.size == kFdBytes) {
    PushFd(frame, host_time);
  } else if (!frame.fd && frame.size == 8) {
    PushClassic(frame, part, host_time);
  } else {
    ++rejected_;
  }
  Release();
}

void CanLevelAssembler::PushClassic(const CanFrame& frame, std::size_t part, nanoseconds host_time) {
  const Bytes bytes = Bytes(frame.data).first(8);
  const std::uint64_t nibbles = GetLittleEndian<std::uint64_t>(bytes);
  if (part == kLastRangePart && (WordAt(bytes, 6) >> 7 & 0xFFU) != (serial_ & 0xFFU)) {
    foreign_serial_ = true;
    return;
  }
  std::optional<std::uint32_t> sequence;
  if (part == kHeaderPart) {
    sequence = SequenceOfWord(WordAt(bytes, 4));
  } else {
    sequence =
        SequenceOfLowBits(part == kQualityPart ? static_cast<std::uint8_t>(nibbles & 0xFU) : SequenceBitsOf(bytes));
  }
  Slot* slot = sequence ? SlotFor(*sequence, static_cast<std::uint8_t>(1U << part), host_time) : nullptr;
  if (slot == nullptr) {
    ++duplicates_;
    return;
  }
  if (part == kHeaderPart) {
    TakeHeader(bytes, slot->level);
  } else if (part == kQualityPart) {
    TakeQualities(nibbles, slot->level);
  } else {
    TakeRanges(bytes, part, slot->level);
  }
}

void CanLevelAssembler::PushFd(const CanFrame& frame, nanoseconds host_time) {
  const Bytes bytes(frame.data);
  const bool spare_is_zero =
      std::all_of(frame.data.begin() + kFdSpareAt, frame.data.end(), [](std::byte b) { return b == std::byte{0}; });
  if (std::to_integer<unsigned>(bytes[kFdVersionAt]) != kCanLevelVersion || !spare_is_zero) {
    ++rejected_;
    return;
  }
  if (GetLittleEndian<std::uint32_t>(bytes) != serial_) {
    foreign_serial_ = true;
    return;
  }
  const auto sequence = SequenceOfWord(WordAt(bytes, kFdSequenceAt));
  Slot* slot = sequence ? SlotFor(*sequence, kAllParts, host_time) : nullptr;
  if (slot == nullptr) {
    ++duplicates_;
    return;
  }
  slot->level.status = std::to_integer<std::uint8_t>(bytes[kFdStatusAt]);
  slot->level.device_time = std::chrono::microseconds(GetLittleEndian<std::uint32_t>(bytes.subspan(kFdTimeAt)));
  slot->level.temperature_centi_c = static_cast<std::int16_t>(WordAt(bytes, kFdTemperatureAt));
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    const std::uint32_t steps = WordAt(bytes, kFdRangesAt + 2 * i);
    slot->level.range_um[i] = steps == kNoFdRange ? kNoReturn : steps * kCanFdRangeStepUm;
    slot->level.quality[i] = std::to_integer<std::uint8_t>(bytes[kFdQualitiesAt + i]);
  }
}

std::optional<std::uint32_t> CanLevelAssembler::SequenceOfLowBits(std::uint8_t low_bits) const {
  const std::uint32_t ahead = (low_bits - next_) & 0xFU;
  if (ahead >= kWindow) return std::nullopt;
  return next_ + ahead;
}

std::optional<std::uint32_t> CanLevelAssembler::SequenceOfWord(std::uint16_t word) {
  const auto ahead = static_cast<std::int16_t>(static_cast<std::uint16_t>(word - next_));
  if (ahead < 0) return std::nullopt;
  const std::uint32_t sequence = next_ + static_cast<std::uint32_t>(ahead);
  // Beyond the window nothing that is under way can be of this level, though its low bits may say so.
  if (ahead >= static_cast<int>(kWindow)) {
    for (Slot& slot : slots_) slot = {};
    next_ = sequence;
  }
  return sequence;
}

/// Where a frame belongs; nothing if the level has it already. `part_bit` may be all parts at once.
CanLevelAssembler::Slot* CanLevelAssembler::SlotFor(std::uint32_t sequence, std::uint8_t part_bit,
                                                    nanoseconds host_time) {
  Slot& slot = slots_[sequence % kWindow];
  // What is left of a level sixteen before must not be taken for a part of this one.
  if (slot.have != 0 && host_time - slot.first > kStalePeriods * level_period_) slot = {};
  if ((slot.have & part_bit) != 0) return nullptr;
  if (slot.have == 0) {
    slot.first = host_time;
    slot.level.board_serial = serial_;
    slot.level.sequence = sequence;
  }
  slot.have = static_cast<std::uint8_t>(slot.have | part_bit);
  ++slot.frames;
  slot.last = std::max(slot.last, host_time);
  return &slot;
}

std::size_t CanLevelAssembler::LaterFrames() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < kWindow; ++i) {
    if (i == next_ % kWindow) continue;
    count += slots_[i].frames;
  }
  return count;
}

void CanLevelAssembler::Advance() {
  slots_[next_ % kWindow] = {};
  ++next_;
}

void CanLevelAssembler::Release() {
  while (true) {
    Slot& slot = slots_[next_ % kWindow];
    if (slot.have == kAllParts) {
      ForgetQualitiesWithoutReturn(slot.level);
      if (whole_.size() < kMostWhole) whole_.push_back({slot.level, slot.last});
    } else if (LaterFrames() <= kCanReorderFrames) {
      return;
    }
    Advance();
  }
}

bool CanLevelAssembler::GiveUpOldest() {
  if (!running_ || (slots_[next_ % kWindow].have == 0 && LaterFrames() == 0)) return false;
  Advance();
  Release();
  return true;
}

nanoseconds WrappedClock::Unwrap(std::uint32_t device_us, nanoseconds host_time) {
  if (!known_) {
    known_ = true;
    last_us_ = device_us;
  } else {
    const std::int64_t expected = last_us_ + (host_time - last_host_).count() / 1000;
    const auto off = static_cast<std::int32_t>(device_us - static_cast<std::uint32_t>(expected));
    last_us_ = expected + off;
  }
  last_host_ = host_time;
  return std::chrono::microseconds(last_us_);
}

}  // namespace annulus
