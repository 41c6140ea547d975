// The contract of every ring, on the boards behind the real kernel's USB.

#include <set>

#include "firmware_iface/usb_host.h"
#include "tests/firmware_iface/range_ring_contract.h"
#include "tests/hil/guest/usb_ring.h"

namespace annulus::contract {
namespace {

/// The twelve boards that the runner plugs into the machine, in real time.
class KernelUsbRing final : public RangeRingFixture {
 public:
  ~KernelUsbRing() override {
    for (const std::size_t board : unplugged_) hil::Plug(board);
  }
  Clock& clock() override { return clock_; }
  Result<std::unique_ptr<RangeRing>> Make() override {
    EXPECT_TRUE(hil::WaitForBoards(clock_)) << "the kernel does not see all boards";
    auto host = OpenLibusbHost(clock_);
    if (!host) return Fail(host);
    host_ = std::move(*host);
    return OpenUsbRangeRing(*host_, hil::PatientRingOptions(), clock_);
  }
  [[nodiscard]] std::vector<Board> boards() const override {
    std::vector<Board> boards;
    for (std::size_t i = 0; i < hil::kBoards; ++i) {
      boards.push_back({hil::kFirstSerial + static_cast<std::uint32_t>(i), static_cast<std::uint16_t>(15 * i)});
    }
    return boards;
  }
  [[nodiscard]] double expected_range_mm(std::size_t) const override { return hil::kExpectedRangeMm; }
  [[nodiscard]] double patience() const override { return 5.0; }

  [[nodiscard]] bool CanUnplug() const override { return true; }
  void Unplug(std::size_t board) override {
    hil::Unplug(board);
    unplugged_.insert(board);
  }
  void Replug(std::size_t board) override {
    hil::Plug(board);
    unplugged_.erase(board);
  }

 private:
  SystemClock clock_;
  std::unique_ptr<UsbHost> host_;
  std::set<std::size_t> unplugged_;
};

INSTANTIATE_TEST_SUITE_P(UsbKernel, RangeRingContract,
                         testing::Values(RangeRingCase{"xhci", [] { return std::make_unique<KernelUsbRing>(); }}),
                         NameOfCase);

}  // namespace
}  // namespace annulus::contract
