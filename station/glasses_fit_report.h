#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "modeling/glasses/glasses_fit.h"
#include "modeling/glasses/glasses_rank.h"
#include "modeling/glasses/placement.h"

namespace annulus {

/// What a fit found, as it stands in WORN.json under "fit" and in `--json`: goals, contacts, balance, advice. Lengths
/// in mm, angles in degrees; a sigma that is not known is left out.
[[nodiscard]] nlohmann::ordered_json FitReport(const GlassesFit& fit);
/// The same for reading.
[[nodiscard]] std::string FitText(const GlassesFit& fit);
/// The clearance map: part,x_mm,y_mm,z_mm,distance_mm.
[[nodiscard]] std::string ClearanceCsv(const GlassesFit& fit);

/// What placing by the paper's steps left.
[[nodiscard]] nlohmann::ordered_json PlacementReport(const WornFrame& worn);
[[nodiscard]] std::string PlacementText(const WornFrame& worn);

/// The first `count` of a ranking.
[[nodiscard]] nlohmann::ordered_json RankReport(const std::vector<RankedFrame>& ranked, std::size_t count);
[[nodiscard]] std::string RankText(const std::vector<RankedFrame>& ranked, std::size_t count);

}  // namespace annulus
