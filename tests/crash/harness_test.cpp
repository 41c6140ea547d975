#include <gtest/gtest.h>

#include <iostream>
#include <utility>

#include "planted_defects.h"
#include "properties.h"

namespace annulus {
namespace {

using test::PlantedDefect;
using test::Subject;
using test::Tally;

/// A property, small enough to be asked of every defect.
struct Property {
  const char* name;
  Tally (*check)(const Subject& subject);
};

constexpr std::uint64_t kCuts = 1'000;

const Property kProperties[] = {
    {"rearranged writes", [](const Subject& subject) { return RearrangeWrites(subject, 6); }},
    {"recovery", [](const Subject& subject) { return Recover(subject, 30); }},
    {"start after a cut", [](const Subject& subject) { return StartAgain(subject, 40); }},
    {"failing calls", [](const Subject& subject) { return FailEveryCall(subject, 6); }},
    {"power cut",
     [](const Subject& subject) { return CutPower(RecordAtBothRates(subject), subject.reader, 1, kCuts); }},
    {"cut file", [](const Subject& subject) { return CutTheFile(subject, 6, 17); }},
    {"flipped bits", [](const Subject& subject) { return FlipBits(subject, 6, 13); }},
};

/// The first property that the subject does not have, with what was seen; empty: it has all.
std::string BrokenBy(const Subject& subject) {
  for (const Property& property : kProperties) {
    const Tally tally = property.check(subject);
    if (!tally.ok()) return std::string(property.name) + ": " + tally.first;
  }
  return "";
}

TEST(Harness, CatchesEveryPlantedDefect) {
  ASSERT_EQ(BrokenBy(Subject()), "") << "the program itself; nothing can be said of the defects";
  std::vector<PlantedDefect> defects = test::DefectiveDisks();
  for (PlantedDefect& defect : test::DefectiveReaders()) defects.push_back(std::move(defect));
  std::size_t caught = 0;
  for (const PlantedDefect& defect : defects) {
    const std::string broken = BrokenBy(defect.subject);
    std::cout << (broken.empty() ? "NOT CAUGHT: " : "caught: ") << defect.name << ": " << broken << "\n";
    EXPECT_NE(broken, "") << defect.name;
    caught += broken.empty() ? 0 : 1;
  }
  std::cout << "planted defects: " << defects.size() << ", caught " << caught << "\n";
  EXPECT_GE(defects.size(), 12U);
}

}  // namespace
}  // namespace annulus
