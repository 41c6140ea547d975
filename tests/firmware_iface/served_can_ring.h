#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "sim/booth.h"
#include "sim/can_bridge.h"
#include "tests/firmware_iface/range_ring_contract.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::contract {

/// The ring's contract in real time: twelve simulated boards are served in a thread on real buses, and the ring under
/// test hangs on the same buses by other sockets. Everything on SystemClock.
class ServedCanRing final : public RangeRingFixture {
 public:
  struct Set {
    std::vector<std::unique_ptr<CanBus>> hosts;   ///< For the ring under test.
    std::vector<std::unique_ptr<CanBus>> boards;  ///< For the boards, on the same buses in the same order.
    bool fd = false;
    double patience = 5.0;
    bool unplug = true;  ///< Also the tests that unplug boards, which take half a minute.
  };
  explicit ServedCanRing(Set set) : set_(std::move(set)) {
    server_ = std::jthread([this](const std::stop_token& stop) { Serve(stop); });
  }

  Clock& clock() override { return clock_; }
  Result<std::unique_ptr<RangeRing>> Make() override {
    std::vector<CanBus*> buses;
    for (const auto& bus : set_.hosts) buses.push_back(bus.get());
    CanRangeRingOptions options;
    options.boot_deadline = Patient(options.boot_deadline);
    options.heartbeat = Patient(options.heartbeat);
    options.sdo_timeout = Patient(options.sdo_timeout);
    return MakeCanRangeRing(buses, options, clock_);
  }
  [[nodiscard]] std::vector<Board> boards() const override {
    std::vector<Board> boards;
    for (std::uint16_t i = 0; i < kBoards; ++i) boards.push_back({1001U + i, static_cast<std::uint16_t>(15 * i)});
    return boards;
  }
  [[nodiscard]] double expected_range_mm(std::size_t) const override { return 600.0 - sim::kCylinderRadiusMm; }
  [[nodiscard]] double tolerance_mm() const override { return set_.fd ? 0.0101 : 0.0201; }
  [[nodiscard]] double patience() const override { return set_.patience; }
  [[nodiscard]] bool CanUnplug() const override { return set_.unplug; }
  void Unplug(std::size_t board) override { Order(board, kUnplug); }
  void Replug(std::size_t board) override { Order(board, kReplug); }

 private:
  static constexpr std::size_t kBoards = sim::Booth::kBoards;
  enum Change : int { kNone, kUnplug, kReplug };

  [[nodiscard]] std::chrono::nanoseconds Patient(std::chrono::nanoseconds time) const {
    return std::chrono::nanoseconds(static_cast<std::int64_t>(static_cast<double>(time.count()) * set_.patience));
  }
  /// Waits until the serving thread has done it.
  void Order(std::size_t board, Change change) {
    changes_[board] = change;
    const auto deadline = clock_.Now() + std::chrono::seconds(10);
    while (changes_[board] != kNone && clock_.Now() < deadline) {
      clock_.SleepUntil(clock_.Now() + std::chrono::milliseconds(1));
    }
  }
  void Serve(const std::stop_token& stop) {
    sim::BoothOptions options = sim::CylinderBooth();
    options.axis.start_z_mm = 500.0;
    options.can_buses = set_.boards.size();
    options.can_fd = set_.fd;
    sim::BoothDevices devices(std::move(options), clock_);
    std::vector<sim::CanBridge> bridges;
    for (std::size_t i = 0; i < set_.boards.size(); ++i) {
      bridges.push_back({devices.can_buses()[i], set_.boards[i].get()});
    }
    sim::ServeCanBoards(bridges, clock_, stop, [&](std::chrono::nanoseconds now) {
      for (std::size_t board = 0; board < kBoards; ++board) {
        if (changes_[board] == kUnplug) devices.can_board(board).PowerOffAt(now);
        if (changes_[board] == kReplug) devices.can_board(board).PowerOnAt(now);
        changes_[board] = kNone;
      }
      return true;
    });
  }

  SystemClock clock_;
  Set set_;
  std::array<std::atomic<int>, kBoards> changes_{};
  std::jthread server_;
};

}  // namespace annulus::contract
