#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/faulty_usb_port.h"
#include "sim/usb_host_model.h"
#include "tests/firmware_iface/forwarding_usb_port.h"
#include "tests/firmware_iface/range_ring_contract.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::contract {
namespace {

using std::chrono::milliseconds;

/// The boards of the simulated booth through ports that never close, in virtual time.
class BorrowedPorts : public RangeRingFixture {
 public:
  /// `reference`: sensors beside the ring, on a board of which the ring must not take notice.
  explicit BorrowedPorts(const std::vector<ReferenceSensor>& reference = {}) : booth_(Options(reference)) {
    if (!reference.empty()) options_.reference = {sim::BoothDevices::kReferenceSerial, {0, 1}};
    for (UsbPort* port : booth_.usb_ports()) {
      ports_.push_back(std::make_unique<ForwardingUsbPort>(*port));
      first_sensors_.push_back(static_cast<std::uint16_t>(15 * first_sensors_.size()));
    }
  }

  Clock& clock() override { return booth_.clock(); }
  Result<std::unique_ptr<RangeRing>> Make() override {
    std::vector<UsbPort*> ports;
    for (const auto& port : ports_) ports.push_back(port.get());
    return MakeUsbRangeRing(ports, options_, booth_.clock());
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
  [[nodiscard]] bool CanSwap() const override { return true; }
  /// By what they say of themselves: a port that never closes is always at the same place.
  void Swap(std::size_t one, std::size_t other) override {
    std::swap(first_sensors_.at(one), first_sensors_.at(other));
    for (const std::size_t board : {one, other}) {
      ports_[board]->on_control_in = [this, board](UsbRequest request, std::vector<std::byte>& reply) {
        if (request.request != static_cast<std::uint8_t>(BoardRequest::kIdentify)) return;
        BoardIdentity identity = DecodeBoardIdentity(reply).value();
        identity.first_sensor = first_sensors_[board];
        const auto bytes = EncodeBoardIdentity(identity);
        reply.assign(bytes.begin(), bytes.end());
      };
    }
  }

 protected:
  [[nodiscard]] sim::Booth& booth() { return booth_; }
  [[nodiscard]] const UsbRangeRingOptions& options() const { return options_; }

 private:
  static sim::BoothOptions Options(const std::vector<ReferenceSensor>& reference) {
    sim::BoothOptions options = sim::CylinderBooth();
    options.reference = reference;
    options.axis.start_z_mm = 500.0;
    return options;
  }

  mutable sim::Booth booth_;
  UsbRangeRingOptions options_;
  std::vector<std::unique_ptr<ForwardingUsbPort>> ports_;
  std::vector<std::uint16_t> first_sensors_;  ///< What each board says.
};

/// The same boards on a bus where they can be unplugged, through ports of which `plan` says how they lie.
class SimulatedBus final : public BorrowedPorts {
 public:
  explicit SimulatedBus(const sim::UsbFaultPlan& plan, const std::vector<ReferenceSensor>& reference = {})
      : BorrowedPorts(reference), host_(booth().clock()) {
    for (std::size_t i = 0; i < booth().board_count(); ++i) host_.Add(booth().board(i));
    host_.wrap = [this, plan](std::unique_ptr<UsbPort> port) {
      sim::UsbFaultPlan own = plan;
      own.seed += ++ports_;
      return std::make_unique<sim::FaultyUsbPort>(std::move(port), own, log_);
    };
  }
  ~SimulatedBus() override { EXPECT_EQ(host_.leaked_transfers(), 0U); }

  Result<std::unique_ptr<RangeRing>> Make() override { return OpenUsbRangeRing(host_, options(), clock()); }
  [[nodiscard]] bool CanUnplug() const override { return true; }
  void Unplug(std::size_t board) override { host_.UnplugAt(board, clock().Now()); }
  void Replug(std::size_t board) override { host_.PlugAt(board, clock().Now() + milliseconds(300), milliseconds(900)); }
  [[nodiscard]] bool CanSwap() const override { return true; }
  void Swap(std::size_t one, std::size_t other) override {
    for (const std::size_t board : {one, other}) Unplug(board);
    for (const std::size_t board : {one, other}) host_.PlugAt(board, clock().Now());
    clock().SleepUntil(clock().Now() + milliseconds(1));
    std::swap(sockets_.at(one), sockets_.at(other));
    for (const std::size_t board : {one, other}) {
      host_.SetIdentity(board, "RB" + std::to_string(boards()[board].serial), "1-1." + std::to_string(sockets_[board]));
    }
  }

 private:
  std::uint64_t ports_ = 0;
  sim::UsbFaultLog log_;
  sim::UsbHostModel host_;
  std::array<int, sim::Booth::kBoards> sockets_{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};  ///< Of each board.
};

/// Faults that a ring must bear without anybody noticing.
sim::UsbFaultPlan Bearable(sim::UsbFaultPlan::UnplugEnding ending) {
  sim::UsbFaultPlan plan;
  plan.timeout_share = 0.1;
  plan.cancel_completes_share = 0.5;
  plan.unplug_ending = ending;
  return plan;
}

template <class Fixture, class... Arguments>
RangeRingCase Case(const char* name, Arguments... arguments) {
  return {name, [arguments...] { return std::make_unique<Fixture>(arguments...); }};
}

using Ending = sim::UsbFaultPlan::UnplugEnding;
INSTANTIATE_TEST_SUITE_P(Usb, RangeRingContract,
                         testing::Values(Case<BorrowedPorts>("borrowed_ports"),
                                         Case<BorrowedPorts>("with_reference", StandardReferenceSensors()),
                                         Case<SimulatedBus>("simulated_bus", sim::UsbFaultPlan{}),
                                         Case<SimulatedBus>("bus_with_reference", Bearable(Ending::kAny),
                                                            StandardReferenceSensors()),
                                         Case<SimulatedBus>("faulty_bus", Bearable(Ending::kAny)),
                                         Case<SimulatedBus>("unplug_ends_in_error", Bearable(Ending::kError)),
                                         Case<SimulatedBus>("unplug_ends_well", Bearable(Ending::kCompleted))),
                         NameOfCase);

}  // namespace
}  // namespace annulus::contract
