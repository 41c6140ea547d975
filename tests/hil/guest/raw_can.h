#pragma once

#include <linux/can.h>

#include <chrono>
#include <optional>
#include <string>

namespace annulus::hil {

/// A raw CAN socket beside our adapter: the other node on the bus, and a way to write what a controller would report.
/// Failures fail the test.
class RawCan {
 public:
  explicit RawCan(const std::string& interface);
  ~RawCan();
  RawCan(const RawCan&) = delete;
  RawCan& operator=(const RawCan&) = delete;

  /// Writes a frame, waiting for room in the queue for at most 5 s.
  void Send(const canfd_frame& frame, bool fd = false) const;
  /// An error frame as a controller's driver writes it: the classes of linux/can/error.h and their eight bytes.
  void SendError(canid_t classes, const unsigned char (&data)[8]) const;
  /// The next frame; nothing after `patience`.
  [[nodiscard]] std::optional<canfd_frame> Receive(std::chrono::milliseconds patience) const;

 private:
  int socket_ = -1;
};

}  // namespace annulus::hil
