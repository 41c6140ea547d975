#include "station/store/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "acquisition/mcap_bytes.h"
#include "tests/station_store/store_folder.h"
#include "tests/support/test_keys.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using test::BytesFrom;
using test::StoreOnDisk;
using test::TextFrom;
using test::WordsOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Names of what was found.
std::vector<std::string> Names(const Result<std::vector<Customer>>& customers) {
  std::vector<std::string> names;
  if (!customers) return {customers.error().Text()};
  for (const Customer& customer : *customers) names.push_back(customer.name);
  return names;
}

User UserOf(const std::string& name, StationRole role) {
  User user;
  user.name = name;
  user.role = role;
  return user;
}

TEST(Store, KeepsCustomersAcrossAClose) {
  StoreOnDisk disk;
  disk.Open();
  Customer customer;
  customer.name = "山田 花子";
  customer.contact = "hanako@example.jp";
  customer.note = "prefers thin temples";
  customer.height_mm = 1583;
  customer.prescription_json = R"({"right":{"sphere_d":-2.25}})";
  const auto added = disk->AddCustomer(customer);
  ASSERT_TRUE(added) << WordsOf(added);
  EXPECT_EQ(added->id, "K-000001");
  EXPECT_EQ(added->created, std::chrono::seconds(946'684'800));
  EXPECT_EQ(added->keep_until, added->created + std::chrono::hours(24 * 90));
  disk.Open();
  const auto read = disk->GetCustomer("K-000001");
  ASSERT_TRUE(read) << WordsOf(read);
  EXPECT_EQ(read->name, customer.name);
  EXPECT_EQ(read->contact, customer.contact);
  EXPECT_EQ(read->note, customer.note);
  EXPECT_EQ(read->height_mm, customer.height_mm);
  EXPECT_EQ(read->prescription_json, customer.prescription_json);
  EXPECT_EQ(read->keep_until, added->keep_until);
  EXPECT_FALSE(disk->GetCustomer("K-000002"));
}

TEST(Store, ChangesACustomerAndFindsThemByTheNewNameOnly) {
  StoreOnDisk disk;
  disk.Open();
  auto [customer, consent] = disk.AddPerson("Anna Old");
  EXPECT_THAT(Names(disk->FindCustomers("old", 10)), ElementsAre("Anna Old"));
  customer.name = "Anna New";
  ASSERT_TRUE(disk->ChangeCustomer(customer));
  EXPECT_THAT(Names(disk->FindCustomers("old", 10)), IsEmpty());
  EXPECT_THAT(Names(disk->FindCustomers("NEW", 10)), ElementsAre("Anna New"));
  customer.id = "K-000009";
  EXPECT_FALSE(disk->ChangeCustomer(customer));
}

TEST(Store, FindsCustomersNewestFirstWhateverLetterCaseAndWidth) {
  StoreOnDisk disk;
  disk.Open();
  disk.AddPerson("ヤマダ ハナコ", "090-1234-5678");
  disk.AddPerson("Yamada Taro", "TARO@example.jp");
  disk.AddPerson("Müller", "");
  EXPECT_THAT(Names(disk->FindCustomers("", 10)), ElementsAre("Müller", "Yamada Taro", "ヤマダ ハナコ"));
  EXPECT_THAT(Names(disk->FindCustomers("", 2)), ElementsAre("Müller", "Yamada Taro"));
  EXPECT_THAT(Names(disk->FindCustomers("ﾔﾏﾀﾞ", 10)), ElementsAre("ヤマダ ハナコ"));
  EXPECT_THAT(Names(disk->FindCustomers("ｙａｍａｄａ", 10)), ElementsAre("Yamada Taro"));
  EXPECT_THAT(Names(disk->FindCustomers("taro@EXAMPLE", 10)), ElementsAre("Yamada Taro"));
  EXPECT_THAT(Names(disk->FindCustomers("１２３４", 10)), ElementsAre("ヤマダ ハナコ"));
  EXPECT_THAT(Names(disk->FindCustomers("MÜLL", 10)), ElementsAre("Müller"));
  EXPECT_THAT(Names(disk->FindCustomers("k-000002", 10)), ElementsAre("Yamada Taro"));
  EXPECT_THAT(Names(disk->FindCustomers("3", 10)), ElementsAre("Müller", "ヤマダ ハナコ"));
  EXPECT_THAT(Names(disk->FindCustomers("nobody", 10)), IsEmpty());
}

TEST(Store, RefusesTextThatIsNotUtf8) {
  StoreOnDisk disk;
  disk.Open();
  Customer customer;
  customer.name = "\xE3\x81";
  EXPECT_THAT(WordsOf(disk->AddCustomer(customer)), HasSubstr("UTF-8"));
}

TEST(Store, HoldsConsentsThatCanBeWithdrawnButNotChanged) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  disk.clock.SleepUntil(std::chrono::seconds(60));
  ASSERT_TRUE(disk->WithdrawConsent(consent.id));
  disk.clock.SleepUntil(std::chrono::seconds(120));
  ASSERT_TRUE(disk->WithdrawConsent(consent.id));  // again: the first time stands
  const auto consents = disk->Consents(customer.id);
  ASSERT_TRUE(consents);
  ASSERT_THAT(*consents, SizeIs(1));
  EXPECT_THAT(consents->front().purposes, ElementsAre("measure"));
  EXPECT_EQ(consents->front().language, "ja");
  EXPECT_EQ(consents->front().taken_by, "sato");
  EXPECT_EQ(*consents->front().withdrawn - consents->front().given, std::chrono::seconds(60));
  EXPECT_FALSE(disk->WithdrawConsent("C-000009"));
  Consent wrong = consent;
  wrong.purposes = {"advertising"};
  EXPECT_THAT(WordsOf(disk->AddConsent(wrong)), HasSubstr("advertising"));
  wrong.purposes = {"measure"};
  wrong.customer_id = "K-000009";
  EXPECT_FALSE(disk->AddConsent(wrong));
}

TEST(Store, TakesARecordingInSealsItAndRemovesTheFile) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const std::string recording = std::string(kMcapMagic) + std::string(200'000, 'r') + "a text in a recording";
  const auto scan = disk.AddScan(consent, recording);
  ASSERT_TRUE(scan) << WordsOf(scan);
  EXPECT_EQ(scan->id, "S-000001");
  EXPECT_FALSE(std::filesystem::exists(disk.disk.path() + "/spool.mcap"));
  const auto read = disk->ReadRecording(scan->id);
  ASSERT_TRUE(read) << WordsOf(read);
  EXPECT_EQ(TextFrom(*read), recording);
  const std::string stored = test::ReadBytes(disk.content(scan->recording));
  EXPECT_TRUE(LooksSealed(BytesFrom(stored)));
  EXPECT_EQ(*SealedKeyId(BytesFrom(stored), "it"), customer.id);
  EXPECT_THAT(stored, testing::Not(HasSubstr("a text in a recording")));
  EXPECT_THAT(*disk->ScansOf(customer.id), SizeIs(1));
  EXPECT_THAT(*disk->LatestScans(5), SizeIs(1));
  ASSERT_TRUE(disk->JudgeScan(scan->id, "good", R"({"coverage":0.98})"));
  EXPECT_EQ(disk->GetScan(scan->id)->verdict, "good");
  EXPECT_EQ(disk->GetScan(scan->id)->summary_json, R"({"coverage":0.98})");
  EXPECT_FALSE(disk->JudgeScan(scan->id, "splendid", ""));
}

TEST(Store, OpensASealedRecordingWithItsKeysAndKeepsItsFrames) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const test::TestKeys keys;
  const std::string path = disk.disk.path() + "/sealed.mcap.enc";
  {
    auto file = disk.posix.Create(path);
    ASSERT_TRUE(file);
    SealedFile sealed(std::move(*file), {"k1", keys.keys.at("k1"), RandomSealedFileId()});
    ASSERT_TRUE(sealed.Append(BytesFrom(std::string(kMcapMagic))));
    ASSERT_TRUE(sealed.Append(BytesFrom("level 1")));
    ASSERT_TRUE(sealed.Append(BytesFrom("level 2")));
  }
  ScanRow scan;
  scan.customer_id = customer.id;
  scan.consent_id = consent.id;
  EXPECT_FALSE(disk->AddScan(scan, path, nullptr));  // no keys
  EXPECT_TRUE(std::filesystem::exists(path));
  const auto added = disk->AddScan(scan, path, &keys);
  ASSERT_TRUE(added) << WordsOf(added);
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_EQ(TextFrom(*disk->ReadRecording(added->id)), std::string(kMcapMagic) + "level 1level 2");
}

TEST(Store, ScansOnlyWithAConsentOfThisCustomerThatIsInForce) {
  StoreOnDisk disk;
  disk.Open();
  const auto [a, consent_of_a] = disk.AddPerson("A");
  const auto [b, consent_of_b] = disk.AddPerson("B");
  Consent of_another = consent_of_a;
  of_another.customer_id = b.id;
  EXPECT_THAT(WordsOf(disk.AddScan(of_another, "r")), HasSubstr("not this customer's"));
  EXPECT_TRUE(std::filesystem::exists(disk.disk.path() + "/spool.mcap"));
  ASSERT_TRUE(disk->WithdrawConsent(consent_of_a.id));
  EXPECT_THAT(WordsOf(disk.AddScan(consent_of_a, "r")), HasSubstr("withdrawn"));
  EXPECT_TRUE(disk.AddScan(consent_of_b, "r"));
}

TEST(Store, TakesTheSameFileOfACustomerInOnce) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const auto first = disk.AddScan(consent, "the recording");
  const auto again = disk.AddScan(consent, "the recording");  // as after a kill before the file was removed
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->id, again->id);
  EXPECT_FALSE(std::filesystem::exists(disk.disk.path() + "/spool.mcap"));
  EXPECT_THAT(*disk->ScansOf(customer.id), SizeIs(1));
}

TEST(Store, ReplacesAnArtefactOfTheSameKindAndName) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const auto scan = disk.AddScan(consent, "r");
  const auto model = disk.PutArtefact(scan->id, "model", "model.json", "{1}");
  const auto design = disk.PutArtefact(scan->id, "design", "Hanako's first", "{d}");
  const auto again = disk.PutArtefact(scan->id, "model", "model.json", "{22}");
  ASSERT_TRUE(model && design && again);
  EXPECT_EQ(model->id, again->id);
  EXPECT_EQ(again->bytes, 4U);
  EXPECT_EQ(again->customer_id, customer.id);
  EXPECT_EQ(TextFrom(*disk->ReadArtefact(model->id)), "{22}");
  EXPECT_EQ(disk->GetArtefact(design->id)->name, "Hanako's first");
  EXPECT_THAT(*disk->ArtefactsOf(scan->id), SizeIs(2));
  EXPECT_THAT(test::FilesBelow(disk.options.folder + "/files"), SizeIs(3));  // recording, model, design
  ASSERT_TRUE(disk->RemoveArtefact(design->id));
  EXPECT_THAT(test::FilesBelow(disk.options.folder + "/files"), SizeIs(2));
  EXPECT_FALSE(disk->RemoveArtefact(design->id));
  EXPECT_FALSE(disk.PutArtefact("S-000009", "model", "model.json", ""));
  EXPECT_FALSE(disk.PutArtefact(scan->id, "Model!", "model.json", ""));
}

TEST(Store, DropsWhatIsDerivedAndKeepsWhatPeopleMade) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("A");
  const auto scan = disk.AddScan(consent, "r");
  ASSERT_TRUE(disk.PutArtefact(scan->id, "model", "model.json", "m"));
  Artefact design;
  design.scan_id = scan->id;
  design.kind = "design";
  design.derived = false;
  ASSERT_TRUE(disk->PutArtefact(design, BytesFrom("d")));
  ASSERT_TRUE(disk->DropDerived(scan->id));
  const auto left = disk->ArtefactsOf(scan->id);
  ASSERT_THAT(*left, SizeIs(1));
  EXPECT_EQ(left->front().kind, "design");
  EXPECT_FALSE(disk->DropDerived("S-000009"));
  EXPECT_TRUE(disk->DropDerived(""));
}

TEST(Store, KnowsWhoseTimeIsOver) {
  StoreOnDisk disk;
  disk.options.keep = std::chrono::hours(24);
  disk.Open();
  const auto [a, consent_of_a] = disk.AddPerson("A");
  disk.clock.SleepUntil(std::chrono::hours(1));
  const auto [b, consent_of_b] = disk.AddPerson("B");
  EXPECT_THAT(Names(disk->Expired()), IsEmpty());
  disk.clock.SleepUntil(std::chrono::hours(24) + std::chrono::seconds(1));
  EXPECT_THAT(Names(disk->Expired()), ElementsAre("A"));
  ASSERT_TRUE(disk->KeepUntil(a.id, a.keep_until + std::chrono::hours(24)));
  EXPECT_THAT(Names(disk->Expired()), IsEmpty());
  EXPECT_FALSE(disk->KeepUntil("K-000009", StoreTime(0)));
}

TEST(Store, KeepsCalibrationsAndSettings) {
  StoreOnDisk disk;
  disk.Open();
  const auto first = disk->AddCalibration("2026-11", "{1}");
  const auto second = disk->AddCalibration("2026-12", "{2}");
  ASSERT_TRUE(first && second);
  const auto list = disk->Calibrations();
  ASSERT_THAT(*list, SizeIs(2));
  EXPECT_EQ(list->front().name, "2026-12");
  EXPECT_EQ(list->front().bytes, 3U);
  EXPECT_EQ(*disk->ReadCalibration(*first), "{1}");
  EXPECT_FALSE(disk->ReadCalibration("L-000009"));
  EXPECT_EQ(*disk->Setting("language"), std::nullopt);
  ASSERT_TRUE(disk->SetSetting("language", "\"ja\""));
  ASSERT_TRUE(disk->SetSetting("language", "\"en\""));
  EXPECT_EQ(*disk->Setting("language"), "\"en\"");
}

TEST(Store, KeepsUsersWithTheirSecretsSealed) {
  StoreOnDisk disk;
  disk.Open();
  ASSERT_TRUE(disk->AddUser(UserOf("sato", StationRole::kOperator), "$argon2id$the-hash-of-sato"));
  EXPECT_FALSE(disk->AddUser(UserOf("sato", StationRole::kAdmin), "other"));
  EXPECT_FALSE(disk->AddUser(UserOf("sato san", StationRole::kAdmin), "other"));
  ASSERT_TRUE(disk->SetSecret("sato", "pin", "hash of the pin"));
  EXPECT_TRUE((*disk->GetUser("sato"))->has_pin);
  EXPECT_FALSE((*disk->GetUser("sato"))->has_totp);
  EXPECT_EQ(*disk->Secret("sato", "password"), "$argon2id$the-hash-of-sato");
  EXPECT_FALSE(disk->Secret("sato", "totp"));
  EXPECT_FALSE(disk->SetSecret("sato", "birthday", "x"));
  ASSERT_TRUE(disk->SetSecret("sato", "pin", ""));
  EXPECT_FALSE((*disk->GetUser("sato"))->has_pin);
  ASSERT_TRUE(disk->NoteLogin("sato"));
  EXPECT_TRUE((*disk->GetUser("sato"))->last_login);
  User changed = **disk->GetUser("sato");
  changed.enabled = false;
  changed.role = StationRole::kTechnician;
  ASSERT_TRUE(disk->ChangeUser(changed));
  disk.Open();
  EXPECT_FALSE((*disk->GetUser("sato"))->enabled);
  EXPECT_EQ((*disk->GetUser("sato"))->role, StationRole::kTechnician);
  EXPECT_THAT(*disk->Users(), SizeIs(1));
  EXPECT_EQ(*disk->GetUser("nobody"), std::nullopt);
  EXPECT_FALSE(disk->NoteLogin("nobody"));
  ASSERT_TRUE(disk->RemoveUser("sato"));
  EXPECT_FALSE(disk->Secret("sato", "password"));
  EXPECT_FALSE(disk->RemoveUser("sato"));
  disk.Close();
  EXPECT_THAT(test::FilesWith(disk.options.folder, "the-hash-of-sato"), IsEmpty());
}

TEST(Store, MakesFoldersAndKeysForItsOwnerOnly) {
  StoreOnDisk disk;
  disk.Open();
  struct stat info {};
  ASSERT_EQ(::stat(disk.options.folder.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0700U);
  ASSERT_EQ(::stat(disk.options.station_key_file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0600U);
}

TEST(Store, RefusesAnotherStationsKey) {
  StoreOnDisk disk;
  disk.Open();
  disk.AddPerson("A");
  disk.Close();
  test::WriteBytes(disk.options.station_key_file, "station-1 = " + std::string(64, '7') + "\n");
  EXPECT_THAT(WordsOf(disk.TryOpen()), HasSubstr("not the one that it was made with"));
  std::filesystem::remove(disk.options.station_key_file);
  EXPECT_FALSE(disk.TryOpen());  // and makes no new one for a store that has one
  EXPECT_FALSE(std::filesystem::exists(disk.options.station_key_file));
}

TEST(Store, NeedsAKeyFile) {
  StoreOnDisk disk;
  disk.options.make_key = false;
  EXPECT_FALSE(disk.TryOpen());
  disk.options.station_key_file.clear();
  EXPECT_THAT(WordsOf(disk.TryOpen()), HasSubstr("no key file"));
}

TEST(Store, KeepsNothingOfAPersonInPlainText) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("Marker-Name-Q7", "marker-contact-q7@example.jp");
  const auto scan = disk.AddScan(consent, "marker-in-recording-q7");
  ASSERT_TRUE(disk->JudgeScan(scan->id, "good", R"("marker-summary-q7")"));
  ASSERT_TRUE(disk.PutArtefact(scan->id, "design", "marker-title-q7", "marker-content-q7"));
  disk.Close();
  for (const char* marker :
       {"Marker-Name", "marker-contact", "marker-in-rec", "marker-summary", "marker-title", "marker-content"}) {
    EXPECT_THAT(test::FilesWith(disk.options.folder, marker), IsEmpty()) << marker;
  }
}

}  // namespace
}  // namespace annulus
