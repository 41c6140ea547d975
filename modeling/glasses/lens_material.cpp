#include "modeling/glasses/lens_material.h"

#include <fmt/format.h>

#include <array>

namespace annulus {
namespace {

/// Nominal indices as the trade writes them; Abbe numbers and densities as makers usually publish them.
const std::array<LensMaterial, 7>& Catalogue() {
  static const std::array<LensMaterial, 7> catalogue{{{"cr39", 1.498, SpectralLine::kD, 58.0, 1.32},
                                                      {"crown-glass", 1.523, SpectralLine::kD, 58.6, 2.54},
                                                      {"trivex", 1.532, SpectralLine::kD, 43.0, 1.11},
                                                      {"polycarbonate", 1.586, SpectralLine::kD, 30.0, 1.20},
                                                      {"1.60", 1.600, SpectralLine::kE, 41.0, 1.30},
                                                      {"1.67", 1.670, SpectralLine::kE, 31.0, 1.36},
                                                      {"1.74", 1.740, SpectralLine::kE, 32.0, 1.47}}};
  return catalogue;
}

Status InRange(std::string_view what, double value, double low, double high) {
  if (value >= low && value <= high) return {};  // NaN is not
  return Fail("use a lens material", fmt::format("{} is {}", what, value), fmt::format("give {} to {}", low, high));
}

}  // namespace

std::string_view SpectralLineName(SpectralLine line) { return line == SpectralLine::kD ? "d" : "e"; }

std::span<const LensMaterial> LensMaterials() { return Catalogue(); }

Result<LensMaterial> FindLensMaterial(std::string_view name) {
  std::string known;
  for (const LensMaterial& material : Catalogue()) {
    // "1.6" is "1.60".
    if (material.name == name || material.name == std::string(name) + "0") return material;
    known += (known.empty() ? "" : ", ") + material.name;
  }
  return Fail(fmt::format("find the lens material '{}'", name), "the catalogue does not have it",
              fmt::format("use one of {}, or give index, Abbe number and density", known));
}

Status Validate(const LensMaterial& material) {
  RETURN_IF_ERROR(InRange("the index", material.index, 1.4, 2.0));
  RETURN_IF_ERROR(InRange("the Abbe number", material.abbe, 15.0, 100.0));
  RETURN_IF_ERROR(InRange("the density in g/cm³", material.density, 0.9, 5.0));
  return {};
}

}  // namespace annulus
