#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "station/command_io.h"

namespace annulus {
namespace {

/// What a display writes to stderr, line by line.
std::vector<std::string> LinesOf(const std::function<void()>& show) {
  testing::internal::CaptureStderr();
  show();
  std::istringstream text(testing::internal::GetCapturedStderr());
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

TEST(ProgressDisplay, JsonIsOneObjectPerLineWithTheKeysOfTheDesign) {
  const auto lines = LinesOf([] {
    ProgressDisplay display(ProgressMode::kJson);
    display.Show("scan", 0.0, 4.0);
    display.Show("scan", 4.0, 4.0);
    display.Show("fit \"it\"", 1.0, 2.0);
  });
  ASSERT_EQ(lines.size(), 3U);
  const auto first = nlohmann::json::parse(lines[0]);
  EXPECT_EQ(first.at("stage"), "scan");
  EXPECT_EQ(first.at("done"), 0.0);
  EXPECT_EQ(first.at("total"), 4.0);
  EXPECT_EQ(nlohmann::json::parse(lines[1]).at("eta_s"), 0.0);
  EXPECT_EQ(nlohmann::json::parse(lines[2]).at("stage"), "fit \"it\"");
}

TEST(ProgressDisplay, NeverSaysMoreThanTheTotal) {
  const auto lines = LinesOf([] { ProgressDisplay(ProgressMode::kJson).Show("scan", 5.0, 4.0); });
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(nlohmann::json::parse(lines[0]).at("done"), 4.0);
}

TEST(ProgressDisplay, ManyReportsOfOneStageAreThinnedOut) {
  const auto lines = LinesOf([] {
    ProgressDisplay display(ProgressMode::kJson);
    for (int k = 0; k < 10'000; ++k) display.Show("scan", k, 10'000.0);
  });
  EXPECT_LT(lines.size(), 1000U);
}

TEST(ProgressDisplay, IsQuietWhenPipedAndWhenTurnedOff) {
  for (const ProgressMode mode : {ProgressMode::kAuto, ProgressMode::kNone}) {
    EXPECT_TRUE(LinesOf([mode] {
                  ProgressDisplay display(mode);
                  display.Show("scan", 0.0, 1.0);
                  display.Show("scan", 1.0, 1.0);
                }).empty());
  }
}

}  // namespace
}  // namespace annulus
