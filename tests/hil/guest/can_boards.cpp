#include "tests/hil/guest/can_boards.h"

#include <gtest/gtest.h>

#include <utility>

#include "sim/can_bridge.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::hil {
namespace {

sim::BoothOptions Options(bool with_fd) {
  sim::BoothOptions options = sim::CylinderBooth();
  options.axis.start_z_mm = 500.0;
  options.can_buses = 1;
  options.can_fd = with_fd;
  return options;
}

}  // namespace

CanBoards::CanBoards(const std::string& interface, bool with_fd) : booth_(Options(with_fd), clock_) {
  auto bus = OpenSocketCan(interface, clock_);
  EXPECT_TRUE(bus) << bus.error().Text();
  if (!bus) return;
  bus_ = std::move(*bus);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    sim::ServeCanBoards({{booth_.can_buses().front(), bus_.get()}}, clock_, stop, [this](std::chrono::nanoseconds) {
      const std::lock_guard lock(mutex_);
      for (const auto& order : std::exchange(orders_, {})) order();
      return true;
    });
  });
}

void CanBoards::PowerOff(std::size_t board) {
  Order([this, board] { booth_.can_board(board).PowerOffAt(clock_.Now()); });
}

void CanBoards::PowerOn(std::size_t board) {
  Order([this, board] { booth_.can_board(board).PowerOnAt(clock_.Now() + std::chrono::milliseconds(300)); });
}

std::chrono::nanoseconds CanBoards::DeviceTime(std::size_t board, std::chrono::nanoseconds time) {
  return booth_.can_board(board).DeviceTime(time);
}

void CanBoards::Order(std::function<void()> order) {
  const std::lock_guard lock(mutex_);
  orders_.push_back(std::move(order));
}

}  // namespace annulus::hil
