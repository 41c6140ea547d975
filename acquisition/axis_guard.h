#pragma once

#include <chrono>
#include <deque>
#include <optional>

#include "acquisition/scan_cause.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// Holds every position of the axis against what it was ordered to do, so that a drive that errs, a contact with
/// something, a brake that slips and an encoder that jumps are found by the program as well:
///
///     ordered      judged
///     nothing      stays where it came to rest: slow is a slipping brake, fast is a move without an order
///     homing       moves upwards first, or slowly down from the switch; not further than its travel
///     move         in the right direction; not faster than ordered; close to its set-point, closer the slower it goes
///     always       no jump between two readings
///
/// A pure value. Times are the host's, heights mm in the station frame.
class AxisGuard {
 public:
  explicit AxisGuard(const AxisLimits& limits) : limits_(limits) {}

  /// A move from where it is was ordered between `before` and `after`.
  void OrderedMove(std::chrono::nanoseconds before, std::chrono::nanoseconds after, double target_mm,
                   double speed_mm_s);
  void OrderedHoming(std::chrono::nanoseconds time);
  /// It is to come to rest on whatever ramp.
  void OrderedStop(std::chrono::nanoseconds time);
  /// It has no power any more, or its place is known anew: rests from now on.
  void Rests(std::chrono::nanoseconds time);
  /// It gets power where it rests: however long ago it was last read, it must still be there.
  void Powered(std::chrono::nanoseconds time);
  /// Where it is is not known any more.
  void Forget(std::chrono::nanoseconds time);

  /// The first thing that is wrong with a reading, which must be fresh and later than the last one.
  std::optional<ScanCause> Judge(const AxisPosition& position);

 private:
  enum class Order { kNone, kHoming, kMove, kStop };
  struct Reading {
    std::chrono::nanoseconds device{0};
    double z_mm = 0.0;
  };

  [[nodiscard]] std::optional<ScanCause> JudgeJump(const AxisPosition& position) const;
  [[nodiscard]] std::optional<ScanCause> JudgeRest(const AxisPosition& position);
  [[nodiscard]] std::optional<ScanCause> JudgeHoming(const AxisPosition& position) const;
  [[nodiscard]] std::optional<ScanCause> JudgeMove(const AxisPosition& position) const;
  /// Speed over the last readings that are kSpeedSpan apart, mm/s, up positive; nothing before there are any.
  [[nodiscard]] std::optional<double> Speed() const;
  /// How far a move has come `elapsed` after its start, mm.
  [[nodiscard]] double Travelled(double elapsed_s) const;

  AxisLimits limits_;
  Order order_ = Order::kNone;
  std::chrono::nanoseconds before_{0};
  std::chrono::nanoseconds after_{0};
  double from_mm_ = 0.0;
  double target_mm_ = 0.0;
  double speed_mm_s_ = 0.0;
  double initial_speed_mm_s_ = 0.0;  ///< A move that overrides another starts from its speed.
  double highest_mm_ = 0.0;          ///< Since homing began.
  bool begins_ = false;              ///< Homing is ordered, and where from is not read yet.
  std::optional<double> rest_mm_;    ///< Where it came to rest.
  std::deque<Reading> readings_;     ///< Of the last 100 ms.
  bool homed_ = false;
  std::optional<double> powered_from_mm_;  ///< Where it rested when it got power, until the next reading.
};

}  // namespace annulus
