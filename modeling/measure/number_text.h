#pragma once

#include <string>

namespace annulus {

/// A number for a message: up to six significant digits ("1380", "0.25").
[[nodiscard]] std::string NumberText(double value);

}  // namespace annulus
