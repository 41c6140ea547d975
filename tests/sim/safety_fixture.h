#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/faulty_gpio_lines.h"
#include "sim/safety_chain.h"
#include "tests/firmware_iface/gpio_lines_contract.h"
#include "tests/firmware_iface/interlock_contract.h"

namespace annulus::sim {

/// Contacts that bounce and edges that come late, as on every day.
inline GpioFaultPlan EverydayFaults(std::uint64_t seed) {
  GpioFaultPlan plan;
  plan.seed = seed;
  plan.chatter_rate = 0.2;
  plan.late = std::chrono::milliseconds(2);
  return plan;
}

/// The simulated safety chain as a GPIO chip, straight or through a wrapper with faults.
class ChainLinesFixture final : public GpioLinesFixture {
 public:
  explicit ChainLinesFixture(std::optional<GpioFaultPlan> plan = std::nullopt) : plan_(std::move(plan)) {}

  Clock& clock() override { return clock_; }
  [[nodiscard]] std::string chip() const override { return SafetyChainOptions().chip; }
  [[nodiscard]] std::vector<std::string> inputs() const override { return {"start_key", "call"}; }
  [[nodiscard]] std::vector<std::string> outputs() const override { return {"lamp_ready", "lamp_running"}; }
  Result<std::unique_ptr<GpioLines>> Open(const std::vector<GpioLineSpec>& specs) override {
    auto lines = chain_.Request(chip(), specs);
    if (!lines || !plan_) return lines;
    return std::make_unique<FaultyGpioLines>(std::move(*lines), *plan_, clock_);
  }
  void Drive(const std::string& input, bool high) override {
    chain_.Set(input == "call" ? InterlockInput::kCall : InterlockInput::kStartKey, high);
  }
  [[nodiscard]] bool Pin(const std::string& output) override {
    return chain_.Pin(output == "lamp_ready" ? InterlockOutput::kLampReady : InterlockOutput::kLampRunning);
  }
  void RemoveChip() override { chain_.RemoveChip(); }
  [[nodiscard]] bool bounces() const override { return plan_ && plan_->chatter_rate > 0.0; }

 private:
  std::optional<GpioFaultPlan> plan_;
  ManualClock clock_;
  SafetyChain chain_{{}, clock_};
};

/// The interlock on the simulated safety chain, whose relays give the feedbacks.
class ChainInterlockFixture final : public InterlockFixture {
 public:
  explicit ChainInterlockFixture(std::optional<GpioFaultPlan> plan = std::nullopt) : plan_(std::move(plan)) {}

  Clock& clock() override { return clock_; }
  Result<std::unique_ptr<Interlock>> Open() override {
    auto lines = chain_.Request({}, InterlockWiring::Default().Lines());
    if (!lines) return Fail(lines);
    if (!plan_) return MakeInterlock(std::move(*lines), clock_);
    return MakeInterlock(std::make_unique<FaultyGpioLines>(std::move(*lines), *plan_, clock_), clock_);
  }
  void Drive(InterlockInput input, bool level) override { chain_.Set(input, level); }
  [[nodiscard]] bool Pin(InterlockOutput output) override { return chain_.Pin(output); }
  void RemoveChip() override { chain_.RemoveChip(); }
  void Follow() override {}

 private:
  std::optional<GpioFaultPlan> plan_;
  ManualClock clock_;
  SafetyChain chain_{{}, clock_};
};

}  // namespace annulus::sim
