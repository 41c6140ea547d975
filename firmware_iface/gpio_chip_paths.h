#pragma once

#include <string>
#include <vector>

namespace annulus {

/// Device files of the system's GPIO chips ("/dev/gpiochip0" …) by number, whether or not they can be opened.
[[nodiscard]] std::vector<std::string> GpioChipPaths();

}  // namespace annulus
