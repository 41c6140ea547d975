/// The reader of libraries of styles. Beyond "no crash": a refusal is one line; what is accepted is written and read
/// back as the same bytes.
#include <cstdint>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "modeling/glasses/frame_library.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace annulus;
  const auto file = FrameLibraryFromJson(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz");
  if (!file) {
    ENSURE(file.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  const std::string written = FrameLibraryToJson(*file);
  const auto again = FrameLibraryFromJson(written, "written");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(FrameLibraryToJson(*again) == written, "it reads back as the same bytes");
  return 0;
}
