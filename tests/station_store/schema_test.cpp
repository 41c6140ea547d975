/// Migrations, and a store of every version that there has been. After a new version:
///
///   ANNULUS_UPDATE_GOLDEN=1 build/release/tests/station_store/station_store_test --gtest_filter=Schema.*
///
/// makes the golden store of that version; those of older versions are never made again.

#include "station/store/schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

#include "tests/station_store/raw_database.h"
#include "tests/station_store/store_folder.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using test::RawDatabase;
using test::StoreOnDisk;
using test::TextFrom;
using test::WordsOf;
using testing::HasSubstr;
using testing::SizeIs;

std::string GoldenFolder(int version) {
  return test::SourceFolder() + "/tests/golden/store_" + std::to_string(version);
}

/// What is in every golden store.
void FillGolden(StoreOnDisk& disk) {
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("山田 花子", "hanako@example.jp");
  const auto scan = disk.AddScan(consent, "the recording of a golden store");
  ASSERT_TRUE(scan);
  ASSERT_TRUE(disk->JudgeScan(scan->id, "good", R"({"coverage":0.97})"));
  ASSERT_TRUE(disk.PutArtefact(scan->id, "model", "model.json", "{model}"));
  User user;
  user.name = "sato";
  user.role = StationRole::kTechnician;
  ASSERT_TRUE(disk->AddUser(user, "hash"));
  ASSERT_TRUE(disk->AddCalibration("2026-11", "{cal}"));
  ASSERT_TRUE(disk->SetSetting("language", "\"ja\""));
  AuditLine line;
  line.user = "sato";
  line.action = "arm";
  ASSERT_TRUE(disk->Audit(line));
  ASSERT_TRUE(disk->Audit(line));
  disk.Close();
}

TEST(Schema, OpensAndMigratesAStoreOfEveryVersion) {
  const int newest = StoreMigrations().back().version;
  if (std::getenv("ANNULUS_UPDATE_GOLDEN") != nullptr && !std::filesystem::exists(GoldenFolder(newest))) {
    StoreOnDisk disk;
    FillGolden(disk);
    std::filesystem::copy(disk.disk.path(), GoldenFolder(newest), std::filesystem::copy_options::recursive);
  }
  for (int version = 1; version <= newest; ++version) {
    ASSERT_TRUE(std::filesystem::exists(GoldenFolder(version))) << version;
    StoreOnDisk disk;
    std::filesystem::copy(GoldenFolder(version), disk.disk.path(),
                          std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
    std::filesystem::permissions(disk.options.station_key_file, std::filesystem::perms::owner_read);
    disk.options.make_key = false;
    disk.Open();
    EXPECT_EQ(disk->state(), StoreState::kReady);
    const auto customer = disk->GetCustomer("K-000001");
    ASSERT_TRUE(customer) << WordsOf(customer);
    EXPECT_EQ(customer->name, "山田 花子");
    EXPECT_THAT(disk->FindCustomers("HANAKO", 5).value(), SizeIs(1));
    EXPECT_THAT(disk->Consents("K-000001").value(), SizeIs(1));
    EXPECT_EQ(disk->GetScan("S-000001")->summary_json, R"({"coverage":0.97})");
    EXPECT_EQ(TextFrom(disk->ReadRecording("S-000001").value()), "the recording of a golden store");
    EXPECT_EQ(TextFrom(disk->ReadArtefact("A-000001").value()), "{model}");
    EXPECT_EQ(disk->Secret("sato", "password").value(), "hash");
    EXPECT_EQ(disk->ReadCalibration("L-000001").value(), "{cal}");
    EXPECT_EQ(disk->Setting("language").value(), "\"ja\"");
    EXPECT_TRUE(disk->VerifyAudit());
    EXPECT_TRUE(disk->Erase("K-000001"));
  }
}

TEST(Schema, RefusesANewerOne) {
  StoreOnDisk disk;
  disk.Open();
  disk.Close();
  {
    RawDatabase raw(disk.database());
    ASSERT_EQ(raw.Try("PRAGMA user_version = 99"), "");
  }
  EXPECT_THAT(WordsOf(disk.TryOpen()), HasSubstr("version 99"));
}

TEST(Schema, CopiesTheDatabaseBeforeItMigratesAndUndoesAStepThatFails) {
  StoreOnDisk disk;
  disk.Open();
  disk.AddPerson("A");
  disk.Close();
  const auto database = Database::Open(disk.database(), Database::Access::kReadWrite);
  ASSERT_TRUE(database);
  const Migration first = StoreMigrations().front();
  const std::array<Migration, 2> broken{{first, {2, "CREATE TABLE extra(a TEXT) STRICT; SELECT no_such_function();"}}};
  EXPECT_FALSE(BringUpToDate(**database, broken, disk.posix));
  EXPECT_EQ(SchemaVersion(**database).value(), 1);
  EXPECT_EQ((*database)->Number("SELECT count(*) FROM sqlite_schema WHERE name = 'extra'").value(), 0);
  const std::array<Migration, 2> better{{first, {2, "ALTER TABLE settings ADD COLUMN changed_ms INTEGER;"}}};
  ASSERT_TRUE(BringUpToDate(**database, better, disk.posix));
  EXPECT_EQ(SchemaVersion(**database).value(), 2);
  const auto copy = Database::Open(disk.database() + ".schema-1", Database::Access::kReadOnly);
  ASSERT_TRUE(copy) << WordsOf(copy);
  EXPECT_EQ(SchemaVersion(**copy).value(), 1);
  EXPECT_EQ((*copy)->Number("SELECT count(*) FROM customers").value(), 1);
  EXPECT_TRUE((*copy)->QuickCheck());
}

}  // namespace
}  // namespace annulus
