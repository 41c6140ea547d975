#pragma once

#include <Eigen/Core>

#include "render/colour.h"
#include "render/gloss_table.h"
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
/// but kLens). A small value, made per hit. Energy: the albedo never exceeds 1 in any channel, and is 1 for a white
/// kMatte, kPlastic, kTranslucent, kSkin (coat and body share what comes in) and for a metal of reflectance 1 (energy
/// lost between facets is given back), within 0.002. Every finish but the two metals is reciprocal.
///
/// With R the share of the light from a direction that the clear coat mirrors and M the mean of R over the hemisphere
/// (GlossTable), the light that R leaves over goes to the body, (1 - R(out)) (1 - R(in)) / (pi (1 - M)) times the
/// body's colour: what enters and what leaves is dimmed alike, and white adds up to 1 (Kelemen, Szirmay-Kalos 2001).
/// Metal mirrors E of the light in one reflection; what bounces between its facets instead is added in the same
/// directions, tinted once more: factor 1 + colour (1 - E(out)) / E(out) (Turquin 2019).
class Bsdf {
 public:
  /// `colour`: the material's colour at this point, texture and vertex colour applied, 0 … 1.
  Bsdf(const Material& material, const LinearRgb& colour);

  /// Both answers about a pair of directions; cheaper than asking twice.
  struct Response {
    LinearRgb value = LinearRgb::Zero();  ///< f · |cos| for light from `in` towards `out`.
    float density = 0.0F;                 ///< With which Sample draws `in`, per steradian.
  };
  /// Local directions; out.z > 0 (grazing or below is taken as just above); in.z < 0 only where light comes through,
  /// else the value is 0 (the density need not be: facets may mirror below the horizon). Mirror parts are rough enough
  /// (roughness is at least 0.03) to be evaluated. Finite, >= 0.
  [[nodiscard]] Response Respond(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const;

  /// f · |cos|: Respond's value.
  [[nodiscard]] LinearRgb Evaluate(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const;
  /// Respond's density. Its integral over the whole sphere is 1.
  [[nodiscard]] float Density(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const;

  struct Draw {
    Eigen::Vector3f in;  ///< Where light comes from, local.
    LinearRgb weight;    ///< Evaluate / Density; zero: absorbed.
    float density = 0.0F;
  };
  /// `choice`, u, v in [0, 1).
  [[nodiscard]] Draw Sample(const Eigen::Vector3f& out, float choice, float u, float v) const;

  /// The directional albedo's rough estimate, for the denoiser's guide.
  [[nodiscard]] const LinearRgb& albedo() const { return albedo_; }

 private:
  /// What depends on one direction alone.
  struct Side {
    Eigen::Vector3f out;       // above the horizon
    float left_over = 1.0F;    // 1 - R(out), or 1 - E(out)
    float facet_share = 0.0F;  // of Sample's choices
  };

  void SetCoat(Coat coat, float roughness, float coverage);
  void SetBody(const LinearRgb& colour, float translucency);
  void SetSoftness(const LinearRgb& colour, float roughness);
  void SetMetal(const LinearRgb& colour);

  [[nodiscard]] float LeftOver(const Eigen::Vector3f& direction) const;
  [[nodiscard]] Side SideOf(const Eigen::Vector3f& out) const;
  [[nodiscard]] bool is_metal() const { return kind_ == Kind::kPolished || kind_ == Kind::kBrushed; }
  [[nodiscard]] Response RespondFrom(const Side& side, const Eigen::Vector3f& in) const;
  [[nodiscard]] Response RespondOfBody(const Side& side, const Eigen::Vector3f& in) const;
  [[nodiscard]] LinearRgb SoftnessOf(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const;

  enum class Kind { kMatte, kCoated, kSkin, kPolished, kBrushed };
  Kind kind_ = Kind::kMatte;
  Coat coat_ = Coat::kPlastic;
  Facets facets_{};
  GlossTable::Row row_{};
  BrushedTable::Row brushed_row_{};
  const GlossTable* table_ = nullptr;      // lives as long as the program
  const BrushedTable* brushed_ = nullptr;  // likewise
  float coverage_ = 0.0F;                  // share of the surface under the coat
  float mean_left_over_ = 1.0F;            // 1 - M
  float through_share_ = 0.0F;             // of the body's choices
  float body_luminance_ = 0.0F;            // of what the body returns, all sides
  LinearRgb albedo_ = LinearRgb::Zero();
  LinearRgb specular_ = LinearRgb::Zero();  // of metal: reflectance at normal incidence
  LinearRgb body_ = LinearRgb::Zero();      // what comes back from the body, on the lit side
  LinearRgb through_ = LinearRgb::Zero();   // and on the other side
  LinearRgb softness_ = LinearRgb::Zero();  // of skin: how far the terminator is softened
  float softness_slope_ = 1.5F;
};

}  // namespace annulus
