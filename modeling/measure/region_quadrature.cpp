#include "modeling/measure/region_quadrature.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

Gradient Sparse(const Eigen::VectorXd& dense) {
  Gradient gradient(dense.size());
  for (Eigen::Index k = 0; k < dense.size(); ++k) {
    if (dense[k] != 0.0) gradient.insertBack(k) = dense[k];
  }
  return gradient;
}

}  // namespace

RegionQuadrature::RegionQuadrature(const SplineSurface& surface, const Eigen::Vector3d& apex)
    : surface_(&surface),
      apex_(apex),
      unit_(PiecewiseGauss(std::array<double, 2>{0.0, 1.0})),
      by_skin_(Eigen::VectorXd::Zero(surface.coefficients().size())),
      by_volume_(Eigen::VectorXd::Zero(surface.coefficients().size())) {
  for (std::size_t strip = 0; strip + 1 < surface.z_basis().breakpoints().size(); ++strip) {
    cubics_.push_back(surface.z_basis().Cubics(strip));
  }
  const double spacing = surface.theta_basis().spacing();
  for (std::size_t cell = 0; cell < surface.theta_basis().count(); ++cell) {
    for (const QuadratureNode& at : unit_) {
      whole_.push_back(
          NodeAt(static_cast<long>(cell), (static_cast<double>(cell) + at.x) * spacing, at.weight * spacing));
    }
  }
}

std::size_t RegionQuadrature::Column(long spline) const {
  const auto count = static_cast<long>(surface_->theta_basis().count());
  return static_cast<std::size_t>((spline % count + count) % count);
}

RegionQuadrature::ThetaNode RegionQuadrature::NodeAt(long cell, double theta, double weight) const {
  const double spacing = surface_->theta_basis().spacing();
  // The polynomials are the same in every interval: those of the first serve all.
  const CubicBasis basis =
      surface_->theta_basis().InInterval(0, std::clamp(theta - static_cast<double>(cell) * spacing, 0.0, spacing));
  const double cosine = std::cos(theta);
  const double sine = std::sin(theta);
  return {theta,       weight,     apex_.x() * cosine + apex_.y() * sine, apex_.y() * cosine - apex_.x() * sine,
          basis.value, basis.first};
}

std::array<RegionQuadrature::ZNode, 4> RegionQuadrature::HeightsIn(std::size_t strip, double top) const {
  const double bottom = surface_->z_basis().breakpoints()[strip];
  const double height = surface_->z_basis().breakpoints()[strip + 1] - bottom;
  std::array<ZNode, 4> nodes;
  for (std::size_t k = 0; k < 4; ++k) {
    const double t = unit_[k].x * (top - bottom) / height;
    ZNode& node = nodes[k];
    node.z = bottom + t * height;
    node.weight = unit_[k].weight * (top - bottom);
    node.value = ValuesAt(cubics_[strip], t);
    for (std::size_t j = 0; j < 4; ++j) {
      const std::array<double, 4>& c = cubics_[strip][j];
      node.first[j] = ((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]) / height;
    }
  }
  return nodes;
}

RegionQuadrature::Densities RegionQuadrature::At(const ThetaNode& node, double z, double r, double r_theta,
                                                 double r_z) const {
  // P_theta × P_z = r e_r - r_theta e_theta - r r_z e_z.
  const double steep = 1.0 + r_z * r_z;
  Densities d;
  d.skin = std::sqrt(r * r * steep + r_theta * r_theta);
  const double inverse = d.skin > 0.0 ? 1.0 / d.skin : 0.0;
  d.skin_by_r = r * steep * inverse;
  d.skin_by_theta = r_theta * inverse;
  d.skin_by_z = r * r * r_z * inverse;
  d.volume = (r * r - (z - apex_.z()) * r * r_z - r * node.apex_outward + r_theta * node.apex_around) / 3.0;
  return d;
}

void RegionQuadrature::AddNodes(const std::array<ThetaNode, 4>& across, const std::array<ZNode, 4>& up,
                                Eigen::Index column, StripRow& row) {
  for (std::size_t b = 0; b < 4; ++b) {
    for (const ThetaNode& node : across) {
      double r = 0.0;
      double r_theta = 0.0;
      double r_z = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        const auto at = column + static_cast<Eigen::Index>(i);
        r += node.value[i] * row.radius[b][at];
        r_theta += node.first[i] * row.radius[b][at];
        r_z += node.value[i] * row.slope[b][at];
      }
      const double weight = node.weight * up[b].weight;
      const Densities d = At(node, up[b].z, r, r_theta, r_z);
      skin_ += weight * d.skin;
      volume_ += weight * d.volume;
      for (std::size_t i = 0; i < 4; ++i) {
        const auto at = column + static_cast<Eigen::Index>(i);
        row.skin_by_radius[b][at] += weight * (d.skin_by_r * node.value[i] + d.skin_by_theta * node.first[i]);
        row.skin_by_slope[b][at] += weight * d.skin_by_z * node.value[i];
        row.volume_by_radius[b][at] += weight * r * node.value[i];
      }
    }
  }
}

void RegionQuadrature::AddRow(std::size_t strip, const std::array<ZNode, 4>& up, long first_cell, const StripRow& row) {
  const auto count = static_cast<Eigen::Index>(surface_->theta_basis().count());
  for (Eigen::Index k = 0; k < row.radius[0].size(); ++k) {
    const auto column = static_cast<Eigen::Index>(Column(first_cell - 1 + static_cast<long>(k)));
    for (std::size_t b = 0; b < 4; ++b) {
      for (std::size_t j = 0; j < 4; ++j) {
        const Eigen::Index at = static_cast<Eigen::Index>(strip + j) * count + column;
        by_skin_[at] += up[b].value[j] * row.skin_by_radius[b][k] + up[b].first[j] * row.skin_by_slope[b][k];
        by_volume_[at] += up[b].value[j] * row.volume_by_radius[b][k];
      }
    }
  }
}

void RegionQuadrature::AddRectangle(std::size_t strip, double from, double to) {
  const double spacing = surface_->theta_basis().spacing();
  const auto first = static_cast<long>(std::floor(from / spacing));
  const auto last = std::max(first, static_cast<long>(std::ceil(to / spacing)) - 1);
  const std::array<ZNode, 4> up = HeightsIn(strip, surface_->z_basis().breakpoints()[strip + 1]);
  const auto count = static_cast<Eigen::Index>(surface_->theta_basis().count());
  const Eigen::Index width = static_cast<Eigen::Index>(last - first) + 4;
  StripRow row;
  for (std::size_t b = 0; b < 4; ++b) {
    for (auto* part : {&row.radius, &row.slope, &row.skin_by_radius, &row.skin_by_slope, &row.volume_by_radius}) {
      (*part)[b] = Eigen::VectorXd::Zero(width);
    }
    for (Eigen::Index k = 0; k < width; ++k) {
      const auto column = static_cast<Eigen::Index>(Column(first - 1 + static_cast<long>(k)));
      for (std::size_t j = 0; j < 4; ++j) {
        const double c = surface_->coefficients()[static_cast<Eigen::Index>(strip + j) * count + column];
        row.radius[b][k] += up[b].value[j] * c;
        row.slope[b][k] += up[b].first[j] * c;
      }
    }
  }
  for (long cell = first; cell <= last; ++cell) {
    const double low = std::max(from, static_cast<double>(cell) * spacing);
    const double high = std::min(to, static_cast<double>(cell + 1) * spacing);
    std::array<ThetaNode, 4> across;
    const bool whole = cell > first && cell < last;
    for (std::size_t a = 0; a < 4; ++a) {
      across[a] = whole ? whole_[4 * Column(cell) + a]
                        : NodeAt(cell, low + unit_[a].x * (high - low), unit_[a].weight * (high - low));
    }
    AddNodes(across, up, static_cast<Eigen::Index>(cell - first), row);
  }
  AddRow(strip, up, first, row);
}

void RegionQuadrature::AddColumn(std::size_t strip, const SurfacePlace& top, double weight) {
  const CubicBasis u = surface_->theta_basis().At(top.theta);
  const auto count = static_cast<Eigen::Index>(surface_->theta_basis().count());
  const double cosine = std::cos(top.theta);
  const double sine = std::sin(top.theta);
  const ThetaNode node{top.theta, weight, apex_.x() * cosine + apex_.y() * sine, apex_.y() * cosine - apex_.x() * sine,
                       u.value,   u.first};
  for (const ZNode& up : HeightsIn(strip, top.z)) {
    double r = 0.0;
    double r_theta = 0.0;
    double r_z = 0.0;
    for (std::size_t j = 0; j < 4; ++j) {
      const double* c = surface_->coefficients().data() + static_cast<Eigen::Index>(strip + j) * count;
      double value = 0.0;
      double first = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        value += u.value[i] * c[u.index[i]];
        first += u.first[i] * c[u.index[i]];
      }
      r += up.value[j] * value;
      r_theta += up.value[j] * first;
      r_z += up.first[j] * value;
    }
    const Densities d = At(node, up.z, r, r_theta, r_z);
    const double w = weight * up.weight;
    skin_ += w * d.skin;
    volume_ += w * d.volume;
    for (std::size_t j = 0; j < 4; ++j) {
      const Eigen::Index row = static_cast<Eigen::Index>(strip + j) * count;
      const double by_value = w * (up.value[j] * d.skin_by_r + up.first[j] * d.skin_by_z);
      const double by_first = w * up.value[j] * d.skin_by_theta;
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Index at = row + static_cast<Eigen::Index>(u.index[i]);
        by_skin_[at] += by_value * u.value[i] + by_first * u.first[i];
        by_volume_[at] += w * r * up.value[j] * u.value[i];
      }
    }
  }
}

void RegionQuadrature::AddSkinByRadius(const SurfacePlace& place, double weight) {
  const RadiusRow row = surface_->Row(place.theta, place.z);
  for (std::size_t k = 0; k < row.index.size(); ++k) {
    by_skin_[static_cast<Eigen::Index>(row.index[k])] += weight * row.value[k];
  }
}

double RegionQuadrature::SkinDensity(const SurfacePlace& place) const {
  const RadiusJet jet = surface_->Jet(place.theta, place.z);
  return std::sqrt(jet.r * jet.r * (1.0 + jet.r_z * jet.r_z) + jet.r_theta * jet.r_theta);
}

Gradient RegionQuadrature::SkinGradient() const { return Sparse(by_skin_); }
Gradient RegionQuadrature::VolumeGradient() const { return Sparse(by_volume_); }

}  // namespace annulus
