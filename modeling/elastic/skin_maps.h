#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "modeling/elastic/elastic_region.h"
#include "modeling/elastic/elastic_solver.h"
#include "modeling/elastic/hex_element.h"

namespace annulus {

/// What a solution means for the skin, by stack.
struct SkinMaps {
  std::vector<double> outward;         ///< Displacement along the skin's normal at rest, mm.
  std::vector<double> sideways;        ///< Displacement across it, mm.
  std::vector<double> von_mises;       ///< N/mm²
  std::vector<double> largest_strain;  ///< Largest principal strain, 1.
  std::vector<double> smallest_strain;
  std::vector<double> area_strain;  ///< Change of the skin's area over itself, 1.
  std::vector<double> pressure;  ///< Of bands and given forces on the skin, inwards, N/mm²; 0 where nothing presses.
};

/// Stresses and strains are those of the elements, turned with them (small strain), continued from the Gauss points to
/// the skin's nodes and averaged there.
[[nodiscard]] SkinMaps MapSkin(const ElasticRegion& region, const ElasticProblem& problem,
                               const ElasticSolution& solution);

/// Strain and stress of each corner of an element, in the element's turned frame.
struct CornerStates {
  std::array<Voigt, 8> strain;
  std::array<Voigt, 8> stress;  ///< N/mm²
};
[[nodiscard]] CornerStates StatesOf(const ElasticProblem& problem, const ElasticSolution& solution, std::size_t pile,
                                    std::size_t level);

/// √(3/2 s:s), N/mm².
[[nodiscard]] double VonMises(const Voigt& stress);

/// Contact pressure of a thread.
struct ContactPressure {
  double largest = 0.0;  ///< N/mm²
  double force = 0.0;    ///< ∫ p dA, N.
  double area = 0.0;     ///< Where it presses, mm².
};

/// A thread whose points are at `positions`, mm. The force at a point acts on the strip of skin that
/// the thread stands for, half way to its neighbours.
[[nodiscard]] ContactPressure ContactOf(const BandFibre& fibre, const FibreState& state,
                                        const std::vector<Eigen::Vector3d>& positions);

}  // namespace annulus
