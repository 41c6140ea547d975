#include "modeling/measure/table.h"

#include <array>
#include <limits>
#include <optional>

#include "base/units.h"
#include "modeling/measure/body_levels.h"

namespace annulus {
namespace {

constexpr double kLargeGirth = 9.0;  // ISO 20685-1 class limits, mm
constexpr double kSmallGirth = 4.0;
constexpr double kHeadGirth = 2.0;
constexpr double kHeight = 4.0;
constexpr double kSegmentLength = 5.0;

/// Term and class limit of a level's girth.
struct GirthClass {
  const char* level;
  const char* term;
  double limit;
};
constexpr std::array<GirthClass, 5> kGirths{{{"head", "Head girth", kHeadGirth},
                                             {"neck", "Neck girth", kSmallGirth},
                                             {"chest", "Chest girth", kLargeGirth},
                                             {"waist", "Waist girth", kLargeGirth},
                                             {"hip", "Hip girth", kLargeGirth}}};

/// A length along the front, back or side between two levels.
struct SurfaceLine {
  const char* id;
  const char* term;
  const char* upper;
  const char* lower;
  double theta_deg;
};
constexpr std::array<SurfaceLine, 4> kLines{{{"neck_to_waist_front", "Neck to waist, front", "neck", "waist", 90.0},
                                             {"neck_to_waist_back", "Neck to waist, back", "neck", "waist", 270.0},
                                             {"waist_to_hip_front", "Waist to hip, front", "waist", "hip", 90.0},
                                             {"waist_to_hip_back", "Waist to hip, back", "waist", "hip", 270.0}}};

std::optional<double> HeightOf(const std::vector<BodyLevel>& levels, const std::string& id) {
  for (const BodyLevel& level : levels) {
    if (level.id == id) return level.z;
  }
  return std::nullopt;
}

void AddGirth(const MeasuredSurface& body, const GirthClass& girth, double z, MeasurementTable& table) {
  const auto section = MeasureSection(body, z);
  if (!section) {
    table.omitted.push_back(std::string(girth.term) + ": " + section.error().seen + ".");
    return;
  }
  const std::string level = girth.level;
  const std::vector<std::string> landmarks{"level." + level};
  table.measurements.push_back({level + "_girth", girth.term,
                                "Horizontal tape girth at the " + level + " level (convex hull of the section).", "mm",
                                section->tape, section->measured_share, girth.limit, landmarks});
  table.measurements.push_back({level + "_perimeter", std::string(girth.term) + ", skin",
                                "Length of the section's curve at the " + level + " level, hollows followed.", "mm",
                                section->perimeter, section->measured_share, 0.0, landmarks});
  // How well the level itself is placed is not computed yet: no sigma, and so no claim about the class limit.
  constexpr double kUnknownSigma = std::numeric_limits<double>::quiet_NaN();
  table.measurements.push_back({level + "_height",
                                std::string(girth.term) + " height",
                                "Height of the " + level + " level above the station's floor.",
                                "mm",
                                {z, kUnknownSigma},
                                section->measured_share,
                                kHeight,
                                landmarks});
}

/// Share of a meridian that was seen and not inferred.
double MeasuredShareOfMeridian(const MeasuredSurface& body, double theta, double lower, double upper) {
  constexpr int kPlaces = 200;
  int measured = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const double z = lower + (upper - lower) * (k + 0.5) / kPlaces;
    if (body.KnowledgeAt(theta, z) == Knowledge::kMeasured) ++measured;
  }
  return static_cast<double>(measured) / kPlaces;
}

void AddLine(const MeasuredSurface& body, const SurfaceLine& line, double lower, double upper,
             MeasurementTable& table) {
  const double theta = RadiansFromDegrees(line.theta_deg);
  const auto along = MeridianLength(body, theta, lower, upper);
  const auto taut = MeridianTape(body, theta, lower, upper);
  if (!along || !taut) {
    table.omitted.push_back(std::string(line.term) + ": " + (along ? taut : along).error().seen + ".");
    return;
  }
  const std::vector<std::string> landmarks{std::string("level.") + line.upper, std::string("level.") + line.lower};
  const double share = MeasuredShareOfMeridian(body, theta, lower, upper);
  const std::string where = std::string(line.upper) + " level to the " + line.lower +
                            " level in the plane theta = " + std::to_string(static_cast<int>(line.theta_deg)) +
                            " degrees.";
  table.measurements.push_back({line.id, line.term, "Length along the surface from the " + where, "mm",
                                body.WithSigma(*along), share, kSegmentLength, landmarks});
  table.measurements.push_back({std::string(line.id) + "_tape", std::string(line.term) + ", taut",
                                "Length of a taut tape over the surface from the " + where, "mm", body.WithSigma(*taut),
                                share, kSegmentLength, landmarks});
}

}  // namespace

Result<MeasurementTable> MeasureTable(const MeasuredSurface& body, const TaskContext& context) {
  BodyLevels levels = FindBodyLevels(body, context);
  if (levels.found.empty()) {
    return Fail("measure the body", "no level of it was seen all around", "scan again with the whole body in the ring");
  }
  MeasurementTable table;
  table.levels = std::move(levels.found);
  table.omitted = std::move(levels.omitted);
  for (const GirthClass& girth : kGirths) {
    if (const auto z = HeightOf(table.levels, girth.level)) AddGirth(body, girth, *z, table);
  }
  for (const SurfaceLine& line : kLines) {
    const auto upper = HeightOf(table.levels, line.upper);
    const auto lower = HeightOf(table.levels, line.lower);
    if (upper && lower) AddLine(body, line, *lower, *upper, table);
  }
  return table;
}

}  // namespace annulus
