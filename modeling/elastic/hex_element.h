#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "modeling/elastic/elastic_material.h"
#include "modeling/elastic/solid_grid.h"

namespace annulus {

/// Stiffness of a hexahedron, N/mm: x, y, z of corner 0, then of corner 1, ….
using HexMatrix = Eigen::Matrix<double, 24, 24>;

/// Stiffness of the eight-node hexahedron with twelve enhanced strains: Simo, Rifai (1990), Simo, Armero, Taylor
/// (1993). The nine linear ones free it from locking in bending, the three bilinear changes of volume from locking when
/// nearly incompressible; constant strain stays exact on any shape (patch test). Nothing if it is inside out at one of
/// its 2 × 2 × 2 Gauss points.
[[nodiscard]] std::optional<HexMatrix> HexStiffness(const HexCorners& corners, const ElasticMaterial& material);

/// Symmetric tensors as xx, yy, zz, xy, yz, zx; shear strains are engineering ones (twice the tensor's).
using Voigt = Eigen::Matrix<double, 6, 1>;

/// Strain at the eight Gauss points for given displacements of the corners (mm), enhanced strains included. Gauss point
/// a + 2b + 4c is nearest to that corner. Requires that HexStiffness exists.
[[nodiscard]] std::array<Voigt, 8> HexStrains(const HexCorners& corners, const ElasticMaterial& material,
                                              const HexCorners& displacement);

/// σ = λ tr(ε) I + 2με, N/mm².
[[nodiscard]] Voigt StressOf(const Voigt& strain, const ElasticMaterial& material);

/// Values at Gauss points continued trilinearly to the corners.
[[nodiscard]] std::array<Voigt, 8> AtCorners(const std::array<Voigt, 8>& at_gauss);

}  // namespace annulus
