#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/can_bus.h"
#include "sim/booth.h"

namespace annulus::hil {

/// The simulated boards of a ring, around a cylinder of 150 mm radius, on a CAN interface of the machine: a thread
/// carries frames between their simulated wire and the interface. Ends with the object.
class CanBoards {
 public:
  static constexpr std::size_t kCount = sim::BoothDevices::kBoards;
  static constexpr std::uint32_t kFirstSerial = 1001;

  /// `with_fd`: the boards send levels in FD frames.
  CanBoards(const std::string& interface, bool with_fd);
  CanBoards(const CanBoards&) = delete;
  CanBoards& operator=(const CanBoards&) = delete;

  void PowerOff(std::size_t board);
  /// The board boots again 300 ms from now.
  void PowerOn(std::size_t board);
  [[nodiscard]] std::chrono::nanoseconds DeviceTime(std::size_t board, std::chrono::nanoseconds time);

 private:
  /// Lets the thread do it, because the models are its own.
  void Order(std::function<void()> order);

  SystemClock clock_;
  std::unique_ptr<CanBus> bus_;
  sim::BoothDevices booth_;
  std::mutex mutex_;  ///< Guards the orders.
  std::vector<std::function<void()>> orders_;
  std::jthread thread_;  ///< Last: it ends before what it uses.
};

}  // namespace annulus::hil
