#include "station/console/booth_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

namespace annulus {
namespace {

constexpr std::array kLanguages{SheetLanguage::kEnglish, SheetLanguage::kJapanese};

bool HasJapanese(const std::string& text) {
  // Hiragana, katakana and the common ideographs are three bytes beginning with E3 … E9.
  return std::any_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0xE3 && byte <= 0xE9;
  });
}

StatusMessage In(ScanState state) {
  StatusMessage message;
  message.scanner.state = state;
  return message;
}

PlainBooth Describe(const StatusMessage& status, bool pressed = false) {
  return DescribeBooth({&status, "", pressed}, SheetLanguage::kEnglish);
}

const PlainStep& Step(const PlainBooth& plain, const std::string& id) {
  static const PlainStep kNone;
  for (const PlainStep& step : plain.steps) {
    if (step.id == id) return step;
  }
  ADD_FAILURE() << "no step " << id;
  return kNone;
}

TEST(BoothWords, HaveTextAndAdviceForEveryCauseInBothLanguages) {
  std::set<std::string> texts;
  for (std::size_t code = 0; code < kCauseCodes; ++code) {
    for (const SheetLanguage language : kLanguages) {
      const PlainWords words = WordsOfCause(static_cast<CauseCode>(code), language);
      EXPECT_GT(words.text.size(), 10U) << TraitsOf(static_cast<CauseCode>(code)).name;
      EXPECT_GT(words.advice.size(), 10U) << TraitsOf(static_cast<CauseCode>(code)).name;
      const bool japanese = language == SheetLanguage::kJapanese;
      EXPECT_EQ(HasJapanese(words.text), japanese) << words.text;
      EXPECT_EQ(HasJapanese(words.advice), japanese) << words.advice;
      EXPECT_TRUE(texts.insert(words.text).second) << "twice: " << words.text;
    }
  }
}

TEST(BoothWords, SendWhoMayNotAcknowledgeToTheTechnician) {
  for (std::size_t code = 0; code < kCauseCodes; ++code) {
    if (TraitsOf(static_cast<CauseCode>(code)).role != CauseRole::kService) continue;
    EXPECT_THAT(WordsOfCause(static_cast<CauseCode>(code), SheetLanguage::kEnglish).advice,
                testing::HasSubstr("technician"));
    EXPECT_THAT(WordsOfCause(static_cast<CauseCode>(code), SheetLanguage::kJapanese).advice,
                testing::HasSubstr("技術者"));
  }
}

TEST(BoothWords, HaveATextForEveryState) {
  for (std::size_t state = 0; state < kScanStates; ++state) {
    EXPECT_FALSE(HasJapanese(WordsOfState(static_cast<ScanState>(state), SheetLanguage::kEnglish)));
    EXPECT_TRUE(HasJapanese(WordsOfState(static_cast<ScanState>(state), SheetLanguage::kJapanese)));
  }
}

TEST(BoothWords, AskForTheResetAfterPowerUp) {
  StatusMessage status = In(ScanState::kSafe);
  status.scanner.held_by = "no reset since the program started";
  const PlainBooth plain = Describe(status);
  EXPECT_FALSE(plain.ready);
  EXPECT_TRUE(Step(plain, "chain").ok);
  EXPECT_FALSE(Step(plain, "reset").ok);
  EXPECT_THAT(Step(plain, "reset").words.advice, testing::HasSubstr("reset button"));
}

TEST(BoothWords, NameWhatOpenedTheChain) {
  StatusMessage status = In(ScanState::kSafe);
  status.scanner.held_by = "open: estop_a, estop_b, door";
  const PlainBooth plain = Describe(status);
  EXPECT_FALSE(Step(plain, "chain").ok);
  EXPECT_EQ(Step(plain, "chain").words.text, "The emergency stop was pressed. The door was opened.");
}

TEST(BoothWords, LeadFromHomeToTheStartKey) {
  StatusMessage status = In(ScanState::kIdle);
  EXPECT_FALSE(Describe(status).ready);
  EXPECT_FALSE(Step(Describe(status), "home").ok);
  status.scanner.homed = true;
  EXPECT_TRUE(Describe(status).ready);
  EXPECT_FALSE(Step(Describe(status), "stand").ok);
  status.scanner.state = ScanState::kArmed;
  EXPECT_TRUE(Step(Describe(status), "stand").ok);
  EXPECT_FALSE(Step(Describe(status), "key").ok);
  EXPECT_TRUE(Step(Describe(status, true), "key").ok);
}

TEST(BoothWords, ShowWhatAnOrderToArmHasFound) {
  StatusMessage status = In(ScanState::kIdle);
  status.scanner.homed = true;
  ArmReport arm;
  arm.checks.push_back({"ring", Fail("prove the ring", "board 1003 does not answer", "look at its plug")});
  arm.checks.push_back({"disk", {}});
  arm.checks.push_back({"calibration", Fail("arm", "it has expired", "calibrate")});
  status.scanner.arm = arm;
  const PlainBooth plain = Describe(status);
  EXPECT_FALSE(Step(plain, "sensors").ok);
  EXPECT_THAT(Step(plain, "sensors").words.text, testing::HasSubstr("board 1003"));
  EXPECT_TRUE(Step(plain, "disk").ok);
  EXPECT_FALSE(Step(plain, "calibration").ok);
  EXPECT_TRUE(plain.ready) << "only the next attempt can tell whether it is mended";
}

TEST(BoothWords, ShowCausesWithTheTechnicalText) {
  StatusMessage status = In(ScanState::kFault);
  status.scanner.causes = {{CauseCode::kSensorsDead, "sensors 3, 4 see nothing", "clean them", {}},
                           {CauseCode::kBrakeSlip, "it sinks", "", {}}};
  const PlainBooth plain = Describe(status);
  EXPECT_FALSE(plain.ready);
  EXPECT_FALSE(Step(plain, "fault").ok);
  EXPECT_FALSE(Step(plain, "sensors").ok);
  ASSERT_EQ(plain.causes.size(), 2U);
  EXPECT_EQ(plain.causes[0].code, "sensors_dead");
  EXPECT_FALSE(plain.causes[0].service);
  EXPECT_TRUE(plain.causes[1].service);
  EXPECT_THAT(plain.causes[0].seen, testing::HasSubstr("sensors 3, 4"));
}

TEST(BoothWords, SayWhatToDoWhileTheBoothIsAway) {
  for (const SheetLanguage language : kLanguages) {
    const PlainBooth plain = DescribeBooth({nullptr, "it closed the connection", false}, language);
    EXPECT_FALSE(plain.ready);
    EXPECT_FALSE(plain.lost_text.empty());
    EXPECT_TRUE(plain.steps.empty());
  }
}

TEST(BoothWords, HaveAdviceForEveryStepThatIsNotSo) {
  for (const SheetLanguage language : kLanguages) {
    StatusMessage status = In(ScanState::kSafe);
    status.scanner.held_by = "open: door";
    const PlainBooth plain = DescribeBooth({&status, "", false}, language);
    EXPECT_EQ(plain.steps.size(), 9U);
    for (const PlainStep& step : plain.steps) {
      EXPECT_FALSE(step.words.text.empty()) << step.id;
      EXPECT_EQ(step.words.advice.empty(), step.ok) << step.id;
      EXPECT_EQ(HasJapanese(step.words.text), language == SheetLanguage::kJapanese) << step.words.text;
    }
  }
}

}  // namespace
}  // namespace annulus
