#pragma once

#include <Eigen/Core>

#include "render/colour.h"
#include "render/material.h"

namespace annulus {

/// A local frame at a surface point: x along the part (the grooves of brushed metal), y across, z the shading normal on
/// the side of the eye. Directions in it are unit vectors away from the surface.
struct LocalFrame {
  Eigen::Vector3f x;
  Eigen::Vector3f y;
  Eigen::Vector3f z;

  /// About `normal` (unit); x is `along` made perpendicular, any if it is parallel or zero.
  [[nodiscard]] static LocalFrame About(const Eigen::Vector3f& normal, const Eigen::Vector3f& along);
  [[nodiscard]] Eigen::Vector3f ToLocal(const Eigen::Vector3f& v) const { return {v.dot(x), v.dot(y), v.dot(z)}; }
  [[nodiscard]] Eigen::Vector3f ToWorld(const Eigen::Vector3f& v) const { return v.x() * x + v.y() * y + v.z() * z; }
};

/// How one point of an opaque or milky surface scatters light: the path tracer's reading of a Material (every finish
/// but kLens). A value of a few dozen bytes, made per hit. Energy: the albedo never exceeds 1 in any channel, and is 1
/// for a white kMatte, kPlastic, kTranslucent, kSkin (coat and body share what comes in) and for a metal of reflectance
/// 1 (energy lost between grooves is given back), within 0.002.
class Bsdf {
 public:
  /// `colour`: the material's colour at this point, texture and vertex colour applied, 0 … 1.
  Bsdf(const Material& material, const LinearRgb& colour);

  /// f · |cos| for light from `in` towards `out` (local; out.z > 0; in.z < 0 only where light comes through). Mirror
  /// parts are rough enough (roughness is at least 0.03) to be evaluated.
  [[nodiscard]] LinearRgb Evaluate(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const;
  /// With which density Sample draws `in`, per steradian.
  [[nodiscard]] float Density(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const;

  struct Draw {
    Eigen::Vector3f in;   ///< Where light comes from, local.
    LinearRgb weight;     ///< Evaluate / Density; zero: absorbed.
    float density = 0.0F;
  };
  /// `choice`, u, v in [0, 1).
  [[nodiscard]] Draw Sample(const Eigen::Vector3f& out, float choice, float u, float v) const;

  /// The directional albedo's rough estimate, for the denoiser's guide.
  [[nodiscard]] const LinearRgb& albedo() const { return albedo_; }

 private:
  LinearRgb albedo_ = LinearRgb::Zero();
  LinearRgb specular_ = LinearRgb::Zero();  // reflectance at normal incidence of the mirror part
  LinearRgb diffuse_ = LinearRgb::Zero();   // body colour
  float alpha_x_ = 1.0F;                    // GGX widths
  float alpha_y_ = 1.0F;
  float through_ = 0.0F;  // share of the diffuse light from behind
  bool has_coat_ = false;
  bool is_metal_ = false;
};

}  // namespace annulus
