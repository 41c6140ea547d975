/// The reader of RX.json. Beyond "no crash": what is accepted is a valid order that is written and read back as it was,
/// transposes to a valid order, and can be designed or is refused in one line.
#include <cmath>
#include <cstdint>
#include <string_view>

#include "base/ensure.h"
#include "base/units.h"
#include "modeling/glasses/lens_design.h"

namespace {

using namespace annulus;

FrameForLenses Frame() {
  FrameForLenses frame;
  for (int i = 0; i < 96; ++i) {
    const double angle = kTwoPi * i / 96.0;
    frame.right.outline.points.emplace_back(25.0 * std::cos(angle), 18.0 * std::sin(angle));
  }
  frame.left.outline = Mirrored(frame.right.outline);
  return frame;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FrameForLenses frame = Frame();
  static const LensMaterial material = LensMaterials().front();
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto read = PrescriptionFromJson(text, "fuzz");
  if (!read) {
    ENSURE(read.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  ENSURE(Validate(*read).has_value(), "what is read is valid");
  const std::string written = PrescriptionToJson(*read);
  const auto again = PrescriptionFromJson(written, "written");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(*again == *read && PrescriptionToJson(*again) == written, "an order reads back as the same bytes");
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    const EyePrescription other = InPlusCylinder(InMinusCylinder(read->of(eye)));
    ENSURE(std::isfinite(other.sphere) && other.cylinder >= 0.0, "transposes");
  }
  const auto pair = DesignLensPair(*read, material, frame, {});
  if (!pair) {
    ENSURE(pair.error().Text().find('\n') == std::string::npos, "a refusal is one line");
    return 0;
  }
  ENSURE(LensPairToJson(*pair).size() > 1000, "a report is written");
  return 0;
}
