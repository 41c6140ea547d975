#include "tests/firmware_iface/range_ring_contract.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::contract {
namespace {

/// The boards of the simulated booth through ports that never close, in virtual time.
class BorrowedPorts final : public RangeRingFixture {
 public:
  BorrowedPorts() : booth_(Options()) {}

  Clock& clock() override { return booth_.clock(); }
  Result<std::unique_ptr<RangeRing>> Make() override {
    return MakeUsbRangeRing(booth_.usb_ports(), {}, booth_.clock());
  }
  [[nodiscard]] std::vector<Board> boards() const override {
    std::vector<Board> boards;
    for (std::uint16_t i = 0; i < sim::Booth::kBoards; ++i) {
      boards.push_back({1001U + i, static_cast<std::uint16_t>(15 * i)});
    }
    return boards;
  }
  [[nodiscard]] double expected_range_mm(std::size_t) const override { return 600.0 - sim::kCylinderRadiusMm; }
  [[nodiscard]] std::optional<std::chrono::nanoseconds> DeviceTime(std::size_t board,
                                                                   std::chrono::nanoseconds host) const override {
    return booth_.board(board).DeviceTime(host);
  }

 private:
  static sim::BoothOptions Options() {
    sim::BoothOptions options = sim::CylinderBooth();
    options.axis.start_z_mm = 500.0;
    return options;
  }

  mutable sim::Booth booth_;
};

INSTANTIATE_TEST_SUITE_P(Usb, RangeRingContract,
                         testing::Values(RangeRingCase{"borrowed_ports",
                                                       [] { return std::make_unique<BorrowedPorts>(); }}),
                         NameOfCase);

}  // namespace
}  // namespace annulus::contract
