/// Fault rows D8 (locked), D9 (damaged), D10 (missing), and what was moved from one place to another.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "tests/station_store/raw_database.h"
#include "tests/station_store/store_folder.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

using test::RawDatabase;
using test::StoreOnDisk;
using test::TextFrom;
using test::WordsOf;
using testing::HasSubstr;
using testing::SizeIs;

TEST(StoreDamage, WaitsTwoSecondsForAnotherWriterThenSaysSo) {  // D8
  StoreOnDisk disk;
  disk.Open();
  disk.AddPerson("before");
  RawDatabase other(disk.database());
  ASSERT_EQ(other.Try("BEGIN IMMEDIATE"), "");
  const auto start = std::chrono::steady_clock::now();
  Customer customer;
  customer.name = "B";
  const auto added = disk->AddCustomer(customer);
  const auto waited = std::chrono::steady_clock::now() - start;
  EXPECT_THAT(WordsOf(added), HasSubstr("another program has held its lock for 2 s"));
  EXPECT_GE(waited, std::chrono::milliseconds(1900));
  EXPECT_LT(waited, std::chrono::seconds(10));
  EXPECT_THAT(disk->FindCustomers("", 10).value(), SizeIs(1));  // readers do not wait
  ASSERT_EQ(other.Try("COMMIT"), "");
  EXPECT_TRUE(disk->AddCustomer(customer));
}

TEST(StoreDamage, OpensADamagedDatabaseForReadingOnly) {  // D9
  test::Dice dice(9);
  int read_only = 0;
  for (int round = 0; round < 20; ++round) {
    StoreOnDisk disk;
    disk.Open();
    for (int i = 0; i < 30; ++i) disk.AddPerson("Customer " + std::to_string(i), std::string(200, 'c'));
    disk.Close();
    std::string bytes = test::ReadBytes(disk.database());
    constexpr std::size_t kPage = 4096;
    const std::size_t page = 1 + dice.Below(bytes.size() / kPage - 1);  // not the first: that is the next test
    for (std::size_t i = 0; i < kPage; ++i) bytes[page * kPage + i] = static_cast<char>(dice.Next());
    test::WriteBytes(disk.database(), bytes);
    const auto opened = disk.TryOpen();
    ASSERT_TRUE(opened) << WordsOf(opened);
    if ((*opened)->state() == StoreState::kReady) continue;  // an unused page
    ++read_only;
    EXPECT_THAT((*opened)->problem(), HasSubstr("damaged"));
    Customer customer;
    EXPECT_THAT(WordsOf((*opened)->AddCustomer(customer)), HasSubstr("can only be read"));
    EXPECT_FALSE((*opened)->Erase("K-000001"));
    EXPECT_FALSE((*opened)->Backup(""));
    static_cast<void>((*opened)->FindCustomers("", 100));  // whatever it says, it says it
  }
  EXPECT_GE(read_only, 15);
}

TEST(StoreDamage, OpensWhatIsNoDatabaseForReadingOnly) {
  StoreOnDisk disk;
  disk.Open();
  disk.AddPerson("A");
  disk.Close();
  std::string bytes = test::ReadBytes(disk.database());
  for (std::size_t i = 0; i < 100; ++i) bytes[i] = 'z';
  test::WriteBytes(disk.database(), bytes);
  const auto opened = disk.TryOpen();
  ASSERT_TRUE(opened) << WordsOf(opened);
  EXPECT_EQ((*opened)->state(), StoreState::kReadOnly);
  EXPECT_FALSE((*opened)->GetCustomer("K-000001"));
  EXPECT_EQ(test::ReadBytes(disk.database()), bytes);  // nothing was written
}

TEST(StoreDamage, RefusesAForeignDatabase) {
  StoreOnDisk disk;
  std::filesystem::create_directories(disk.options.folder);
  {
    RawDatabase foreign(disk.database());
    ASSERT_EQ(foreign.Try("CREATE TABLE recipes(name TEXT)"), "");
  }
  EXPECT_THAT(WordsOf(disk.TryOpen()), HasSubstr("not a store's"));
}

TEST(StoreDamage, ShowsARowWhoseRecordingIsMissing) {  // D10
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const auto scan = disk.AddScan(consent, "a recording");
  EXPECT_FALSE(disk->GetScan(scan->id)->recording_missing);
  std::filesystem::remove(disk.content(scan->recording));
  EXPECT_TRUE(disk->GetScan(scan->id)->recording_missing);
  EXPECT_TRUE(disk->ScansOf(customer.id)->front().recording_missing);
  EXPECT_TRUE(disk->LatestScans(1)->front().recording_missing);
  EXPECT_THAT(WordsOf(disk->ReadRecording(scan->id)), HasSubstr("not there"));
  disk.Open();
  EXPECT_TRUE(disk->GetScan(scan->id)->recording_missing);
  EXPECT_TRUE(disk->Erase(customer.id));
}

TEST(StoreDamage, ReadsNoFileOfWhichABitHasChanged) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const auto scan = disk.AddScan(consent, "a recording");
  const auto model = disk.PutArtefact(scan->id, "model", "model.json", "a model");
  for (const std::string& path : test::FilesBelow(disk.options.folder + "/files")) {
    std::string bytes = test::ReadBytes(path);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    test::WriteBytes(path, bytes);
  }
  EXPECT_THAT(WordsOf(disk->ReadRecording(scan->id)), HasSubstr("damaged"));
  EXPECT_THAT(WordsOf(disk->ReadArtefact(model->id)), HasSubstr("damaged"));
}

/// Two customers with a scan and a design each; what is exchanged between them must not open.
struct Exchange : StoreOnDisk {
  Exchange() {
    Open();
    for (const char* name : {"Anna", "Berta"}) {
      const auto [customer, consent] = AddPerson(name);
      for (int i = 0; i < 2; ++i) {
        const auto scan = AddScan(consent, std::string("recording ") + name + std::to_string(i));
        EXPECT_TRUE(PutArtefact(scan->id, "design", "d", name));
      }
    }
    Close();
  }
  void Run(const std::string& sql) {
    {
      RawDatabase raw(database());
      EXPECT_EQ(raw.Try(sql), "") << sql;
    }
    Open();
  }
};

TEST(StoreDamage, RefusesSealsThatWereExchangedBetweenRows) {
  Exchange disk;
  disk.Run("UPDATE customers SET sealed = (SELECT sealed FROM customers WHERE id = 'K-000002') WHERE id = 'K-000001'");
  EXPECT_THAT(WordsOf(disk->GetCustomer("K-000001")), HasSubstr("moved from another place"));
  EXPECT_TRUE(disk->GetCustomer("K-000002"));
  EXPECT_EQ(disk->FindCustomers("", 10)->back().name, "");  // listed, so that it can be erased
}

TEST(StoreDamage, RefusesRecordingsThatWereExchangedBetweenScansOfOneCustomer) {
  Exchange disk;
  disk.Run("UPDATE scans SET recording = (SELECT recording FROM scans WHERE id = 'S-000002') WHERE id = 'S-000001'");
  EXPECT_THAT(WordsOf(disk->ReadRecording("S-000001")), HasSubstr("moved from another place"));
  EXPECT_TRUE(disk->ReadRecording("S-000002"));
}

TEST(StoreDamage, RefusesScansThatWereGivenToAnotherCustomerOrConsent) {
  Exchange disk;
  disk.Run(
      "UPDATE scans SET customer_id = 'K-000002' WHERE id = 'S-000001';"
      "UPDATE scans SET consent_id = 'C-000001' WHERE id = 'S-000003'");
  EXPECT_FALSE(disk->GetScan("S-000001"));
  EXPECT_FALSE(disk->GetScan("S-000003"));
  EXPECT_TRUE(disk->GetScan("S-000004"));
}

TEST(StoreDamage, RefusesContentsThatWereExchangedBetweenArtefacts) {
  Exchange disk;
  disk.Run(
      "UPDATE artefacts SET file = (SELECT file FROM artefacts WHERE id = 'A-000002') WHERE id = 'A-000001';"
      "UPDATE artefacts SET scan_id = 'S-000003', name_tag = x'00' WHERE id = 'A-000004'");
  EXPECT_FALSE(disk->ReadArtefact("A-000001"));
  EXPECT_TRUE(disk->ReadArtefact("A-000002"));
  EXPECT_FALSE(disk->GetArtefact("A-000004"));
}

TEST(StoreDamage, RefusesAKeyThatWasExchanged) {
  Exchange disk;
  std::filesystem::copy_file(disk.options.folder + "/keys/K-000002", disk.options.folder + "/keys/K-000001",
                             std::filesystem::copy_options::overwrite_existing);
  disk.Open();
  EXPECT_FALSE(disk->GetCustomer("K-000001"));
  EXPECT_TRUE(disk->GetCustomer("K-000002"));
}

TEST(StoreDamage, RefusesSecretsThatWereGivenToAnotherUser) {
  StoreOnDisk disk;
  disk.Open();
  User user;
  user.name = "guest";
  ASSERT_TRUE(disk->AddUser(user, "hash of guest"));
  user.name = "boss";
  ASSERT_TRUE(disk->AddUser(user, "hash of boss"));
  disk.Close();
  {
    RawDatabase raw(disk.database());
    ASSERT_EQ(
        raw.Try("UPDATE secrets SET sealed = (SELECT sealed FROM secrets WHERE user = 'guest') WHERE user = 'boss'"),
        "");
  }
  disk.Open();
  EXPECT_FALSE(disk->Secret("boss", "password"));
  EXPECT_TRUE(disk->Secret("guest", "password"));
}

TEST(StoreDamage, RemovesFilesAndKeysWithoutARowAtStartButNotMany) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const auto scan = disk.AddScan(consent, "a recording");
  disk.Close();
  const auto plant = [&](int count) {
    for (int i = 0; i < count; ++i) {
      const std::string hash = std::string(62, 'a') + std::to_string(10 + i);
      std::filesystem::create_directories(disk.options.folder + "/files/aa");
      test::WriteBytes(disk.content(hash), "orphan");
    }
  };
  plant(3);
  test::WriteBytes(disk.options.folder + "/files/incoming/half", "half");
  test::WriteBytes(disk.options.folder + "/keys/K-000077", "a key");
  test::WriteBytes(disk.options.folder + "/keys/K-000078.part-12", "half a key");
  disk.Open();
  EXPECT_THAT(test::FilesBelow(disk.options.folder + "/files"), SizeIs(1));
  EXPECT_THAT(test::FilesBelow(disk.options.folder + "/keys"), SizeIs(1));
  EXPECT_EQ(TextFrom(disk->ReadRecording(scan->id).value()), "a recording");
  disk.Close();
  plant(40);  // as if the database were an older copy
  disk.Open();
  EXPECT_THAT(test::FilesBelow(disk.options.folder + "/files"), SizeIs(41));
}

}  // namespace
}  // namespace annulus
