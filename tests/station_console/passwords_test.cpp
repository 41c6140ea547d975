#include "station/console/passwords.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "station/console/common_passwords.h"

namespace annulus {
namespace {

TEST(Passwords, AreKeptAsArgon2idOfEnoughMemoryAndPasses) {
  const auto hash = HashPassword("tidal crumbs vexed orbit");
  ASSERT_TRUE(hash);
  // The encoding of RFC 9106's reference code: m in KiB. OWASP's least is m=19456, t=2, p=1.
  EXPECT_TRUE(hash->starts_with("$argon2id$v=19$m=65536,t=2,p=1$")) << *hash;
}

TEST(Passwords, TheSameOneIsNeverHashedToTheSameTwice) {
  EXPECT_NE(*HashPassword("tidal crumbs vexed orbit"), *HashPassword("tidal crumbs vexed orbit"));
}

TEST(Passwords, OnlyTheRightOneFits) {
  const std::string hash = *HashPassword("tidal crumbs vexed orbit");
  EXPECT_TRUE(VerifyPassword(hash, "tidal crumbs vexed orbit"));
  EXPECT_FALSE(VerifyPassword(hash, "tidal crumbs vexed orbi"));
  EXPECT_FALSE(VerifyPassword(hash, "Tidal crumbs vexed orbit"));
  EXPECT_FALSE(VerifyPassword(hash, ""));
  EXPECT_FALSE(VerifyPassword(hash, std::string(300, 'a')));
}

TEST(Passwords, NothingFitsAHashThatIsNotThere) {
  EXPECT_FALSE(VerifyPassword("", ""));
  EXPECT_FALSE(VerifyPassword("", "tidal crumbs vexed orbit"));
  EXPECT_FALSE(VerifyPassword("$argon2id$", "x"));
  EXPECT_FALSE(VerifyPassword("tidal crumbs vexed orbit", "tidal crumbs vexed orbit"));
}

TEST(Passwords, NewOnesHaveTwelveCharactersNotBytes) {
  EXPECT_FALSE(CheckNewPassword("fjordbank24", "anna"));
  EXPECT_TRUE(CheckNewPassword("fjord bank 24", "anna"));
  EXPECT_FALSE(CheckNewPassword("鯨が飛ぶ夜", "anna"));                 // 5 characters, 15 bytes
  EXPECT_TRUE(CheckNewPassword("鯨が飛ぶ夜の図書館で眠る猫", "anna"));  // 13 characters
  EXPECT_FALSE(CheckNewPassword(std::string(257, 'x') + "y", "anna"));
}

TEST(Passwords, NewOnesAreText) {
  EXPECT_FALSE(CheckNewPassword("fjord bank\x01 glyphs vex", "anna"));
  EXPECT_FALSE(CheckNewPassword("fjord bank\xC3 glyphs vex", "anna"));
  EXPECT_FALSE(CheckNewPassword("fjord bank\xFF glyphs vex", "anna"));
}

TEST(Passwords, CommonOnesAreRefused) {
  for (const char* common :
       {"password1234", "Password2024!", "P4$$w0rd!!!!", "qwertyuiop12", "aaaaaaaaaaaa", "abcabcabcabc", "123456789012",
        "letmeinplease", "Summer2024!!", "correcthorsebatterystaple", "adminadmin12", "iloveyou12345", "1qaz2wsx3edc",
        "zaq12wsxcde3", "Welcome12345", "annulus-station", "098765432109", "sakura-sakura-1"}) {
    EXPECT_TRUE(IsCommonPassword(common, "anna")) << common;
    EXPECT_FALSE(CheckNewPassword(common, "anna")) << common;
  }
}

TEST(Passwords, TheUsersOwnNameIsCommon) {
  EXPECT_FALSE(IsCommonPassword("brzeczyszcz1987", "anna"));
  EXPECT_TRUE(IsCommonPassword("brzeczyszcz1987", "brzeczyszcz"));
}

TEST(Passwords, UncommonOnesAreTaken) {
  for (const char* good : {"tidal crumbs vexed orbit", "gravel-otter-plinth-27", "my cat eats the green apple today",
                           "nevermind the bollocks 77", "Tr0ub4dor&3xy"}) {
    EXPECT_FALSE(IsCommonPassword(good, "anna")) << good;
  }
}

TEST(Passwords, RandomOnesDifferAndAreTaken) {
  std::set<std::string> seen;
  for (int i = 0; i < 100; ++i) {
    const std::string password = RandomPassword();
    EXPECT_TRUE(CheckNewPassword(password, "operator")) << password;
    seen.insert(password);
  }
  EXPECT_EQ(seen.size(), 100U);
}

TEST(Pins, AreSixToTwelveDigitsWithoutAnOrder) {
  EXPECT_TRUE(CheckNewPin("493817"));
  EXPECT_TRUE(CheckNewPin("493817250364"));
  for (const char* bad : {"", "49381", "4938172503641", "49381a", "000000", "123456", "654321", "890123", "121212",
                          "123123", "48 391", "4-9381"}) {
    EXPECT_FALSE(CheckNewPin(bad)) << bad;
  }
}

}  // namespace
}  // namespace annulus
