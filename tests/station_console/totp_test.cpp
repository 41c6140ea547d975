#include "station/console/totp.h"

#include <gtest/gtest.h>

#include <string>

namespace annulus {
namespace {

using std::chrono::seconds;

const std::string kRfcKey = "12345678901234567890";  // RFC 6238, appendix B, for SHA-1

TEST(Totp, GivesTheCodesOfRfc6238) {
  // Appendix B: time in seconds and the code of 8 digits for SHA-1.
  const std::pair<std::uint64_t, const char*> vectors[] = {{59, "94287082"},         {1111111109, "07081804"},
                                                           {1111111111, "14050471"}, {1234567890, "89005924"},
                                                           {2000000000, "69279037"}, {20000000000, "65353130"}};
  for (const auto& [time, code] : vectors) EXPECT_EQ(TotpCode(kRfcKey, time / 30, 8), code) << time;
}

TEST(Totp, GivesTheCodesOfRfc4226) {
  // Appendix D: counters 0 to 9 with 6 digits.
  const char* codes[] = {"755224", "287082", "359152", "969429", "338314",
                         "254676", "287922", "162583", "399871", "520489"};
  for (std::uint64_t counter = 0; counter < 10; ++counter) EXPECT_EQ(TotpCode(kRfcKey, counter), codes[counter]);
}

TEST(Totp, TakesTheCodeOfNowAndOfOneStepEitherWay) {
  const TotpSecret secret{kRfcKey, 0};
  const seconds now{30 * 5};
  for (std::uint64_t step = 0; step < 10; ++step) {
    const auto found = VerifyTotp(secret, TotpCode(kRfcKey, step), now);
    EXPECT_EQ(found.has_value(), step >= 4 && step <= 6) << step;
    EXPECT_EQ(found.value_or(step), step);
  }
}

TEST(Totp, TakesNoCodeTwiceNorAnOlderOne) {
  const seconds now{30 * 5};
  EXPECT_FALSE(VerifyTotp({kRfcKey, 5}, TotpCode(kRfcKey, 5), now));
  EXPECT_FALSE(VerifyTotp({kRfcKey, 5}, TotpCode(kRfcKey, 4), now));
  EXPECT_TRUE(VerifyTotp({kRfcKey, 5}, TotpCode(kRfcKey, 6), now));
}

TEST(Totp, TakesNothingElse) {
  const TotpSecret secret{kRfcKey, 0};
  for (const char* code : {"", "25467", "2546766", "254677", "abcdef", "      "}) {
    EXPECT_FALSE(VerifyTotp(secret, code, seconds(30 * 5))) << code;
  }
}

TEST(Totp, SecretsComeBackFromTheirText) {
  TotpSecret secret{kRfcKey, 77};
  // Base32 of the key by Python's base64.b32encode.
  EXPECT_EQ(secret.Text(), "GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ 77");
  const auto back = TotpSecret::Parse(secret.Text());
  ASSERT_TRUE(back);
  EXPECT_EQ(back->key, kRfcKey);
  EXPECT_EQ(back->last_step, 77U);
  for (const char* bad : {"", "GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ", "GEZD 1", "GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJ1 7",
                          "GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ 7x"}) {
    EXPECT_FALSE(TotpSecret::Parse(bad)) << bad;
  }
}

TEST(Totp, AuthenticatorsGetAUri) {
  EXPECT_EQ((TotpSecret{kRfcKey, 0}.Uri("anna")),
            "otpauth://totp/annulus:anna?secret=GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ&issuer=annulus");
}

TEST(Totp, RandomSecretsDiffer) { EXPECT_NE(TotpSecret::Random().key, TotpSecret::Random().key); }

}  // namespace
}  // namespace annulus
