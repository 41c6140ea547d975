#pragma once

#include "acquisition/axis_guard.h"
#include "acquisition/scan_cause.h"
#include "base/clock.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// What the state machine has to say about the devices, and hears of them. Called on the worker thread.
class DeviceSupervisor {
 public:
  virtual ~DeviceSupervisor() = default;
  /// Whether the axis may be ordered to move now (I1); an Error that names the state if not.
  virtual Status MayMove() = 0;
  /// Returns when the enable relay has pulled in and the quick-stop line says run; an Error if it does not.
  virtual Status AwaitPower() = 0;
  /// The axis is about to have power, or has none any more and its brake is closing.
  virtual void OnPower(bool powered) = 0;
  virtual void OnPosition(const AxisPosition& position) = 0;
  /// A device failed, or does what it should not.
  virtual void OnFault(const ScanCause& cause) = 0;
  /// An input of the drive stopped it: the chain's doing, most likely, which is then the cause and not this.
  virtual void OnDriveStopped(const ScanCause& cause) = 0;
};

/// An axis that moves only while the state machine lets it, and whose every reading is judged (AxisGuard). Failures are
/// told to the supervisor with their cause before the caller has them. Borrows all.
class SupervisedAxis final : public ScanAxis {
 public:
  SupervisedAxis(ScanAxis& axis, DeviceSupervisor& supervisor, Clock& clock)
      : axis_(axis), supervisor_(supervisor), clock_(clock), guard_(axis.identity().limits) {}

  [[nodiscard]] State state() const override { return axis_.state(); }
  [[nodiscard]] const AxisIdentity& identity() const override { return axis_.identity(); }
  [[nodiscard]] AxisTrouble trouble() const override { return axis_.trouble(); }
  Status Enable() override;
  Status StartHoming() override;
  Status MoveTo(Millimetres z, MillimetresPerSecond speed) override;
  Result<AxisPosition> Position() override;
  Status Halt() override;
  Status QuickStop() override;
  Status Disable() override;
  Status Verify() override;
  Status Reopen(std::chrono::nanoseconds deadline) override;

 private:
  /// Tells the supervisor of a failure, if it is one, and passes it on.
  Status Judge(Status status);
  [[nodiscard]] CauseCode CodeOf(const Error& error) const;
  /// A set-point that is older than this when it is sent is refused (I4).
  static constexpr std::chrono::milliseconds kOldestOrder{100};

  ScanAxis& axis_;
  DeviceSupervisor& supervisor_;
  Clock& clock_;
  AxisGuard guard_;
  AxisPosition last_;
};

/// A ring whose failures are told to the supervisor with their cause. Borrows all.
class SupervisedRing final : public RangeRing {
 public:
  SupervisedRing(RangeRing& ring, DeviceSupervisor& supervisor, Clock& clock)
      : ring_(ring), supervisor_(supervisor), clock_(clock) {}

  [[nodiscard]] State state() const override { return ring_.state(); }
  [[nodiscard]] const std::vector<RingBoard>& boards() const override { return ring_.boards(); }
  [[nodiscard]] const RingLimits& limits() const override { return ring_.limits(); }
  [[nodiscard]] const RingCounters& counters() const override { return ring_.counters(); }
  [[nodiscard]] RingTrouble trouble() const override { return ring_.trouble(); }
  [[nodiscard]] const ReferenceBoard* reference() const override { return ring_.reference(); }
  Status Start(Hertz level_rate) override { return Judge(ring_.Start(level_rate)); }
  /// Not told: a ring that is stopped after a failure may fail again, and the first cause counts.
  Status Stop() override { return ring_.Stop(); }
  Result<RingLevel> NextLevel(std::chrono::nanoseconds deadline) override { return Judge(ring_.NextLevel(deadline)); }
  Status Reopen(std::chrono::nanoseconds deadline) override { return ring_.Reopen(deadline); }
  /// What fails of the reference board is no fault.
  Result<ClockExchange> ReadClock(std::size_t board) override {
    return board < ring_.boards().size() ? Judge(ring_.ReadClock(board)) : ring_.ReadClock(board);
  }

 private:
  template <class T>
  Result<T> Judge(Result<T> result) {
    if (!result) Tell(result.error());
    return result;
  }
  void Tell(const Error& error);

  RangeRing& ring_;
  DeviceSupervisor& supervisor_;
  Clock& clock_;
};

/// The cause that a ring's trouble is.
[[nodiscard]] CauseCode CauseOf(RingTrouble trouble);

}  // namespace annulus
