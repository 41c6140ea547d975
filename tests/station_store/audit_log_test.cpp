#include "station/store/audit_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/station_store/raw_database.h"
#include "tests/station_store/store_folder.h"

namespace annulus {
namespace {

using test::RawDatabase;
using test::StoreOnDisk;
using test::WordsOf;
using testing::HasSubstr;
using testing::SizeIs;

AuditLine Line(const std::string& action) {
  AuditLine line;
  line.user = "sato";
  line.origin = "screen";
  line.action = action;
  line.subject = "S-000001";
  line.result = "ok";
  return line;
}

/// A closed store with `count` lines.
void FillAudit(StoreOnDisk& disk, int count) {
  disk.Open();
  for (int i = 1; i <= count; ++i) ASSERT_TRUE(disk->Audit(Line("start")));
  disk.Close();
}

TEST(AuditLog, NumbersAndChainsItsLines) {
  StoreOnDisk disk;
  FillAudit(disk, 3);
  disk.Open();
  const auto lines = disk->AuditLines(2, 10);
  ASSERT_TRUE(lines);
  ASSERT_THAT(*lines, SizeIs(2));
  EXPECT_EQ(lines->front().number, 2U);
  EXPECT_EQ(lines->front().user, "sato");
  const auto last = disk->VerifyAudit();
  ASSERT_TRUE(last) << WordsOf(last);
  EXPECT_EQ(*last, lines->back().hash);
}

TEST(AuditLog, HashesAsDocumented) {
  AuditLine line = Line("arm");
  line.number = 1;
  line.time = StoreTime(1000);
  line.monotonic_ns = 5;
  // python3 -c "import hashlib; f=['1','1000','5','sato','screen','arm','S-000001','ok'];
  //   print(hashlib.sha256(('0'*64+''.join('%d:%s'%(len(x),x) for x in f)).encode()).hexdigest())"
  EXPECT_EQ(AuditHash(std::string(64, '0'), line), "98c8e414ebdc6b5cb6059d4600162e67db78fa00abea3219c5e64940b91af767");
}

TEST(AuditLog, RefusesChangesThroughTheDatabase) {
  StoreOnDisk disk;
  FillAudit(disk, 3);
  RawDatabase raw(disk.database());
  EXPECT_THAT(raw.Try("UPDATE audit SET result = 'x' WHERE number = 2"), HasSubstr("not changed"));
  EXPECT_THAT(raw.Try("DELETE FROM audit WHERE number = 3"), HasSubstr("not deleted"));
  EXPECT_THAT(raw.Try("INSERT INTO audit SELECT 9, time_ms, 0, '', '', '', '', '', '' FROM audit LIMIT 1"),
              HasSubstr("without gaps"));
}

TEST(AuditLog, FindsTheFirstLineThatWasTamperedWith) {
  struct Tampering {
    const char* sql;
    const char* says;
  };
  const std::string unlocked =
      "DROP TRIGGER audit_is_not_changed; DROP TRIGGER audit_is_not_deleted; DROP TRIGGER audit_has_no_gaps;";
  for (const Tampering& tampering :
       {Tampering{"UPDATE audit SET subject = 'S-000002' WHERE number = 4", "line 4 was changed"},
        Tampering{"UPDATE audit SET time_ms = time_ms - 1 WHERE number = 1", "line 1 was changed"},
        Tampering{"DELETE FROM audit WHERE number = 5", "line 5 is missing"},
        Tampering{"DELETE FROM audit WHERE number = 1", "line 1 is missing"},
        Tampering{"DELETE FROM audit WHERE number > 6", "line 7 is missing"},
        Tampering{"DELETE FROM audit", "line 1 is missing"},
        Tampering{"DELETE FROM audit; DELETE FROM audit_head", "anchor"},
        Tampering{"UPDATE audit SET number = -number WHERE number IN (2, 3);"
                  "UPDATE audit SET number = 3 WHERE number = -2; UPDATE audit SET number = 2 WHERE number = -3",
                  "line 2 was changed"}}) {
    StoreOnDisk disk;
    FillAudit(disk, 4);
    disk.clock.SleepUntil(std::chrono::hours(24));  // an anchor with line 4
    FillAudit(disk, 4);
    {
      RawDatabase raw(disk.database());
      ASSERT_EQ(raw.Try(unlocked + tampering.sql), "");
    }
    disk.Open();
    EXPECT_THAT(WordsOf(disk->VerifyAudit()), HasSubstr(tampering.says)) << tampering.sql;
  }
}

TEST(AuditLog, KeepsAnAnchorForEveryDay) {
  StoreOnDisk disk;
  FillAudit(disk, 2);
  disk.clock.SleepUntil(std::chrono::hours(25));
  FillAudit(disk, 2);
  disk.Open();
  const auto lines = disk->AuditLines(1, 10);
  const std::string anchors = test::ReadBytes(disk.options.folder + "/audit-anchors.txt");
  EXPECT_EQ(anchors, "2000-01-01 0 " + std::string(64, '0') + "\n2000-01-02 2 " + lines->at(1).hash + "\n");
  EXPECT_TRUE(disk->VerifyAudit());
}

TEST(AuditLog, CutsLongTextsAtACharacter) {
  StoreOnDisk disk;
  disk.Open();
  AuditLine line = Line("login");
  for (int i = 0; i < 500; ++i) line.result += "あ";
  ASSERT_TRUE(disk->Audit(line));
  EXPECT_EQ(disk->AuditLines(1, 1)->front().result.size(), 998U);
  EXPECT_TRUE(disk->VerifyAudit());
}

}  // namespace
}  // namespace annulus
