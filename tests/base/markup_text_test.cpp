#include "base/markup_text.h"

#include <gtest/gtest.h>

namespace annulus {
namespace {

TEST(MarkupText, EscapesWhatMarkupMeansSomethingBy) {
  EXPECT_EQ(MarkupText("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
}

TEST(MarkupText, LeavesOtherScriptsAloneAndTakesControlCharactersOut) {
  EXPECT_EQ(MarkupText("胴囲\n\x7f§"), "胴囲  §");
}

}  // namespace
}  // namespace annulus
