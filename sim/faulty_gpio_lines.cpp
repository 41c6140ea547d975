#include "sim/faulty_gpio_lines.h"

#include <algorithm>
#include <utility>

#include "sim/world.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kChatter = std::chrono::milliseconds(5);

}  // namespace

FaultyGpioLines::FaultyGpioLines(std::unique_ptr<GpioLines> lines, GpioFaultPlan plan, Clock& clock)
    : lines_(std::move(lines)), plan_(std::move(plan)), clock_(clock), engine_(plan_.seed) {}

double FaultyGpioLines::Draw() { return UnitFromBits(engine_()); }

std::optional<GpioFailure> FaultyGpioLines::FailureNow(std::optional<std::size_t> line) const {
  const nanoseconds now = clock_.Now();
  for (const GpioFaultPlan::Outage& outage : plan().outages) {
    if (now < outage.from || now >= outage.to) continue;
    if (!line && outage.calls == GpioFaultPlan::Calls::kWrites) continue;
    if (line && !outage.lines.empty() && std::count(outage.lines.begin(), outage.lines.end(), *line) == 0) continue;
    return GpioFailure{outage.fault, outage.fault == GpioFault::kGone ? "the chip is unplugged" : "input/output error"};
  }
  return std::nullopt;
}

std::optional<bool> FaultyGpioLines::StuckAt(std::size_t line, nanoseconds time) const {
  for (const GpioFaultPlan::Stuck& stuck : plan().stuck) {
    if (stuck.line == line && time >= stuck.from && time < stuck.to) return stuck.level;
  }
  return std::nullopt;
}

GpioResult<std::vector<bool>> FaultyGpioLines::Read() {
  if (hook_) hook_();
  if (const auto failure = FailureNow()) return tl::unexpected<GpioFailure>(*failure);
  auto levels = lines_->Read();
  for (std::size_t i = 0; levels && i < levels->size(); ++i) {
    if (const auto stuck = StuckAt(i, clock_.Now())) (*levels)[i] = *stuck;
  }
  return levels;
}

GpioResult<void> FaultyGpioLines::Write(std::size_t line, bool level) {
  if (hook_) hook_();
  if (const auto failure = FailureNow(line)) return tl::unexpected<GpioFailure>(*failure);
  return lines_->Write(line, level);
}

GpioResult<std::optional<GpioEdge>> FaultyGpioLines::WaitEdge(nanoseconds deadline) {
  if (hook_) hook_();
  while (true) {
    if (const auto failure = FailureNow()) return tl::unexpected<GpioFailure>(*failure);
    const nanoseconds now = clock_.Now();
    const bool ready = !held_.empty() && held_.front().told_at <= now;
    // Whatever is there to be collected first: it may have to be told before what is held.
    nanoseconds until = ready ? now : deadline;
    if (!ready && !held_.empty()) until = std::min(until, held_.front().told_at);
    auto edge = lines_->WaitEdge(until);
    if (!edge) return edge;
    if (*edge) {
      Take(**edge);
      continue;
    }
    if (!held_.empty() && held_.front().told_at <= clock_.Now()) {
      const GpioEdge told = held_.front().edge;
      held_.pop_front();
      return told;
    }
    if (clock_.Now() >= deadline) return std::nullopt;
  }
}

void FaultyGpioLines::Take(const GpioEdge& edge) {
  if (StuckAt(edge.line, edge.host_time)) return;
  if (plan().loss_line.value_or(edge.line) == edge.line && Draw() < plan().loss_rate) return;
  Hold(edge);
  if (Draw() >= plan().chatter_rate) return;
  const int pairs = 1 + static_cast<int>(Draw() * plan().most_chatter);
  for (int i = 1; i <= pairs; ++i) {
    // Bounces that the kernel saw at once, and whose last is back at the level.
    const nanoseconds later = kChatter * i / (pairs + 1);
    GpioEdge back = edge;
    back.level = !edge.level;
    back.host_time = edge.host_time + later;
    GpioEdge again = edge;
    again.host_time = back.host_time + kChatter / (2 * (pairs + 1));
    Hold(back);
    Hold(again);
  }
}

void FaultyGpioLines::Hold(const GpioEdge& edge) {
  const nanoseconds late(static_cast<std::int64_t>(Draw() * static_cast<double>(plan().late.count())));
  nanoseconds told_at = edge.host_time + late;
  // The edges of one line keep their order.
  for (const Held& held : held_) {
    if (held.edge.line == edge.line) told_at = std::max(told_at, held.told_at);
  }
  const auto place = std::upper_bound(held_.begin(), held_.end(), told_at,
                                      [](nanoseconds time, const Held& held) { return time < held.told_at; });
  held_.insert(place, {edge, told_at});
}

}  // namespace annulus::sim
