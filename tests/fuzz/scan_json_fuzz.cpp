/// The JSON texts inside recordings and exported tables. The first byte chooses the text. Beyond "no crash": what is
/// accepted is written and read back to the same value.
#include <cstdint>

#include "acquisition/scan_json.h"
#include "base/ensure.h"
#include "tests/acquisition/scan_fixture.h"

namespace {

using namespace annulus;

void CheckHeader(std::string_view text) {
  const auto header = HeaderFromJson(text);
  if (!header) return;
  const auto again = HeaderFromJson(JsonFromHeader(*header));
  ENSURE(again.has_value() && test::SameHeader(*again, *header), "a header reads back as it was");
}

void CheckLevel(std::string_view text, std::size_t sensor_count) {
  static_cast<void>(LevelFromJson(text, sensor_count, sensor_count));
  const auto level = LevelFromJson(text, sensor_count);
  if (!level) return;
  ENSURE(level->readings.size() == sensor_count, "a level has every sensor");
  const auto again = LevelFromJson(JsonFromLevel(*level), sensor_count);
  ENSURE(again.has_value() && test::SameLevel(*again, *level), "a level reads back as it was");
}

void CheckAxisPoint(std::string_view text) {
  const auto point = AxisPointFromJson(text);
  if (!point) return;
  const auto again = AxisPointFromJson(JsonFromAxisPoint(*point));
  ENSURE(again.has_value() && *again == *point, "an axis point reads back as it was");
}

void CheckEvent(std::string_view text) {
  const auto event = EventFromJson(text);
  if (!event) return;
  const auto again = EventFromJson(JsonFromEvent(*event));
  ENSURE(again.has_value() && *again == *event, "an event reads back as it was");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'h':
      CheckHeader(text);
      break;
    case 'a':
      CheckAxisPoint(text);
      break;
    case 'e':
      CheckEvent(text);
      break;
    default:
      CheckLevel(text, data[0] % 4);
      break;
  }
  return 0;
}
