// PatternFromJson on any bytes: an error or a pattern that reads back the same.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "modeling/flatten/pattern_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto pattern = annulus::PatternFromJson({reinterpret_cast<const char*>(data), size}, "pattern.json");
  if (!pattern) return 0;
  const std::string text = annulus::PatternToJson(*pattern);
  const auto again = annulus::PatternFromJson(text, "again.json");
  ENSURE(again, "what was written reads back");
  return 0;
}
