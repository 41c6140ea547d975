#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "station/key_file.h"
#include "station/store/key_vault.h"
#include "station/store/sealed_text.h"
#include "tests/station_store/raw_database.h"
#include "tests/station_store/store_folder.h"

namespace annulus {
namespace {

using test::StoreOnDisk;
using test::WordsOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr const char* kName = "Marker-Name-9f3b 山田";
constexpr const char* kContact = "marker-contact-9f3b@example.jp";
constexpr const char* kInRecording = "marker in a recording 9f3b";

/// A customer with all that there can be of one, and the ids of it.
Customer AddEverythingOf(StoreOnDisk& disk) {
  const auto [customer, consent] = disk.AddPerson(kName, kContact);
  const auto scan = disk.AddScan(consent, std::string(100'000, 'x') + kInRecording);
  EXPECT_TRUE(scan) << WordsOf(scan);
  EXPECT_TRUE(disk->JudgeScan(scan->id, "good", "\"marker-summary-9f3b\""));
  EXPECT_TRUE(disk.PutArtefact(scan->id, "model", "model.json", "marker-model-9f3b"));
  EXPECT_TRUE(disk.PutArtefact(scan->id, "design", "marker-title-9f3b", "{}"));
  return customer;
}

/// The raw key of a customer, as it is in their key file.
std::string RawKey(const StoreOnDisk& disk, const std::string& id) {
  const auto station = ReadKeyFile(disk.options.station_key_file);
  PosixStorage storage;
  KeyVault vault(disk.options.folder + "/keys", ReadKeyFile(disk.options.station_key_file).value(), storage);
  const auto key = vault.Key(id);
  EXPECT_TRUE(key) << WordsOf(key);
  return {reinterpret_cast<const char*>(key->bytes.data()), key->bytes.size()};
}

TEST(Erasure, LeavesNothingOfACustomerToAByteSearchOfEverything) {
  StoreOnDisk disk;
  disk.Open();
  const Customer customer = AddEverythingOf(disk);
  const auto [other, consent_of_other] = disk.AddPerson("Somebody Else");
  ASSERT_TRUE(disk.AddScan(consent_of_other, "their recording"));
  const auto backup = disk->Backup("");
  ASSERT_TRUE(backup) << WordsOf(backup);
  const std::string outside = disk.disk.path() + "/usb";
  ASSERT_TRUE(disk->Backup(outside));
  const std::string key = RawKey(disk, customer.id);
  const std::string wrapped = test::ReadBytes(disk.options.folder + "/keys/" + customer.id);
  EXPECT_THAT(disk->FindCustomers("marker", 5).value(), SizeIs(1));  // names are in memory now

  const auto proof = disk->Erase(customer.id);
  ASSERT_TRUE(proof) << WordsOf(proof);
  EXPECT_TRUE(proof->key_destroyed);
  EXPECT_EQ(proof->files, 3U);  // recording, model, design
  EXPECT_EQ(proof->rows, 5U);   // customer, consent, scan, two artefacts
  EXPECT_EQ(proof->marker_hits, 0U);
  EXPECT_GT(proof->bytes_searched, 100'000U);
  EXPECT_FALSE(disk->GetCustomer(customer.id));
  EXPECT_THAT(disk->FindCustomers("marker", 5).value(), IsEmpty());
  EXPECT_THAT(test::FilesBelow(disk.options.folder + "/files"), SizeIs(1));  // the other's
  EXPECT_TRUE(disk->GetCustomer(other.id));
  disk.Close();
  const std::string wrapped_hex = wrapped.substr(wrapped.rfind(' ') + 1, 64);
  const auto wrapped_bytes = BytesOfHex(wrapped_hex);
  for (const std::string& marker :
       {std::string(kName), std::string(kContact), std::string(kInRecording), std::string("marker-summary-9f3b"),
        std::string("marker-model-9f3b"), std::string("marker-title-9f3b"), key, wrapped_hex,
        std::string(reinterpret_cast<const char*>(wrapped_bytes.data()), wrapped_bytes.size())}) {
    EXPECT_THAT(test::FilesWith(disk.disk.path(), marker), IsEmpty()) << marker.substr(0, 10);
  }
}

TEST(Erasure, FindsWhatWasLeftInPlainText) {
  StoreOnDisk disk;
  disk.Open();
  const Customer customer = AddEverythingOf(disk);
  std::filesystem::create_directories(disk.options.folder + "/backups");
  test::WriteBytes(disk.options.folder + "/backups/note.txt", std::string("call ") + kContact);
  const auto proof = disk->Erase(customer.id);
  ASSERT_TRUE(proof);
  EXPECT_EQ(proof->marker_hits, 1U);
}

TEST(Erasure, LeavesNoCiphertextOfTheCustomerInTheDatabase) {
  StoreOnDisk disk;
  disk.Open();
  std::string other_id;
  for (int i = 0; i < 40; ++i) disk.AddPerson("Customer " + std::to_string(i), std::string(300, 'c'));
  disk.Close();
  std::string sealed;
  {
    test::RawDatabase raw(disk.database());
    sealed = raw.Ask("SELECT hex(sealed) FROM customers WHERE id = 'K-000017'");
  }
  std::transform(sealed.begin(), sealed.end(), sealed.begin(),
                 [](char c) { return static_cast<char>(std::tolower(c)); });
  const auto bytes = BytesOfHex(sealed.substr(0, 64));
  const std::string start(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_THAT(test::FilesWith(disk.options.folder, start), SizeIs(1));
  disk.Open();
  ASSERT_TRUE(disk->Erase("K-000017"));
  disk.Close();
  EXPECT_THAT(test::FilesWith(disk.options.folder, start), IsEmpty());
}

TEST(Erasure, ReachesTheKeysOfBackupsSoThatAnOldBackupOpensNothing) {
  StoreOnDisk disk;
  disk.Open();
  const Customer customer = AddEverythingOf(disk);
  const auto [other, consent] = disk.AddPerson("Somebody Else");
  const auto backup = disk->Backup("");
  ASSERT_TRUE(backup);
  ASSERT_TRUE(disk->Erase(customer.id));
  disk.Close();
  EXPECT_THAT(test::ReadBytes(*backup + "-keys"), testing::Not(HasSubstr(customer.id)));
  StoreOnDisk again;
  again.options.station_key_file = disk.options.station_key_file;
  again.options.make_key = false;
  const auto left_out = RestoreStore(again.options, *backup, *backup + "-keys", again.posix, again.clock);
  ASSERT_TRUE(left_out) << WordsOf(left_out);
  EXPECT_THAT(*left_out, ElementsAre(customer.id));
  again.Open();
  EXPECT_FALSE(again->GetCustomer(customer.id));
  EXPECT_EQ(again->GetCustomer(other.id)->name, "Somebody Else");
  EXPECT_THAT(again->LatestScans(10).value(), IsEmpty());
}

TEST(Erasure, GivesTheSameProofAgain) {
  StoreOnDisk disk;
  disk.Open();
  const Customer customer = AddEverythingOf(disk);
  const auto first = disk->Erase(customer.id);
  const auto again = disk->Erase(customer.id);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->files, again->files);
  EXPECT_EQ(first->bytes_searched, again->bytes_searched);
  EXPECT_FALSE(disk->Erase("K-000777"));
}

TEST(Erasure, LooksForShortNamesAsTheyWouldBeWritten) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("Li", "1");
  ASSERT_TRUE(disk.AddScan(consent, std::string(100'000, 'x')));  // "Li" occurs by chance in so much ciphertext
  EXPECT_EQ(disk->Erase(customer.id)->marker_hits, 0U);
  const auto [second, consent_of_second] = disk.AddPerson("Li", "1");
  test::WriteBytes(disk.options.folder + "/files/dump.json", R"({"contact":"1","name":"Li"})");
  EXPECT_EQ(disk->Erase(second.id)->marker_hits, 2U);
}

TEST(Erasure, NumbersOfErasedCustomersAreNotGivenAgain) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  ASSERT_TRUE(disk->Erase(customer.id));
  disk.Open();
  EXPECT_EQ(disk.AddPerson("B").first.id, "K-000002");
}

TEST(Erasure, IsSeenByAnotherOpenStore) {
  StoreOnDisk disk;
  disk.Open();
  const Customer customer = AddEverythingOf(disk);
  EXPECT_THAT(disk->FindCustomers("marker", 5).value(), SizeIs(1));
  {
    const auto other = Store::Open(disk.options, disk.posix, disk.clock);
    ASSERT_TRUE(other) << WordsOf(other);
    ASSERT_TRUE((*other)->Erase(customer.id));
  }
  EXPECT_THAT(disk->FindCustomers("marker", 5).value(), IsEmpty());
  EXPECT_FALSE(disk->GetCustomer(customer.id));
}

}  // namespace
}  // namespace annulus
