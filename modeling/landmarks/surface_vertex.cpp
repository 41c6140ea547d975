#include "modeling/landmarks/surface_vertex.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/ensure.h"
#include "base/frames.h"

namespace annulus {
namespace {

constexpr std::size_t kNodesPerSide = 11;
constexpr int kMaxSteps = 60;
constexpr double kConverged = 1e-11;  // of a window's half size
constexpr double kFarthest = 3.0;     // windows

/// The window's nodes in [-1, 1] and their weights 1 − u²: the midpoint rule, whose sums of odd powers vanish to the
/// bit, so that the least-squares slopes are plain first moments.
struct WindowRule {
  std::array<double, kNodesPerSide> at{};
  std::array<double, kNodesPerSide> weight{};
  double second = 0.0;  // Σ w u² / Σ w
  double sum = 0.0;     // Σ w
};

WindowRule MakeWindowRule() {
  WindowRule rule;
  double second = 0.0;
  for (std::size_t k = 0; k < kNodesPerSide; ++k) {
    const double u = (2.0 * static_cast<double>(k) + 1.0) / static_cast<double>(kNodesPerSide) - 1.0;
    rule.at[k] = u;
    rule.weight[k] = 1.0 - u * u;
    rule.sum += rule.weight[k];
    second += rule.weight[k] * u * u;
  }
  rule.second = second / rule.sum;
  return rule;
}

/// Where the window stands.
struct Window {
  double theta = 0.0;
  double z = 0.0;
  double half_theta = 0.0;  // rad
  double half_up = 0.0;     // mm
};

/// The field and its derivatives along theta and z at one place, mm, mm/rad, mm/mm.
struct FieldJet {
  double value = 0.0;
  double by_theta = 0.0;
  double by_z = 0.0;
};

FieldJet JetAt(const SplineSurface& surface, const SurfaceField& field, double theta, double z) {
  FieldJet sum;
  for (const FieldTerm& term : field.terms()) {
    const double t = theta + term.d_theta;
    const double height = std::clamp(z + term.d_z, surface.z_min(), surface.z_max());
    const RadiusJet jet = surface.Jet(t, height);
    const double radial = field.radial(t);
    sum.value += term.weight * (radial * jet.r + field.upward() * height);
    sum.by_theta += term.weight * (radial * jet.r_theta + field.radial_theta(t) * jet.r);
    if (height == z + term.d_z) sum.by_z += term.weight * (radial * jet.r_z + field.upward());
  }
  return sum;
}

/// The least-squares slopes of the field in the window's coordinates u, v (both -1 … 1), and how they follow the window
/// and the surface.
struct Slopes {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();      // mm per half window
  Eigen::Matrix2d by_centre = Eigen::Matrix2d::Zero();  // columns: by theta, by z; the window's size held
  Eigen::Vector2d by_half_theta = Eigen::Vector2d::Zero();
};

class WindowFit {
 public:
  WindowFit(const SplineSurface& surface, const VertexQuery& query)
      : surface_(surface), query_(query), rule_(MakeWindowRule()) {}

  [[nodiscard]] Window At(double theta, double z) const {
    return {theta, z, query_.half_across / std::max(surface_.Radius(theta, z), 1.0), query_.half_up};
  }

  /// Slopes with the derivatives of the window's own size: half_theta = half_across / r(theta, z).
  [[nodiscard]] Slopes SlopesAt(const Window& window) const {
    Slopes s;
    ForEachNode(window, [&](double u, double v, double weight, const FieldJet& jet) {
      const Eigen::Vector2d moment(weight * u, weight * v);
      s.slope += jet.value * moment;
      s.by_centre.col(0) += jet.by_theta * moment;
      s.by_centre.col(1) += jet.by_z * moment;
      s.by_half_theta += u * jet.by_theta * moment;
    });
    const RadiusJet centre = surface_.Jet(window.theta, window.z);
    if (centre.r > 1.0) {
      s.by_centre.col(0) += s.by_half_theta * (-window.half_theta / centre.r * centre.r_theta);
      s.by_centre.col(1) += s.by_half_theta * (-window.half_theta / centre.r * centre.r_z);
    }
    return s;
  }

  /// How slope `axis` (0: u, 1: v) follows the surface's coefficients, the centre held.
  [[nodiscard]] Gradient SlopeGradient(const Window& window, int axis, double by_half_theta) const {
    GradientSum sum(surface_);
    for (std::size_t i = 0; i < kNodesPerSide; ++i) {
      for (std::size_t j = 0; j < kNodesPerSide; ++j) {
        const double moment = Weight(i, j) * rule_.at[axis == 0 ? i : j];
        for (const FieldTerm& term : query_.field.terms()) {
          const double theta = window.theta + rule_.at[i] * window.half_theta + term.d_theta;
          const double z = window.z + rule_.at[j] * window.half_up + term.d_z;
          sum.AddRadius(theta, std::clamp(z, surface_.z_min(), surface_.z_max()),
                        moment * term.weight * query_.field.radial(theta));
        }
      }
    }
    const double r = surface_.Radius(window.theta, window.z);
    if (r > 1.0) sum.AddRadius(window.theta, window.z, -by_half_theta * window.half_theta / r);
    return sum.Get();
  }

  /// Height, rises, residual and confidence of the paraboloid.
  [[nodiscard]] SurfaceVertex Describe(const Window& window) const {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    double squares = 0.0;
    double weights = 0.0;
    ForEachNode(window, [&](double u, double v, double moment_weight, const FieldJet& jet) {
      const double w = moment_weight;
      const Eigen::Matrix<double, 6, 1> basis{{1.0, u, v, u * u, u * v, v * v}};
      normal += w * basis * basis.transpose();
      right += w * jet.value * basis;
      squares += w * jet.value * jet.value;
      weights += w;
    });
    const Eigen::Matrix<double, 6, 1> p = normal.ldlt().solve(right);
    SurfaceVertex vertex;
    vertex.height = p[0];
    vertex.rise_across = p[3];
    vertex.rise_up = p[5];
    vertex.residual = std::sqrt(std::max(squares - p.dot(right), 0.0) / weights);
    double clear = std::min(std::abs(p[3]), std::abs(p[5]));
    if (query_.freedom == VertexFreedom::kAcross) clear = std::abs(p[3]);
    if (query_.freedom == VertexFreedom::kUp) clear = std::abs(p[5]);
    vertex.confidence = clear / (clear + vertex.residual + 0.5);
    return vertex;
  }

 private:
  /// Normalised so that Σ weight u f is the least-squares slope of f along u.
  [[nodiscard]] double Weight(std::size_t i, std::size_t j) const {
    return rule_.weight[i] * rule_.weight[j] / (rule_.sum * rule_.sum * rule_.second);
  }

  template <class Visit>
  void ForEachNode(const Window& window, Visit visit) const {
    for (std::size_t i = 0; i < kNodesPerSide; ++i) {
      for (std::size_t j = 0; j < kNodesPerSide; ++j) {
        visit(rule_.at[i], rule_.at[j], Weight(i, j),
              JetAt(surface_, query_.field, window.theta + rule_.at[i] * window.half_theta,
                    window.z + rule_.at[j] * window.half_up));
      }
    }
  }

  const SplineSurface& surface_;
  const VertexQuery& query_;
  WindowRule rule_;
};

/// Signs of the second derivatives across and up that the shape asks for.
Eigen::Vector2d WantedSigns(VertexShape shape) {
  switch (shape) {
    case VertexShape::kSummit:
      return {-1.0, -1.0};
    case VertexShape::kHollow:
      return {1.0, 1.0};
    case VertexShape::kRidgeHollow:
      return {-1.0, 1.0};
    case VertexShape::kRidgeBulge:
      return {1.0, -1.0};
  }
  return {-1.0, -1.0};
}

/// The change of the slopes along the window's own coordinates: symmetric but for the weights.
Eigen::Matrix2d InWindow(const Slopes& s, const Window& window) {
  Eigen::Matrix2d scaled = s.by_centre;
  scaled.col(0) *= window.half_theta;
  scaled.col(1) *= window.half_up;
  return scaled;
}

bool HasShape(const Eigen::Matrix2d& bend, const VertexQuery& query) {
  const Eigen::Vector2d wanted = WantedSigns(query.shape);
  const bool across = wanted[0] * bend(0, 0) > 0.0;
  const bool up = wanted[1] * bend(1, 1) > 0.0;
  if (query.freedom == VertexFreedom::kAcross) return across;
  if (query.freedom == VertexFreedom::kUp) return up;
  return across && up && wanted[0] * wanted[1] * bend.determinant() > 0.0;
}

/// Newton's step in half windows where the field has the wanted shape, else a step along the slope; at most half a
/// window.
Eigen::Vector2d Step(const Slopes& s, const Eigen::Matrix2d& bend, const VertexQuery& query) {
  const Eigen::Vector2d wanted = WantedSigns(query.shape);
  Eigen::Vector2d step = Eigen::Vector2d::Zero();
  if (query.freedom == VertexFreedom::kBoth && HasShape(bend, query)) {
    step = -bend.inverse() * s.slope;
  } else {
    for (int axis = 0; axis < 2; ++axis) {
      const double size = std::max(std::abs(bend(axis, axis)), 1e-9);
      step[axis] = -wanted[axis] * s.slope[axis] / size;
    }
  }
  if (query.freedom == VertexFreedom::kAcross) step[1] = 0.0;
  if (query.freedom == VertexFreedom::kUp) step[0] = 0.0;
  const double longest = step.cwiseAbs().maxCoeff();
  if (longest > 0.5) step *= 0.5 / longest;
  return step;
}

/// The window whose paraboloid has its vertex in the middle.
std::optional<Window> Settle(const SplineSurface& surface, const WindowFit& fit, const SurfacePlace& start,
                             const VertexQuery& query) {
  Window window = fit.At(start.theta, start.z);
  const Window first = window;
  for (int k = 0; k < kMaxSteps; ++k) {
    if (window.z - window.half_up < surface.z_min() || window.z + window.half_up > surface.z_max()) return std::nullopt;
    const Slopes s = fit.SlopesAt(window);
    const Eigen::Matrix2d bend = InWindow(s, window);
    const Eigen::Vector2d step = Step(s, bend, query);
    if (!step.allFinite()) return std::nullopt;
    if (step.cwiseAbs().maxCoeff() < kConverged) return HasShape(bend, query) ? std::optional(window) : std::nullopt;
    window = fit.At(window.theta + step[0] * window.half_theta, window.z + step[1] * window.half_up);
    const bool is_far = std::abs(window.theta - first.theta) > kFarthest * first.half_theta ||
                        std::abs(window.z - first.z) > kFarthest * first.half_up;
    if (is_far) return std::nullopt;
  }
  return std::nullopt;
}

bool IsUsable(const SplineSurface& surface, double theta, double z, const VertexQuery& query) {
  return std::isfinite(theta) && z >= surface.z_min() && z <= surface.z_max() && query.half_across > 0.0 &&
         query.half_up > 0.0 && std::isfinite(query.half_across) && std::isfinite(query.half_up);
}

}  // namespace

SurfaceField SurfaceField::Radius() { return {}; }

SurfaceField SurfaceField::Along(const Eigen::Vector3d& direction) {
  ENSURE(direction.norm() > 0.0, "a field along no direction");
  SurfaceField field;
  field.along_ = direction.normalized();
  return field;
}

SurfaceField SurfaceField::OverChord(double d_theta, double d_z) const {
  SurfaceField field = *this;
  field.terms_.clear();
  for (const FieldTerm& term : terms_) {
    field.terms_.push_back(term);
    field.terms_.push_back({term.d_theta + d_theta, term.d_z + d_z, -0.5 * term.weight});
    field.terms_.push_back({term.d_theta - d_theta, term.d_z - d_z, -0.5 * term.weight});
  }
  return field;
}

SurfaceField SurfaceField::Fall(double d_theta, double d_z) const {
  SurfaceField field = *this;
  field.terms_.clear();
  for (const FieldTerm& term : terms_) {
    field.terms_.push_back({term.d_theta - d_theta, term.d_z - d_z, term.weight});
    field.terms_.push_back({term.d_theta + d_theta, term.d_z + d_z, -term.weight});
  }
  return field;
}

double SurfaceField::At(const SplineSurface& surface, const SurfacePlace& place) const {
  return JetAt(surface, *this, place.theta, place.z).value;
}

double SurfaceField::radial(double theta) const {
  return along_ ? along_->x() * std::cos(theta) + along_->y() * std::sin(theta) : 1.0;
}

double SurfaceField::radial_theta(double theta) const {
  return along_ ? along_->y() * std::cos(theta) - along_->x() * std::sin(theta) : 0.0;
}

std::optional<SurfaceVertex> FindVertex(const SplineSurface& surface, const SurfacePlace& start,
                                        const VertexQuery& query) {
  return FindVertexAlong(surface, {start.theta, {}}, {start.z, {}}, query);
}

std::optional<SurfaceVertex> FindVertexAlong(const SplineSurface& surface, const Estimate& theta, const Estimate& z,
                                             const VertexQuery& query) {
  if (!IsUsable(surface, theta.value, z.value, query)) return std::nullopt;
  const WindowFit fit(surface, query);
  const std::optional<Window> window = Settle(surface, fit, {theta.value, z.value}, query);
  if (!window) return std::nullopt;
  SurfaceVertex vertex = fit.Describe(*window);
  const Slopes s = fit.SlopesAt(*window);
  const Estimate across{s.slope[0], fit.SlopeGradient(*window, 0, s.by_half_theta[0])};
  const Estimate up{s.slope[1], fit.SlopeGradient(*window, 1, s.by_half_theta[1])};
  // slope(centre, surface) = 0 keeps holding: d(centre) = -by_centre⁻¹ · d(slope).
  if (query.freedom == VertexFreedom::kAcross) {
    const double bend = s.by_centre(0, 0);
    vertex.z = z;
    vertex.theta.gradient = Combine(-1.0 / bend, across, -s.by_centre(0, 1) / bend, z).gradient;
  } else if (query.freedom == VertexFreedom::kUp) {
    const double bend = s.by_centre(1, 1);
    vertex.theta = theta;
    vertex.z.gradient = Combine(-1.0 / bend, up, -s.by_centre(1, 0) / bend, theta).gradient;
  } else {
    const Eigen::Matrix2d inverse = s.by_centre.inverse();
    vertex.theta.gradient = Combine(-inverse(0, 0), across, -inverse(0, 1), up).gradient;
    vertex.z.gradient = Combine(-inverse(1, 0), across, -inverse(1, 1), up).gradient;
  }
  vertex.theta.value = window->theta;
  vertex.z.value = window->z;
  return vertex;
}

}  // namespace annulus
