/// The reader of frames. Beyond "no crash": a refusal is one line; what is accepted is written and read back as the
/// same bytes.
#include <cstdint>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "modeling/glasses/frame_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace annulus;
  const auto file = FrameFromJson(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz");
  if (!file) {
    ENSURE(file.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  const std::string written = FrameToJson(*file);
  const auto again = FrameFromJson(written, "written");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(FrameToJson(*again) == written, "it reads back as the same bytes");
  return 0;
}
