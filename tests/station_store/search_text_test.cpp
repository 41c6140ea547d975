#include "station/store/search_text.h"

#include <gtest/gtest.h>

namespace annulus {
namespace {

// Expected values: python3 -c "import unicodedata; print(unicodedata.normalize('NFKC', 'ﾊﾟﾋﾟﾌﾞ ｱｰ｡ Ａｂ１　').lower())"
TEST(SearchText, SetsWidthAsideAsNfkcDoes) {
  EXPECT_EQ(SearchForm("ﾊﾟﾋﾟﾌﾞ ｱｰ｡ Ａｂ１　"), "パピブ アー。 ab1 ");
  EXPECT_EQ(SearchForm("ｶﾞｷﾞｸﾞｹﾞｺﾞｻﾞｼﾞｽﾞｾﾞｿﾞﾀﾞﾁﾞﾂﾞﾃﾞﾄﾞﾊﾞﾋﾞﾌﾞﾍﾞﾎﾞｳﾞﾜﾞｦﾞ"),
            "ガギグゲゴザジズゼゾダヂヅデドバビブベボヴヷヺ");
  EXPECT_EQ(SearchForm("ﾊﾟﾋﾟﾌﾟﾍﾟﾎﾟ"), "パピプペポ");
  EXPECT_EQ(SearchForm("か\u3099は\u309A"), "がぱ");
  EXPECT_EQ(SearchForm("ｱﾞ"), "ア\u3099");  // there is no such kana
  EXPECT_EQ(SearchForm("ﾅﾞﾏﾟ"), "ナ\u3099マ\u309A");
  EXPECT_EQ(SearchForm("ッ\u3099"), "ッ\u3099");
}

// unicodedata as above, with .lower()
TEST(SearchText, SetsLetterCaseAside) {
  EXPECT_EQ(SearchForm("ÀÉÎÕÜ×ÞŁŽŸĀ"), "àéîõü×þłžÿā");
  EXPECT_EQ(SearchForm("ΑΒΩ АЯЁ"), "αβω аяё");
  EXPECT_EQ(SearchForm("山田 花子 𠮷"), "山田 花子 𠮷");
}

TEST(SearchText, TellsWellFormedUtf8) {
  for (const char* good : {"", "a", "é", "山", "𠮷", "\xF4\x8F\xBF\xBF"}) EXPECT_TRUE(IsUtf8(good)) << good;
  for (const char* bad : {"\x80", "\xC0\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                          "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xE3\x81", "a\xFF"}) {
    EXPECT_FALSE(IsUtf8(bad));
  }
  EXPECT_FALSE(IsUtf8(std::string_view("a\0b", 3)));
  EXPECT_EQ(SearchForm("a\xFF"), "a\xFF");
}

}  // namespace
}  // namespace annulus
