#include "sim/can_bridge.h"

#include <deque>
#include <optional>
#include <utility>
#include <variant>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kTurn = std::chrono::microseconds(500);
constexpr nanoseconds kReopenPause = std::chrono::milliseconds(20);
constexpr std::size_t kMostWaiting = 1024;
/// Frames taken from one side in a turn, so that a flood does not starve the other.
constexpr int kMostPerTurn = 256;

/// One bridge with what waits for room on the other side.
class Span {
 public:
  explicit Span(const CanBridge& bridge) : bridge_(bridge) {
    ENSURE(bridge.simulated != nullptr && bridge.real != nullptr, "a bridge joins two buses");
  }

  void Turn(Clock& clock, nanoseconds wait_until, CanBridgeCounts& counts) {
    if (retry_at_ && clock.Now() < *retry_at_) {
      clock.SleepUntil(wait_until);
    } else {
      if (std::exchange(retry_at_, std::nullopt)) Reopen(clock, counts);
      Take(*bridge_.real, to_simulated_, wait_until, clock, counts);
    }
    counts.to_simulated += Give(*bridge_.simulated, to_simulated_, clock);
    Take(*bridge_.simulated, to_real_, nanoseconds(0), clock, counts);
    counts.to_real += Give(*bridge_.real, to_real_, clock);
  }

 private:
  void Take(CanBus& from, std::deque<CanFrame>& into, nanoseconds wait_until, Clock& clock, CanBridgeCounts& counts) {
    for (int i = 0; i < kMostPerTurn; ++i) {
      auto received = from.Receive(i == 0 ? wait_until : nanoseconds(0));
      if (!received) {
        if (&from == bridge_.real) retry_at_ = clock.Now() + kReopenPause;
        return;
      }
      if (!*received) return;
      const auto* frame = std::get_if<CanFrame>(&(*received)->what);
      if (frame == nullptr) continue;
      if (into.size() < kMostWaiting) {
        into.push_back(*frame);
      } else {
        ++counts.dropped;
      }
    }
  }

  /// Sends as much as there is room for; returns how many frames.
  std::uint64_t Give(CanBus& to, std::deque<CanFrame>& waiting, Clock& clock) {
    std::uint64_t given = 0;
    for (; !waiting.empty(); waiting.pop_front(), ++given) {
      const auto sent = to.Send(waiting.front());
      if (sent) continue;
      if (sent.error().fault != CanFault::kQueueFull && &to == bridge_.real) retry_at_ = clock.Now() + kReopenPause;
      break;
    }
    return given;
  }

  void Reopen(Clock& clock, CanBridgeCounts& counts) {
    counts.dropped += to_real_.size();
    to_real_.clear();
    if (bridge_.real->Reopen()) {
      ++counts.reopened;
    } else {
      retry_at_ = clock.Now() + kReopenPause;
    }
  }

  CanBridge bridge_;
  std::deque<CanFrame> to_real_;
  std::deque<CanFrame> to_simulated_;
  std::optional<nanoseconds> retry_at_;
};

}  // namespace

CanBridgeCounts ServeCanBoards(const std::vector<CanBridge>& bridges, Clock& clock, const std::stop_token& stop,
                               const std::function<bool(nanoseconds now)>& on_turn) {
  ENSURE(!bridges.empty(), "a bus is served");
  std::vector<Span> spans(bridges.begin(), bridges.end());
  CanBridgeCounts counts;
  while (!stop.stop_requested()) {
    if (on_turn && !on_turn(clock.Now())) break;
    const auto share = kTurn / static_cast<std::int64_t>(spans.size());
    for (Span& span : spans) span.Turn(clock, clock.Now() + share, counts);
  }
  return counts;
}

}  // namespace annulus::sim
