#pragma once

#include "station/console/route.h"

namespace annulus {

/// POST /api/colour: a colour in sRGB bytes, or by hue, value and chroma, changed dark ⇔ bright and dull ⇔ vivid as
/// paper 000, §6.1 has it. Answers what is shown of it.
[[nodiscard]] ApiResult ColourAnswer(const ApiRequest& request);

}  // namespace annulus
