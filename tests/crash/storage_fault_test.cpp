#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "properties.h"

namespace annulus {
namespace {

using test::Sealing;
using test::Subject;
using test::Tally;

bool IsLong() { return std::getenv("ANNULUS_LONG") != nullptr; }
bool IsSoak() { return std::getenv("ANNULUS_SOAK") != nullptr; }

/// Plain and sealed recordings have the same properties.
class Damaged : public testing::TestWithParam<Sealing> {
 protected:
  static Subject Program() {
    Subject subject;
    subject.sealing = GetParam();
    return subject;
  }
  static void Expect(const Tally& tally, const std::string& property) {
    std::cout << tally.Line(property + (GetParam() == Sealing::kSealed ? ", sealed" : "")) << "\n";
    EXPECT_TRUE(tally.ok()) << tally.first;
  }
};
INSTANTIATE_TEST_SUITE_P(Recording, Damaged, testing::Values(Sealing::kPlain, Sealing::kSealed),
                         [](const auto& test) { return test.param == Sealing::kSealed ? "sealed" : "plain"; });

TEST_P(Damaged, D1_D2_D3_D5_AFailureOfAnyCallIsFinalAndCostsNothingAcknowledged) {
  Expect(FailEveryCall(Program(), IsSoak() ? 360 : 30), "failing calls");
}

TEST_P(Damaged, D6_CutAtAnyByteGivesBackExactlyWhatIsWhole) {
  Expect(CutTheFile(Program(), 100, IsLong() ? 1 : 37), "cut file");
}

TEST_P(Damaged, D7_AnyFlippedBitCostsAtMostOneLevelAndChangesNone) {
  Expect(FlipBits(Program(), IsSoak() ? 100 : 10, IsLong() ? 1 : 13), "flipped bits");
}

TEST_P(Damaged, P4_MissingRepeatedAndExchangedWritesAreTold) {
  Expect(RearrangeWrites(Program(), IsLong() ? 30 : 12), "rearranged writes");
}

TEST_P(Damaged, H7_TheRecordingThatWasInterruptedOutlivesTheNextOne) {
  Expect(StartAgain(Program(), IsLong() ? 5'000 : 500), "start after a cut");
}

TEST_P(Damaged, RecoveredIsWholeAndRecoveringItAgainChangesNothing) {
  Expect(Recover(Program(), IsLong() ? 10'000 : 500), "recovery");
}

}  // namespace
}  // namespace annulus
