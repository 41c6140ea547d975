#include "modeling/wrinkly/shuffle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace annulus {
namespace {

/// A smallest interval as its base interval and source digits.
struct Piece {
  int interval = 0;
  std::vector<int> digits;
  bool operator==(const Piece&) const = default;
};

/// DESIGN.md §5 word by word: pattern_0(s) = A_s; pattern_k(s) is, for p = 0 … 2M, the p-th part of every small
/// interval of pattern_{k−1}(s + p − M). On an endless axis, so intervals are plain numbers.
std::vector<Piece> Pattern(int s, const std::vector<int>& crossings, std::size_t k) {
  if (k == 0) return {{s, {}}};
  std::vector<Piece> pattern;
  const int m = crossings[k - 1];
  for (int p = 0; p <= 2 * m; ++p) {
    for (Piece piece : Pattern(s + p - m, crossings, k - 1)) {
      piece.digits.push_back(p);
      pattern.push_back(std::move(piece));
    }
  }
  return pattern;
}

Shuffle MakeShuffle(int m, int k) { return Shuffle::Make(m, k).value(); }

TEST(Shuffle, AgreesWithTheConstructionStepByStep) {
  for (const auto& crossings :
       std::vector<std::vector<int>>{{}, {0}, {1}, {1, 1}, {1, 1, 1, 1}, {2, 2, 2}, {3, 3}, {1, 2}, {2, 0, 1}}) {
    const Shuffle shuffle = Shuffle::Make(crossings).value();
    const std::vector<Piece> pattern = Pattern(0, crossings, crossings.size());
    ASSERT_EQ(pattern.size(), shuffle.parts());
    for (std::uint32_t code = 0; code < shuffle.parts(); ++code) {
      const Shuffle::Move move = shuffle.Source(code);
      EXPECT_EQ(move.shift, pattern[code].interval);
      EXPECT_EQ(shuffle.SourceDigits(move.code), pattern[code].digits);
      const Shuffle::Move back = shuffle.Destination(move.code);
      EXPECT_EQ(back.code, code);
      EXPECT_EQ(back.shift, -move.shift);
    }
  }
}

TEST(Shuffle, DealsTheFirstLevelsOfFigureOne) {
  // M = 1: after one iteration block s holds the first third of s − 1, the middle of s, the last of s + 1.
  const Shuffle once = MakeShuffle(1, 1);
  EXPECT_EQ(once.Source(0).shift, -1);
  EXPECT_EQ(once.Source(1).shift, 0);
  EXPECT_EQ(once.Source(2).shift, 1);
  // After two, block 5's leading digits are 3 4 5 | 4 5 6 | 5 6 7: each part those of the part before plus one.
  const Shuffle twice = MakeShuffle(1, 2);
  std::vector<int> leading;
  for (std::uint32_t code = 0; code < 9; ++code) leading.push_back(5 + twice.Source(code).shift);
  EXPECT_EQ(leading, (std::vector<int>{3, 4, 5, 4, 5, 6, 5, 6, 7}));
}

struct AxisCase {
  int m, k, count;
  AxisKind kind;
};

std::vector<AxisCase> SmallCases() {
  std::vector<AxisCase> cases;
  for (const AxisKind kind : {AxisKind::kOpen, AxisKind::kCyclic}) {
    for (const int m : {0, 1, 2, 3}) {
      for (int k = 0; k <= 6; ++k) {
        for (const int count : {1, 2, 3, 8, 11}) cases.push_back({m, k, count, kind});
      }
    }
  }
  return cases;
}

TEST(Shuffle, IsOneToOneOnEveryAxisUpToThreeCrossingsAndSixIterations) {
  for (const AxisCase& axis : SmallCases()) {
    const Shuffle shuffle = MakeShuffle(axis.m, axis.k);
    std::vector<char> taken(static_cast<std::size_t>(axis.count) * shuffle.parts(), 0);
    for (int interval = 0; interval < axis.count; ++interval) {
      for (std::uint32_t code = 0; code < shuffle.parts(); ++code) {
        const AxisPart source = SourcePart(shuffle, {interval, code}, axis.count, axis.kind);
        const std::size_t at = static_cast<std::size_t>(source.interval) * shuffle.parts() + source.code;
        ASSERT_FALSE(taken[at]) << axis.m << ' ' << axis.k << ' ' << axis.count;
        taken[at] = 1;
        const AxisPart back = DestinationPart(shuffle, {source.interval, source.code}, axis.count, axis.kind);
        ASSERT_EQ(back.interval, interval);
        ASSERT_EQ(back.code, code);
        ASSERT_EQ(back.mirrored, source.mirrored);
      }
    }
  }
}

TEST(Shuffle, DrawsFromAtMostMTimesKIntervals) {
  for (const int m : {1, 2, 3}) {
    for (const int k : {1, 2, 3, 4}) {
      const Shuffle shuffle = MakeShuffle(m, k);
      int low = 0;
      int high = 0;
      for (std::uint32_t code = 0; code < shuffle.parts(); ++code) {
        low = std::min(low, shuffle.Source(code).shift);
        high = std::max(high, shuffle.Source(code).shift);
      }
      EXPECT_EQ(low, -m * k);
      EXPECT_EQ(high, m * k);
      EXPECT_EQ(shuffle.reach(), m * k);
    }
  }
}

TEST(Shuffle, LeadingIndicesGrowByOneFromPartToPartInEveryAlignedRange) {
  for (const int m : {1, 2, 3}) {
    const int k = 3;
    const Shuffle shuffle = MakeShuffle(m, k);
    const auto radix = static_cast<std::uint32_t>(2 * m + 1);
    // Blocks far from any end: interval numbers are those of the endless axis.
    std::vector<int> leading;
    for (int s = 0; s < static_cast<int>(radix); ++s) {
      for (std::uint32_t code = 0; code < shuffle.parts(); ++code)
        leading.push_back(100 + s + shuffle.Source(code).shift);
    }
    // Aligned ranges: all the blocks, one block, one of its parts …
    for (std::size_t length = leading.size(); length >= radix; length /= radix) {
      const std::size_t part = length / radix;
      for (std::size_t start = 0; start < leading.size(); start += length) {
        for (std::size_t at = start; at + part < start + length; ++at) ASSERT_EQ(leading[at + part], leading[at] + 1);
      }
    }
  }
}

TEST(Shuffle, CommutesWithMirroringAndTranslation) {
  for (const int m : {1, 2, 3}) {
    const Shuffle shuffle = MakeShuffle(m, 4);
    for (std::uint32_t code = 0; code < shuffle.parts(); ++code) {
      const Shuffle::Move move = shuffle.Source(code);
      const Shuffle::Move mirrored = shuffle.Source(shuffle.parts() - 1 - code);
      EXPECT_EQ(mirrored.code, shuffle.parts() - 1 - move.code);
      EXPECT_EQ(mirrored.shift, -move.shift);
    }
    // On a ring of 7, turning by 3 before or after is the same.
    for (int s = 0; s < 7; ++s) {
      for (std::uint32_t code = 0; code < shuffle.parts(); ++code) {
        const AxisPart here = SourcePart(shuffle, {s, code}, 7, AxisKind::kCyclic);
        const AxisPart there = SourcePart(shuffle, {(s + 3) % 7, code}, 7, AxisKind::kCyclic);
        ASSERT_EQ(there.interval, (here.interval + 3) % 7);
        ASSERT_EQ(there.code, here.code);
      }
    }
  }
}

TEST(Shuffle, OpenAxesFoldByReflection) {
  // Of 3 intervals, −1 is 0 seen in the mirror, −3 is 2, 3 is 2, 5 is 0, 6 is 0 again unmirrored.
  const auto at = [](std::int64_t index) { return Fold(index, 3, AxisKind::kOpen); };
  EXPECT_EQ(at(-1).index, 0);
  EXPECT_TRUE(at(-1).mirrored);
  EXPECT_EQ(at(-3).index, 2);
  EXPECT_TRUE(at(3).mirrored);
  EXPECT_EQ(at(3).index, 2);
  EXPECT_EQ(at(5).index, 0);
  EXPECT_FALSE(at(6).mirrored);
  EXPECT_EQ(at(6).index, 0);
  EXPECT_EQ(Fold(-1, 3, AxisKind::kCyclic).index, 2);
  EXPECT_FALSE(Fold(-1, 3, AxisKind::kCyclic).mirrored);
}

TEST(Shuffle, WithoutIterationsOrCrossingsMovesNothing) {
  for (const Shuffle& shuffle : {MakeShuffle(3, 0), MakeShuffle(0, 64)}) {
    EXPECT_EQ(shuffle.parts(), 1U);
    EXPECT_EQ(shuffle.Source(0).shift, 0);
    EXPECT_EQ(shuffle.Source(0).code, 0U);
  }
}

TEST(Shuffle, LongCodesWithoutATableAreTheSame) {
  const Shuffle deep = MakeShuffle(1, 19);  // 3^19 parts
  for (std::uint32_t code = 7; code < deep.parts() - 99'999'999U; code += 99'999'989U) {
    const Shuffle::Move move = deep.Source(code);
    EXPECT_EQ(deep.Destination(move.code).code, code);
    std::vector<int> digits = deep.DestinationDigits(code);
    int shift = 0;
    for (const int digit : digits) shift += digit - 1;
    EXPECT_EQ(move.shift, shift);
    std::reverse(digits.begin(), digits.end());
    EXPECT_EQ(deep.SourceDigits(move.code), digits);
  }
}

TEST(Shuffle, RefusesWhatItCannotHold) {
  EXPECT_FALSE(Shuffle::Make(-1, 2));
  EXPECT_FALSE(Shuffle::Make(1001, 2));
  EXPECT_FALSE(Shuffle::Make(1, -1));
  EXPECT_FALSE(Shuffle::Make(1, 20));
  EXPECT_FALSE(Shuffle::Make(0, 1'000'000'000));
  EXPECT_NE(Shuffle::Make(3, 40).error().Text().find("fewer iterations"), std::string::npos);
}

}  // namespace
}  // namespace annulus
