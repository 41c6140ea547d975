// The contract of every USB port, on a board behind the real kernel's USB.

#include "tests/firmware_iface/usb_port_contract.h"

#include "firmware_iface/usb_host.h"
#include "tests/hil/guest/usb_ring.h"

namespace annulus::contract {
namespace {

constexpr std::size_t kBoard = 4;

class KernelUsbPort final : public UsbPortFixture {
 public:
  KernelUsbPort() {
    EXPECT_TRUE(hil::WaitForBoards(clock_)) << "the kernel does not see all boards";
    auto host = OpenLibusbHost(clock_);
    EXPECT_TRUE(host) << host.error().Text();
    if (!host) return;
    host_ = std::move(*host);
    auto port =
        OpenPort(*host_, {0x1209, 0xA180, hil::SerialOf(kBoard), ""}, clock_, clock_.Now() + std::chrono::seconds(30));
    EXPECT_TRUE(port) << port.error().detail;
    if (port) port_ = std::move(*port);
  }
  ~KernelUsbPort() override {
    if (unplugged_) hil::Plug(kBoard);
  }
  Clock& clock() override { return clock_; }
  UsbPort& port() override { return *port_; }
  [[nodiscard]] std::uint32_t serial() const override { return hil::kFirstSerial + static_cast<std::uint32_t>(kBoard); }
  [[nodiscard]] double patience() const override { return 5.0; }
  [[nodiscard]] bool CanUnplug() const override { return true; }
  void Unplug() override {
    hil::Unplug(kBoard);
    unplugged_ = true;
  }

 private:
  SystemClock clock_;
  std::unique_ptr<UsbHost> host_;
  std::unique_ptr<UsbPort> port_;
  bool unplugged_ = false;
};

INSTANTIATE_TEST_SUITE_P(UsbKernel, UsbPortContract,
                         testing::Values(UsbPortCase{"xhci", [] { return std::make_unique<KernelUsbPort>(); }}),
                         NameOfPortCase);

}  // namespace
}  // namespace annulus::contract
