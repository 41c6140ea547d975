/// write_can_capture FILE: boots a simulated ring on CAN, scans ten levels and writes all that the host sent and
/// received as a capture (pcap, LINKTYPE_CAN_SOCKETCAN). After it come frames whose content is known, one of each kind;
/// check_can.py knows them too.
#include <cstdio>
#include <string>
#include <vector>

#include "firmware_iface/can_level_codec.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/ring_objects.h"
#include "firmware_iface/sdo.h"
#include "sim/booth.h"
#include "tests/sim/booth_fixture.h"

namespace {

using namespace annulus;
using std::chrono::nanoseconds;

/// Little-endian numbers and frames of a pcap file.
class Capture {
 public:
  Capture() {
    constexpr std::uint32_t kLinkTypeCanSocketCan = 227;
    Put<std::uint32_t>(0xA1B23C4D);  // stamps in ns
    Put<std::uint16_t>(2);
    Put<std::uint16_t>(4);
    Put<std::uint32_t>(0);
    Put<std::uint32_t>(0);
    Put<std::uint32_t>(65535);
    Put<std::uint32_t>(kLinkTypeCanSocketCan);
  }
  void Add(const CanFrame& frame, nanoseconds time) {
    Put(static_cast<std::uint32_t>(time / std::chrono::seconds(1)));
    Put(static_cast<std::uint32_t>((time % std::chrono::seconds(1)).count()));
    const std::uint32_t length = 8U + frame.size;
    Put(length);
    Put(length);
    // The identifier alone stands in network byte order.
    for (int shift = 24; shift >= 0; shift -= 8) bytes_.push_back(static_cast<std::byte>(frame.id >> shift & 0xFF));
    bytes_.push_back(static_cast<std::byte>(frame.size));
    bytes_.push_back(static_cast<std::byte>(frame.fd ? 0x05 : 0x00));
    bytes_.insert(bytes_.end(), 2, std::byte{0});
    bytes_.insert(bytes_.end(), frame.data.begin(), frame.data.begin() + frame.size);
  }
  [[nodiscard]] bool Save(const std::string& path) const {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return false;
    const bool written = std::fwrite(bytes_.data(), 1, bytes_.size(), file) == bytes_.size();
    return std::fclose(file) == 0 && written;
  }

 private:
  template <class Unsigned>
  void Put(Unsigned value) {
    std::array<std::byte, sizeof(Unsigned)> bytes{};
    PutLittleEndian(std::span<std::byte>(bytes), value);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> bytes_;
};

/// Passes everything on and writes it down.
class CapturingBus final : public CanBus {
 public:
  CapturingBus(CanBus& bus, Clock& clock, Capture& capture) : bus_(bus), clock_(clock), capture_(capture) {}
  CanResult<CanLink> ReadLink() override { return bus_.ReadLink(); }
  CanResult<void> Send(const CanFrame& frame) override {
    capture_.Add(frame, clock_.Now());
    return bus_.Send(frame);
  }
  CanResult<std::optional<CanReception>> Receive(nanoseconds deadline) override {
    auto received = bus_.Receive(deadline);
    if (!received || !*received) return received;
    if (const auto* frame = std::get_if<CanFrame>(&(*received)->what)) capture_.Add(*frame, (*received)->host_time);
    return received;
  }
  [[nodiscard]] std::uint64_t overflows() const override { return bus_.overflows(); }
  CanResult<void> Reopen() override { return bus_.Reopen(); }
  CanResult<void> Restart() override { return bus_.Restart(); }

 private:
  CanBus& bus_;
  Clock& clock_;
  Capture& capture_;
};

Status Scan(Capture& capture, nanoseconds& end) {
  sim::BoothOptions options = sim::CylinderBooth();
  options.axis.start_z_mm = 500.0;
  options.can_buses = 1;
  sim::Booth booth(std::move(options));
  CapturingBus bus(*booth.can_buses()[0], booth.clock(), capture);
  auto ring = MakeCanRangeRing({&bus}, {}, booth.clock());
  if (!ring) return Fail(ring);
  RETURN_IF_ERROR((*ring)->Start(Hertz(30.0)));
  for (int i = 0; i < 10; ++i) {
    const auto level = (*ring)->NextLevel(booth.clock().Now() + std::chrono::milliseconds(200));
    if (!level) return Fail(level);
  }
  RETURN_IF_ERROR((*ring)->Stop());
  end = booth.clock().Now() + std::chrono::seconds(1);
  return {};
}

void AddKnownFrames(Capture& capture, nanoseconds time) {
  capture.Add(EncodeNmt({NmtCommand::kStart, 5}), time);
  capture.Add(EncodeNmt({NmtCommand::kResetCommunication, 0}), time);
  capture.Add(EncodeSync(17), time);
  capture.Add(EncodeEmergency({9, 0x8150, 1, 1009, 0}), time);
  capture.Add(EncodeHeartbeat({12, NmtState::kBootUp}), time);
  capture.Add(EncodeHeartbeat({12, NmtState::kOperational}), time);
  capture.Add(*SdoTransfer::Upload(7, {kClockIndex, 3}).TakeRequest(), time);
  capture.Add(*SdoTransfer::Download(7, kObjectHeartbeat, ObjectBytes(std::uint16_t{100})).TakeRequest(), time);
  SdoServer server(7, {[](SdoAddress) { return ObjectBytes(std::uint32_t{0x44332211}); }, {}});
  capture.Add(*server.Answer(*SdoTransfer::Upload(7, {kClockIndex, 3}).TakeRequest()), time);
  for (const CanFrame& frame : EncodeCanLevel(3, {})) capture.Add(frame, time);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_can_capture FILE\n");
    return 2;
  }
  Capture capture;
  nanoseconds end{0};
  if (const Status scanned = Scan(capture, end); !scanned) {
    std::fprintf(stderr, "%s\n", scanned.error().Text().c_str());
    return 1;
  }
  AddKnownFrames(capture, end);
  return capture.Save(argv[1]) ? 0 : 1;
}
