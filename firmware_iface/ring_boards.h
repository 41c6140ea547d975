#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_frame_codec.h"
#include "firmware_iface/usb_host.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

/// A board that has introduced itself, with its port.
struct IdentifiedBoard {
  RingBoard board;
  RingLimits limits;
  UsbPort* port = nullptr;
};

/// Asks every port who is there. The boards come back sorted by first sensor and cover each sensor of the ring once; an
/// Error says which board does not answer, does not fit, is missing or is there twice.
Result<std::vector<IdentifiedBoard>> IdentifyBoards(const std::vector<UsbPort*>& ports,
                                                    const UsbRangeRingOptions& options);

/// Asks one port who is there.
Result<IdentifiedBoard> IdentifyBoard(UsbPort& port, const UsbRangeRingOptions& options);

/// Whether this is the port of the reference board of these options.
[[nodiscard]] bool IsReference(const UsbIdentity& identity, const UsbRangeRingOptions& options);

/// Asks a board on a port just opened who it is, and stops it: it may have been streaming for a program that was
/// killed.
Result<IdentifiedBoard> Quieten(UsbPort& port, const UsbRangeRingOptions& options);

/// What all boards can do.
[[nodiscard]] RingLimits CommonLimits(const std::vector<IdentifiedBoard>& known, std::uint16_t sensor_count);

/// A board that came back as another one, or on a port where another belongs, would put its ranges in the wrong place:
/// an Error that shows both maps. Both lists are in the same order.
Status CheckPlaces(const std::vector<RingBoard>& before, const std::vector<RingBoard>& now);

/// Opens every ring board that the host lists, with retries until `deadline` for those that have just come. Fails if
/// there is none, if two have the same serial number (with a list of all), or if one can not be opened; the reference
/// board, which comes last, may be missing.
Result<std::vector<std::unique_ptr<UsbPort>>> OpenListedBoards(UsbHost& host, const UsbRangeRingOptions& options,
                                                               Clock& clock, std::chrono::nanoseconds deadline);

/// The answer to a request for a board's clock, and the host's time before and after it; device_time is not filled in.
struct ClockReply {
  ClockExchange exchange;
  UsbResult<std::vector<std::byte>> reply;
};
[[nodiscard]] ClockReply AskClock(UsbPort& port, std::chrono::nanoseconds timeout, Clock& clock);

/// Which board is where, for messages.
[[nodiscard]] std::string BoardMap(const std::vector<RingBoard>& boards);
/// A board as messages call it.
[[nodiscard]] std::string BoardName(const RingBoard& board);
/// A failed request to a board, with what to do about it.
[[nodiscard]] tl::unexpected<Error> FailUsb(std::string attempted, const UsbFailure& failure);
/// The set-up stage of a request to a board.
[[nodiscard]] UsbRequest RequestTo(BoardRequest request);

}  // namespace annulus
