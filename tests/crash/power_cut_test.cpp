#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "survival.h"

namespace annulus {
namespace {

using test::CutPower;
using test::HonestReader;
using test::RecordAtBothRates;
using test::Subject;
using test::Tally;
using test::Trace;

/// 20,000 states; ANNULUS_LONG: 200,000; ANNULUS_SOAK: 5,000,000.
std::uint64_t States() {
  if (std::getenv("ANNULUS_SOAK") != nullptr) return 5'000'000;
  return std::getenv("ANNULUS_LONG") != nullptr ? 200'000 : 20'000;
}

TEST(PowerCut, D11_KeepsEverySyncedLevelAndReturnsNoFalseOne) {
  const std::vector<Trace> traces = RecordAtBothRates(Subject());
  for (const Trace& trace : traces) ASSERT_TRUE(trace.finished) << trace.failure->Text();
  const Tally tally = CutPower(traces, HonestReader, 1, States());
  std::cout << tally.Line("power cut") << "\n";
  EXPECT_TRUE(tally.ok()) << tally.first;
}

}  // namespace
}  // namespace annulus
