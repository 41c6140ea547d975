#include "modeling/measure/slab.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/frames.h"
#include "modeling/measure/gauss.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/section_sampler.h"
#include "modeling/measure/surface_path.h"

namespace annulus {
namespace {

/// Every row of the knowledge map that the slab cuts, by the height it takes of it.
PathKnowledge SharesOfSlab(const MeasuredSurface& body, double z_min, double z_max) {
  const KnowledgeMap& map = body.segment().knowledge;
  const auto rows = static_cast<double>(map.rows());
  std::vector<double> edges;
  for (double row = 0.0; row <= rows; row += 1.0) {
    edges.push_back(map.z_min() + (map.z_max() - map.z_min()) * row / std::max(rows, 1.0));
  }
  const std::vector<double> breaks = ClipBreaks(edges, z_min, z_max);
  PathKnowledge shares;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const PathKnowledge row = KnowledgeOfLevel(body, 0.5 * (breaks[k] + breaks[k + 1]));
    const double height = (breaks[k + 1] - breaks[k]) / (z_max - z_min);
    shares.measured += height * row.measured;
    shares.unknown += height * row.unknown;
  }
  shares.measured = std::min(1.0, shares.measured);  // the heights may add up to more by a rounding
  shares.unknown = std::min(1.0, shares.unknown);
  return shares;
}

/// Volume and skin of a slab by 4 × 4 Gauss points per patch, row by row: the splines over theta are the same in every
/// patch.
class SlabIntegral {
 public:
  explicit SlabIntegral(const SplineSurface& surface)
      : surface_(surface), width_(surface.theta_basis().count()), volume_gradient_(surface), area_gradient_(surface) {
    const double spacing = surface.theta_basis().spacing();
    const std::vector<QuadratureNode> nodes = PiecewiseGauss(std::array<double, 2>{0.0, spacing});
    for (std::size_t g = 0; g < nodes.size(); ++g) {
      around_[g] = surface.theta_basis().InInterval(0, nodes[g].x);
      weights_[g] = nodes[g].weight;
    }
  }

  /// Adds the section at a height with the weight of a node over z.
  void AddSection(const QuadratureNode& up) {
    const CubicBasis at_z = surface_.z_basis().At(up.x);
    const Eigen::VectorXd value = Wrapped(at_z, at_z.value);
    const Eigen::VectorXd slope = Wrapped(at_z, at_z.first);
    Adjoint volume(value.size());
    Adjoint area(value.size());
    for (std::size_t i = 0; i < width_; ++i) {
      for (std::size_t g = 0; g < around_.size(); ++g)
        AddNode({i, g, up.weight * weights_[g]}, value, slope, volume, area);
    }
    volume_gradient_.AddSection(at_z, Folded(volume.value), Folded(volume.slope));
    area_gradient_.AddSection(at_z, Folded(area.value), Folded(area.slope));
  }

  [[nodiscard]] Estimate volume() const { return {volume_, volume_gradient_.Get()}; }
  [[nodiscard]] Estimate area() const { return {area_, area_gradient_.Get()}; }

 private:
  /// A node of interval `interval`: which of its Gauss points, and the weight of both directions.
  struct Node {
    std::size_t interval;
    std::size_t point;
    double weight;
  };
  /// Derivatives with respect to the coefficients of a section and of its slope.
  struct Adjoint {
    explicit Adjoint(Eigen::Index size) : value(Eigen::VectorXd::Zero(size)), slope(Eigen::VectorXd::Zero(size)) {}
    Eigen::VectorXd value;
    Eigen::VectorXd slope;
  };

  /// The section's coefficients, the last and first ones repeated: entries i … i + 3 act in interval i.
  [[nodiscard]] Eigen::VectorXd Wrapped(const CubicBasis& at_z, const std::array<double, 4>& weights) const {
    const Eigen::VectorXd section = SectionCoefficients(surface_, at_z, weights, surface_.coefficients());
    Eigen::VectorXd wrapped(section.size() + 3);
    wrapped << section[section.size() - 1], section, section[0], section[1];
    return wrapped;
  }
  [[nodiscard]] Eigen::VectorXd Folded(const Eigen::VectorXd& wrapped) const {
    const auto width = static_cast<Eigen::Index>(width_);
    Eigen::VectorXd section = wrapped.segment(1, width);
    section[width - 1] += wrapped[0];
    section[0] += wrapped[width + 1];
    section[1] += wrapped[width + 2];
    return section;
  }

  void AddNode(const Node& node, const Eigen::VectorXd& value, const Eigen::VectorXd& slope, Adjoint& volume,
               Adjoint& area) {
    const CubicBasis& basis = around_[node.point];
    const auto first = static_cast<Eigen::Index>(node.interval);
    const Eigen::Map<const Eigen::Vector4d> n(basis.value.data());
    const Eigen::Map<const Eigen::Vector4d> n_theta(basis.first.data());
    const double r = n.dot(value.segment<4>(first));
    const double r_theta = n_theta.dot(value.segment<4>(first));
    const double r_z = n.dot(slope.segment<4>(first));
    // |P_theta × P_z|² = r² + r_theta² + r² r_z²
    const double density = std::sqrt(r * r * (1.0 + r_z * r_z) + r_theta * r_theta);
    volume_ += node.weight * 0.5 * r * r;
    area_ += node.weight * density;
    volume.value.segment<4>(first) += (node.weight * r) * n;
    if (density == 0.0) return;
    const double scale = node.weight / density;
    area.value.segment<4>(first) += (scale * r * (1.0 + r_z * r_z)) * n + (scale * r_theta) * n_theta;
    area.slope.segment<4>(first) += (scale * r * r * r_z) * n;
  }

  const SplineSurface& surface_;
  std::size_t width_;
  std::array<CubicBasis, 4> around_;
  std::array<double, 4> weights_{};
  double volume_ = 0.0;
  double area_ = 0.0;
  GradientSum volume_gradient_;
  GradientSum area_gradient_;
};

}  // namespace

Result<SlabEstimates> SlabBetween(const MeasuredSurface& body, double z_min, double z_max) {
  const std::string attempted = "measure the slab from z = " + NumberText(z_min) + " to " + NumberText(z_max) + " mm";
  if (!(z_min < z_max)) return Fail(attempted, "it has no height", "give --z-min below --z-max");
  RETURN_IF_ERROR(CheckInRange(body, z_min, attempted));
  RETURN_IF_ERROR(CheckInRange(body, z_max, attempted));
  const PathKnowledge shares = SharesOfSlab(body, z_min, z_max);
  RETURN_IF_ERROR(CheckKnown(shares, attempted));

  SlabIntegral integral(body.surface());
  const std::vector<double> breaks = ClipBreaks(body.surface().z_basis().breakpoints(), z_min, z_max);
  for (const QuadratureNode& up : PiecewiseGauss(breaks)) integral.AddSection(up);
  return SlabEstimates{z_min, z_max, integral.volume(), integral.area(), shares.measured};
}

Result<SlabMeasures> MeasureSlab(const MeasuredSurface& body, double z_min, double z_max) {
  const auto slab = SlabBetween(body, z_min, z_max);
  if (!slab) return Fail(slab);
  const std::vector<Uncertain> numbers = body.WithSigmas({slab->volume, slab->area});
  return SlabMeasures{z_min, z_max, numbers[0], numbers[1], slab->measured_share};
}

}  // namespace annulus
