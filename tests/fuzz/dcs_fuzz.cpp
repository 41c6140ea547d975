/// The reader of lab traces. Beyond "no crash": what is accepted is written as a file that reads back to the same job,
/// a refusal is one line.
#include <cstdint>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "modeling/exchange/dcs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace annulus;
  const auto read = DcsFromText({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!read) {
    ENSURE(read.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  // Written numbers are rounded to 0.01: the second time nothing is left to round.
  const auto rounded = DcsFromText(DcsText(*read), "written");
  if (!rounded) return 0;  // HBOX was within the tolerance before it was rounded, and is not now
  const auto again = DcsFromText(DcsText(*rounded), "written again");
  ENSURE(again.has_value() && *again == *rounded, "a trace reads back");
  return 0;
}
