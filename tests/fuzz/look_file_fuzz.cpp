/// The reader of looks and of colours in words. Beyond "no crash": a refusal is one line; what is accepted is written
/// and read back as the same bytes.
#include <cstdint>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "render/colour_choice.h"
#include "station/look_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace annulus;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto colour = ParseColourChoice(text)) {
    ENSURE(ParseColourChoice(ColourText(*colour)) == *colour, "a colour reads back to the same bits");
  }
  const auto look = LookFromJson(text, "fuzz");
  if (!look) {
    ENSURE(look.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  const std::string written = LookToJson(*look);
  const auto again = LookFromJson(written, "written");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(LookToJson(*again) == written, "it reads back as the same bytes");
  return 0;
}
