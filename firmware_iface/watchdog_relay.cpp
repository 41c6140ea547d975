#include <algorithm>

#include "firmware_iface/interlock.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Beats, and reads in between, until `deadline` or until the watchdog relay's feedback is as wanted.
Result<bool> BeatUntil(Interlock& interlock, Clock& clock, nanoseconds deadline, bool wanted) {
  for (nanoseconds next = clock.Now(); next < deadline;) {
    RETURN_IF_ERROR(interlock.KickWatchdog());
    next = std::max(next + interlock_time::kBeat, clock.Now());
    do {
      const auto reading = interlock.WaitChange(next);
      if (!reading) return Fail(reading);
      if ((*reading)[InterlockInput::kWatchdogFeedback] == wanted) return true;
    } while (clock.Now() < next);
  }
  return false;
}

}  // namespace

Result<nanoseconds> TestWatchdogRelay(Interlock& interlock, Clock& clock) {
  const std::string attempted = "test the watchdog relay";
  const std::string advice = "check the relay, its window and its feedback; the booth must not run without it";
  if (interlock.output(InterlockOutput::kEnable)) return Fail(attempted, "enable is on", "switch it off first");
  const auto pulled_in = BeatUntil(interlock, clock, clock.Now() + milliseconds(1000), true);
  if (!pulled_in) return Fail(pulled_in);
  if (!*pulled_in) return Fail(attempted, "it does not pull in within 1 s of beats", advice);
  const auto dropped = BeatUntil(interlock, clock, clock.Now() + milliseconds(300), false);
  if (!dropped) return Fail(dropped);
  if (*dropped) return Fail(attempted, "it dropped though beats went on", advice);
  const nanoseconds last_beat = clock.Now();
  RETURN_IF_ERROR(interlock.KickWatchdog());
  while (clock.Now() < last_beat + 2 * interlock_time::kWatchdogDrop) {
    const auto reading = interlock.WaitChange(last_beat + 2 * interlock_time::kWatchdogDrop);
    if (!reading) return Fail(reading);
    if ((*reading)[InterlockInput::kWatchdogFeedback]) continue;
    const nanoseconds took = reading->host_time - last_beat;
    if (took <= interlock_time::kWatchdogDrop) return took;
    return Fail(attempted,
                "it took " + std::to_string(std::chrono::duration_cast<milliseconds>(took).count()) + " ms to drop",
                advice);
  }
  return Fail(attempted, "it did not drop when the beats ended", advice);
}

}  // namespace annulus
