#include "station/console/accounts.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/station_console/console_desk.h"

namespace annulus {
namespace {

using test::ConsoleDesk;
using test::kGoodPassword;

TEST(UserNames, AreShortAndPlain) {
  for (const char* good : {"a", "anna", "A.Tanaka-2_x"}) EXPECT_TRUE(IsUserName(good)) << good;
  for (const char* bad : {"", "a b", "../x", "anna\n", "浩", "a/b", "a'--"}) EXPECT_FALSE(IsUserName(bad)) << bad;
  EXPECT_FALSE(IsUserName(std::string(65, 'a')));
}

class AccountsTest : public testing::Test {
 protected:
  AccountsTest() { desk_.AddUser("root", StationRole::kAdmin); }
  User Get(const std::string& name) { return **desk_.store.GetUser(name); }

  ConsoleDesk desk_;
  Accounts& accounts_ = desk_.accounts;
};

TEST_F(AccountsTest, TheLastAdminCannotBeTakenAway) {
  desk_.AddUser("anna", StationRole::kOperator);
  EXPECT_FALSE(accounts_.Remove("root"));
  User root = Get("root");
  root.enabled = false;
  EXPECT_FALSE(accounts_.Change(root));
  root.enabled = true;
  root.role = StationRole::kTechnician;
  EXPECT_FALSE(accounts_.Change(root));
  desk_.AddUser("second", StationRole::kAdmin);
  EXPECT_TRUE(accounts_.Change(root));
  EXPECT_FALSE(accounts_.Remove("second"));
  EXPECT_TRUE(accounts_.Remove("anna"));
}

TEST_F(AccountsTest, AnAdminThatIsSwitchedOffIsNoneLeft) {
  User second;
  second.name = "second";
  second.role = StationRole::kAdmin;
  second.enabled = false;
  ASSERT_TRUE(desk_.store.AddUser(second, "x"));
  EXPECT_FALSE(accounts_.Remove("root"));
}

TEST_F(AccountsTest, NamesAreTakenOnce) {
  EXPECT_FALSE(accounts_.Add("root", StationRole::kOperator, "gravel-otter-plinth-27"));
  EXPECT_EQ(Get("root").role, StationRole::kAdmin);
}

TEST_F(AccountsTest, AnOperatorWhoBecomesATechnicianLosesThePin) {
  desk_.AddUser("anna", StationRole::kOperator);
  ASSERT_TRUE(accounts_.SetPin("anna", "493817"));
  User anna = Get("anna");
  EXPECT_TRUE(anna.has_pin);
  anna.role = StationRole::kTechnician;
  ASSERT_TRUE(accounts_.Change(anna));
  EXPECT_FALSE(Get("anna").has_pin);
}

TEST_F(AccountsTest, AnUnknownUserTakesAsLongAsAWrongPassword) {
  desk_.AddUser("anna", StationRole::kOperator);
  const auto time_of = [&](const std::string& user) {
    std::chrono::nanoseconds best = std::chrono::hours(1);
    for (int i = 0; i < 4; ++i) {
      const auto start = std::chrono::steady_clock::now();
      EXPECT_FALSE(accounts_.LogIn({user, "wrong", false, "", true, "::1"}));
      best = std::min<std::chrono::nanoseconds>(best, std::chrono::steady_clock::now() - start);
    }
    return std::chrono::duration<double>(best).count();
  };
  time_of("warm up");
  const double known = time_of("anna");
  const double unknown = time_of("nobody");
  // One Argon2id each; a machine that is busy otherwise may double either, no more on the best of four.
  EXPECT_LT(unknown, 3 * known);
  EXPECT_LT(known, 3 * unknown);
}

TEST_F(AccountsTest, ReachedFromAfarOnlyWithAnAdmin) {
  EXPECT_TRUE(*accounts_.HasAdmin());
  ConsoleDesk empty;
  EXPECT_FALSE(*empty.accounts.HasAdmin());
  empty.AddUser("anna", StationRole::kOperator);
  EXPECT_FALSE(*empty.accounts.HasAdmin());
}

}  // namespace
}  // namespace annulus
