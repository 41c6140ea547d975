#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "base/units.h"
#include "firmware_iface/range_ring.h"

namespace annulus::contract {

/// A ring's surroundings, as a test of its contract needs them: the devices on their bus, in simulated or in real time.
class RangeRingFixture {
 public:
  struct Board {
    std::uint32_t serial = 0;
    std::uint16_t first_sensor = 0;
  };

  virtual ~RangeRingFixture() = default;

  /// The host's clock: virtual, or SystemClock.
  virtual Clock& clock() = 0;
  /// A ring over the fixture's devices, which must be idle. Called once per test; the fixture outlives the ring.
  virtual Result<std::unique_ptr<RangeRing>> Make() = 0;
  /// The boards that there are, in the order of their first sensor, which cover sensors 0 … n − 1.
  [[nodiscard]] virtual std::vector<Board> boards() const = 0;
  /// The range that this sensor must tell, mm; NaN where it sees nothing.
  [[nodiscard]] virtual double expected_range_mm(std::size_t sensor) const = 0;

  /// Largest error of a range. 0.6 µm is the rounding of the wire protocol.
  [[nodiscard]] virtual double tolerance_mm() const { return 0.0006; }
  /// What the tests scan at.
  [[nodiscard]] virtual Hertz level_rate() const { return Hertz(30.0); }
  /// Factor on every time that a test allows; about 5 on a slow emulated machine.
  [[nodiscard]] virtual double patience() const { return 1.0; }
  /// A board's clock at a time of the host's, where the fixture knows it.
  [[nodiscard]] virtual std::optional<std::chrono::nanoseconds> DeviceTime(std::size_t /*board*/,
                                                                           std::chrono::nanoseconds /*host*/) const {
    return std::nullopt;
  }

  /// Whether Unplug and Replug do something; the tests that need them are skipped otherwise.
  [[nodiscard]] virtual bool CanUnplug() const { return false; }
  /// Takes a board off the bus at once, whatever it is doing.
  virtual void Unplug(std::size_t /*board*/) {}
  /// Puts it back: it is a freshly started board now, possibly at another address, and may need a second to be ready.
  virtual void Replug(std::size_t /*board*/) {}

  /// Whether Swap does something; the tests that need it are skipped otherwise.
  [[nodiscard]] virtual bool CanSwap() const { return false; }
  /// Two boards of an idle ring change places, as Reopen must notice; once more, and they are back.
  virtual void Swap(std::size_t /*one*/, std::size_t /*other*/) {}
};

/// A named way to make a fixture; the parameter of the suite.
struct RangeRingCase {
  std::string name;
  std::function<std::unique_ptr<RangeRingFixture>()> make;
};
inline void PrintTo(const RangeRingCase& one, std::ostream* out) { *out << one.name; }
/// Names instances by their case: the last argument of INSTANTIATE_TEST_SUITE_P.
inline std::string NameOfCase(const testing::TestParamInfo<RangeRingCase>& info) { return info.param.name; }

/// What every RangeRing must do, whatever its bus. The tests are in range_ring_contract.cpp: add that file to the
/// program, and in any file of it write
///
///     INSTANTIATE_TEST_SUITE_P(Usb, RangeRingContract, testing::Values(RangeRingCase{"simulated", MakeIt}),
///     NameOfCase);
class RangeRingContract : public testing::TestWithParam<RangeRingCase> {
 protected:
  void SetUp() override;

  [[nodiscard]] std::chrono::nanoseconds Patient(std::chrono::nanoseconds time) const;
  [[nodiscard]] std::chrono::nanoseconds In(std::chrono::nanoseconds time) const;
  Result<RingLevel> Next();
  /// Reads levels until one fails, at most as many as two seconds hold.
  Result<RingLevel> ReadUntilFailure();
  /// Reads `count` levels and expects them whole and in order from `first` on.
  void ExpectLevels(std::uint32_t first, std::uint32_t count);
  void ExpectRanges(const RingLevel& level) const;
  /// Reads this board's clock a few times and expects each answer between its bounds.
  void ExpectClock(std::size_t board);
  /// Expects that the ring, whose Reopen was refused with this error, starts and asks nothing until it is opened again.
  void ExpectUnusable(const Error& refused);
  /// Expects the text to name this board by its serial number.
  void ExpectNamed(const std::string& text, std::size_t board) const;

  std::unique_ptr<RangeRingFixture> fixture_;
  std::vector<RangeRingFixture::Board> expected_;
  std::unique_ptr<RangeRing> ring_;
};

}  // namespace annulus::contract
