/// can_board_peer: a ring of twelve simulated CAN boards for another program. Frames come on the standard input and go
/// to the standard output as records of 16 bytes (struct can_frame of linux/can.h). Ends with its input.
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <deque>
#include <vector>

#include "firmware_iface/socket_can_codec.h"
#include "sim/booth.h"
#include "sim/can_bridge.h"
#include "tests/sim/booth_fixture.h"

namespace {

using namespace annulus;
using std::chrono::nanoseconds;

constexpr std::size_t kRecordBytes = 16;

/// The standard input and output as a CAN bus.
class PipeCanBus final : public CanBus {
 public:
  explicit PipeCanBus(Clock& clock) : clock_(clock) {}

  [[nodiscard]] bool at_end() const { return at_end_; }
  CanResult<CanLink> ReadLink() override { return CanLink{"pipe", CanState::kErrorActive, false, {}, {}, {}, 1}; }
  CanResult<void> Send(const CanFrame& frame) override {
    const auto bytes = EncodeSocketCan(frame);
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t written = write(STDOUT_FILENO, bytes.data() + at, bytes.size() - at);
      if (written <= 0) return tl::unexpected<CanFailure>({CanFault::kGone, "output closed"});
      at += static_cast<std::size_t>(written);
    }
    return {};
  }
  CanResult<std::optional<CanReception>> Receive(nanoseconds deadline) override {
    while (true) {
      if (buffer_.size() >= kRecordBytes) {
        const std::vector<std::byte> record(buffer_.begin(), buffer_.begin() + kRecordBytes);
        buffer_.erase(buffer_.begin(), buffer_.begin() + kRecordBytes);
        if (auto what = DecodeSocketCan(record)) return std::optional(CanReception{clock_.Now(), std::move(*what)});
        continue;
      }
      const nanoseconds left = std::max(deadline - clock_.Now(), nanoseconds(0));
      if (at_end_) clock_.SleepUntil(clock_.Now() + left);
      if (at_end_) return std::optional<CanReception>();
      pollfd input{STDIN_FILENO, POLLIN, 0};
      const timespec wait{0, static_cast<long>(left.count())};
      if (ppoll(&input, 1, &wait, nullptr) <= 0) return std::optional<CanReception>();
      std::byte chunk[1024];
      const ssize_t got = read(STDIN_FILENO, chunk, sizeof(chunk));
      at_end_ = got <= 0;
      if (got > 0) buffer_.insert(buffer_.end(), chunk, chunk + got);
    }
  }
  [[nodiscard]] std::uint64_t overflows() const override { return 0; }
  CanResult<void> Reopen() override { return {}; }
  CanResult<void> Restart() override { return {}; }

 private:
  Clock& clock_;
  std::deque<std::byte> buffer_;
  bool at_end_ = false;
};

}  // namespace

int main() {
  SystemClock clock;
  sim::BoothOptions options = sim::CylinderBooth();
  options.axis.start_z_mm = 500.0;
  options.can_buses = 1;
  sim::BoothDevices devices(std::move(options), clock);
  PipeCanBus pipe(clock);
  sim::ServeCanBoards({{devices.can_buses()[0], &pipe}}, clock, {}, [&](nanoseconds) { return !pipe.at_end(); });
  return 0;
}
