#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "base/result.h"
#include "modeling/glasses/placement.h"
#include "modeling/glasses/wearer_head.h"
#include "modeling/landmarks/landmark.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// A customer's head as the designer works on it: looked at once (about 70 ms), and where the last frame sat on it.
/// Borrows the measured surface, with which it ends. Thread-safe.
class GlassesWearer {
 public:
  /// Face points that a person has set count in place of those found. Fails if there is no head.
  static Result<std::shared_ptr<GlassesWearer>> Look(const MeasuredSurface& body, const Landmarks& landmarks);

  [[nodiscard]] const WearerHead& head() const { return head_; }
  /// The last frame that the fit put on; nothing before.
  [[nodiscard]] std::optional<WornFrame> last() const;
  void Remember(const WornFrame& worn);

 private:
  explicit GlassesWearer(WearerHead head) : head_(std::move(head)) {}

  WearerHead head_;
  mutable std::mutex mutex_;
  std::optional<WornFrame> last_;
};

/// A wearer that is looked at when somebody first asks. Thread-safe.
class GlassesWearerSlot {
 public:
  [[nodiscard]] Result<std::shared_ptr<GlassesWearer>> Get(const MeasuredSurface& body, const Landmarks& landmarks);

 private:
  std::mutex mutex_;
  std::shared_ptr<GlassesWearer> wearer_;
};

}  // namespace annulus
