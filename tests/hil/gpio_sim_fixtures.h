#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/firmware_iface/gpio_lines_contract.h"
#include "tests/firmware_iface/interlock_contract.h"
#include "tests/hil/gpio_sim.h"

namespace annulus::hil {

/// Fixture of the GPIO contract on the real kernel.
class GpioSimLinesFixture final : public GpioLinesFixture {
 public:
  GpioSimLinesFixture() {
    auto made = GpioSimChip::Make(chip(), {"in_0", "in_1", "out_0", "out_1"});
    EXPECT_TRUE(made) << made.error().Text();
    if (made) chip_ = std::move(*made);
  }
  Clock& clock() override { return clock_; }
  [[nodiscard]] int patience() const override { return 5; }
  [[nodiscard]] std::string chip() const override { return "annulus-lines"; }
  [[nodiscard]] std::vector<std::string> inputs() const override { return {"in_0", "in_1"}; }
  [[nodiscard]] std::vector<std::string> outputs() const override { return {"out_0", "out_1"}; }
  Result<std::unique_ptr<GpioLines>> Open(const std::vector<GpioLineSpec>& lines) override {
    return OpenGpioLines(chip(), lines, clock_);
  }
  void Drive(const std::string& input, bool high) override {
    chip_->Pull(input, high);
    LetTheKernelSee();
  }
  [[nodiscard]] bool Pin(const std::string& output) override { return chip_->Value(output); }
  void RemoveChip() override { chip_->Remove(); }

 private:
  SystemClock clock_;
  std::unique_ptr<GpioSimChip> chip_;
};

/// Fixture of the interlock's contract on the real kernel. The feedbacks follow by InterlockFixture::Follow.
class GpioSimInterlockFixture final : public InterlockFixture {
 public:
  GpioSimInterlockFixture() {
    wiring_.chip = "annulus-safety";
    // The pull that a request asks for takes the place of the one from outside, which is all the pin has here.
    for (auto& [input, line] : wiring_.inputs) line.bias = GpioBias::kAsIs;
    std::vector<std::string> names;
    for (const GpioLineSpec& line : wiring_.Lines()) names.push_back(line.name);
    auto made = GpioSimChip::Make(wiring_.chip, names);
    EXPECT_TRUE(made) << made.error().Text();
    if (made) chip_ = std::move(*made);
  }
  Clock& clock() override { return clock_; }
  [[nodiscard]] int patience() const override { return 5; }
  Result<std::unique_ptr<Interlock>> Open() override {
    auto lines = OpenGpioLines(wiring_.chip, wiring_.Lines(), clock_);
    if (!lines) return Fail(lines);
    return MakeInterlock(std::move(*lines), clock_);
  }
  void Drive(InterlockInput input, bool level) override {
    const GpioLineSpec& spec = wiring_.inputs.at(input);
    chip_->Pull(spec.name, level != spec.active_low);
    LetTheKernelSee();
  }
  [[nodiscard]] bool Pin(InterlockOutput output) override { return chip_->Value(wiring_.outputs.at(output).name); }
  void RemoveChip() override { chip_->Remove(); }

 private:
  InterlockWiring wiring_ = InterlockWiring::Default();
  SystemClock clock_;
  std::unique_ptr<GpioSimChip> chip_;
};

}  // namespace annulus::hil
