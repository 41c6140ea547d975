#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "acquisition/bus_tap.h"
#include "acquisition/scanner.h"
#include "base/progress.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/config.h"
#include "station/devices.h"

namespace annulus {

/// Who presses the buttons of a simulated booth.
enum class SimOperator {
  kAutomatic,  ///< Reset and start key are pressed when the booth waits for them.
  kNobody,
};

struct BoothSessionOptions {
  Pace pace = Pace::kAsFastAsPossible;
  SimOperator sim_operator = SimOperator::kAutomatic;
  ScannerOptions scanner;
};

/// A booth with its program: devices opened as the configuration says, tapped, and the scanner on them. In real time
/// there are two threads, from Open to the end; in virtual time whoever waits does the work of both, and in paced
/// virtual time one thread does.
class BoothSession {
 public:
  /// Opens and identifies the devices, and tests the watchdog relay; nothing moves. Gate and storage are borrowed.
  static Result<std::unique_ptr<BoothSession>> Open(const Config& config, ScanGate& gate, Storage& storage,
                                                    BoothSessionOptions options = {});
  BoothSession(const BoothSession&) = delete;
  BoothSession& operator=(const BoothSession&) = delete;
  /// Stops what runs, on the normal ramp if it can, then the threads.
  ~BoothSession();

  [[nodiscard]] Scanner& scanner() { return *scanner_; }
  [[nodiscard]] Clock& clock() { return ground_->clock(); }
  [[nodiscard]] DeviceGround& ground() { return *ground_; }
  [[nodiscard]] const RangeRing& ring() const { return *ring_.ring; }
  [[nodiscard]] const ScanAxis& axis() const { return *axis_.axis; }

  /// Lets the booth work until `done` is true of its status. False: `patience` is over. `watch` sees the status every
  /// 10 ms, also in the middle of an order; it may give orders.
  using Watch = std::function<void(const ScannerStatus&)>;
  bool RunUntil(const std::function<bool(const ScannerStatus&)>& done, std::chrono::nanoseconds patience,
                const Watch& watch = {});

  /// A fault plan has killed the program.
  [[nodiscard]] bool killed() const { return killed_; }

  /// What the control thread could not have of the system, in words ("real-time priority: …"); empty if it has all, or
  /// in virtual time.
  [[nodiscard]] std::string scheduling_note() const;

 private:
  BoothSession() = default;
  void StartThreads();
  void RunPaced(const std::stop_token& stop);
  void RunControl(const std::stop_token& stop);
  /// One step of the worker, which lets time pass, in virtual time.
  void Work();
  void Tick();
  /// What somebody at a simulated booth would do.
  void ActForPeople();

  std::unique_ptr<DeviceGround> ground_;
  BusTap tap_;
  RingDevice ring_;
  AxisDevice axis_;
  std::unique_ptr<Interlock> interlock_;
  std::unique_ptr<Scanner> scanner_;
  Pace pace_ = Pace::kAsFastAsPossible;
  SimOperator operator_ = SimOperator::kNobody;
  std::uint64_t levels_ = 0;  ///< Taken since the session was opened.
  // What a fault plan does to the host.
  std::atomic<bool> killed_ = false;
  bool stalled_ = false;
  bool worker_dead_ = false;
  std::chrono::nanoseconds late_until_{0};
  std::chrono::nanoseconds next_press_{0};
  const Watch* watch_ = nullptr;  ///< Of the RunUntil that does the work; null: nobody looks.
  mutable std::mutex note_mutex_;
  std::string scheduling_note_;
  std::jthread control_;  ///< Last: they end first.
  std::jthread worker_;
};

}  // namespace annulus
