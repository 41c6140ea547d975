#include <gtest/gtest.h>

#include <iostream>

#include "effort.h"
#include "properties.h"

namespace annulus {
namespace {

using test::ByEffort;
using test::Sealing;
using test::Subject;
using test::Tally;

/// Plain and sealed recordings have the same properties.
class Damaged : public testing::TestWithParam<Sealing> {
 protected:
  static Subject Program() {
    Subject subject;
    subject.sealing = GetParam();
    return subject;
  }
  /// Every byte and bit of a plain recording; a sealed one is opened by the same reader.
  static std::uint64_t Dense() { return GetParam() == Sealing::kPlain ? 1 : 7; }
  static void Expect(const Tally& tally, const std::string& property) {
    std::cout << tally.Line(property + (GetParam() == Sealing::kSealed ? ", sealed" : "")) << "\n";
    EXPECT_TRUE(tally.ok()) << tally.first;
  }
};
INSTANTIATE_TEST_SUITE_P(Recording, Damaged, testing::Values(Sealing::kPlain, Sealing::kSealed),
                         [](const auto& test) { return test.param == Sealing::kSealed ? "sealed" : "plain"; });

TEST_P(Damaged, D1_D2_D3_D5_AFailureOfAnyCallIsFinalAndCostsNothingAcknowledged) {
  Expect(FailEveryCall(Program(), static_cast<std::uint32_t>(ByEffort({12, 30, 30, 360}))), "failing calls");
}

TEST_P(Damaged, D6_CutAtAnyByteGivesBackExactlyWhatIsWhole) {
  Expect(CutTheFile(Program(), 100, ByEffort({997, 97, Dense(), 1})), "cut file");
}

TEST_P(Damaged, D7_AnyFlippedBitCostsAtMostOneLevelAndChangesNone) {
  Expect(FlipBits(Program(), static_cast<std::uint32_t>(ByEffort({6, 10, 10, 100})), ByEffort({211, 29, Dense(), 3})),
         "flipped bits");
}

TEST_P(Damaged, P4_MissingRepeatedAndExchangedWritesAreTold) {
  Expect(RearrangeWrites(Program(), static_cast<std::uint32_t>(ByEffort({8, 12, 30, 60}))), "rearranged writes");
}

TEST_P(Damaged, H7_TheRecordingThatWasInterruptedOutlivesTheNextOne) {
  Expect(StartAgain(Program(), ByEffort({100, 500, 5'000, 50'000})), "start after a cut");
}

TEST_P(Damaged, P6_IsRecoveredAtTheNextStartEvenIfThePowerGoesInTheMidstOfIt) {
  Expect(StartUpTwice(Program(), ByEffort({40, 300, 5'000, 50'000})), "start-up, twice");
}

TEST_P(Damaged, RecoveredIsWholeAndRecoveringItAgainChangesNothing) {
  Expect(Recover(Program(), ByEffort({40, 200, 5'000, 50'000})), "recovery");
}

}  // namespace
}  // namespace annulus
