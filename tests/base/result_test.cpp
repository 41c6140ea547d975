#include "base/result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/ensure.h"

namespace annulus {
namespace {

Result<int> Half(int value) {
  if (value % 2 != 0) return Fail("halve " + std::to_string(value), "it is odd", "give an even number");
  return value / 2;
}

Status HalveTwice(int value) {
  const Result<int> half = Half(value);
  RETURN_IF_ERROR(half);
  RETURN_IF_ERROR(Half(*half));
  return {};
}

TEST(Error, TextIsItsThreePartsInOrder) {
  const Error error{"read scan.csv", "line 7: range_mm is 'abc'", "give a number"};
  EXPECT_EQ(error.Text(), "read scan.csv: line 7: range_mm is 'abc': give a number");
}

TEST(Error, TextStaysOneLineWhateverTheFileNameHolds) {
  const Error error{"read a\nb\r\tc", std::string("it holds \0 and \x1b[31m and \x7f", 26), "look"};
  const std::string text = error.Text();
  for (const char c : text) EXPECT_GE(static_cast<unsigned char>(c), 0x20U);
  EXPECT_EQ(text.find('\x7f'), std::string::npos);
  EXPECT_THAT(text, testing::HasSubstr("a?b??c"));
}

TEST(Error, TextKeepsLettersBeyondAscii) {
  const Error error{"read Größe.csv", "長さ", "ü"};
  EXPECT_EQ(error.Text(), "read Größe.csv: 長さ: ü");
}

TEST(Result, HoldsAValueOrTheError) {
  EXPECT_EQ(Half(4).value(), 2);
  const Result<int> failed = Half(3);
  ASSERT_FALSE(failed.has_value());
  EXPECT_EQ(failed.error().attempted, "halve 3");
}

TEST(ReturnIfError, ForwardsTheFirstErrorAndOnlyErrors) {
  EXPECT_TRUE(HalveTwice(8).has_value());
  EXPECT_EQ(HalveTwice(6).error().attempted, "halve 3");
  EXPECT_EQ(HalveTwice(5).error().attempted, "halve 5");
}

TEST(Ensure, ThrowsWithFileLineConditionAndMessage) {
  const int line = __LINE__ + 2;
  try {
    ENSURE(1 + 1 == 3, "arithmetic works");
    FAIL() << "ENSURE of a false condition returned";
  } catch (const LogicError& error) {
    const std::string text = error.what();
    EXPECT_THAT(text, testing::HasSubstr("result_test.cpp:" + std::to_string(line)));
    EXPECT_THAT(text, testing::HasSubstr("1 + 1 == 3"));
    EXPECT_THAT(text, testing::HasSubstr("arithmetic works"));
  }
}

TEST(Ensure, NamesTheFileWithoutTheFolderItWasBuiltIn) {
  try {
    ENSURE(false, "never");
    FAIL() << "ENSURE of a false condition returned";
  } catch (const LogicError& error) {
    EXPECT_EQ(std::string(error.what()).find('/'), std::string::npos);
  }
}

TEST(Ensure, EvaluatesItsConditionOnceAndItsMessageOnlyOnFailure) {
  int conditions = 0;
  int messages = 0;
  const auto message = [&messages] {
    ++messages;
    return std::string("unused");
  };
  ENSURE(++conditions == 1, message());
  EXPECT_EQ(conditions, 1);
  EXPECT_EQ(messages, 0);
}

}  // namespace
}  // namespace annulus
