#include "firmware_iface/gpio_lines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace annulus {
namespace {

using testing::AllOf;
using testing::HasSubstr;

GpioChipInfo Chip(const std::string& name, const std::string& label, const std::vector<std::string>& lines) {
  GpioChipInfo info;
  info.name = name;
  info.label = label;
  info.path = "/dev/" + name;
  for (const std::string& line : lines) info.lines.push_back({line, false, {}});
  return info;
}

std::vector<GpioLineSpec> Named(const std::vector<std::string>& names) {
  std::vector<GpioLineSpec> lines;
  for (const std::string& name : names) lines.emplace_back().name = name;
  return lines;
}

std::vector<GpioChipInfo> TwoChips() {
  return {Chip("gpiochip0", "soc", {"", "led", "door"}), Chip("gpiochip1", "io-board", {"door", "reset", "enable"})};
}

std::string Problem(const Result<std::vector<GpioPlace>>& places) { return places ? "none" : places.error().Text(); }

TEST(GpioLines, AreFoundOnAChipByItsLabelNameOrPath) {
  for (const std::string chip : {"io-board", "gpiochip1", "/dev/gpiochip1"}) {
    const auto places = FindGpioLines(TwoChips(), chip, Named({"enable", "door"}));
    ASSERT_TRUE(places) << Problem(places);
    EXPECT_EQ((*places)[0].chip, 1U);
    EXPECT_EQ((*places)[0].offset, 2U);
    EXPECT_EQ((*places)[1].offset, 0U);
  }
}

TEST(GpioLines, AreFoundOnAnyChipIfNoneIsNamed) {
  const auto places = FindGpioLines(TwoChips(), "", Named({"led", "reset"}));
  ASSERT_TRUE(places) << Problem(places);
  EXPECT_EQ((*places)[0].chip, 0U);
  EXPECT_EQ((*places)[1].chip, 1U);
}

TEST(GpioLines, E10_ALineThatIsOnTwoChipsIsNamedWithThem) {
  EXPECT_THAT(Problem(FindGpioLines(TwoChips(), "", Named({"door"}))),
              HasSubstr("line 'door' is there twice, on gpiochip0 and gpiochip1"));
}

TEST(GpioLines, E10_AllLinesThatAreMissingOrInUseAreNamed) {
  auto chips = TwoChips();
  chips[1].lines[1] = {"reset", true, "gpio-keys"};
  chips[1].lines[2] = {"enable", true, ""};
  EXPECT_THAT(Problem(FindGpioLines(chips, "io-board", Named({"door", "estop_a", "reset", "enable", "door", ""}))),
              AllOf(HasSubstr("there is no line 'estop_a'"), HasSubstr("line 'reset' is in use by 'gpio-keys'"),
                    HasSubstr("line 'enable' is in use by somebody unknown"),
                    HasSubstr("line 'door' is asked for twice"), HasSubstr("without a name")));
}

TEST(GpioLines, E10_AChipThatIsMissingIsNamedWithThoseThatAreThere) {
  EXPECT_THAT(Problem(FindGpioLines(TwoChips(), "io-bord", Named({"door"}))),
              AllOf(HasSubstr("'io-bord'"), HasSubstr("there is no such chip"), HasSubstr("gpiochip1 (io-board)")));
  EXPECT_THAT(Problem(FindGpioLines({}, "io-board", Named({"door"}))), HasSubstr("this system has no GPIO chip"));
  EXPECT_THAT(Problem(FindGpioLines({}, "", Named({"door"}))), HasSubstr("this system has no GPIO chip"));
}

TEST(GpioLines, E10_AChipThatCannotBeOpenedIsNamedWithTheReason) {
  auto chips = TwoChips();
  chips[1] = {"gpiochip1", "", "/dev/gpiochip1", {}, "Permission denied"};
  EXPECT_THAT(Problem(FindGpioLines(chips, "gpiochip1", Named({"reset"}))),
              AllOf(HasSubstr("Permission denied"), HasSubstr("udev")));
  EXPECT_THAT(Problem(FindGpioLines(chips, "io-board", Named({"reset"}))), HasSubstr("Permission denied"));
}

TEST(GpioLines, E10_TwoChipsOfOneLabelAreNamed) {
  auto chips = TwoChips();
  chips[0].label = "io-board";
  EXPECT_THAT(Problem(FindGpioLines(chips, "io-board", Named({"reset"}))),
              AllOf(HasSubstr("there are two"), HasSubstr("gpiochip0"), HasSubstr("path")));
}

// The rest of the adapter needs a kernel with GPIO chips: tests/hil.
TEST(GpioLines, ThisSystemsChipsAreListedWithoutFailing) {
  const auto chips = ListGpioChips();
  ASSERT_TRUE(chips) << chips.error().Text();
  for (const GpioChipInfo& chip : *chips) EXPECT_THAT(chip.path, HasSubstr("/dev/gpiochip"));
}

TEST(GpioLines, E10_OpeningOnASystemWithoutThatChipSaysWhatToDo) {
  SystemClock clock;
  for (const std::string chip : {"no-such-chip", "/dev/no-such-chip", "/dev/null"}) {
    const auto lines = OpenGpioLines(chip, Named({"estop_a"}), clock);
    ASSERT_FALSE(lines) << chip;
    EXPECT_THAT(lines.error().Text(), AllOf(HasSubstr(chip), HasSubstr("docs/booth.md")));
  }
}

TEST(GpioLines, AGoneChipReadsAsSuch) {
  const Error error = GpioError("read the lines", {GpioFault::kGone, "No such device"});
  EXPECT_THAT(error.Text(), AllOf(HasSubstr("removed"), HasSubstr("No such device")));
}

}  // namespace
}  // namespace annulus
