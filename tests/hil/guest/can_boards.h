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
#include "sim/can_board_firmware.h"

namespace annulus::hil {

/// The firmware models of twelve boards on a CAN interface of the machine, around a cylinder of 150 mm radius: a thread
/// that carries frames between a socket of its own and the models. Ends with the object.
class CanBoards {
 public:
  static constexpr std::size_t kCount = sim::BoothDevices::kBoards;
  static constexpr std::uint32_t kFirstSerial = 1001;

  /// `fd`: the boards send levels in FD frames.
  CanBoards(const std::string& interface, bool with_fd);
  ~CanBoards();
  CanBoards(const CanBoards&) = delete;
  CanBoards& operator=(const CanBoards&) = delete;

  void PowerOff(std::size_t board);
  /// The board boots again 300 ms from now.
  void PowerOn(std::size_t board);
  [[nodiscard]] std::chrono::nanoseconds DeviceTime(std::size_t board, std::chrono::nanoseconds time) const;

 private:
  void Serve(const std::stop_token& stop);
  /// Lets the boards act until `now` and sends what they want to say; when one wants to act next.
  std::chrono::nanoseconds Advance(std::chrono::nanoseconds now);
  /// Hands a frame to all boards but its sender.
  void Deliver(const CanFrame& frame, const sim::CanBoardModel* sender, std::chrono::nanoseconds now);

  SystemClock clock_;
  std::unique_ptr<CanBus> bus_;
  std::mutex mutex_;  ///< Guards the models.
  sim::BoothDevices booth_;
  std::vector<std::unique_ptr<sim::CanBoardModel>> boards_;
  std::jthread thread_;
};

}  // namespace annulus::hil
