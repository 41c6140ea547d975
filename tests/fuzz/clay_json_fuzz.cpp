/// The readers of clay: scripts of operations and bodies. Beyond "no crash": a script that is read is carried out on a
/// small block or refused in one line, and keeps what it must; a body that is read is written as the same bytes.
#include <cmath>
#include <cstdint>
#include <string_view>

#include "base/ensure.h"
#include "modeling/clay/clay_json.h"
#include "modeling/clay/clay_script.h"
#include "modeling/clay/clay_shapes.h"

namespace {

using namespace annulus;

constexpr std::size_t kMostSteps = 2;       ///< Carried out of a script: each may refine a lot.
constexpr std::size_t kMostPatches = 3000;  ///< A body that is larger is not worked on any further.

void CarryOut(const ClayScript& script) {
  static const ClayBody block = *ClayBody::Make(ClayBlock(6.0, 3.0, 2, 1));
  ClayBody body = block;
  for (std::size_t n = 0; n < script.steps.size() && n < kMostSteps; ++n) {
    const auto* line = std::get_if<LineAct>(&script.steps[n].act);
    if (line != nullptr && line->radius_mm < 0.3) continue;  // thousands of places
    const double before = body.kept_volume();
    const auto report = Perform(body, script.steps[n], script.practice);
    if (!report) {
      ENSURE(report.error().Text().find('\n') == std::string::npos, "a message is one line");
      continue;
    }
    ENSURE(std::isfinite(report->volume_after_mm3), "a volume is a number");
    ENSURE(std::abs(body.volume() - before - report->moved_mm3) <= 1e-9 * before, "what is kept is kept");
    if (body.mesh().leaf_count() > kMostPatches) return;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto script = ClayScriptFromJson(text, "fuzz")) CarryOut(*script);
  const auto file = ClayFromJson(text, "fuzz");
  if (!file) {
    ENSURE(file.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  const std::string written = ClayToJson(*file);
  const auto again = ClayFromJson(written, "written");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(ClayToJson(*again) == written, "a body reads back as the same bytes");
  return 0;
}
