#pragma once

#include <array>
#include <vector>

namespace annulus {

/// The polynomial c[0] + c[1]·k + c[2]·k² + c[3]·k³. A plain value.
struct Cubic {
  std::array<double, 4> c{};

  [[nodiscard]] double At(double k) const { return ((c[3] * k + c[2]) * k + c[1]) * k + c[0]; }
  [[nodiscard]] double Slope(double k) const { return (3.0 * c[3] * k + 2.0 * c[2]) * k + c[1]; }
  Cubic& operator+=(const Cubic& other);
};

/// Its real roots, the one nearest 0 first, each once; polished by Newton to rounding. Empty for a constant. A double
/// root is found where rounding leaves it one.
[[nodiscard]] std::vector<double> RealRoots(const Cubic& cubic);

}  // namespace annulus
