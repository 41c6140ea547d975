#include "station/values_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "station/place_table.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSame = 1e-6;  // degrees or mm: the same column or row of a grid

std::vector<double> Distinct(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end(), [](double a, double b) { return b - a < kSame; }),
               values.end());
  return values;
}

std::size_t IndexOf(const std::vector<double>& values, double value) {
  const auto at = std::lower_bound(values.begin(), values.end(), value - kSame);
  return static_cast<std::size_t>(at - values.begin());
}

/// A full grid over the turn.
struct ValueGrid {
  std::vector<double> theta;  ///< Degrees in [0, 360), rising.
  std::vector<double> z;      ///< mm, rising.
  Eigen::MatrixXd value;      ///< Row: z.

  /// nan outside, and beside nan.
  [[nodiscard]] double At(double theta_deg, double height) const {
    if (height < z.front() - kSame || height > z.back() + kSame) return kNan;
    const auto row = static_cast<Eigen::Index>(
        std::clamp<std::ptrdiff_t>(std::upper_bound(z.begin(), z.end(), height) - z.begin() - 1, 0,
                                   std::max<std::ptrdiff_t>(0, static_cast<std::ptrdiff_t>(z.size()) - 2)));
    const Eigen::Index row_above = std::min<Eigen::Index>(row + 1, value.rows() - 1);
    const auto count = static_cast<Eigen::Index>(theta.size());
    const Eigen::Index column =
        (std::upper_bound(theta.begin(), theta.end(), theta_deg) - theta.begin() - 1 + count) % count;
    const Eigen::Index next = (column + 1) % count;
    const auto turn = [](double degrees) { return degrees < 0.0 ? degrees + 360.0 : degrees; };
    const double wide = turn(theta[static_cast<std::size_t>(next)] - theta[static_cast<std::size_t>(column)]);
    const double right = wide > 0.0 ? turn(theta_deg - theta[static_cast<std::size_t>(column)]) / wide : 0.0;
    const double tall = z[static_cast<std::size_t>(row_above)] - z[static_cast<std::size_t>(row)];
    const double up = tall > 0.0 ? std::clamp((height - z[static_cast<std::size_t>(row)]) / tall, 0.0, 1.0) : 0.0;
    return (1.0 - up) * ((1.0 - right) * value(row, column) + right * value(row, next)) +
           up * ((1.0 - right) * value(row_above, column) + right * value(row_above, next));
  }
};

/// The grid that the rows fill, if they fill one.
std::shared_ptr<ValueGrid> GridOf(const std::vector<PlaceRow>& rows) {
  auto grid = std::make_shared<ValueGrid>();
  for (const PlaceRow& row : rows) {
    grid->theta.push_back(row.theta_deg);
    grid->z.push_back(row.z);
  }
  grid->theta = Distinct(grid->theta);
  grid->z = Distinct(grid->z);
  if (grid->theta.size() * grid->z.size() != rows.size()) return nullptr;
  grid->value.setConstant(static_cast<Eigen::Index>(grid->z.size()), static_cast<Eigen::Index>(grid->theta.size()),
                          std::numeric_limits<double>::infinity());
  for (const PlaceRow& row : rows) {
    grid->value(static_cast<Eigen::Index>(IndexOf(grid->z, row.z)),
                static_cast<Eigen::Index>(IndexOf(grid->theta, row.theta_deg))) = row.value;
  }
  return grid->value.array().isInf().any() ? nullptr : grid;
}

/// Places anywhere: those in the cells around are looked at.
class ScatteredValues {
 public:
  ScatteredValues(const SurfaceModel& model, const std::vector<PlaceRow>& rows) {
    const SplineSurface& surface = model.main().surface;
    for (const PlaceRow& row : rows) {
      const double z = std::clamp(row.z, surface.z_min(), surface.z_max());
      points_.push_back({surface.Point(RadiansFromDegrees(row.theta_deg), z), row.value});
    }
    // Points that cover an area evenly are the root of their share of it apart.
    const double height = std::max(surface.z_max() - surface.z_min(), 1.0);
    double radius = 0.0;
    for (const Point& point : points_) radius += point.position.head<2>().norm() / static_cast<double>(points_.size());
    reach_ = 3.0 * std::sqrt(kTwoPi * std::max(radius, 1.0) * height / static_cast<double>(points_.size()));
    for (std::size_t k = 0; k < points_.size(); ++k) cells_[CellOf(points_[k].position)].push_back(k);
  }

  [[nodiscard]] double Nearest(const Eigen::Vector3d& p) const {
    double best = reach_ * reach_;
    double value = kNan;
    const Cell middle = CellOf(p);
    for (long x = -1; x <= 1; ++x) {
      for (long y = -1; y <= 1; ++y) {
        for (long z = -1; z <= 1; ++z) {
          const auto cell = cells_.find({middle[0] + x, middle[1] + y, middle[2] + z});
          if (cell == cells_.end()) continue;
          for (const std::size_t k : cell->second) {
            const double apart = (points_[k].position - p).squaredNorm();
            if (apart >= best) continue;
            best = apart;
            value = points_[k].value;
          }
        }
      }
    }
    return value;
  }

 private:
  using Cell = std::array<long, 3>;
  struct Point {
    Eigen::Vector3d position;
    double value = 0.0;
  };
  [[nodiscard]] Cell CellOf(const Eigen::Vector3d& p) const {
    return {std::lround(p.x() / reach_), std::lround(p.y() / reach_), std::lround(p.z() / reach_)};
  }
  std::vector<Point> points_;
  double reach_ = 1.0;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

}  // namespace

Result<BodyField> ValuesField(const SurfaceModel& model, std::string_view csv, const std::string& name) {
  auto rows = ParsePlaceTable(csv, name, "value");
  if (!rows) return Fail(rows);
  if (rows->empty()) return Fail("read " + name, "it has no values", "give at least one line below the columns' names");
  for (PlaceRow& row : *rows) row.theta_deg = DegreesFromRadians(WrapAngle(RadiansFromDegrees(row.theta_deg)));
  BodyField field;
  field.title = "Values of " + name.substr(name.find_last_of('/') + 1);
  const std::size_t count = rows->size();
  const bool is_signed = std::any_of(rows->begin(), rows->end(), [](const PlaceRow& row) { return row.value < 0.0; });
  field.map = is_signed ? ColourMap::kDiverging : ColourMap::kSequential;
  field.rule = is_signed ? ScaleRule::kAboutZero : ScaleRule::kPercentiles;
  if (const std::shared_ptr<const ValueGrid> grid = GridOf(*rows)) {
    field.definition = "Numbers of a table at " + std::to_string(count) + " places of a grid, linear in between.";
    field.value = [&model, grid](const BodyPlace& place) {
      const SurfaceSegment& main = model.main();
      if (place.segment != 0) return kNan;
      if (main.knowledge.rows() > 0 && main.knowledge.At(place.theta, place.z) == Knowledge::kUnknown) return kNan;
      return grid->At(DegreesFromRadians(WrapAngle(place.theta)), place.z);
    };
    return field;
  }
  const auto scattered = std::make_shared<const ScatteredValues>(model, *rows);
  field.definition = "Numbers of a table at " + std::to_string(count) + " places; everywhere that of the nearest.";
  field.value = [&model, scattered](const BodyPlace& place) {
    return place.segment == 0 ? scattered->Nearest(model.main().surface.Point(place.theta, place.z)) : kNan;
  };
  return field;
}

}  // namespace annulus
