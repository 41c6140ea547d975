#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <utility>

#include "survival.h"

namespace annulus {
namespace {

using test::CheckPowerCut;
using test::CutPower;
using test::DrawCut;
using test::Garbage;
using test::HonestReader;
using test::PowerCut;
using test::Record;
using test::RecordAtBothRates;
using test::Sealing;
using test::Subject;
using test::Tally;
using test::Trace;

/// Chunks of one level are longer than half a sector here: at most two of them lie in one.
constexpr std::uint64_t kLevelsInASector = 2;

/// 20,000 states; ANNULUS_LONG: 200,000; ANNULUS_SOAK: 5,000,000.
std::uint64_t States() {
  if (std::getenv("ANNULUS_SOAK") != nullptr) return 5'000'000;
  return std::getenv("ANNULUS_LONG") != nullptr ? 200'000 : 20'000;
}

TEST(PowerCut, D11_KeepsEverySyncedLevelAndReturnsNoFalseOne) {
  std::vector<Trace> traces = RecordAtBothRates(Subject());
  Subject sealed;
  sealed.sealing = Sealing::kSealed;
  for (Trace& trace : RecordAtBothRates(sealed)) traces.push_back(std::move(trace));
  for (const Trace& trace : traces) ASSERT_TRUE(trace.finished) << trace.failure->Text();
  const Tally tally = CutPower(traces, HonestReader, 1, States());
  std::cout << tally.Line("power cut") << "\n";
  EXPECT_TRUE(tally.ok()) << tally.first;
}

/// A drive without power-safe overwrite may spoil the sector that the last durable bytes share with the next ones.
TEST(PowerCut, OfADriveThatSpoilsTheSectorItRewritesCostsWhatStandsInThatSector) {
  const std::vector<Trace> traces = RecordAtBothRates(Subject());
  Tally tally;
  const std::uint64_t states = States() / 10;
  for (std::uint64_t seed = 1; seed <= states; ++seed) {
    const Trace& trace = traces[seed % traces.size()];
    PowerCut cut = DrawCut(trace, seed);
    cut.garbage = Garbage::kWholeSector;
    CheckPowerCut(trace, cut, HonestReader, tally);
  }
  std::cout << tally.Line("power cut, spoilt sectors") << ", most durable lost " << tally.most_durable_lost << "\n";
  EXPECT_EQ(tally.false_levels + tally.false_records + tally.false_headers + tally.miscounted, 0U) << tally.first;
  EXPECT_LE(tally.most_durable_lost, kLevelsInASector);
}

/// A file system that hands out what deleted files held: sectors of an older recording, written in the same way.
TEST(PowerCut, ReturnsNoLevelOfAnOlderRecordingFromSectorsThatWereNeverWritten) {
  std::vector<Trace> traces = RecordAtBothRates(Subject());
  for (Trace& trace : traces) {
    const Trace older = Record({.levels_per_s = trace.levels_per_s, .content = 1});
    trace.disk->set_stale_bytes(older.disk->Live().at(older.path));
  }
  const Tally tally = CutPower(traces, HonestReader, 1, States() / 2);
  std::cout << tally.Line("power cut, stale sectors") << "\n";
  EXPECT_TRUE(tally.ok()) << tally.first;
}

}  // namespace
}  // namespace annulus
