#include "station/console/retention.h"

#include <gmock/gmock.h>

#include "station/console/model_cache.h"
#include "tests/station_store/store_folder.h"

namespace annulus {
namespace {

using std::chrono::hours;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr hours kDay{24};

/// A store that keeps people for 90 days, on the virtual clock, and its retention.
class RetentionTest : public testing::Test {
 protected:
  RetentionTest()
      : models_(ModelCache::Make([](const std::string&) { return Fail("open a model", "there is none", "fit one"); })) {
    disk_.Open();
    retention_ = std::make_unique<Retention>(*disk_, *models_, disk_.clock);
  }
  void GoTo(hours time) { disk_.clock.SleepUntil(time); }
  std::vector<std::string> Customers() {
    std::vector<std::string> ids;
    const auto found = disk_->FindCustomers("", 100);
    for (const Customer& customer : found.value()) ids.push_back(customer.id);
    return ids;
  }
  /// What the program wrote of `action` into the audit: "subject result".
  std::vector<std::string> Audited(const std::string& action) {
    std::vector<std::string> lines;
    const auto written = disk_->AuditLines(1, 1000);
    for (const AuditLine& line : written.value()) {
      if (line.action == action && line.origin == "program") lines.push_back(line.subject + " " + line.result);
    }
    return lines;
  }

  test::StoreOnDisk disk_;
  std::unique_ptr<ModelCache> models_;
  std::unique_ptr<Retention> retention_;
};

TEST_F(RetentionTest, IsDueAtTheStartAndThenOnceADay) {
  EXPECT_TRUE(retention_->IsDue());
  EXPECT_FALSE(retention_->IsDue());
  GoTo(hours(23));
  EXPECT_FALSE(retention_->IsDue());
  GoTo(hours(24));
  EXPECT_TRUE(retention_->IsDue());
  EXPECT_FALSE(retention_->IsDue());
}

TEST_F(RetentionTest, ErasesByItselfWhoseTimeIsOverAndNobodyElse) {
  const auto first = disk_.AddPerson("first").first.id;
  GoTo(30 * kDay);
  ASSERT_TRUE(retention_->ApplyByItself());
  const auto second = disk_.AddPerson("second").first.id;
  GoTo(60 * kDay);
  ASSERT_THAT(retention_->ApplyByItself().value(), IsEmpty());
  GoTo(91 * kDay);
  const auto proofs = retention_->ApplyByItself();
  ASSERT_THAT(proofs.value(), SizeIs(1));
  EXPECT_EQ(proofs->front().customer_id, first);
  EXPECT_TRUE(proofs->front().key_destroyed);
  EXPECT_THAT(Customers(), ElementsAre(second));
  EXPECT_THAT(Audited("erase"), ElementsAre(first + " ok"));
}

TEST_F(RetentionTest, IsHeldWhenTheClockHasJumpedUntilAnAdminAppliesIt) {
  disk_.AddPerson("somebody");
  ASSERT_TRUE(retention_->ApplyByItself());
  GoTo(91 * kDay);
  EXPECT_TRUE(retention_->IsHeld().value());
  EXPECT_THAT(retention_->ApplyByItself().value(), IsEmpty());
  EXPECT_THAT(Customers(), SizeIs(1));
  EXPECT_THAT(Audited("apply retention"), SizeIs(1));
  std::vector<std::string> told;
  ASSERT_TRUE(
      retention_->Apply([&](const std::string& id, const std::string& result) { told.push_back(id + result); }));
  EXPECT_THAT(told, SizeIs(1));
  EXPECT_THAT(Customers(), IsEmpty());
  EXPECT_FALSE(retention_->IsHeld().value());
  EXPECT_EQ(retention_->LastApplied().value(), std::chrono::floor<StoreTime>(disk_.clock.WallNow()));
}

TEST_F(RetentionTest, IsNotHeldAfterALongPauseIfNobodysTimeIsOver) {
  ASSERT_TRUE(retention_->ApplyByItself());
  GoTo(40 * kDay);
  disk_.AddPerson("somebody");
  EXPECT_FALSE(retention_->IsHeld().value());
  ASSERT_TRUE(retention_->ApplyByItself());
  EXPECT_EQ(retention_->LastApplied().value(), std::chrono::floor<StoreTime>(disk_.clock.WallNow()));
}

TEST_F(RetentionTest, TakesTheDaysThatAnAdminHasSetForWhoComesThen) {
  const auto before = disk_.AddPerson("before").first;
  ASSERT_TRUE(disk_->SetSetting(kRetentionSetting, "7"));
  EXPECT_EQ(RetentionDays(*disk_, {}), 7);
  const auto after = disk_.AddPerson("after").first;
  EXPECT_EQ(after.keep_until - after.created, 7 * kDay);
  EXPECT_EQ(disk_->GetCustomer(before.id)->keep_until - before.created, 90 * kDay);
}

TEST_F(RetentionTest, StartsAnewForWhoComesAgainOrAgreesToMore) {
  const auto [customer, consent] = disk_.AddPerson("somebody");
  GoTo(89 * kDay);
  ASSERT_TRUE(disk_.AddScan(consent, "a recording"));
  EXPECT_EQ(disk_->GetCustomer(customer.id)->keep_until - customer.created, (89 + 90) * kDay);
  GoTo(100 * kDay);
  Consent more = consent;
  ASSERT_TRUE(disk_->AddConsent(more));
  EXPECT_EQ(disk_->GetCustomer(customer.id)->keep_until - customer.created, (100 + 90) * kDay);
  ASSERT_TRUE(disk_->KeepUntil(customer.id, customer.created + 1000 * kDay));  // an admin's word is not cut short
  ASSERT_TRUE(disk_->AddConsent(more));
  EXPECT_EQ(disk_->GetCustomer(customer.id)->keep_until - customer.created, 1000 * kDay);
}

}  // namespace
}  // namespace annulus
