#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/result.h"

namespace annulus {

/// The spectral line for which an index is stated: d (helium, 587.6 nm) or e (mercury, 546.1 nm; ISO 7944).
enum class SpectralLine { kD, kE };

/// What a lens is made of.
struct LensMaterial {
  std::string name;      ///< "cr39", "1.67"; as the catalogue and files name it.
  double index = 0.0;    ///< The index that all powers and radii are computed with; 1.4…2.0.
  SpectralLine line{};   ///< The line of `index` and `abbe`.
  double abbe = 0.0;     ///< Abbe number; 15…100.
  double density = 0.0;  ///< g/cm³; 0.9…5.
};

/// "d" or "e".
[[nodiscard]] std::string_view SpectralLineName(SpectralLine line);

/// Usual materials, by rising index: cr39 1.498, crown-glass 1.523, trivex 1.532, polycarbonate 1.586 (d line); 1.60,
/// 1.67, 1.74 (e line).
[[nodiscard]] std::span<const LensMaterial> LensMaterials();
/// A material of the catalogue; an unknown name is an error that lists the known ones.
[[nodiscard]] Result<LensMaterial> FindLensMaterial(std::string_view name);
/// Whether a material that somebody gave by its numbers is possible; names the number and its range.
[[nodiscard]] Status Validate(const LensMaterial& material);

}  // namespace annulus
