#include "firmware_iface/can_timing.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

nanoseconds BitTimes(std::int64_t bits, std::uint32_t rate) { return nanoseconds(bits * 1'000'000'000 / rate); }

nanoseconds ClassicTime(const CanFrame& frame, CanBitRates rates) {
  const std::int64_t stuffed = (frame.extended ? 54 : 34) + (frame.remote ? 0 : 8 * std::int64_t{frame.size});
  return BitTimes(stuffed + 13 + (stuffed - 1) / 4, rates.nominal);
}

nanoseconds FdTime(const CanFrame& frame, CanBitRates rates) {
  // SOF, identifier, RRS (and SRR, IDE, 18 more bits), IDE, FDF, res, BRS; then at the data rate ESI, DLC, data; all
  // with a stuff bit after every four. Then the stuff count and the checksum with fixed stuff bits.
  const std::int64_t arbitration = frame.extended ? 36 : 17;
  const std::int64_t payload = 5 + 8 * std::int64_t{frame.size};
  const std::int64_t checksum = 4 + (frame.size <= 16 ? 17 : 21);
  const std::int64_t nominal = arbitration + (arbitration - 1) / 4;
  const std::int64_t data = payload + payload / 4 + checksum + (checksum + 3) / 4;
  // CRC delimiter, ACK, ACK delimiter, end of frame, interframe space.
  constexpr std::int64_t kTail = 1 + 1 + 1 + 7 + 3;
  return BitTimes(nominal + kTail, rates.nominal) + BitTimes(data, frame.bit_rate_switch ? rates.data : rates.nominal);
}

}  // namespace

nanoseconds LongestFrameTime(const CanFrame& frame, CanBitRates rates) {
  return frame.fd ? FdTime(frame, rates) : ClassicTime(frame, rates);
}

}  // namespace annulus
