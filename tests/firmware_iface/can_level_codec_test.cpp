#include "firmware_iface/can_level_codec.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "tests/firmware_iface/can_frame_text.h"

namespace annulus {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr NodeId kNode = 8;
constexpr nanoseconds kPeriod = milliseconds(33);

// docs/wire_protocol.md, "Golden vectors": board 1008, node 8. Made with Python, not with this code:
//   words = [0x7FFF if r is None else round(r / 40) for r in ranges] + [status | (serial & 0xFF) << 7]
//   for p in range(4):
//       struct.pack('<4H', *[words[4 * p + k] | (seq >> k & 1) << 15 for k in range(4)])
//   header = struct.pack('<IHh', time_ns // 1000 % 2**32, seq, 2315)
//   n = [seq & 15] + [0 if q == 0 else max(1, (q + 8) // 17) for q in qualities]
//   quality = bytes(n[2 * i] | n[2 * i + 1] << 4 for i in range(8))
//   fd = struct.pack('<IHBBIh', serial, seq, status, 1, time_ns // 1000 % 2**32, 2315)
//        + struct.pack('<15H', *[0xFFFF if r is None else round(r / 20) for r in ranges]) + bytes(qualities) + bytes(5)
// seq 513, time_ns 1234567890123, ranges 450000 + 1000 i um with none at 3, qualities 255 - i with 0 at 3.
const std::vector<std::string> kGoldenFrames = {"188#F2AB0B2C242CFF7F", "208#D202964901020B09", "288#56AC6F2C882CA12C",
                                                "308#F1FFF0FFFFEEEEEE", "388#BAACD32CEC2C052D", "488#1EAD372D502D0078"};
const std::string kGoldenFdFrame =
    "188##"
    "F003000001020001D20296490B09E45716584858FFFFAC58DE58105942597459A659D8590A5A3C5A6E5AA05AFFFEFD00FBFAF9F8F7F6F5"
    "F4F3F2F10000000000";

LevelFrame GoldenLevel() {
  LevelFrame level;
  level.board_serial = 1008;
  level.sequence = 513;
  level.device_time = nanoseconds(1'234'567'890'123);
  level.temperature_centi_c = 2315;
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    level.range_um[i] = static_cast<std::uint32_t>(450'000 + 1000 * i);
    level.quality[i] = static_cast<std::uint8_t>(255 - i);
  }
  level.range_um[3] = kNoReturn;
  level.quality[3] = 0;
  return level;
}

/// A level with content of its own, such that classic frames carry it without rounding.
LevelFrame Level(std::uint32_t sequence) {
  std::mt19937_64 random(sequence);
  LevelFrame level;
  level.board_serial = 1008;
  level.sequence = sequence;
  level.device_time = microseconds(33'000 * sequence);
  level.status = 0;
  level.temperature_centi_c = static_cast<std::int16_t>(2000 + sequence % 1000);
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    level.range_um[i] =
        random() % 10 == 0 ? kNoReturn : static_cast<std::uint32_t>(random() % 0x7FFF) * kCanRangeStepUm;
    level.quality[i] =
        level.range_um[i] == kNoReturn ? std::uint8_t{0} : static_cast<std::uint8_t>(17 * (random() % 15 + 1));
  }
  return level;
}

/// Feeds frames at times and takes what comes out.
class Assembly {
 public:
  Assembly() { assembler.Begin(kPeriod); }
  void Push(const CanFrame& frame, nanoseconds time) {
    assembler.Push(frame, time);
    Take();
  }
  void PushLevel(std::uint32_t sequence) {
    for (const CanFrame& frame : EncodeCanLevel(kNode, Level(sequence))) Push(frame, TimeOf(sequence));
  }
  static nanoseconds TimeOf(std::uint32_t sequence) { return kPeriod * sequence; }
  void Take() {
    for (; assembler.has_level(); assembler.Pop()) levels.push_back(assembler.front().level);
  }
  CanLevelAssembler assembler{kNode, 1008};
  std::vector<LevelFrame> levels;
};

TEST(CanLevelCodec, WritesTheGoldenFrames) {
  const auto frames = EncodeCanLevel(kNode, GoldenLevel());
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(TextOf(frames[i]), kGoldenFrames[i]);
  EXPECT_EQ(TextOf(EncodeCanFdLevel(kNode, GoldenLevel())), kGoldenFdFrame);
}

TEST(CanLevelCodec, ReadsTheGoldenFramesOfBothKinds) {
  for (const bool fd : {false, true}) {
    CanLevelAssembler assembler(kNode, 1008);
    assembler.Begin(kPeriod);
    if (fd) {
      assembler.Push(FrameOf(kGoldenFdFrame), nanoseconds(5));
    } else {
      // The header first: it alone tells that 512 levels are missing.
      for (const std::size_t i : {1U, 0U, 2U, 3U, 4U, 5U}) assembler.Push(FrameOf(kGoldenFrames[i]), nanoseconds(5));
    }
    ASSERT_TRUE(assembler.has_level());
    LevelFrame expected = GoldenLevel();
    expected.device_time = microseconds(1'234'567'890);
    for (std::size_t i = 0; i < kSensorsPerBoard && !fd; ++i) {
      if (i != 3) expected.quality[i] = i < 9 ? 255 : 238;
    }
    EXPECT_EQ(assembler.front().level, expected);
    EXPECT_EQ(assembler.front().host_arrival, nanoseconds(5));
  }
}

TEST(CanLevelCodec, SendsRangesBeyondItsReachAsNoReturnAndRoundsTheOthers) {
  LevelFrame level = GoldenLevel();
  level.sequence = 0;
  level.range_um = {0, 19, 20, 59, kMostCanRangeUm, kMostCanRangeUm + 20, kMostCanRangeUm + 19, 4'000'000'000U};
  CanLevelAssembler assembler(kNode, 1008);
  assembler.Begin(kPeriod);
  for (const CanFrame& frame : EncodeCanLevel(kNode, level)) assembler.Push(frame, nanoseconds(0));
  ASSERT_TRUE(assembler.has_level());
  const auto& range = assembler.front().level.range_um;
  EXPECT_EQ(std::vector<std::uint32_t>(range.begin(), range.begin() + 8),
            (std::vector<std::uint32_t>{0, 0, 40, 40, kMostCanRangeUm, kNoReturn, kMostCanRangeUm, kNoReturn}));
  EXPECT_GE(kMostCanRangeUm, 1'200'000U);
}

TEST(CanLevelCodec, KeepsAWeakReturnsQualityAboveNone) {
  LevelFrame level = GoldenLevel();
  level.sequence = 0;
  level.quality.fill(1);
  Assembly assembly;
  for (const CanFrame& frame : EncodeCanLevel(kNode, level)) assembly.Push(frame, nanoseconds(0));
  ASSERT_EQ(assembly.levels.size(), 1U);
  EXPECT_EQ(assembly.levels[0].quality[0], 17);
  EXPECT_EQ(assembly.levels[0].quality[3], 0);
}

TEST(CanLevelAssembler, GivesLevelsInOrderOverManyWrapsOfTheSequence) {
  Assembly assembly;
  for (std::uint32_t sequence = 0; sequence < 140'000; ++sequence) {
    assembly.PushLevel(sequence);
    ASSERT_EQ(assembly.levels.size(), 1U);
    ASSERT_EQ(assembly.levels[0].sequence, sequence);
    assembly.levels.clear();
  }
  EXPECT_EQ(assembly.assembler.duplicates(), 0U);
}

TEST(CanLevelAssembler, ToleratesFramesThatComeUpToFourFramesLate) {
  std::mt19937_64 random(7);
  for (int run = 0; run < 200; ++run) {
    std::vector<std::pair<CanFrame, std::uint32_t>> stream;
    for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
      for (const CanFrame& frame : EncodeCanLevel(kNode, Level(sequence))) stream.emplace_back(frame, sequence);
    }
    // Every fifth frame at most, so that none is passed by more than four.
    for (std::size_t i = 0; i + 5 < stream.size(); i += 5) {
      const std::size_t late = random() % 5;
      std::rotate(stream.begin() + static_cast<std::ptrdiff_t>(i), stream.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                  stream.begin() + static_cast<std::ptrdiff_t>(i + late) + 1);
    }
    Assembly assembly;
    for (const auto& [frame, sequence] : stream) assembly.Push(frame, Assembly::TimeOf(sequence));
    ASSERT_EQ(assembly.levels.size(), 20U) << "run " << run;
    for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
      EXPECT_EQ(assembly.levels[sequence], Level(sequence));
    }
  }
}

TEST(CanLevelAssembler, LosesALevelWithItsFrameAndNoOther) {
  for (std::size_t lost = 0; lost < kCanFramesPerLevel; ++lost) {
    Assembly assembly;
    assembly.PushLevel(0);
    const auto torn = EncodeCanLevel(kNode, Level(1));
    for (std::size_t part = 0; part < torn.size(); ++part) {
      if (part != lost) assembly.Push(torn[part], Assembly::TimeOf(1));
    }
    assembly.PushLevel(2);
    ASSERT_EQ(assembly.levels.size(), 2U) << "lost " << lost;
    EXPECT_EQ(assembly.levels[1], Level(2));
    EXPECT_EQ(assembly.assembler.next(), 3U);
  }
}

TEST(CanLevelAssembler, FindsItsPlaceAgainAfterAGapOfAnyLength) {
  for (const std::uint32_t gap : {1U, 2U, 7U, 8U, 9U, 15U, 16U, 17U, 31U, 32U, 48U, 1000U, 32'000U}) {
    Assembly assembly;
    assembly.PushLevel(0);
    // The last level before the gap is torn in two, so that the first after it could complete it.
    const auto before = EncodeCanLevel(kNode, Level(1));
    for (std::size_t part = 0; part < 3; ++part) assembly.Push(before[part], Assembly::TimeOf(1));
    const auto after = EncodeCanLevel(kNode, Level(1 + gap));
    for (std::size_t part = 3; part < 6; ++part) assembly.Push(after[part], Assembly::TimeOf(1 + gap));
    for (std::uint32_t i = 2; i < 6; ++i) assembly.PushLevel(gap + i);
    ASSERT_GE(assembly.levels.size(), 4U) << "gap " << gap;
    for (const LevelFrame& level : assembly.levels) EXPECT_EQ(level, Level(level.sequence)) << "gap " << gap;
    EXPECT_EQ(assembly.levels.back().sequence, gap + 5);
  }
}

TEST(CanLevelAssembler, DropsRepeatedFramesAndCountsThem) {
  Assembly assembly;
  for (std::uint32_t sequence = 0; sequence < 10; ++sequence) {
    for (const CanFrame& frame : EncodeCanLevel(kNode, Level(sequence))) {
      assembly.Push(frame, Assembly::TimeOf(sequence));
      assembly.Push(frame, Assembly::TimeOf(sequence));
    }
  }
  EXPECT_EQ(assembly.levels.size(), 10U);
  EXPECT_EQ(assembly.assembler.duplicates(), 60U);
}

TEST(CanLevelAssembler, NoticesFramesOfAnotherBoardUnderItsNodeId) {
  for (const bool fd : {false, true}) {
    Assembly assembly;
    LevelFrame foreign = Level(0);
    foreign.board_serial = 2222;
    if (fd) assembly.Push(EncodeCanFdLevel(kNode, foreign), nanoseconds(0));
    for (const CanFrame& frame : EncodeCanLevel(kNode, foreign)) {
      if (!fd) assembly.Push(frame, nanoseconds(0));
    }
    EXPECT_TRUE(assembly.assembler.foreign_serial());
    EXPECT_TRUE(assembly.levels.empty());
  }
}

TEST(CanLevelAssembler, IgnoresFramesOfOtherNodesAndShapesAndAllBeforeItBegins) {
  CanLevelAssembler assembler(kNode, 1008);
  for (const CanFrame& frame : EncodeCanLevel(kNode, Level(0))) assembler.Push(frame, nanoseconds(0));
  EXPECT_FALSE(assembler.has_level());
  assembler.Begin(kPeriod);
  for (const CanFrame& frame : EncodeCanLevel(9, Level(0))) assembler.Push(frame, nanoseconds(0));
  CanFrame odd = EncodeCanLevel(kNode, Level(0))[0];
  odd.size = 7;
  assembler.Push(odd, nanoseconds(0));
  EXPECT_FALSE(assembler.has_level());
  EXPECT_EQ(assembler.next(), 0U);
  EXPECT_EQ(assembler.rejected(), 1U);
}

TEST(WrappedClock, CountsOnAfterEach71Minutes) {
  WrappedClock clock;
  const std::uint32_t start = 0xFFFFFF00U;
  EXPECT_EQ(clock.Unwrap(start, nanoseconds(0)), microseconds(start));
  EXPECT_EQ(clock.Unwrap(0x100, microseconds(0x200)), microseconds(std::int64_t{1} << 32 | 0x100));
  // Two wraps without a word of the board, told apart by the host's clock.
  const std::int64_t later = (std::int64_t{3} << 32) + 5;
  EXPECT_EQ(clock.Unwrap(5, microseconds(later - start + 30'000)), microseconds(later));
  // A stamp from a little before the last one.
  EXPECT_EQ(clock.Unwrap(2, microseconds(later - start + 30'010)), microseconds(later - 3));
}

}  // namespace
}  // namespace annulus
