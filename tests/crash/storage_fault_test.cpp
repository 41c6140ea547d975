#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "properties.h"

namespace annulus {
namespace {

using test::Subject;
using test::Tally;

bool IsLong() { return std::getenv("ANNULUS_LONG") != nullptr; }
bool IsSoak() { return std::getenv("ANNULUS_SOAK") != nullptr; }

void Expect(const Tally& tally, const std::string& property) {
  std::cout << tally.Line(property) << "\n";
  EXPECT_TRUE(tally.ok()) << tally.first;
}

TEST(StorageFaults, AtEveryCallOfAScanAreFinalAndCostNothingAcknowledged) {
  Expect(FailEveryCall(Subject(), IsSoak() ? 360 : 30), "failing calls");
}

TEST(Damage, D6_AFileCutAtAnyByteGivesBackExactlyWhatIsWhole) {
  Expect(CutTheFile(Subject(), 100, IsLong() ? 1 : 11), "cut file");
}

TEST(Damage, D7_AnyFlippedBitCostsAtMostOneLevelAndChangesNone) {
  Expect(FlipBits(Subject(), IsSoak() ? 100 : 10, IsLong() ? 1 : 7), "flipped bits");
}

TEST(Damage, P4_MissingRepeatedAndExchangedWritesAreTold) {
  Expect(RearrangeWrites(Subject(), 30), "rearranged writes");
}

TEST(Restart, H7_KeepsTheRecordingThatWasInterrupted) {
  Expect(StartAgain(Subject(), IsLong() ? 5'000 : 500), "start after a cut");
}

TEST(Recovery, MakesEveryCrashStateWholeAndIsIdempotent) {
  Expect(Recover(Subject(), IsLong() ? 20'000 : 2'000), "recovery");
}

}  // namespace
}  // namespace annulus
