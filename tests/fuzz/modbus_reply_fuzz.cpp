#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "firmware_iface/drive_dialogue.h"

namespace {

using annulus::ModbusFraming;
using Bytes = std::vector<std::uint8_t>;

constexpr int kUnit = 1;
constexpr std::size_t kMostReplies = 4;

void Require(bool condition) {
  if (!condition) std::abort();
}

/// CRC-16 of Modbus over serial line V1.02, 6.2.2: reflected polynomial A001h, start FFFFh; low byte first.
void AppendCrc(Bytes& frame) {
  std::uint16_t crc = 0xFFFF;
  for (const std::uint8_t byte : frame) {
    crc = static_cast<std::uint16_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 1U) != 0 ? crc >> 1 ^ 0xA001 : crc >> 1);
    }
  }
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
}

/// A reply as a drive frames it, around a body that the input chose.
Bytes Framed(ModbusFraming framing, std::uint16_t transaction, const Bytes& body) {
  if (framing == ModbusFraming::kRtu) {
    Bytes frame{kUnit};
    frame.insert(frame.end(), body.begin(), body.end());
    AppendCrc(frame);
    return frame;
  }
  const std::size_t length = body.size() + 1;
  Bytes frame{static_cast<std::uint8_t>(transaction >> 8), static_cast<std::uint8_t>(transaction & 0xFFU), 0,    0,
              static_cast<std::uint8_t>(length >> 8),      static_cast<std::uint8_t>(length & 0xFFU),      kUnit};
  frame.insert(frame.end(), body.begin(), body.end());
  return frame;
}

/// The body of a well-formed FC23 reply with this echo, its other registers from the input.
Bytes WellFormed(std::uint16_t counter, std::uint16_t count, const Bytes& chosen) {
  Bytes body{0x17, static_cast<std::uint8_t>(2 * count), static_cast<std::uint8_t>(counter >> 8),
             static_cast<std::uint8_t>(counter & 0xFFU)};
  body.resize(static_cast<std::size_t>(2 + 2 * count), 0);
  for (std::size_t i = 0; i < chosen.size() && 4 + i < body.size(); ++i) body[4 + i] = chosen[i];
  return body;
}

}  // namespace

// A wait of 1 us shall not become one of the kernel's usual 50 us.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  return 0;
}

// Whatever bytes come back through libmodbus: no crash, no wait, and what is taken for the answer carries the counter
// of this very transaction and stands, register by register, in the bytes that came.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const ModbusFraming framing = (data[0] & 1U) != 0 ? ModbusFraming::kRtu : ModbusFraming::kTcp;
  std::array<int, 2> ends{};
  Require(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) == 0);
  auto link = annulus::AdoptModbusDescriptor(ends[0], framing, kUnit);
  Require(link.has_value());
  annulus::ManualClock clock;
  const annulus::AxisRegisterMap map;
  const auto block = map.StatusBlock();
  annulus::DriveDialogue dialogue(**link, map, clock, {std::chrono::microseconds(1), std::chrono::nanoseconds(0)});

  Bytes came;
  std::size_t at = 1;
  std::uint16_t counter = 0;
  for (std::size_t reply = 0; reply < kMostReplies && at + 1 < size; ++reply) {
    ++counter;
    const std::uint8_t kind = data[at];
    const std::size_t length = std::min<std::size_t>(data[at + 1], size - at - 2);
    const Bytes chosen(data + at + 2, data + at + 2 + length);
    at += 2 + length;
    // What arrives before we ask waits in the socket, as a late reply does. A counter off by a little: also that.
    const auto told = static_cast<std::uint16_t>(counter - kind / 64);
    Bytes bytes = chosen;
    if (kind % 4 == 1) bytes = Framed(framing, told, chosen);
    if (kind % 4 >= 2) bytes = Framed(framing, told, WellFormed(told, block.count, chosen));
    if (kind % 4 == 3 && !bytes.empty()) bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), kind / 4 % 8));
    static_cast<void>(::write(ends[1], bytes.data(), bytes.size()));
    came.insert(came.end(), bytes.begin(), bytes.end());

    const annulus::DriveReply answer = dialogue.Read(block);
    if (!answer) continue;
    Require(answer->registers.Word(map.echo) == counter);
    Bytes taken;
    for (int i = 0; i < block.count; ++i) {
      const std::uint16_t word = answer->registers.Word(static_cast<std::uint16_t>(block.address + i));
      taken.push_back(static_cast<std::uint8_t>(word >> 8));
      taken.push_back(static_cast<std::uint8_t>(word & 0xFFU));
    }
    Require(std::search(came.begin(), came.end(), taken.begin(), taken.end()) != came.end());
  }
  link->reset();
  ::close(ends[1]);
  return 0;
}
