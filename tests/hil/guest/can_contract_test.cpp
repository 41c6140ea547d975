// The contracts of CAN buses and of the ring on CAN, through SocketCAN and the kernel's drivers.

#include "tests/firmware_iface/can_bus_contract.h"
#include "tests/firmware_iface/range_ring_contract.h"
#include "tests/hil/guest/can_boards.h"
#include "tests/hil/guest/machine.h"

namespace annulus::contract {
namespace {

using std::chrono::nanoseconds;

/// Two sockets on the kernel's interfaces.
class KernelBuses : public CanBusFixture {
 public:
  Clock& clock() override { return clock_; }
  CanBus& one() override { return *one_; }
  CanBus& other() override { return *other_; }
  [[nodiscard]] double patience() const override { return 5.0; }

 protected:
  void Open(const std::string& one, const std::string& other) {
    one_ = OpenOne(one);
    other_ = OpenOne(other);
    // The kernel switches time stamps on in the background when the first socket asks for them.
    clock_.SleepUntil(clock_.Now() + std::chrono::milliseconds(150));
  }

 private:
  std::unique_ptr<CanBus> OpenOne(const std::string& name) {
    auto bus = OpenSocketCan(name, clock_);
    EXPECT_TRUE(bus) << bus.error().Text();
    return bus ? std::move(*bus) : nullptr;
  }

  SystemClock clock_;
  std::unique_ptr<CanBus> one_;
  std::unique_ptr<CanBus> other_;
};

/// Both on one virtual interface, which can be removed.
class VcanBuses final : public KernelBuses {
 public:
  explicit VcanBuses(bool with_fd) : fd_(with_fd) {
    Create();
    Open("vcan1", "vcan1");
  }
  ~VcanBuses() override { hil::Shell("/hil/ip link del vcan1 || true"); }
  [[nodiscard]] bool fd() const override { return fd_; }
  [[nodiscard]] std::size_t too_many_frames() const override { return 40'000; }
  [[nodiscard]] bool CanBreak() const override { return true; }
  void Break() override { hil::Ip("link del vcan1"); }
  void Mend() override { Create(); }

 private:
  void Create() const {
    hil::Ip("link add dev vcan1 txqueuelen 128 type vcan");
    hil::Ip(std::string("link set vcan1 up mtu ") + (fd_ ? "72" : "16"));
  }
  bool fd_;
};

/// Two controllers on one bus, can0 and can1, set up by these words of `ip link`.
class Controllers final : public KernelBuses {
 public:
  Controllers(std::string how, bool with_fd) : how_(std::move(how)), fd_(with_fd) {
    Raise("can0");
    Raise("can1");
    Open("can0", "can1");
  }
  ~Controllers() override {
    hil::Ip("link set can0 down");
    hil::Ip("link set can1 down");
  }
  [[nodiscard]] bool fd() const override { return fd_; }
  [[nodiscard]] bool CanBreak() const override { return true; }
  void Break() override { hil::Ip("link set can0 down"); }
  void Mend() override { Raise("can0"); }

 private:
  void Raise(const std::string& name) const {
    hil::Ip("link set " + name + " txqueuelen 128 type can " + how_);
    hil::Ip("link set " + name + " up");
  }
  std::string how_;
  bool fd_;
};

constexpr const char* kClassic = "bitrate 500000 restart-ms 100";
constexpr const char* kFd = "bitrate 500000 dbitrate 2000000 fd on restart-ms 100";

INSTANTIATE_TEST_SUITE_P(CanKernel, CanBusContract,
                         testing::Values(CanBusCase{"Vcan", [] { return std::make_unique<VcanBuses>(false); }},
                                         CanBusCase{"VcanFd", [] { return std::make_unique<VcanBuses>(true); }},
                                         CanBusCase{"Kvaser",
                                                    [] { return std::make_unique<Controllers>(kClassic, false); }}),
                         NameOfCanBusCase);

INSTANTIATE_TEST_SUITE_P(FdCanKernel, CanBusContract,
                         testing::Values(CanBusCase{"CtuCan", [] { return std::make_unique<Controllers>(kFd, true); }}),
                         NameOfCanBusCase);

/// A ring of twelve boards on a virtual interface, in real time.
class VcanRing final : public RangeRingFixture {
 public:
  explicit VcanRing(bool with_fd) : fd_(with_fd) {
    hil::Ip("link add dev vcan2 txqueuelen 128 type vcan");
    hil::Ip(std::string("link set vcan2 up mtu ") + (with_fd ? "72" : "16"));
    boards_ = std::make_unique<hil::CanBoards>("vcan2", with_fd);
  }
  ~VcanRing() override {
    boards_.reset();
    hil::Shell("/hil/ip link del vcan2 || true");
  }

  Clock& clock() override { return clock_; }
  Result<std::unique_ptr<RangeRing>> Make() override {
    auto bus = OpenSocketCan("vcan2", clock_);
    if (!bus) return Fail(bus);
    bus_ = std::move(*bus);
    CanRangeRingOptions options;
    options.boot_deadline = std::chrono::seconds(15);
    options.heartbeat = std::chrono::milliseconds(300);
    options.sdo_timeout = std::chrono::milliseconds(500);
    return MakeCanRangeRing({bus_.get()}, options, clock_);
  }
  [[nodiscard]] std::vector<Board> boards() const override {
    std::vector<Board> boards;
    for (std::size_t i = 0; i < hil::CanBoards::kCount; ++i) {
      boards.push_back(
          {hil::CanBoards::kFirstSerial + static_cast<std::uint32_t>(i), static_cast<std::uint16_t>(15 * i)});
    }
    return boards;
  }
  [[nodiscard]] double expected_range_mm(std::size_t) const override { return 450.0; }
  [[nodiscard]] double tolerance_mm() const override { return fd_ ? 0.0101 : 0.0201; }  // rounding of the protocol
  [[nodiscard]] double patience() const override { return 5.0; }
  [[nodiscard]] std::optional<nanoseconds> DeviceTime(std::size_t board, nanoseconds host) const override {
    return boards_->DeviceTime(board, host);
  }
  [[nodiscard]] bool CanUnplug() const override { return true; }
  void Unplug(std::size_t board) override { boards_->PowerOff(board); }
  void Replug(std::size_t board) override { boards_->PowerOn(board); }

 private:
  bool fd_;
  SystemClock clock_;
  std::unique_ptr<hil::CanBoards> boards_;
  std::unique_ptr<CanBus> bus_;
};

INSTANTIATE_TEST_SUITE_P(CanKernel, RangeRingContract,
                         testing::Values(RangeRingCase{"Vcan", [] { return std::make_unique<VcanRing>(false); }},
                                         RangeRingCase{"VcanFd", [] { return std::make_unique<VcanRing>(true); }}),
                         NameOfCase);

}  // namespace
}  // namespace annulus::contract
