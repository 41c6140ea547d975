// Lines on two chips, as on two expanders, of which one goes: the outputs of the other are still switched off.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware_iface/interlock.h"
#include "tests/hil/gpio_sim.h"

namespace annulus {
namespace {

using In = InterlockInput;
using Out = InterlockOutput;

/// The interlock's inputs on one simulated chip, its outputs on another.
class GpioTwoChips : public testing::Test {
 protected:
  static constexpr std::array<Out, 3> kDangerous = {Out::kQuickStop, Out::kEmitters, Out::kEnable};

  void SetUp() override {
    inputs_ = Make("annulus-inputs", true);
    outputs_ = Make("annulus-outputs", false);
    ASSERT_TRUE(inputs_ && outputs_);
    for (const auto& [input, spec] : wiring_.inputs) Drive(input, IsChainInput(input));
  }
  std::unique_ptr<hil::GpioSimChip> Make(const std::string& label, bool of_inputs) {
    std::vector<std::string> names;
    // The pull that a request asks for takes the place of the one from outside, which is all the pin has here.
    for (auto& [input, spec] : wiring_.inputs) spec.bias = GpioBias::kAsIs;
    for (const GpioLineSpec& spec : wiring_.Lines()) {
      if ((spec.direction == GpioDirection::kInput) == of_inputs) names.push_back(spec.name);
    }
    auto chip = hil::GpioSimChip::Make(label, names);
    EXPECT_TRUE(chip) << chip.error().Text();
    return chip ? std::move(*chip) : nullptr;
  }
  void Drive(In input, bool level) {
    const GpioLineSpec& spec = wiring_.inputs.at(input);
    inputs_->Pull(spec.name, level != spec.active_low);
    hil::LetTheKernelSee();
  }
  [[nodiscard]] bool Pin(Out output) const { return outputs_->Value(wiring_.outputs.at(output).name); }
  std::unique_ptr<GpioLines> Open() {
    auto lines = OpenGpioLines("", wiring_.Lines(), clock_);
    EXPECT_TRUE(lines) << lines.error().Text();
    return lines ? std::move(*lines) : nullptr;
  }
  /// Beats and reads until `reading` says so, at most for 10 s.
  bool RunUntil(Interlock& interlock, bool (*done)(const InterlockReading& reading)) {
    for (const auto end = clock_.Now() + std::chrono::seconds(10); clock_.Now() < end;) {
      (void)interlock.KickWatchdog();
      clock_.SleepUntil(clock_.Now() + interlock_time::kBeat);
      const auto reading = interlock.Read();
      EXPECT_TRUE(reading) << reading.error().Text();
      if (!reading || done(*reading)) return reading.has_value();
    }
    return false;
  }
  void SwitchOn(Interlock& interlock) {
    ASSERT_TRUE(RunUntil(interlock, [](const InterlockReading& reading) { return reading.chain_closed; }));
    Drive(In::kReset, true);
    ASSERT_TRUE(RunUntil(interlock, [](const InterlockReading& reading) { return !reading.latched; }));
    Drive(In::kReset, false);
    Drive(In::kWatchdogFeedback, true);
    ASSERT_TRUE(RunUntil(interlock, [](const InterlockReading& reading) { return reading[In::kWatchdogFeedback]; }));
    for (const Out output : kDangerous) {
      const Status status = interlock.Set(output, true);
      ASSERT_TRUE(status) << status.error().Text();
      ASSERT_TRUE(Pin(output));
    }
  }

  InterlockWiring wiring_ = InterlockWiring::Default();
  SystemClock clock_;
  std::unique_ptr<hil::GpioSimChip> inputs_;
  std::unique_ptr<hil::GpioSimChip> outputs_;
};

TEST_F(GpioTwoChips, E10_InputsThatGoLeaveTheOutputsOfTheOtherChipOff) {
  auto made = MakeInterlock(Open(), clock_);
  ASSERT_TRUE(made) << made.error().Text();
  Interlock& interlock = **made;
  SwitchOn(interlock);
  inputs_->Remove();
  const auto reading = interlock.Read();
  ASSERT_FALSE(reading);
  EXPECT_THAT(reading.error().Text(), testing::HasSubstr("removed"));
  for (const Out output : kDangerous) EXPECT_FALSE(Pin(output)) << InterlockName(output);
}

TEST_F(GpioTwoChips, E10_LinesOfAChipThatStayedCanBeWrittenAfterTheOtherWent) {
  const auto lines = Open();
  ASSERT_NE(lines, nullptr);
  const std::size_t enable = kInterlockInputs;
  ASSERT_TRUE(lines->Write(enable, true));
  inputs_->Remove();
  const auto levels = lines->Read();
  ASSERT_FALSE(levels);
  EXPECT_EQ(levels.error().fault, GpioFault::kGone);
  EXPECT_FALSE(lines->WaitEdge(clock_.Now() + std::chrono::seconds(5)));
  ASSERT_TRUE(lines->Write(enable, false));
  EXPECT_FALSE(Pin(Out::kEnable));
}

TEST_F(GpioTwoChips, E10_AWaitForEdgesEndsWhenTheChipOfTheOutputsGoes) {
  const auto lines = Open();
  ASSERT_NE(lines, nullptr);
  outputs_->Remove();
  const auto before = clock_.Now();
  const auto edge = lines->WaitEdge(before + std::chrono::seconds(30));
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().fault, GpioFault::kGone);
  EXPECT_LT(clock_.Now() - before, std::chrono::seconds(5));
}

}  // namespace
}  // namespace annulus
