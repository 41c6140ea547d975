#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware_iface/gpio_lines.h"

namespace annulus {

/// A GPIO chip with lines that a test can pull and look at from outside.
class GpioLinesFixture {
 public:
  virtual ~GpioLinesFixture() = default;

  virtual Clock& clock() = 0;
  /// All waiting times are multiplied by it: 1 in virtual time, more on a slow machine.
  [[nodiscard]] virtual int patience() const { return 1; }
  [[nodiscard]] virtual std::string chip() const = 0;
  /// Names of at least two lines that can be inputs, and of two that can be outputs.
  [[nodiscard]] virtual std::vector<std::string> inputs() const = 0;
  [[nodiscard]] virtual std::vector<std::string> outputs() const = 0;
  virtual Result<std::unique_ptr<GpioLines>> Open(const std::vector<GpioLineSpec>& lines) = 0;
  /// The pin of an input, from outside.
  virtual void Drive(const std::string& input, bool high) = 0;
  [[nodiscard]] virtual bool Pin(const std::string& output) = 0;
  virtual void RemoveChip() = 0;
  /// Contacts bounce: more edges than were driven.
  [[nodiscard]] virtual bool bounces() const { return false; }
};

struct GpioLinesTransport {
  std::string name;
  std::function<std::unique_ptr<GpioLinesFixture>()> make;
};

/// What every GpioLines does, whatever is below.
class GpioLinesContract : public testing::TestWithParam<GpioLinesTransport> {
 protected:
  using nanoseconds = std::chrono::nanoseconds;

  void SetUp() override {
    fixture_ = GetParam().make();
    in_ = fixture_->inputs();
    out_ = fixture_->outputs();
    for (const std::string& input : in_) fixture_->Drive(input, false);
  }

  [[nodiscard]] nanoseconds Soon() { return Now() + std::chrono::milliseconds(200) * fixture_->patience(); }
  [[nodiscard]] nanoseconds Now() { return fixture_->clock().Now(); }

  [[nodiscard]] static GpioLineSpec Input(std::string name, bool active_low = false) {
    GpioLineSpec spec;
    spec.name = std::move(name);
    spec.active_low = active_low;
    spec.edges = true;
    return spec;
  }
  [[nodiscard]] static GpioLineSpec Output(std::string name, bool initial = false, bool active_low = false) {
    GpioLineSpec spec;
    spec.name = std::move(name);
    spec.direction = GpioDirection::kOutput;
    spec.active_low = active_low;
    spec.initial = initial;
    return spec;
  }
  std::unique_ptr<GpioLines> Open(const std::vector<GpioLineSpec>& specs) {
    auto lines = fixture_->Open(specs);
    EXPECT_TRUE(lines) << lines.error().Text();
    return lines ? std::move(*lines) : nullptr;
  }
  /// Edges until none has come for the fixture's patience.
  std::vector<GpioEdge> Edges(GpioLines& lines) {
    std::vector<GpioEdge> edges;
    while (true) {
      const auto edge = lines.WaitEdge(Soon());
      EXPECT_TRUE(edge) << edge.error().detail;
      if (!edge || !*edge) return edges;
      edges.push_back(**edge);
    }
  }

  std::unique_ptr<GpioLinesFixture> fixture_;
  std::vector<std::string> in_;
  std::vector<std::string> out_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(GpioLinesContract);

TEST_P(GpioLinesContract, ReadsLevelsInTheOrderOfTheRequest) {
  const auto lines = Open({Input(in_[1]), Input(in_[0]), Output(out_[0], true), Output(out_[1])});
  ASSERT_NE(lines, nullptr);
  EXPECT_EQ(lines->count(), 4U);
  fixture_->Drive(in_[0], true);
  const auto levels = lines->Read();
  ASSERT_TRUE(levels) << levels.error().detail;
  EXPECT_THAT(*levels, testing::ElementsAre(false, true, true, false));
}

TEST_P(GpioLinesContract, DrivesOutputsAndReadsThemBack) {
  const auto lines = Open({Output(out_[0]), Output(out_[1], true)});
  ASSERT_NE(lines, nullptr);
  EXPECT_FALSE(fixture_->Pin(out_[0]));
  EXPECT_TRUE(fixture_->Pin(out_[1]));
  for (const bool level : {true, false, true}) {
    ASSERT_TRUE(lines->Write(0, level));
    EXPECT_EQ(fixture_->Pin(out_[0]), level);
    EXPECT_EQ(lines->Read().value(), (std::vector<bool>{level, true}));
  }
}

TEST_P(GpioLinesContract, ActiveLowInvertsLevelsEdgesAndOutputs) {
  const auto lines = Open({Input(in_[0], true), Output(out_[0], false, true)});
  ASSERT_NE(lines, nullptr);
  EXPECT_EQ(lines->Read().value(), (std::vector<bool>{true, false}));
  EXPECT_TRUE(fixture_->Pin(out_[0]));
  ASSERT_TRUE(lines->Write(1, true));
  EXPECT_FALSE(fixture_->Pin(out_[0]));
  fixture_->Drive(in_[0], true);
  const auto edge = lines->WaitEdge(Soon());
  ASSERT_TRUE(edge && *edge);
  EXPECT_FALSE((*edge)->level);
}

TEST_P(GpioLinesContract, TellsBothEdgesWithTheTimesAtWhichTheyHappened) {
  const auto lines = Open({Input(in_[0]), Input(in_[1])});
  ASSERT_NE(lines, nullptr);
  nanoseconds last{0};
  for (int i = 0; i < 6; ++i) {
    const std::size_t line = static_cast<std::size_t>(i / 2) % 2;
    const bool level = i % 2 == 0;
    const nanoseconds before = Now();
    fixture_->Drive(in_[line], level);
    const auto edge = lines->WaitEdge(Soon());
    ASSERT_TRUE(edge && *edge) << "edge " << i;
    EXPECT_EQ((*edge)->line, line);
    EXPECT_EQ((*edge)->level, level);
    EXPECT_FALSE((*edge)->after_loss);
    EXPECT_GE((*edge)->host_time, before);
    EXPECT_LE((*edge)->host_time, Now());
    EXPECT_GE((*edge)->host_time, last);
    last = (*edge)->host_time;
    if (fixture_->bounces()) Edges(*lines);
  }
}

TEST_P(GpioLinesContract, TellsAThousandEdges) {
  const auto lines = Open({Input(in_[0])});
  ASSERT_NE(lines, nullptr);
  int told = 0;
  for (int i = 0; i < 1000; ++i) {
    const bool level = i % 2 == 0;
    fixture_->Drive(in_[0], level);
    const auto edge = lines->WaitEdge(Soon());
    ASSERT_TRUE(edge && *edge) << "edge " << i;
    if ((*edge)->level == level) ++told;
    if (fixture_->bounces()) Edges(*lines);
  }
  EXPECT_EQ(told, 1000);
  EXPECT_THAT(Edges(*lines), testing::IsEmpty());
}

TEST_P(GpioLinesContract, SaysThatEdgesWereLostAndEndsWithTheLevel) {
  const auto lines = Open({Input(in_[0]), Input(in_[1])});
  ASSERT_NE(lines, nullptr);
  for (int i = 0; i < 41; ++i) fixture_->Drive(in_[0], i % 2 == 0);
  const std::vector<GpioEdge> edges = Edges(*lines);
  ASSERT_GE(edges.size(), 16U);
  EXPECT_LT(edges.size(), 41U + (fixture_->bounces() ? 400U : 0U));
  EXPECT_TRUE(std::any_of(edges.begin(), edges.end(), [](const GpioEdge& edge) { return edge.after_loss; }));
  EXPECT_TRUE(edges.back().level);
  EXPECT_EQ(lines->Read().value(), (std::vector<bool>{true, false}));
}

TEST_P(GpioLinesContract, WaitsUntilTheDeadlineAndNotLonger) {
  const auto lines = Open({Input(in_[0])});
  ASSERT_NE(lines, nullptr);
  const nanoseconds deadline = Now() + std::chrono::milliseconds(30);
  const auto edge = lines->WaitEdge(deadline);
  ASSERT_TRUE(edge) << edge.error().detail;
  EXPECT_FALSE(*edge);
  EXPECT_GE(Now(), deadline);
  EXPECT_LE(Now(),
            deadline + std::chrono::milliseconds(100) * (fixture_->patience() - 1) + std::chrono::milliseconds(1));
}

TEST_P(GpioLinesContract, ADeadlineInThePastOnlyCollects) {
  const auto lines = Open({Input(in_[0])});
  ASSERT_NE(lines, nullptr);
  EXPECT_FALSE(lines->WaitEdge(nanoseconds(0)).value());
  fixture_->Drive(in_[0], true);
  ASSERT_TRUE(lines->WaitEdge(Soon()).value());
  if (fixture_->bounces()) Edges(*lines);
  EXPECT_FALSE(lines->WaitEdge(nanoseconds(0)).value());
}

TEST_P(GpioLinesContract, NamesALineThatIsInUseAndWhoUsesIt) {
  const auto lines = Open({Input(in_[0]), Output(out_[0])});
  ASSERT_NE(lines, nullptr);
  const auto second = fixture_->Open({Input(in_[1]), Output(out_[0])});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().Text(), testing::HasSubstr("line '" + out_[0] + "' is in use by 'annulus'"));
}

TEST_P(GpioLinesContract, LinesAreFreeAgainAfterwards) {
  for (int i = 0; i < 3; ++i) ASSERT_NE(Open({Input(in_[0]), Output(out_[0])}), nullptr);
}

TEST_P(GpioLinesContract, NamesLinesThatAreMissing) {
  const auto lines = fixture_->Open({Input(in_[0]), Input("no_such_line"), Output("nor_this_one")});
  ASSERT_FALSE(lines);
  EXPECT_THAT(lines.error().Text(), testing::AllOf(testing::HasSubstr("there is no line 'no_such_line'"),
                                                   testing::HasSubstr("there is no line 'nor_this_one'")));
}

TEST_P(GpioLinesContract, SaysThatTheChipIsGoneAndNeverHangs) {
  const auto lines = Open({Input(in_[0]), Output(out_[0], true)});
  ASSERT_NE(lines, nullptr);
  fixture_->RemoveChip();
  const auto read = lines->Read();
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().fault, GpioFault::kGone);
  const auto written = lines->Write(1, false);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().fault, GpioFault::kGone);
  const auto edge = lines->WaitEdge(Soon());
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().fault, GpioFault::kGone);
}

TEST_P(GpioLinesContract, AWaitEndsWhenTheChipIsGone) {
  const auto lines = Open({Input(in_[0])});
  ASSERT_NE(lines, nullptr);
  fixture_->RemoveChip();
  const auto edge = lines->WaitEdge(Now() + std::chrono::seconds(2) * fixture_->patience());
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().fault, GpioFault::kGone);
}

}  // namespace annulus
