#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/arm_check.h"
#include "acquisition/beat_clock.h"
#include "acquisition/bus_tap.h"
#include "acquisition/recording.h"
#include "acquisition/scan_gate.h"
#include "acquisition/scan_machine.h"
#include "acquisition/scan_quality.h"
#include "acquisition/scan_run.h"
#include "acquisition/scan_sink.h"
#include "acquisition/scan_warning.h"
#include "base/clock.h"
#include "base/result.h"
#include "base/storage.h"
#include "firmware_iface/interlock.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// The booth's devices, opened and identified. Borrowed; only the scanner calls them from its making on. Ring, axis and
/// tap belong to the worker thread, the interlock to the control thread.
struct ScannerDevices {
  RangeRing& ring;
  ScanAxis& axis;
  Interlock& interlock;
  BeatClock& clock;       ///< That of ring and axis.
  BusTap* tap = nullptr;  ///< Null: no raw bytes are recorded.
};

/// How a scan, or a search, ended.
struct ScanResult {
  std::uint64_t number = 0;  ///< Of the scan since the program started, 1 first.
  Status status;             ///< An error if it did not come to its end, except by Cancel.
  ScanPlan plan;
  ScanSummary summary;
  bool complete = false;           ///< Every level of the plan, durable (I10).
  bool recorded = false;           ///< There is a file.
  std::string recording;           ///< Its path; of an interrupted scan, too.
  std::optional<Millimetres> top;  ///< Of a search.
  /// Shared, because everybody who looks at the status would copy the whole map, with the scanner held up meanwhile.
  std::shared_ptr<const ScanQuality> quality;  ///< Of a scan that was recorded.
};

/// What anybody may know.
struct ScannerStatus {
  ScanState state = ScanState::kSafe;
  std::uint64_t version = 0;
  bool homed = false;
  std::vector<ScanCause> causes;       ///< Latched, the first one first.
  std::string held_by;                 ///< Why the chain holds the outputs, if it does.
  std::vector<InterlockNotice> chain;  ///< What is wrong with the chain.
  std::optional<SafetyLines> lines;    ///< Of the chain, since they last changed; nothing before the first reading.
  std::vector<ScanWarning> warnings;   ///< What stops nothing: late ticks, a slow disk, lamps.
  std::string job;                     ///< What the worker does: "", "home", "arm", "scan", "jog", "recover".
  std::string stage;                   ///< Of it, for people.
  double done = 0.0;                   ///< Of `total` units of the stage.
  double total = 0.0;
  std::uint64_t start_presses = 0;           ///< Of the start key at the booth, since the program started.
  bool start_agreed = false;                 ///< Pressed since this was armed, and not longer ago than kStartAgreed.
  double z_mm = 0.0;                         ///< Carriage; meaningless unless homed.
  std::optional<LiveQuality> quality;        ///< Of the scan that runs, level by level.
  std::optional<ArmReport> arm;              ///< Of the last order to arm.
  std::optional<ScanResult> scan;            ///< The last one that ended.
  std::chrono::nanoseconds longest_tick{0};  ///< Between two ticks, since the start.
};

struct ScannerOptions {
  RecordingOptions recording;
  std::size_t single_dead_sensors = 2;  ///< So many sensors that never see anything, not adjacent, are put up with.
  double jog_speed_mm_s = 20.0;         ///< Service speed.
  /// What the host has to say before a scan: real-time priority, temperature, supply, wall clock. May be empty.
  std::function<std::vector<ArmCheck>()> host_checks;
  /// Told every level as it is taken, on the worker thread; must return quickly. May be empty.
  std::function<void(const ScanLevel&)> on_level;
};

/// Runs the booth: the state machine (scan_machine.h) with its devices. Two threads call it:
///
///     control thread   Tick() every 10 ms. Reads the interlock, takes what it says to the machine, sets the lines that
///                      the machine wants, watches deadlines and threads, beats for the watchdog relay. Waits for
///                      nothing.
///     worker thread    Step() in a loop. Carries out orders on axis and ring, whose calls may take tenths of a second,
///                      and looks at the axis when there is nothing to do.
///
/// In virtual time one thread does both: see InterleavedClock. Orders and status are for any thread. An order is an
/// Error if the machine refuses it; otherwise its outcome is seen in the status. Nothing moves but by Home, Start and
/// Jog.
class Scanner {
 public:
  /// Gate, storage and clock are borrowed; `clock` is the control thread's, and shows the same time as the devices'.
  Scanner(ScannerDevices devices, ScanGate& gate, Storage& storage, Clock& clock, ScannerOptions options = {});
  ~Scanner();
  Scanner(const Scanner&) = delete;
  Scanner& operator=(const Scanner&) = delete;

  // Orders and status: any thread.
  Status OrderHome();
  Status OrderArm(ArmRequest request);
  /// `version`: of the status that was looked at.
  Status OrderStart(std::uint64_t version);
  /// A controlled stop; success also when there is nothing to stop.
  Status Cancel();
  /// Ends a fault whose cause is gone; devices that were lost are opened again first.
  Status Acknowledge(CauseRole role);
  /// Moves at service speed for as long as it is called at least every scan_time::kJogBeat. `up`: away from the floor.
  enum class JogDirection { kUp, kDown };
  Status Jog(JogDirection direction);
  [[nodiscard]] ScannerStatus status() const;

  /// Control thread, once, before the first tick: tests the watchdog relay, which takes about a second. After an Error
  /// nothing can be homed, armed or jogged.
  Status Begin();
  /// Control thread.
  void Tick();
  /// Worker thread: the next order, or one look at the axis; returns after the order, or at the next tick.
  void Step();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace annulus
