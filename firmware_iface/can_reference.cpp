#include "firmware_iface/can_reference.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/ring_boards.h"
#include "firmware_iface/ring_objects.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// What an exchange with a board that may be dead costs the ring at most.
constexpr nanoseconds kPatience = milliseconds(50);
constexpr int kAttempts = 2;

}  // namespace

CanReference::CanReference(const CanRangeRingOptions& options) : options_(options) {
  ENSURE(options_.reference, "the ring has a reference board");
  for (const std::uint8_t channel : options_.reference->channels) {
    ENSURE(channel < kSensorsPerBoard, "a board has channels 0 to 14");
  }
  board_.serial = options_.reference->serial;
}

void CanReference::Lose(const Error& error) { board_.trouble = error.attempted + ": " + error.seen; }

void CanReference::Boot(std::vector<CanRingBus>& buses, Clock& clock) {
  if (absent_) return;
  const bool first = !board_.board;
  const auto booted = BootReferenceBoard(buses, options_, clock);
  if (!booted) {
    absent_ = first;
    return Lose(booted.error());
  }
  board_.trouble.clear();
  board_.board = booted->board;
  node_ = *booted;
}

Status CanReference::Enter(NmtCommand command, NmtState state, CanRingBus& bus) {
  const std::string attempted = "make " + BoardName(node_->board) + " " + NmtStateText(state);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    RETURN_IF_ERROR(bus.Send(EncodeNmt({command, node_->node}), attempted));
    const auto told = ReadNumber<std::uint8_t>(bus, node_->node, kObjectNmtState, kPatience, 1);
    if (told && *told == static_cast<std::uint8_t>(state)) return {};
  }
  return Fail(attempted, "it does not say that it is", "check the board's supply and cable");
}

void CanReference::Begin(std::vector<CanRingBus>& buses, nanoseconds level_period) {
  if (!node_) return;
  CanRingBus& bus = buses[node_->bus];
  CanNode& node = NodeOf(buses);
  board_.trouble.clear();
  node.trouble.clear();
  losses_ = {};
  // Only the change to operational sets its sequence back, so it must have been out of it.
  Status begun = Enter(NmtCommand::kEnterPreOperational, NmtState::kPreOperational, bus);
  if (begun) begun = Enter(NmtCommand::kStart, NmtState::kOperational, bus);
  if (!begun) return Lose(begun.error());
  node.levels.Begin(level_period);
}

void CanReference::End(std::vector<CanRingBus>& buses) {
  if (node_) NodeOf(buses).levels.End();
}

void CanReference::Await(std::uint32_t sequence, nanoseconds deadline, std::vector<CanRingBus>& buses, Clock& clock) {
  if (!reads()) return;
  CanRingBus& bus = buses[node_->bus];
  CanNode& node = NodeOf(buses);
  const auto decided = [&] { return node.levels.has_level() || node.levels.next() > sequence; };
  bool drained = false;
  while (!decided() && !bus.fault()) {
    if (drained && clock.Now() >= deadline) break;
    drained = bus.CollectUntil(deadline, [&] { return decided() || bus.fault(); });
  }
  if (!decided()) static_cast<void>(node.levels.GiveUpOldest());
  if (decided()) return;
  // What it reported, if anything, is why; as long as its levels come, they count.
  board_.trouble = node.trouble.empty() ? "read " + BoardName(node_->board) + ": it says nothing" : node.trouble;
}

Status CanReference::Put(std::vector<CanRingBus>& buses, RingLevel& level) {
  const std::vector<std::uint8_t>& channels = options_.reference->channels;
  level.reference_range_mm.assign(channels.size(), std::numeric_limits<double>::quiet_NaN());
  level.reference_quality.assign(channels.size(), 0);
  if (!reads()) return {};
  CanNode& node = NodeOf(buses);
  if (!node.levels.has_level() || node.levels.front().level.sequence != level.sequence) {
    losses_.Lose();
    if (losses_.full()) board_.trouble = "read " + BoardName(node_->board) + ": it loses frames repeatedly";
    return {};
  }
  losses_.Keep();
  const CanLevel arrived = node.levels.front();
  node.levels.Pop();
  const LevelFrame& told = arrived.level;
  if ((told.status & kFrameEmitterFault) != 0) {
    return Fail("read " + BoardName(node_->board), "it reports an emitter fault",
                "keep the ring off and have the board replaced");
  }
  const auto wire_us = static_cast<std::uint32_t>(told.device_time / std::chrono::microseconds(1));
  level.reference = {true, node.clock.Unwrap(wire_us, arrived.host_arrival), arrived.host_arrival,
                     told.temperature_centi_c / 100.0};
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (told.range_um[channels[i]] == kNoReturn) continue;
    level.reference_range_mm[i] = told.range_um[channels[i]] / 1000.0;
    level.reference_quality[i] = told.quality[channels[i]];
  }
  return {};
}

Result<ClockExchange> CanReference::ReadClock(std::uint8_t question, std::vector<CanRingBus>& buses, Clock& clock) {
  const std::string attempted = "read the clock of reference board " + std::to_string(board_.serial);
  if (!reads()) return Fail(attempted, board_.trouble, "check its cable and supply; the ring does without it");
  auto exchange = AskCanClock(buses[node_->bus], *node_, question, std::min(options_.sdo_timeout, kPatience), clock);
  if (!exchange) Lose(exchange.error());
  return exchange;
}

}  // namespace annulus
