#pragma once

#include <string>
#include <vector>

#include "modeling/exchange/solid_model.h"

namespace annulus {

/// STEP AP214 (ISO 10303-214), lengths in mm: one product per solid, named as its body; solids of a body that is not
/// fused are NAME_1, NAME_2, …. No date, host or path: same bodies, same bytes. Fails if Open CASCADE refuses.
[[nodiscard]] Result<std::string> StepText(const std::vector<SolidBody>& bodies, const std::string& title);

}  // namespace annulus
