// Whatever the booth can say by a code, the page can say in both languages.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "acquisition/arm_check.h"
#include "acquisition/scan_quality.h"
#include "acquisition/scan_warning.h"
#include "base/storage.h"
#include "station/booth_messages.h"
#include "station/console/booth_words.h"
#include "station/console/scan_judgement.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

/// What stands behind `key: ` in the page's table, up to the next key; "" if it is not there.
std::string EntryOf(const std::string& table, const std::string& key) {
  const std::string begin = "\n  " + key + ": [";
  const std::size_t at = table.find(begin);
  if (at == std::string::npos) return "";
  return table.substr(at + begin.size(), table.find("],\n", at) - at - begin.size());
}

bool HasJapanese(const std::string& text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) >= 0xE3; });
}

/// Every code of a kind, by its number.
template <class Code>
std::vector<std::string> NamesOf(std::size_t count, const char* (*name)(Code)) {
  std::vector<std::string> names;
  for (std::size_t code = 0; code < count; ++code) names.emplace_back(name(static_cast<Code>(code)));
  return names;
}

class BoothCodes : public testing::Test {
 protected:
  void SetUp() override {
    PosixStorage storage;
    const auto text = ReadTextFile(storage, test::SourceFolder() + "/station/web/src/words/booth.ts");
    ASSERT_TRUE(text) << text.error().Text();
    table_ = *text;
  }
  void ExpectWords(const std::string& kind, const std::vector<std::string>& names, bool with_advice) {
    for (const std::string& name : names) {
      const std::string key = kind + "_" + name;
      EXPECT_TRUE(HasJapanese(EntryOf(table_, key))) << key << " has no words in words/booth.ts";
      if (with_advice) {
        EXPECT_TRUE(HasJapanese(EntryOf(table_, key + "_do"))) << key << "_do has none";
      }
    }
  }
  std::string table_;
};

TEST_F(BoothCodes, OfChecksBeforeAScanHaveWords) { ExpectWords("check", NamesOf(kArmCheckCodes, ArmCheckName), true); }

TEST_F(BoothCodes, OfWarningsHaveWords) { ExpectWords("warning", NamesOf(kWarningCodes, WarningName), false); }

TEST_F(BoothCodes, OfScanNoticesHaveWords) {
  ExpectWords("notice", NamesOf(kNoticeCodes, NoticeName), true);
  ExpectWords("notice", {kIncompleteNotice}, true);
}

TEST_F(BoothCodes, OfFaultsOfTheSafetyChainHaveWords) {
  ExpectWords("chain", NamesOf(kChainFaults, ChainFaultName), true);
}

TEST_F(BoothCodes, ThatAreNoneAreMissed) { EXPECT_EQ(EntryOf(table_, "check_no_such"), ""); }

TEST(BoothCodesOfCauses, HaveWordsInBothLanguages) {
  for (std::size_t code = 0; code < kCauseCodes; ++code) {
    const auto cause = static_cast<CauseCode>(code);
    const PlainWords english = WordsOfCause(cause, SheetLanguage::kEnglish);
    const PlainWords japanese = WordsOfCause(cause, SheetLanguage::kJapanese);
    EXPECT_FALSE(english.text.empty() || english.advice.empty()) << TraitsOf(cause).name;
    EXPECT_FALSE(HasJapanese(english.text)) << TraitsOf(cause).name;
    EXPECT_TRUE(HasJapanese(japanese.text) && HasJapanese(japanese.advice)) << TraitsOf(cause).name;
  }
}

}  // namespace
}  // namespace annulus
