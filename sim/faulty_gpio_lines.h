#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/gpio_lines.h"

namespace annulus::sim {

/// What goes wrong with a set of GPIO lines. All of it is drawn from `seed`: same plan, same calls, same faults.
struct GpioFaultPlan {
  std::uint64_t seed = 1;

  // Benign: contacts and kernels do this every day, and no level ends up wrong.
  double chatter_rate = 0.0;         ///< Share of the edges that come as several, there and back, within 5 ms.
  int most_chatter = 10;             ///< Pairs of extra edges.
  std::chrono::nanoseconds late{0};  ///< Edges are told up to so much later; their time stamps are true.

  // Not benign.
  double loss_rate = 0.0;                ///< Share of the edges that are never told.
  std::optional<std::size_t> loss_line;  ///< Whose edges; nothing: of any line.
  struct Stuck {
    std::size_t line = 0;
    bool level = false;  ///< That is read, whatever the pin has.
    std::chrono::nanoseconds from{0};
    std::chrono::nanoseconds to = std::chrono::nanoseconds::max();
  };
  std::vector<Stuck> stuck;  ///< Inputs; a broken wire is one that is stuck at 0.

  enum class Calls { kAll, kWrites };
  /// Calls fail, and no level is set; outputs keep theirs.
  struct Outage {
    std::chrono::nanoseconds from{0};
    std::chrono::nanoseconds to = std::chrono::nanoseconds::max();
    GpioFault fault = GpioFault::kError;
    std::vector<std::size_t> lines;  ///< Those of one chip of several; empty: all. A failing line fails every reading.
    Calls calls = Calls::kAll;
  };
  std::vector<Outage> outages;
};

/// Passes on what real lines do and damages it by a plan. Thread-bound. Borrows the clock.
class FaultyGpioLines final : public GpioLines {
 public:
  FaultyGpioLines(std::unique_ptr<GpioLines> lines, GpioFaultPlan plan, Clock& clock);

  /// From now on what goes wrong is what `plan`, which is borrowed, says at the time. Its seed is not looked at.
  void FollowPlan(const GpioFaultPlan& plan) { followed_ = &plan; }
  /// Told before every call but count.
  void OnCall(std::function<void()> hook) { hook_ = std::move(hook); }

  [[nodiscard]] std::size_t count() const override { return lines_->count(); }
  GpioResult<std::vector<bool>> Read() override;
  GpioResult<void> Write(std::size_t line, bool level) override;
  GpioResult<std::optional<GpioEdge>> WaitEdge(std::chrono::nanoseconds deadline) override;

 private:
  struct Held {
    GpioEdge edge;
    std::chrono::nanoseconds told_at{0};
  };

  [[nodiscard]] const GpioFaultPlan& plan() const { return followed_ != nullptr ? *followed_ : plan_; }
  /// Of a write to `line`; of a reading or a wait, which need all lines, without one.
  [[nodiscard]] std::optional<GpioFailure> FailureNow(std::optional<std::size_t> line = std::nullopt) const;
  [[nodiscard]] double Draw();
  /// What becomes of one edge.
  void Take(const GpioEdge& edge);
  void Hold(const GpioEdge& edge);
  [[nodiscard]] std::optional<bool> StuckAt(std::size_t line, std::chrono::nanoseconds time) const;

  std::unique_ptr<GpioLines> lines_;
  GpioFaultPlan plan_;
  const GpioFaultPlan* followed_ = nullptr;  ///< Null: plan_ counts.
  std::function<void()> hook_;
  Clock& clock_;
  std::mt19937_64 engine_;
  std::deque<Held> held_;  ///< In the order in which they are told.
};

}  // namespace annulus::sim
