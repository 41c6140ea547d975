#include "firmware_iface/socket_can_codec.h"

#include <linux/can.h>
#include <linux/can/error.h>

#include <algorithm>
#include <cstring>

#include "base/ensure.h"

namespace annulus {
namespace {

static_assert(sizeof(can_frame) == CAN_MTU && sizeof(canfd_frame) == CANFD_MTU);

/// A counter above this makes a controller warn (ISO 11898-1 leaves the number to it; all use 96).
constexpr unsigned kPassiveLimit = 128;
constexpr unsigned kWarningLimit = 96;

CanState StateOfController(std::uint8_t flags, const CanReport& report) {
  if ((flags & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) return CanState::kErrorPassive;
  if ((flags & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) return CanState::kErrorWarning;
  const unsigned worst = std::max(report.transmit_errors, report.receive_errors);
  if (worst >= kPassiveLimit) return CanState::kErrorPassive;
  return worst >= kWarningLimit ? CanState::kErrorWarning : CanState::kErrorActive;
}

CanReport DecodeReport(const can_frame& frame) {
  CanReport report;
  const canid_t what = frame.can_id;
  // Drivers without the CNT flag leave zeros here, or (as sja1000) fill them in all the same.
  report.transmit_errors = frame.data[6];
  report.receive_errors = frame.data[7];
  if ((what & CAN_ERR_CRTL) != 0) {
    const std::uint8_t flags = frame.data[1];
    report.receive_overflow = (flags & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
    report.transmit_overflow = (flags & CAN_ERR_CRTL_TX_OVERFLOW) != 0;
    constexpr int kStateFlags = CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE | CAN_ERR_CRTL_RX_WARNING |
                                CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_ACTIVE;
    if ((flags & kStateFlags) != 0) report.state = StateOfController(flags, report);
  }
  report.no_acknowledge = (what & CAN_ERR_ACK) != 0;
  report.protocol_error = (what & (CAN_ERR_PROT | CAN_ERR_BUSERROR)) != 0;
  report.lost_arbitration = (what & CAN_ERR_LOSTARB) != 0;
  if ((what & CAN_ERR_RESTARTED) != 0) {
    report.restarted = true;
    report.state = CanState::kErrorActive;
  }
  if ((what & CAN_ERR_BUSOFF) != 0) report.state = CanState::kBusOff;
  return report;
}

canid_t IdOf(const CanFrame& frame) {
  return frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.remote ? CAN_RTR_FLAG : 0U);
}

template <class Kernel>
std::vector<std::byte> BytesOf(const Kernel& kernel_frame) {
  std::vector<std::byte> bytes(sizeof(Kernel));
  std::memcpy(bytes.data(), &kernel_frame, sizeof(Kernel));
  return bytes;
}

CanFrame FrameOf(canid_t id, std::uint8_t size, const std::uint8_t* data) {
  CanFrame frame;
  frame.extended = (id & CAN_EFF_FLAG) != 0;
  frame.remote = (id & CAN_RTR_FLAG) != 0;
  frame.id = id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.size = size;
  if (!frame.remote) std::memcpy(frame.data.data(), data, size);
  return frame;
}

}  // namespace

std::vector<std::byte> EncodeSocketCan(const CanFrame& frame) {
  ENSURE(frame.id <= (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK), "the identifier fits its kind");
  ENSURE(frame.fd ? IsCanFdSize(frame.size) && !frame.remote : frame.size <= CAN_MAX_DLEN, "CAN has such a frame");
  if (frame.fd) {
    canfd_frame out{};
    out.can_id = IdOf(frame);
    out.len = frame.size;
    out.flags = static_cast<__u8>(CANFD_FDF | (frame.bit_rate_switch ? CANFD_BRS : 0));
    std::memcpy(out.data, frame.data.data(), frame.size);
    return BytesOf(out);
  }
  can_frame out{};
  out.can_id = IdOf(frame);
  out.len = frame.size;
  std::memcpy(out.data, frame.data.data(), frame.size);
  return BytesOf(out);
}

std::optional<std::variant<CanFrame, CanReport>> DecodeSocketCan(std::span<const std::byte> bytes) {
  if (bytes.size() == CANFD_MTU) {
    canfd_frame in;
    std::memcpy(&in, bytes.data(), sizeof(in));
    if ((in.can_id & (CAN_ERR_FLAG | CAN_RTR_FLAG)) != 0 || !IsCanFdSize(in.len)) return std::nullopt;
    CanFrame frame = FrameOf(in.can_id, in.len, in.data);
    frame.fd = true;
    frame.bit_rate_switch = (in.flags & CANFD_BRS) != 0;
    return frame;
  }
  if (bytes.size() != CAN_MTU) return std::nullopt;
  can_frame in;
  std::memcpy(&in, bytes.data(), sizeof(in));
  if (in.len > CAN_MAX_DLEN) return std::nullopt;
  if ((in.can_id & CAN_ERR_FLAG) != 0) return DecodeReport(in);
  return FrameOf(in.can_id, in.len, in.data);
}

std::chrono::nanoseconds ArrivalOf(const SocketCanTimes& times) {
  using std::chrono::nanoseconds;
  // A wall clock that is slewed runs up to 0.05 % faster than the host's.
  constexpr int kSlew = 1000;
  constexpr nanoseconds kRounding = std::chrono::milliseconds(1);
  // What a full receive buffer can hold.
  constexpr nanoseconds kOldest = std::chrono::seconds(10);
  const nanoseconds waited = std::min(times.now - times.empty_since, kOldest);
  const nanoseconds age = times.wall_now - times.stamp;
  if (age < nanoseconds(0) || age > waited + waited / kSlew + kRounding) return times.now;
  return times.now - std::min(age, waited);
}

}  // namespace annulus
