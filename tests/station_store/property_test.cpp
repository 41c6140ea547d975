#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/station_store/store_model.h"

namespace annulus {
namespace {

using test::StoreExercise;
using test::StoreOnDisk;

/// How many rows of each kind the store has, as the model would say it.
std::string Counts(Store& store) {
  std::size_t things = 0;
  const auto scans = store.LatestScans(100'000);
  if (!scans) return scans.error().Text();
  for (const ScanRow& scan : *scans) things += store.ArtefactsOf(scan.id)->size();
  return std::to_string(store.FindCustomers("", 100'000)->size()) + " " + std::to_string(scans->size()) + " " +
         std::to_string(things);
}

std::string Counts(const test::StoreModel& model) {
  return std::to_string(model.people.size()) + " " + std::to_string(model.scans.size()) + " " +
         std::to_string(model.things.size());
}

TEST(StoreProperties, HoldsWhatASimpleModelHoldsAfterAnyOperations) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    StoreOnDisk disk;
    disk.Open();
    StoreExercise exercise(seed, disk.disk.path() + "/spool");
    for (int step = 0; step < 120; ++step) {
      exercise.Step(*disk);
      if (step % 40 == 20) disk.Open();
      if (step % 30 != 29) continue;
      ASSERT_EQ(exercise.Difference(*disk), "") << "seed " << seed << ", step " << step;
    }
    disk.Open();
    EXPECT_EQ(exercise.Difference(*disk), "") << "seed " << seed;
    EXPECT_EQ(Counts(*disk), Counts(exercise.model())) << "seed " << seed;
    // Not one file more than what rows name.
    EXPECT_EQ(test::FilesBelow(disk.options.folder + "/files").size(),
              exercise.model().scans.size() + exercise.model().things.size());
    EXPECT_EQ(test::FilesBelow(disk.options.folder + "/keys").size(), exercise.model().people.size());
  }
}

}  // namespace
}  // namespace annulus
