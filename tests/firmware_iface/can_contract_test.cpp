// The contracts of CAN buses and of the ring on CAN, on simulated buses and on buses that go wrong harmlessly.

#include <cmath>
#include <utility>
#include <vector>

#include "sim/booth.h"
#include "sim/faulty_can_bus.h"
#include "tests/firmware_iface/can_bus_contract.h"
#include "tests/firmware_iface/range_ring_contract.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::contract {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Two hosts on a simulated wire; `one` goes through a wrapper that can break it.
class SimulatedBuses final : public CanBusFixture {
 public:
  explicit SimulatedBuses(bool with_fd) : wire_(Options(with_fd), clock_), fd_(with_fd) {}

  Clock& clock() override { return clock_; }
  CanBus& one() override { return broken_one_; }
  CanBus& other() override { return other_; }
  [[nodiscard]] bool fd() const override { return fd_; }
  [[nodiscard]] std::size_t too_many_frames() const override { return 6000; }
  [[nodiscard]] bool CanBreak() const override { return true; }
  void Break() override { broken_one_.BreakBetween(clock_.Now(), nanoseconds::max(), CanFault::kDown); }
  void Mend() override { broken_one_.BreakBetween(nanoseconds(0), clock_.Now(), CanFault::kDown); }

 private:
  static sim::CanWireOptions Options(bool with_fd) {
    sim::CanWireOptions options;
    options.fd = with_fd;
    return options;
  }

  ManualClock clock_;
  sim::CanWire wire_;
  CanBus& one_ = wire_.Connect("can0");
  CanBus& other_ = wire_.Connect("can1");
  sim::FaultyCanBus broken_one_{one_, clock_};
  bool fd_;
};

INSTANTIATE_TEST_SUITE_P(
    Can, CanBusContract,
    testing::Values(CanBusCase{"Simulated", [] { return std::make_unique<SimulatedBuses>(false); }},
                    CanBusCase{"SimulatedFd", [] { return std::make_unique<SimulatedBuses>(true); }}),
    NameOfCanBusCase);

/// A ring of twelve boards on simulated buses.
class SimulatedRing final : public RangeRingFixture {
 public:
  struct Set {
    std::size_t buses = 1;
    bool fd = false;
    sim::CanFrameFaults faults;
    std::vector<ReferenceSensor> reference{};  ///< On a board of which the ring must not take notice.
  };
  explicit SimulatedRing(const Set& set) : booth_(Options(set)), fd_(set.fd) {
    if (!set.reference.empty()) options_.reference = {sim::BoothDevices::kReferenceSerial, {0, 1}};
    for (CanBus* bus : booth_.can_buses()) {
      buses_.push_back(std::make_unique<sim::FaultyCanBus>(*bus, booth_.clock(), set.faults));
    }
    for (const Board& board : SimulatedRing::boards()) first_sensors_.push_back(board.first_sensor);
  }

  Clock& clock() override { return booth_.clock(); }
  Result<std::unique_ptr<RangeRing>> Make() override {
    std::vector<CanBus*> buses;
    for (const auto& bus : buses_) buses.push_back(bus.get());
    return MakeCanRangeRing(buses, options_, booth_.clock());
  }
  [[nodiscard]] std::vector<Board> boards() const override {
    std::vector<Board> boards;
    for (std::uint16_t i = 0; i < sim::Booth::kBoards; ++i) {
      boards.push_back({1001U + i, static_cast<std::uint16_t>(15 * i)});
    }
    return boards;
  }
  [[nodiscard]] double expected_range_mm(std::size_t) const override { return 600.0 - sim::kCylinderRadiusMm; }
  [[nodiscard]] double tolerance_mm() const override { return fd_ ? 0.0101 : 0.0201; }
  [[nodiscard]] std::optional<nanoseconds> DeviceTime(std::size_t board, nanoseconds host) const override {
    return const_cast<sim::Booth&>(booth_).can_board(board).DeviceTime(host);
  }
  [[nodiscard]] bool CanUnplug() const override { return true; }
  void Unplug(std::size_t board) override { booth_.can_board(board).PowerOffAt(booth_.clock().Now()); }
  void Replug(std::size_t board) override {
    booth_.can_board(board).PowerOnAt(booth_.clock().Now() + milliseconds(300));
  }
  [[nodiscard]] bool CanSwap() const override { return true; }
  void Swap(std::size_t one, std::size_t other) override {
    std::swap(first_sensors_.at(one), first_sensors_.at(other));
    for (const std::size_t board : {one, other}) booth_.can_board(board).PretendFirstSensor(first_sensors_[board]);
  }

 private:
  static sim::BoothOptions Options(const Set& set) {
    sim::BoothOptions options = sim::CylinderBooth();
    options.axis.start_z_mm = 500.0;
    options.can_buses = set.buses;
    options.can_fd = set.fd;
    options.reference = set.reference;
    return options;
  }

  sim::Booth booth_;
  CanRangeRingOptions options_;
  std::vector<std::unique_ptr<sim::FaultyCanBus>> buses_;
  bool fd_;
  std::vector<std::uint16_t> first_sensors_;  ///< What each board says.
};

RangeRingCase Ring(std::string name, SimulatedRing::Set set) {
  return {std::move(name), [set] { return std::make_unique<SimulatedRing>(set); }};
}

/// Displaced frames only: nothing is lost, and the ring must put everything into its place.
sim::CanFrameFaults Displacing(std::uint64_t seed) {
  sim::CanFrameFaults faults;
  faults.seed = seed;
  faults.displace = 0.1;
  return faults;
}

INSTANTIATE_TEST_SUITE_P(
    Can, RangeRingContract,
    testing::Values(Ring("OneBus", {1, false, {}}), Ring("TwoBuses", {2, false, {}}),
                    Ring("TwelveBuses", {12, false, {}}), Ring("FdBus", {1, true, {}}),
                    Ring("TwoFdBuses", {2, true, {}}), Ring("DisplacedFrames", {1, false, Displacing(1)}),
                    Ring("DisplacedFramesOnTwoBuses", {2, false, Displacing(2)}),
                    Ring("DisplacedFdFrames", {2, true, Displacing(3)}),
                    Ring("WithReference", {1, false, {}, StandardReferenceSensors()}),
                    Ring("DisplacedFramesWithReference", {2, false, Displacing(4), StandardReferenceSensors()})),
    NameOfCase);

}  // namespace
}  // namespace annulus::contract
