#include "tests/hil/guest/can_boards.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "firmware_iface/usb_frame_codec.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::hil {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Longest sleep of the thread, so that an order from outside takes effect soon.
constexpr milliseconds kLongestSleep{5};

sim::BoothOptions Options() {
  sim::BoothOptions options = sim::CylinderBooth();
  options.axis.start_z_mm = 500.0;
  return options;
}

}  // namespace

CanBoards::CanBoards(const std::string& interface, bool with_fd) : booth_(Options(), clock_) {
  auto bus = OpenSocketCan(interface, clock_);
  EXPECT_TRUE(bus) << bus.error().Text();
  if (!bus) return;
  bus_ = std::move(*bus);
  for (std::size_t i = 0; i < kCount; ++i) {
    sim::CanBoardOptions board;
    board.board.serial = kFirstSerial + static_cast<std::uint32_t>(i);
    board.board.first_sensor = static_cast<std::uint16_t>(i * kSensorsPerBoard);
    board.node = static_cast<NodeId>(i + 1);
    board.fd = with_fd;
    boards_.push_back(std::make_unique<sim::CanBoardModel>(board, booth_.world(), booth_.can_sync(), clock_.Now()));
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { Serve(stop); });
}

CanBoards::~CanBoards() = default;

void CanBoards::PowerOff(std::size_t board) {
  const std::lock_guard lock(mutex_);
  boards_.at(board)->PowerOffAt(clock_.Now());
}

void CanBoards::PowerOn(std::size_t board) {
  const std::lock_guard lock(mutex_);
  boards_.at(board)->PowerOnAt(clock_.Now() + milliseconds(300));
}

nanoseconds CanBoards::DeviceTime(std::size_t board, nanoseconds time) const {
  return boards_.at(board)->DeviceTime(time);
}

void CanBoards::Serve(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    nanoseconds next = clock_.Now() + kLongestSleep;
    {
      const std::lock_guard lock(mutex_);
      next = std::min(next, Advance(clock_.Now()));
    }
    const auto received = bus_->Receive(next);
    if (!received) {
      clock_.SleepUntil(next);
      static_cast<void>(bus_->Reopen());  // the interface fell: that is what the test is about
    } else if (*received && std::holds_alternative<CanFrame>((*received)->what)) {
      const std::lock_guard lock(mutex_);
      Deliver(std::get<CanFrame>((*received)->what), nullptr, clock_.Now());
    }
  }
}

nanoseconds CanBoards::Advance(nanoseconds now) {
  nanoseconds next = nanoseconds::max();
  for (const auto& board : boards_) {
    if (board->NextTime().value_or(nanoseconds::max()) <= now) board->Act(now);
    for (const CanFrame& frame : board->TakeFrames()) {
      if (!bus_->Send(frame)) continue;  // lost, as on a bus that is off
      board->OnSent(frame, now);
      Deliver(frame, board.get(), now);
    }
  }
  for (const auto& board : boards_) next = std::min(next, board->NextTime().value_or(nanoseconds::max()));
  return next;
}

void CanBoards::Deliver(const CanFrame& frame, const sim::CanBoardModel* sender, nanoseconds now) {
  for (const auto& board : boards_) {
    if (board.get() != sender) board->OnFrame(frame, now);
  }
}

}  // namespace annulus::hil
