#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/usb_port.h"
#include "sim/unix_socket.h"

namespace annulus::sim {

/// One board as a USB device of an emulated machine: speaks usbredir (as the end that has the device) on a socket, and
/// asks the board behind its USB seam, so the machine's kernel meets the same firmware as the driver in a unit test.
///
///     kernel of the machine ── xHCI, usb-redir (QEMU) ── socket ── UsbredirDevice ── UsbPort (RingBoardModel)
///
/// The board must run on the system's clock. Thread-bound.
class UsbredirDevice {
 public:
  virtual ~UsbredirDevice() = default;

  /// The socket, for poll(2).
  [[nodiscard]] virtual int socket() const = 0;
  /// Whether something waits for the socket to take it.
  [[nodiscard]] virtual bool wants_to_write() const = 0;
  /// Transfers of the machine that the board has not answered yet.
  [[nodiscard]] virtual std::size_t in_flight() const = 0;
  /// Level bytes that went to the machine.
  [[nodiscard]] virtual std::uint64_t sent_bytes() const = 0;
  /// Does what can be done now: requests that came, bytes that the board has. Never waits. An Error when the machine
  /// has closed the socket or does not speak usbredir.
  virtual Status Serve() = 0;
  /// Pulls the plug in the midst of whatever runs: nothing in flight is answered. The board stops.
  virtual void Unplug() = 0;
  /// Plugs in (again): the machine sees a new device. Done once by the factories.
  virtual void Plug() = 0;
};

/// Serves `board` on a connected socket, which the device owns from now on. The board is borrowed.
std::unique_ptr<UsbredirDevice> MakeUsbredirDevice(UsbPort& board, OwnedFd socket);

/// Serves all devices, and waits between for the next request or at most a millisecond while a board is read (until
/// `deadline` otherwise). Returns at `deadline`, or with the Error of the first device that lost its machine.
Status ServeUsbredir(const std::vector<UsbredirDevice*>& devices, Clock& clock, std::chrono::nanoseconds deadline);

}  // namespace annulus::sim
