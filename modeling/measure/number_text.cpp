#include "modeling/measure/number_text.h"

#include <array>
#include <cstdio>

namespace annulus {

std::string NumberText(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

}  // namespace annulus
