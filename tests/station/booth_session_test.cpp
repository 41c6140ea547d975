#include "station/booth_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "acquisition/recording.h"
#include "station/profile_plan.h"
#include "tests/station/served_booth.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr seconds kPatience{8};

bool Rests(const ScannerStatus& status) {
  return (status.state == ScanState::kIdle || status.state == ScanState::kSafe || status.state == ScanState::kFault) &&
         status.job.empty();
}

/// True if the booth stopped for a cause that a machine too busy for real time brings. That it stops then is right, and
/// tested in virtual time; here the threads are what is tested.
bool TooBusy(const ScannerStatus& status) {
  return std::any_of(status.causes.begin(), status.causes.end(), [](const ScanCause& cause) {
    switch (cause.code) {
      case CauseCode::kHostLate:
      case CauseCode::kHostHang:
      case CauseCode::kThreadDead:
      case CauseCode::kFollowingError:
      case CauseCode::kAxisLink:
      case CauseCode::kSensorLost:
        return true;
      default:
        return false;
    }
  });
}

/// The simulated booth with its threads and an automatic operator; another thread looks at it all the time, as a
/// console does.
class BoothWithThreads : public testing::Test {
 protected:
  explicit BoothWithThreads(Pace pace) {
    config_.profiles["short"].z_top_mm = 1700.0;
    config_.profiles["short"].z_bottom_mm = 1600.0;
    config_.profiles["short"].pitch_mm = 5.0;
    config_.profiles["short"].speed_mm_s = 100.0;
    BoothSessionOptions options;
    options.pace = pace;
    options.scanner.on_level = [this](const ScanLevel&) { ++levels_; };
    auto session = BoothSession::Open(config_, gate_, storage_, std::move(options));
    if (!session) throw std::runtime_error(session.error().Text());
    session_ = std::move(*session);
    looker_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        const ScannerStatus status = session_->scanner().status();
        looks_ += status.state == ScanState::kSafe ? 0 : 1;
        if (TooBusy(status)) saw_busy_ = true;
        SystemClock().SleepUntil(SystemClock().Now() + milliseconds(5));
      }
    });
  }
  ~BoothWithThreads() override { EndLooking(); }

  void EndLooking() {
    looker_.request_stop();
    if (looker_.joinable()) looker_.join();
  }
  Scanner& scanner() { return session_->scanner(); }
  /// Waits; if that fails, the test has failed unless the machine is too busy.
  bool Reach(const char* what, const std::function<bool(const ScannerStatus&)>& done) {
    const bool reached =
        session_->RunUntil([&](const ScannerStatus& status) { return done(status) || TooBusy(status); }, kPatience);
    const ScannerStatus status = scanner().status();
    const std::string seen = std::string(what) + ": " + ScanStateText(status.state) +
                             (status.causes.empty() ? "" : ", " + status.causes.front().text);
    if (busy_.empty() && TooBusy(status)) busy_ = seen;
    EXPECT_TRUE(reached || !busy_.empty()) << seen;
    return reached && busy_.empty();
  }
  bool Home() {
    return Reach("reset", [](const ScannerStatus& status) { return status.state == ScanState::kIdle; }) &&
           scanner().OrderHome() &&
           Reach("home", [](const ScannerStatus& status) { return status.homed && Rests(status); });
  }
  bool Arm() {
    ArmRequest request;
    request.plan = *PlanOfProfile(config_, "short", std::nullopt);
    request.out = path_;
    request.header.station_id = "test";
    request.header.calibration = RingCalibration::Ideal(config_.ring.radius_mm);
    request.header.ring_radius_mm = config_.ring.radius_mm;
    return scanner().OrderArm(std::move(request)) &&
           Reach("arm", [](const ScannerStatus& status) { return status.arm && status.job.empty(); });
  }

  test::FreshFolder folder_;
  const std::string path_ = folder_ / "a.mcap";
  Config config_ = SimulatedConfig();
  PosixStorage storage_;
  PermissiveGate gate_;
  std::atomic<int> levels_{0};
  std::atomic<int> looks_{0};
  std::atomic<bool> saw_busy_{false};
  std::unique_ptr<BoothSession> session_;
  std::string busy_;  ///< Why this machine is too busy; empty: it is not.
  std::jthread looker_;
};

/// On the host's time, with two threads.
class BoothInRealTime : public BoothWithThreads {
 protected:
  BoothInRealTime() : BoothWithThreads(Pace::kRealTime) {}
};

/// In time that waits for the computer, with one.
class BoothInPacedTime : public BoothWithThreads {
 protected:
  BoothInPacedTime() : BoothWithThreads(Pace::kPaced) {}
};

TEST_F(BoothInPacedTime, TakesAWholeScanOnAComputerThatIsFarTooBusyForRealTime) {
  std::vector<std::jthread> others;
  for (unsigned i = 0; i < 8 * std::max(1U, std::thread::hardware_concurrency()); ++i) {
    others.emplace_back([](const std::stop_token& stop) {
      for (std::atomic<int> turns = 0; !stop.stop_requested();) ++turns;
    });
  }
  ASSERT_TRUE(Home());
  ASSERT_TRUE(Arm());
  const std::uint64_t presses = scanner().status().start_presses;
  ASSERT_TRUE(Reach("start key", [&](const ScannerStatus& status) { return status.start_presses > presses; }));
  const auto begin = session_->clock().Now();
  ASSERT_TRUE(scanner().OrderStart(scanner().status().version));
  ASSERT_TRUE(
      session_->RunUntil([](const ScannerStatus& status) { return status.scan && Rests(status); }, seconds(60)));
  const ScannerStatus status = scanner().status();
  ASSERT_TRUE(status.scan->status) << status.scan->status.error().Text();
  EXPECT_TRUE(status.scan->complete);
  EXPECT_FALSE(saw_busy_);
  // 100 mm and back at 100 mm/s.
  EXPECT_GE(session_->clock().Now() - begin, seconds(1));
  EXPECT_LE(session_->clock().Now() - begin, seconds(10));
  EndLooking();
  session_.reset();
  const auto recording = ReadWholeRecording(storage_, path_);
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_EQ(recording->scan.levels.size(), status.scan->summary.levels);
}

TEST_F(BoothInRealTime, TakesAScanThatIsCancelledAndKeepsWhatItHas) {
  if (Home() && Arm()) {
    const std::uint64_t presses = scanner().status().start_presses;
    const bool pressed =
        Reach("start key", [&](const ScannerStatus& status) { return status.start_presses > presses; });
    if (pressed && scanner().OrderStart(scanner().status().version)) {
      Reach("levels", [this](const ScannerStatus& status) { return levels_ >= 3 || (status.scan && Rests(status)); });
    }
  }
  const auto cancelled = session_->clock().Now();
  EXPECT_TRUE(scanner().Cancel());
  EXPECT_TRUE(session_->RunUntil(Rests, kPatience));
  EXPECT_LT(session_->clock().Now() - cancelled, kPatience);
  const ScannerStatus status = scanner().status();
  EndLooking();
  session_.reset();
  if (!busy_.empty()) GTEST_SKIP() << "too busy a machine for real time, the threads alone were tested: " << busy_;
  ASSERT_TRUE(status.scan);
  // The automatic operator may have reset the booth before this thread looked; the third one looks more often.
  if (saw_busy_) GTEST_SKIP() << "too busy a machine for real time, the threads alone were tested";
  ASSERT_TRUE(status.scan->status) << status.scan->status.error().Text();
  EXPECT_GT(looks_, 0);
  EXPECT_FALSE(status.scan->complete);
  EXPECT_GE(status.scan->summary.levels, 3U);
  const auto recording = ReadWholeRecording(storage_, path_);
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_EQ(recording->scan.levels.size(), status.scan->summary.levels);
}

TEST_F(BoothInRealTime, JogsWhileTheKeyIsHeldAndEndsInTheMiddleOfAnOrder) {
  if (Home()) {
    const double before = scanner().status().z_mm;
    const auto end = session_->clock().Now() + milliseconds(600);
    while (session_->clock().Now() < end) {
      // The automatic booth may refuse it once it has stopped for a late tick.
      if (!scanner().Jog(Scanner::JogDirection::kDown)) break;
      session_->clock().SleepUntil(session_->clock().Now() + milliseconds(30));
    }
    const bool rested = Reach("rest after the jog", Rests);
    if (rested) {
      EXPECT_LT(scanner().status().z_mm, before);
    }
  }
  static_cast<void>(scanner().OrderHome());
  const auto begin = session_->clock().Now();
  EndLooking();
  session_.reset();
  EXPECT_LT(SystemClock().Now() - begin, kPatience) << "the end waits for nothing but the stop";
}

}  // namespace
}  // namespace annulus
