#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/station_store/raw_database.h"
#include "tests/station_store/store_folder.h"

namespace annulus {
namespace {

using test::StoreOnDisk;
using test::TextFrom;
using test::WordsOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// A place to restore to, with the key of another store.
struct Restored : StoreOnDisk {
  explicit Restored(const StoreOnDisk& from) {
    options.station_key_file = from.options.station_key_file;
    options.make_key = false;
  }
};

TEST(Backup, BringsEverythingBack) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("Hanako", "h@example.jp");
  const auto scan = disk.AddScan(consent, "a recording");
  const auto model = disk.PutArtefact(scan->id, "model", "model.json", "{m}");
  User user;
  user.name = "sato";
  user.role = StationRole::kOperator;
  ASSERT_TRUE(disk->AddUser(user, "hash"));
  AuditLine line;
  line.action = "login";
  ASSERT_TRUE(disk->Audit(line));
  ASSERT_TRUE(disk->SetSetting("a", "1"));
  const auto backup = disk->Backup("");
  ASSERT_TRUE(backup) << WordsOf(backup);
  disk.AddPerson("after the backup");
  disk.Close();
  Restored again(disk);
  const auto left_out = RestoreStore(again.options, *backup, *backup + "-keys", again.posix, again.clock);
  ASSERT_TRUE(left_out) << WordsOf(left_out);
  EXPECT_THAT(*left_out, IsEmpty());
  again.Open();
  EXPECT_EQ(again->state(), StoreState::kReady);
  EXPECT_EQ(again->GetCustomer(customer.id)->contact, "h@example.jp");
  EXPECT_THAT(again->FindCustomers("", 10).value(), SizeIs(1));
  EXPECT_EQ(TextFrom(again->ReadRecording(scan->id).value()), "a recording");
  EXPECT_EQ(TextFrom(again->ReadArtefact(model->id).value()), "{m}");
  EXPECT_EQ(again->Secret("sato", "password").value(), "hash");
  EXPECT_TRUE(again->VerifyAudit());
  EXPECT_EQ(again->Setting("a").value(), "1");
}

TEST(Backup, OpensNothingWithoutItsKeys) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("Hanako");
  ASSERT_TRUE(disk.AddScan(consent, "a recording"));
  const auto backup = disk->Backup(disk.disk.path() + "/usb");
  disk.Close();
  test::WriteBytes(*backup + "-keys", "# none\n");
  Restored again(disk);
  EXPECT_THAT(RestoreStore(again.options, *backup, *backup + "-keys", again.posix, again.clock).value(),
              testing::ElementsAre(customer.id));
  EXPECT_THAT(test::FilesBelow(again.options.folder + "/files"), IsEmpty());
}

TEST(Backup, IsRefusedWithAnotherStationsKeyAndLeavesNothingBehind) {
  StoreOnDisk disk;
  disk.Open();
  disk.AddPerson("Hanako");
  const auto backup = disk->Backup("");
  StoreOnDisk other;
  other.Open();
  other.Close();
  std::filesystem::remove_all(other.options.folder);
  EXPECT_THAT(WordsOf(RestoreStore(other.options, *backup, *backup + "-keys", other.posix, other.clock)),
              HasSubstr("not the one that it was made with"));
  EXPECT_FALSE(std::filesystem::exists(other.options.folder));
  EXPECT_FALSE(std::filesystem::exists(other.options.folder + ".restoring"));
}

TEST(Backup, IsNotRestoredOverAStore) {
  StoreOnDisk disk;
  disk.Open();
  const auto backup = disk->Backup("");
  EXPECT_THAT(WordsOf(RestoreStore(disk.options, *backup, *backup + "-keys", disk.posix, disk.clock)),
              HasSubstr("already"));
}

TEST(Backup, TellsOfADamagedOne) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("Hanako");
  const auto scan = disk.AddScan(consent, "a recording");
  const auto backup = disk->Backup("");
  const std::string file = *backup + "/files/" + scan->recording.substr(0, 2) + "/" + scan->recording;
  std::string bytes = test::ReadBytes(file);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  test::WriteBytes(file, bytes);
  Restored again(disk);
  ASSERT_TRUE(RestoreStore(again.options, *backup, *backup + "-keys", again.posix, again.clock));
  again.Open();
  EXPECT_TRUE(again->GetScan(scan->id)->recording_missing);  // the rest is there
}

TEST(Backup, KeysAreDestroyedAfterTheirTime) {
  StoreOnDisk disk;
  disk.Open();
  disk.AddPerson("Hanako");
  const auto backup = disk->Backup("");
  disk.clock.SleepUntil(std::chrono::hours(24 * 29));
  disk.Open();
  EXPECT_TRUE(std::filesystem::exists(*backup + "-keys"));
  disk.clock.SleepUntil(std::chrono::hours(24 * 31));
  AuditLine line;
  ASSERT_TRUE(disk->Audit(line));  // the first of a day looks after it, so that a program that runs for months does
  EXPECT_FALSE(std::filesystem::exists(*backup + "-keys"));
  EXPECT_TRUE(std::filesystem::exists(*backup));
}

TEST(Backup, MayBeMadeTwiceInASecond) {
  StoreOnDisk disk;
  disk.Open();
  const auto first = disk->Backup("");
  const auto second = disk->Backup("");
  ASSERT_TRUE(first && second);
  EXPECT_NE(*first, *second);
}

TEST(Backup, RemovesOneThatWasCutShort) {
  StoreOnDisk disk;
  disk.Open();
  const std::string place = disk.disk.path() + "/usb";
  const std::string abandoned = place + "/annulus-backup-2000-01-01-000000";
  std::filesystem::create_directories(abandoned + ".part/files");
  test::WriteBytes(abandoned + ".part/unfinished", "");
  test::WriteBytes(abandoned + "-keys", "# none\n");
  test::WriteBytes(place + "/somebody-elses.part", "");
  const auto backup = disk->Backup(place);
  ASSERT_TRUE(backup) << WordsOf(backup);
  EXPECT_FALSE(std::filesystem::exists(abandoned + ".part"));
  EXPECT_TRUE(std::filesystem::exists(place + "/somebody-elses.part"));
  EXPECT_FALSE(std::filesystem::exists(*backup + ".part"));
  EXPECT_FALSE(std::filesystem::exists(*backup + "/unfinished"));
}

TEST(Backup, LeavesOneAloneThatIsBeingWritten) {
  StoreOnDisk disk;
  disk.Open();
  const std::string other = disk.disk.path() + "/usb/annulus-backup-1999-12-31-235959.part";
  std::filesystem::create_directories(other);
  const auto mark = disk.posix.Create(other + "/unfinished");
  ASSERT_TRUE(mark);
  ASSERT_TRUE(disk->Backup(disk.disk.path() + "/usb"));
  EXPECT_TRUE(std::filesystem::exists(other));
}

TEST(Backup, LeavesNothingBehindWhenItFails) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("Hanako");
  const auto scan = disk.AddScan(consent, "a recording");
  const std::string place = disk.disk.path() + "/usb";
  // A folder in the place of a file that is copied last makes it fail when keys and files are there already.
  std::filesystem::create_directories(disk.options.folder + "/audit-anchors.txt");
  EXPECT_FALSE(disk->Backup(place));
  EXPECT_TRUE(std::filesystem::is_empty(place));
}

TEST(Backup, LeavesOutAFileThatIsMissing) {
  StoreOnDisk disk;
  disk.Open();
  const auto [customer, consent] = disk.AddPerson("Hanako");
  const auto scan = disk.AddScan(consent, "a recording");
  std::filesystem::remove(disk.content(scan->recording));
  EXPECT_TRUE(disk->Backup(""));
}

}  // namespace
}  // namespace annulus
