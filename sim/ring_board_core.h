#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <random>
#include <vector>

#include "base/reference_sensor.h"
#include "firmware_iface/usb_frame_codec.h"
#include "sim/board_faults.h"
#include "sim/world.h"

namespace annulus::sim {

/// The wire that makes all boards fire together. One board drives it. SYNC edge k is at start + k · period.
struct SyncLine {
  std::uint32_t run = 0;  ///< Times started; edge 0 is that of the present run.
  std::chrono::nanoseconds start{0};
  std::chrono::nanoseconds stop{0};  ///< No edge from here on; start >= stop: the line is quiet.
  double period_ns = 0.0;

  [[nodiscard]] std::chrono::nanoseconds EdgeTime(std::uint64_t edge) const;
  /// The first edge at `time` or later, whether or not the line still runs then. Requires a period.
  [[nodiscard]] std::uint64_t EdgeFrom(std::chrono::nanoseconds time) const;
};

struct RingBoardOptions {
  std::uint32_t serial = 1;
  std::uint16_t first_sensor = 0;
  std::uint64_t seed = 1;
  double clock_drift_ppm = 20.0;  ///< Largest; each board draws its own, either sign.
  std::chrono::nanoseconds fire_delay = std::chrono::microseconds(300);     ///< Largest constant SYNC-to-fire delay.
  std::chrono::nanoseconds fire_jitter = std::chrono::microseconds(20);     ///< Largest, per level, on top.
  std::chrono::nanoseconds frame_delay = std::chrono::microseconds(900);    ///< From firing to the frame's arrival.
  std::chrono::nanoseconds frame_jitter = std::chrono::microseconds(300);   ///< Largest, on top.
  std::chrono::nanoseconds control_delay = std::chrono::microseconds(60);   ///< One way, at least.
  std::chrono::nanoseconds control_jitter = std::chrono::microseconds(40);  ///< Mean of what comes on top, one way.
  double split_share = 0.2;                                                 ///< Frames that arrive in two transfers.
  std::uint32_t max_level_rate_mhz = 100'000;  ///< Highest level rate that a board on USB takes, mHz.
  std::size_t fifo_frames = 64;                ///< Frames kept while nobody asks; then the newest is lost.
  double temperature_c = 31.0;                 ///< Of the ring, degrees Celsius; what boards report lies within 1.
  /// Of a reference board: where its sensors stand; channels without one see nothing. Empty: a board of the ring.
  std::vector<ReferenceSensor> reference;
};

/// What every board says of itself, on any bus.
inline constexpr std::array<std::uint8_t, 3> kBoardFirmwareVersion{1, 2, 0};
inline constexpr std::uint32_t kBoardMinLevelRateMhz = 15'000;
inline constexpr std::uint32_t kBoardMaxLevelRateMhz = 100'000;

/// What a number drawn by a board is for, so that each purpose has its own.
enum class BoardDraw : std::uint64_t {
  kClock = 1,
  kDrift = 2,
  kDelay = 3,
  kControl = 4,
  kFire = 5,
  kArrival = 6,
  kSplit = 7,
  kBeam = 8,
  kTemperature = 9,
  kBoot = 10,
  kFault = 11,
  kStuck = 12,
};

/// A concentrator board without its bus: 15 sensors, a crystal of its own, delays. What it measures depends on seed,
/// serial, run, sequence, the time of firing and what is wrong with it only. Reentrant but for StartRun. Borrows the
/// world.
class RingBoardCore {
 public:
  RingBoardCore(const RingBoardOptions& options, World& world);

  /// The board's clock at a time.
  [[nodiscard]] std::chrono::nanoseconds DeviceTime(std::chrono::nanoseconds time) const;
  /// A time that the board counts on its own crystal, in true ns.
  [[nodiscard]] double CrystalNs(double counted_ns) const { return counted_ns / (1.0 + clock_drift_); }
  /// A new run has other noise than those before.
  void StartRun() { ++runs_; }
  /// When the sensors fire for an edge of SYNC.
  [[nodiscard]] std::chrono::nanoseconds FireTime(std::uint32_t sequence, std::chrono::nanoseconds edge) const;
  /// When the level that fired at `fire` is ready to leave the board. Levels are `period_ns` apart.
  [[nodiscard]] std::chrono::nanoseconds ReadyTime(std::uint32_t sequence, std::chrono::nanoseconds fire,
                                                   double period_ns) const;
  /// The sensors' readings of the moment of firing.
  [[nodiscard]] LevelFrame Measure(std::uint32_t sequence, std::chrono::nanoseconds fire) const;
  /// 64 random bits of a level of this run.
  [[nodiscard]] std::uint64_t LevelBits(std::uint32_t sequence, BoardDraw purpose) const;
  /// What is wrong with the board.
  [[nodiscard]] BoardFaults& faults() { return faults_; }
  [[nodiscard]] const BoardFaults& faults() const { return faults_; }
  /// 64 random bits of the board.
  [[nodiscard]] std::uint64_t BoardBits(BoardDraw purpose) const;

 private:
  /// What a sensor reads at a time.
  [[nodiscard]] BeamReading Look(std::size_t sensor, std::chrono::nanoseconds time, std::mt19937_64& random) const;
  /// The same of a channel of a reference board: the ring itself gets in the way when it passes.
  [[nodiscard]] BeamReading LookFromWall(std::size_t channel, std::chrono::nanoseconds time,
                                         std::mt19937_64& random) const;

  RingBoardOptions options_;
  World& world_;
  BoardFaults faults_;
  std::uint64_t seed_;
  std::chrono::nanoseconds clock_offset_{0};
  double clock_drift_ = 0.0;
  std::chrono::nanoseconds fire_delay_{0};
  std::uint32_t runs_ = 0;
};

/// A share of a time, to the nearest ns.
[[nodiscard]] std::chrono::nanoseconds ShareOf(std::chrono::nanoseconds whole, double share);

}  // namespace annulus::sim
