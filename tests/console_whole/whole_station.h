#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/sealed_file.h"
#include "base/clock.h"
#include "base/storage.h"
#include "station/booth_server.h"
#include "station/booth_session.h"
#include "station/console/console_server.h"
#include "station/scanner_port.h"
#include "station/store/store.h"
#include "tests/console_whole/console_browser.h"
#include "tests/station/served_booth.h"

namespace annulus::test {

/// The host's clock, which a test may put forward, and whose wall clock it may set wrong. Thread-safe.
class MovedClock final : public Clock {
 public:
  [[nodiscard]] std::chrono::nanoseconds Now() const override { return system_.Now() + ahead_.load(); }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override {
    return system_.WallNow() + ahead_.load() + wrong_.load();
  }
  void SleepUntil(std::chrono::nanoseconds deadline) override { system_.SleepUntil(deadline - ahead_.load()); }
  void PutForward(std::chrono::nanoseconds by) { ahead_ = ahead_.load() + by; }
  /// From now on the wall clock is wrong by so much; 0: it is right.
  void SetWallWrong(std::chrono::nanoseconds by) { wrong_ = by; }

 private:
  SystemClock system_;
  std::atomic<std::chrono::nanoseconds> ahead_{std::chrono::nanoseconds(0)};
  std::atomic<std::chrono::nanoseconds> wrong_{std::chrono::nanoseconds(0)};
};

/// The machine that a test runs on was too busy for a booth in real time, which stopped for it. That it stops then is
/// right, and tested in virtual time.
struct TooBusy : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What `annulus boothd` is, in threads of this process: the simulated booth behind its socket. Its automatic operator
/// presses reset and start key.
class Boothd {
 public:
  using LevelName = std::pair<std::uint32_t, std::uint32_t>;  ///< Sweep, level.

  /// Borrows keys.
  Boothd(const Config& config, Pace pace, const std::string& recordings, const KeySource* keys,
         const std::string& socket);
  ~Boothd();
  Boothd(const Boothd&) = delete;
  Boothd& operator=(const Boothd&) = delete;

  [[nodiscard]] ScannerStatus status() const { return session_->scanner().status(); }
  /// When each level was taken and handed to the recording; of all scans since the start.
  [[nodiscard]] std::map<LevelName, std::chrono::nanoseconds> Taken() const;
  /// Waits until the status is as wanted. Throws runtime_error with `what` if it takes too long; in real time TooBusy
  /// if the booth has stopped for a cause that a busy machine brings.
  void Wait(const std::string& what, const std::function<bool(const ScannerStatus&)>& wanted);
  /// The times between the control ticks since the last call, in real time.
  [[nodiscard]] std::vector<std::chrono::nanoseconds> TakeTicks();
  /// What the control thread could not have of the system; "" if it has its priority.
  [[nodiscard]] std::string scheduling_note() const { return session_->scheduling_note(); }

 private:
  void Look(const std::stop_token& stop);

  PosixStorage storage_;
  PermissiveGate gate_;
  std::unique_ptr<LevelMailbox> mailbox_;
  mutable std::mutex mutex_;
  std::map<LevelName, std::chrono::nanoseconds> taken_;
  std::vector<std::chrono::nanoseconds> ticks_;
  std::string busy_;  ///< Why this machine is too busy; "": it is not.
  std::unique_ptr<BoothSession> session_;
  std::unique_ptr<ScannerPort> port_;
  std::unique_ptr<BoothServer> server_;
  std::jthread serving_;
  std::jthread looking_;  ///< In real time.
};

/// A scan that the console has started.
struct StartedScan {
  std::string customer_id;
  std::string consent_id;
};

/// Booth and console of a station, with users anna and boris (operators), tessa (technician), ada (admin).
class WholeStation {
 public:
  /// Paced: a busy machine does not stop the booth. `remote`: addresses to listen on beside loopback.
  explicit WholeStation(Pace pace = Pace::kPaced, const std::vector<std::string>& remote = {});
  ~WholeStation();
  WholeStation(const WholeStation&) = delete;
  WholeStation& operator=(const WholeStation&) = delete;

  MovedClock clock;
  ConsoleServer& console() { return *console_; }
  Boothd& booth() { return *booth_; }
  [[nodiscard]] std::string DatabasePath() const { return folder_ / "store/annulus.db"; }
  /// Ends the console, does what is to be done meanwhile, and starts it again; the booth goes on.
  void RestartConsole(const std::function<void()>& meanwhile);
  /// How a browser on the booth's own screen reaches it.
  [[nodiscard]] RawTarget target() const;
  [[nodiscard]] ConsoleBrowser Browser() const { return ConsoleBrowser(target()); }

  /// Everything up to the first levels of a scan, with the requests of the page, by an operator who is logged in.
  /// Profiles: "short" (8 s), "long" (about 20 s).
  StartedScan StartScan(ConsoleBrowser& browser, const std::string& profile);
  /// Waits until the booth is at rest and the scan is in the store; its row.
  ScanRow WaitTakenIn(const StartedScan& scan);
  /// Names of the levels of the scan's recording, as the store gives it back.
  std::vector<Boothd::LevelName> Recorded(const std::string& scan_id);

 private:
  FreshFolder folder_;
  const ConsoleServerOptions options_;
  PosixStorage storage_;
  std::unique_ptr<ConsoleServer> console_;
  std::unique_ptr<KeySource> keys_;
  std::unique_ptr<Boothd> booth_;
};

/// True if the scanner is in IDLE with nothing to do.
[[nodiscard]] bool IsIdle(const ScannerStatus& status);

}  // namespace annulus::test
