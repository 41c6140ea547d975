/// Drift histories. Beyond "no crash": what is accepted is judged without a throw, and is written and read back to the
/// same bytes.
#include <cstdint>
#include <string_view>

#include "acquisition/drift_alarm.h"
#include "base/ensure.h"

using namespace annulus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto history = DriftHistory::FromJson({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!history) {
    ENSURE(!history.error().advice.empty(), "a refusal says what to do");
    return 0;
  }
  const std::string text = history->ToJson();
  const auto again = DriftHistory::FromJson(text, "again");
  ENSURE(again.has_value() && again->ToJson() == text, "a history reads back as it was");
  if (history->sensors() > 64) return 0;  // too slow to be judged thousands of times a second
  ENSURE(JudgeDrift(*history).sensors.size() <= DriftHistory::kMostSensors, "one state per sensor");
  return 0;
}
