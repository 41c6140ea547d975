#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "firmware_iface/range_ring.h"
#include "sim/booth.h"
#include "sim/faulty_can_bus.h"
#include "tests/sim/booth_fixture.h"

namespace annulus {

/// A booth whose boards hang on CAN buses that can go wrong. The carriage stands above the cylinder's foot.
class CanRingBench {
 public:
  static constexpr double kExpectedRangeMm = 600.0 - sim::kCylinderRadiusMm;
  static constexpr Hertz kRate{30.0};

  struct Set {
    std::size_t buses = 1;
    bool fd = false;
    sim::CanWireOptions wire;
    sim::BeamOptions beam = sim::ExactBeam();
    std::vector<ReferenceSensor> reference{};
  };
  CanRingBench() : CanRingBench(Set()) {}
  explicit CanRingBench(Set set) : booth_(Options(set)) {
    for (CanBus* bus : booth_.can_buses()) {
      buses_.push_back(std::make_unique<sim::FaultyCanBus>(*bus, booth_.clock()));
    }
  }
  static sim::BoothOptions Options(const Set& set) {
    sim::BoothOptions options = sim::CylinderBooth(set.beam);
    options.axis.start_z_mm = 500.0;
    options.can_buses = set.buses;
    options.can_fd = set.fd;
    options.can_wire = set.wire;
    options.reference = set.reference;
    return options;
  }
  std::vector<CanBus*> Buses() {
    std::vector<CanBus*> buses;
    for (const auto& bus : buses_) buses.push_back(bus.get());
    return buses;
  }
  Result<std::unique_ptr<RangeRing>> Make(CanRangeRingOptions options = {}) {
    return MakeCanRangeRing(Buses(), std::move(options), booth_.clock());
  }
  std::unique_ptr<RangeRing> Started() {
    auto ring = Make();
    EXPECT_TRUE(ring) << ring.error().Text();
    const Status started = (*ring)->Start(kRate);
    EXPECT_TRUE(started) << started.error().Text();
    return std::move(*ring);
  }
  Result<RingLevel> Next(RangeRing& ring) { return ring.NextLevel(Now() + std::chrono::milliseconds(100)); }
  /// Reads until an error, at most `levels`.
  Result<RingLevel> ReadUntilFailure(RangeRing& ring, int levels = 60) {
    Result<RingLevel> level = Next(ring);
    for (int i = 0; i < levels && level; ++i) level = Next(ring);
    return level;
  }
  [[nodiscard]] std::chrono::nanoseconds Now() { return booth_.clock().Now(); }

  sim::Booth booth_;
  std::vector<std::unique_ptr<sim::FaultyCanBus>> buses_;
};

}  // namespace annulus
