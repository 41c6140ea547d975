#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "modeling/flatten/curved_sheet.h"
#include "modeling/flatten/flat_element.h"

namespace annulus {

/// Two vertices of a part between which its grain line runs, from the first upwards.
using GrainPair = std::array<std::uint32_t, 2>;

/// The elements of a sheet, one per face. Requires a sheet that CheckSheet accepts.
[[nodiscard]] std::vector<FlatElement> ElementsOf(const CurvedSheet& sheet);

/// The least-squares conformal map of every part (Lévy, Petitjean, Ray, Maillot 2002), at the part's true area, the
/// grain pair of each part upright. Triangles may be turned over where the sheet is strongly curved.
[[nodiscard]] std::vector<Eigen::Vector2d> ConformalMap(const CurvedSheet& sheet, const SheetTopology& topology,
                                                        const std::vector<GrainPair>& grain);

/// Tutte's map (1963): rims on circles, every other vertex the mean of its neighbours. No triangle is turned over.
[[nodiscard]] std::vector<Eigen::Vector2d> TutteMap(const CurvedSheet& sheet, const SheetTopology& topology,
                                                    const std::vector<GrainPair>& grain);

/// Turns each part so that its grain pair is upright, its first vertex at the origin.
void TurnUpright(const SheetTopology& topology, const std::vector<GrainPair>& grain,
                 std::vector<Eigen::Vector2d>& flat);

/// How many triangles are turned over or without area.
[[nodiscard]] std::size_t CountFlips(const CurvedSheet& sheet, const std::vector<Eigen::Vector2d>& flat);

}  // namespace annulus
