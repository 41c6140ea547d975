#include "station/truth_table.h"

#include <algorithm>
#include <cmath>

#include "modeling/measure/slab.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

constexpr double kBelowArmpit = 20.0;  // mm, clear of the fold

const Measurement* Find(const MeasurementTable& table, const std::string& id) {
  const auto found = std::find_if(table.measurements.begin(), table.measurements.end(),
                                  [&](const Measurement& m) { return m.id == id; });
  return found == table.measurements.end() ? nullptr : &*found;
}

const sim::NamedLevel* FindLevel(const sim::ParametricBody& truth, const std::string& id) {
  const auto& levels = truth.levels();
  const auto found = std::find_if(levels.begin(), levels.end(), [&](const auto& level) { return level.id == id; });
  return found == levels.end() ? nullptr : &*found;
}

std::string Capitalised(std::string text) {
  text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

TruthComparison Row(ComparisonGroup group, std::string term, const Uncertain& measured, double truth) {
  return {group, std::move(term), "mm", measured.value, HalfWidth95(measured), truth, false};
}

/// The same in a larger unit.
TruthComparison Scaled(TruthComparison row, double factor, const char* unit) {
  row.measured *= factor;
  row.half95 *= factor;
  row.truth *= factor;
  row.unit = unit;
  return row;
}

void AddFound(const MeasurementTable& table, const sim::NamedLevel& level, const sim::SectionTruth& section,
              std::vector<TruthComparison>& rows) {
  if (const Measurement* girth = Find(table, level.id + "_girth")) {
    rows.push_back(Row(ComparisonGroup::kFoundLevel, girth->term, girth->value, section.tape_mm));
    rows.back().girth = true;
  }
  if (const Measurement* height = Find(table, level.id + "_height")) {
    rows.push_back(Row(ComparisonGroup::kFoundLevel, height->term, height->value, level.z_mm));
  }
}

Status AddAtTrueLevel(const MeasuredSurface& surface, const sim::NamedLevel& level, const sim::SectionTruth& section,
                      std::vector<TruthComparison>& rows) {
  const auto measured = MeasureSection(surface, level.z_mm);
  if (!measured) return Fail(measured);
  const std::string name = Capitalised(level.id);
  rows.push_back(Row(ComparisonGroup::kTrueLevel, name + " girth", measured->tape, section.tape_mm));
  rows.back().girth = true;
  rows.push_back(Row(ComparisonGroup::kTrueLevel, name + " skin length", measured->perimeter, section.perimeter_mm));
  rows.push_back(
      Scaled(Row(ComparisonGroup::kTrueLevel, name + " area", measured->area, section.area_mm2), 0.01, "cm²"));
  return {};
}

Status AddVolume(const MeasuredSurface& surface, const sim::ParametricBody& truth, std::vector<TruthComparison>& rows) {
  const auto armpit = truth.heights().armpit_mm;
  const sim::NamedLevel* lower = FindLevel(truth, armpit ? "hip" : "neck");
  const sim::NamedLevel* brow = FindLevel(truth, "head");
  if (lower == nullptr || (!armpit && brow == nullptr)) return {};
  const double upper = armpit ? *armpit - kBelowArmpit : brow->z_mm;
  const auto slab = MeasureSlab(surface, lower->z_mm, upper);
  if (!slab) return Fail(slab);
  rows.push_back(Scaled(Row(ComparisonGroup::kVolume, armpit ? "Volume, hip to armpit" : "Volume, neck to brow",
                            slab->volume, truth.TorsoVolume(lower->z_mm, upper)),
                        1e-6, "dm³"));
  return {};
}

}  // namespace

const char* ComparisonGroupName(ComparisonGroup group) {
  switch (group) {
    case ComparisonGroup::kFoundLevel:
      return "at the levels found";
    case ComparisonGroup::kTrueLevel:
      return "at the true levels";
    case ComparisonGroup::kVolume:
      return "volume";
  }
  return "";
}

Result<std::vector<TruthComparison>> CompareWithTruth(const MeasuredSurface& surface, const MeasurementTable& table,
                                                      const sim::ParametricBody& truth) {
  std::vector<TruthComparison> rows;
  const auto section_of = [&](const sim::NamedLevel& level) { return truth.TorsoSection(level.z_mm); };
  for (const sim::NamedLevel& level : truth.levels()) {
    if (const auto section = section_of(level)) AddFound(table, level, *section, rows);
  }
  for (const sim::NamedLevel& level : truth.levels()) {
    if (const auto section = section_of(level)) RETURN_IF_ERROR(AddAtTrueLevel(surface, level, *section, rows));
  }
  RETURN_IF_ERROR(AddVolume(surface, truth, rows));
  return rows;
}

double LargestGirthError(const std::vector<TruthComparison>& comparisons) {
  double largest = 0.0;
  for (const TruthComparison& row : comparisons) {
    if (row.girth) largest = std::max(largest, std::abs(row.measured - row.truth));
  }
  return largest;
}

double LargestVolumeError(const std::vector<TruthComparison>& comparisons) {
  double largest = 0.0;
  for (const TruthComparison& row : comparisons) {
    if (row.group == ComparisonGroup::kVolume) largest = std::max(largest, std::abs(row.measured / row.truth - 1.0));
  }
  return largest;
}

std::vector<Eigen::Vector2d> TrueOutline(const sim::ParametricBody& truth, double z) {
  constexpr std::size_t kPoints = 720;
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t k = 0; k < kPoints; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(kPoints);
    outline.emplace_back(truth.StationFromBody(truth.torso().Point(theta, z)).head<2>());
  }
  return outline;
}

std::vector<Eigen::Vector2d> Exaggerated(const std::vector<Eigen::Vector2d>& measured,
                                         const std::vector<Eigen::Vector2d>& truth, double factor) {
  std::vector<std::pair<double, double>> polar;  // angle and radius of the truth, by angle
  polar.reserve(truth.size() + 2);
  for (const Eigen::Vector2d& point : truth) polar.emplace_back(std::atan2(point.y(), point.x()), point.norm());
  std::sort(polar.begin(), polar.end());
  if (polar.empty()) return measured;
  // Once around more at both ends, so that every angle lies between two.
  polar.insert(polar.begin(), {polar.back().first - kTwoPi, polar.back().second});
  polar.emplace_back(polar[1].first + kTwoPi, polar[1].second);
  std::vector<Eigen::Vector2d> drawn;
  for (const Eigen::Vector2d& point : measured) {
    const double angle = std::atan2(point.y(), point.x());
    const auto after = std::upper_bound(polar.begin() + 1, polar.end() - 1, std::pair{angle, 0.0});
    const auto before = after - 1;
    const double share = (angle - before->first) / std::max(1e-12, after->first - before->first);
    const double radius = before->second + share * (after->second - before->second);
    drawn.emplace_back(point.normalized() * (radius + factor * (point.norm() - radius)));
  }
  return drawn;
}

}  // namespace annulus
