#include "acquisition/supervised_axis.h"

#include <utility>

namespace annulus {

using std::chrono::nanoseconds;

CauseCode SupervisedAxis::CodeOf(const Error&) const {
  switch (axis_.trouble()) {
    case AxisTrouble::kParameters:
      return CauseCode::kAxisParameters;
    case AxisTrouble::kDrive:
    case AxisTrouble::kStopped:
      return CauseCode::kAxisFault;
    case AxisTrouble::kOrder:
      return CauseCode::kInternal;
    case AxisTrouble::kNone:
    case AxisTrouble::kLink:
      break;
  }
  return CauseCode::kAxisLink;
}

Status SupervisedAxis::Judge(Status status) {
  if (!status) {
    const Error& error = status.error();
    const ScanCause cause{CodeOf(error), error.attempted + ": " + error.seen, error.advice, clock_.Now()};
    axis_.trouble() == AxisTrouble::kStopped ? supervisor_.OnDriveStopped(cause) : supervisor_.OnFault(cause);
  }
  return status;
}

Status SupervisedAxis::Enable() {
  RETURN_IF_ERROR(supervisor_.MayMove());
  RETURN_IF_ERROR(supervisor_.AwaitPower());
  supervisor_.OnPower(true);
  guard_.Powered(clock_.Now());
  return Judge(axis_.Enable());
}

Status SupervisedAxis::StartHoming() {
  RETURN_IF_ERROR(supervisor_.MayMove());
  guard_.OrderedHoming(clock_.Now());
  return Judge(axis_.StartHoming());
}

Status SupervisedAxis::MoveTo(Millimetres z, MillimetresPerSecond speed) {
  RETURN_IF_ERROR(supervisor_.MayMove());
  const nanoseconds before = clock_.Now();
  if (before - last_.host_time() > kOldestOrder) {
    return Fail("move the axis", "its place was last read too long ago to order a move from it",
                "try again; if it happens again, report it");
  }
  Status moved = Judge(axis_.MoveTo(z, speed));
  guard_.OrderedMove(before, clock_.Now(), z.value(), speed.value());
  return moved;
}

Result<AxisPosition> SupervisedAxis::Position() {
  auto position = axis_.Position();
  if (!position) {
    static_cast<void>(Judge(Fail(position)));
    return position;
  }
  if (!position->fresh) return position;
  last_ = *position;
  supervisor_.OnPosition(last_);
  if (auto cause = guard_.Judge(last_)) {
    supervisor_.OnFault(*cause);
    return Fail("run the axis", cause->text, cause->advice);
  }
  return position;
}

Status SupervisedAxis::Halt() {
  guard_.OrderedStop(clock_.Now());
  return Judge(axis_.Halt());
}

Status SupervisedAxis::QuickStop() {
  guard_.OrderedStop(clock_.Now());
  return Judge(axis_.QuickStop());
}

Status SupervisedAxis::Disable() {
  Status disabled = Judge(axis_.Disable());
  guard_.Rests(clock_.Now());
  if (disabled) supervisor_.OnPower(false);
  return disabled;
}

Status SupervisedAxis::Verify() { return Judge(axis_.Verify()); }

Status SupervisedAxis::Reopen(nanoseconds deadline) {
  Status reopened = axis_.Reopen(deadline);
  guard_.Forget(clock_.Now());
  if (reopened) supervisor_.OnPower(false);
  return reopened;
}

CauseCode CauseOf(RingTrouble trouble) {
  switch (trouble) {
    case RingTrouble::kBus:
      return CauseCode::kSensorBus;
    case RingTrouble::kData:
      return CauseCode::kSensorData;
    case RingTrouble::kEmitter:
      return CauseCode::kEmitter;
    case RingTrouble::kIdentity:
      return CauseCode::kRingIdentity;
    case RingTrouble::kOrder:
      return CauseCode::kInternal;
    case RingTrouble::kNone:
    case RingTrouble::kBoardLost:
      break;
  }
  return CauseCode::kSensorLost;
}

void SupervisedRing::Tell(const Error& error) {
  supervisor_.OnFault({CauseOf(ring_.trouble()), error.attempted + ": " + error.seen, error.advice, clock_.Now()});
}

}  // namespace annulus
