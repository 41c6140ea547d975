#include "render/bsdf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

constexpr auto kPiF = static_cast<float>(kPi);
constexpr float kInversePi = 1.0F / kPiF;
/// Directions nearer to the horizon than this are taken as this far above it.
constexpr float kLeastCosine = 1e-4F;

/// Relative luminance of the sRGB primaries (IEC 61966-2-1).
float LuminanceOf(const LinearRgb& rgb) { return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2]; }

float FifthPower(float x) {
  const float x2 = x * x;
  return x2 * x2 * x;
}

Eigen::Vector3f CosineDirection(float u, float v) {
  const float radius = std::sqrt(u);
  const float azimuth = 2.0F * kPiF * v;
  return {radius * std::cos(azimuth), radius * std::sin(azimuth), std::sqrt(std::max(0.0F, 1.0F - u))};
}

/// Skin: share of the surface that shines, and how much stronger light comes back towards its source.
constexpr float kSebumCoverage = 0.6F;
constexpr float kBackwards = 0.15F;
constexpr float kSoftest = 0.84F;

}  // namespace

LocalFrame LocalFrame::About(const Eigen::Vector3f& normal, const Eigen::Vector3f& along) {
  Eigen::Vector3f x = along - normal.dot(along) * normal;
  const float length = x.squaredNorm();
  if (!(length > 1e-10F * along.squaredNorm() && length > 0.0F)) {
    // The axis that is least like the normal.
    const Eigen::Vector3f axis = std::abs(normal.x()) < 0.6F ? Eigen::Vector3f::UnitX() : Eigen::Vector3f::UnitY();
    x = axis - normal.dot(axis) * normal;
  }
  x.normalize();
  return {x, normal.cross(x), normal};
}

Bsdf::Bsdf(const Material& material, const LinearRgb& colour) {
  ENSURE(material.finish != Finish::kLens, "a lens is no surface that scatters");
  const LinearRgb held = colour.cwiseMax(0.0F).cwiseMin(1.0F);
  switch (material.finish) {
    case Finish::kPlastic:
      SetCoat(Coat::kPlastic, material.roughness, 1.0F);
      SetBody(held, 0.0F);
      break;
    case Finish::kTranslucent:
      SetCoat(Coat::kPlastic, material.roughness, 1.0F);
      SetBody(held, std::min(1.0F, std::max(0.0F, material.translucency)));
      break;
    case Finish::kSkin:
      SetCoat(Coat::kSkin, material.roughness, kSebumCoverage);
      SetBody(held, 0.0F);
      SetSoftness(held, material.roughness);
      break;
    case Finish::kMetal:
      kind_ = Kind::kPolished;
      facets_ = Facets::Polished(material.roughness);
      table_ = &GlossTable::Polished();
      row_ = GlossTable::RowOf(material.roughness);
      SetMetal(held);
      break;
    case Finish::kBrushed:
      kind_ = Kind::kBrushed;
      facets_ = Facets::Brushed(material.roughness);
      brushed_ = &BrushedTable::Get();
      brushed_row_ = BrushedTable::RowOf(material.roughness);
      SetMetal(held);
      break;
    case Finish::kMatte:
    case Finish::kLens:
      SetBody(held, 0.0F);
      break;
  }
}

void Bsdf::SetCoat(Coat coat, float roughness, float coverage) {
  kind_ = Kind::kCoated;
  coat_ = coat;
  coverage_ = coverage;
  facets_ = Facets::Polished(roughness);
  table_ = &GlossTable::Polished();
  row_ = GlossTable::RowOf(roughness);
  mean_left_over_ = 1.0F - coverage_ * table_->MeansOf(coat_, row_).first;
}

void Bsdf::SetBody(const LinearRgb& colour, float translucency) {
  // Part of what the body sends up is sent down again by the coat, and coloured once more: colours deepen, white stays.
  const float kept = mean_left_over_;
  const LinearRgb deepened = (kept * colour.array() / (1.0F - (1.0F - kept) * colour.array())).matrix();
  // What comes through has a longer way in the body.
  const LinearRgb deeper = deepened.cwiseProduct(deepened.cwiseSqrt());
  body_ = (1.0F - translucency) * deepened;
  through_ = translucency * deeper;
  const float through = LuminanceOf(through_);
  body_luminance_ = LuminanceOf(body_) + through;
  through_share_ = body_luminance_ > 0.0F ? through / body_luminance_ : 0.0F;
  albedo_ = body_ + through_ + (1.0F - kept) * (LinearRgb::Ones() - body_ - through_);
}

void Bsdf::SetSoftness(const LinearRgb& colour, float roughness) {
  kind_ = Kind::kSkin;
  // Light that is absorbed less goes further in.
  softness_ = kSoftest * colour.cwiseProduct(colour.cwiseSqrt());
  const GlossTable::CoatMeans means = table_->MeansOf(coat_, GlossTable::RowOf(roughness));
  softness_slope_ = 1.5F * (1.0F - coverage_ * means.first) / (1.0F - coverage_ * means.second);
}

void Bsdf::SetMetal(const LinearRgb& colour) {
  specular_ = colour;
  // Mean of Schlick's reflectance over the hemisphere.
  albedo_ = (colour.array() + (1.0F - colour.array()) / 21.0F).matrix();
}

float Bsdf::LeftOver(const Eigen::Vector3f& direction) const {
  const float mu = std::abs(direction.z());
  switch (kind_) {
    case Kind::kMatte:
      return 1.0F;
    case Kind::kPolished:
      return 1.0F - table_->Mirror(row_, facets_.x, mu);
    case Kind::kBrushed:
      return 1.0F - brushed_->Mirror(brushed_row_, facets_, direction);
    case Kind::kCoated:
    case Kind::kSkin:
      break;
  }
  return 1.0F - coverage_ * table_->Coated(coat_, row_, facets_.x, mu);
}

Bsdf::Side Bsdf::SideOf(const Eigen::Vector3f& out) const {
  Side side;
  side.out = {out.x(), out.y(), std::max(kLeastCosine, out.z())};
  if (kind_ == Kind::kMatte) return side;
  side.left_over = LeftOver(side.out);
  const float facets = 1.0F - side.left_over;
  side.facet_share = is_metal() ? 1.0F : facets / (facets + side.left_over * body_luminance_);
  return side;
}

LinearRgb Bsdf::SoftnessOf(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const {
  const float both = (1.0F - softness_slope_ * out.z()) * (1.0F - softness_slope_ * in.z());
  const float towards_source = kBackwards * (out.x() * in.x() + out.y() * in.y());
  return (1.0F + towards_source - both * softness_.array()).matrix();
}

Bsdf::Response Bsdf::RespondFrom(const Side& side, const Eigen::Vector3f& in) const {
  Response response = is_metal() ? Response{} : RespondOfBody(side, in);
  if (kind_ == Kind::kMatte) return response;
  const Eigen::Vector3f& out = side.out;
  const Eigen::Vector3f sum = out + in;
  const float stretch_out = facets_.Stretch(out);
  const float mirrored = facets_.MirrorDensity(out, stretch_out, sum);
  response.density += side.facet_share * mirrored;
  if (!(in.z() > 0.0F)) return response;
  // G2(out, in) / G1(out) of the facets' light finds its way out.
  const float lit =
      mirrored * (stretch_out + out.z()) * in.z() / (stretch_out * in.z() + facets_.Stretch(in) * out.z());
  const float cosine = std::min(1.0F, 0.5F * sum.norm());  // on the facet, half way between the two
  if (is_metal()) {
    const LinearRgb first = specular_ + FifthPower(1.0F - cosine) * (LinearRgb::Ones() - specular_);
    const float again = side.left_over / (1.0F - side.left_over);
    response.value += lit * first.cwiseProduct(LinearRgb::Ones() + again * specular_);
  } else {
    response.value.array() += lit * coverage_ * DielectricReflectance(cosine, IndexOf(coat_));
  }
  return response;
}

Bsdf::Response Bsdf::RespondOfBody(const Side& side, const Eigen::Vector3f& in) const {
  const float cosine = std::abs(in.z());
  const bool is_lit_side = in.z() > 0.0F;
  const float share = is_lit_side ? 1.0F - through_share_ : through_share_;
  Response response;
  response.density = (1.0F - side.facet_share) * share * cosine * kInversePi;
  if (share <= 0.0F || cosine <= 0.0F) return response;
  const float passed = kind_ == Kind::kMatte ? 1.0F : side.left_over * LeftOver(in) / mean_left_over_;
  response.value = passed * cosine * kInversePi * (is_lit_side ? body_ : through_);
  if (kind_ == Kind::kSkin) response.value = response.value.cwiseProduct(SoftnessOf(side.out, in));
  return response;
}

Bsdf::Response Bsdf::Respond(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const {
  return RespondFrom(SideOf(out), in);
}

LinearRgb Bsdf::Evaluate(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const { return Respond(out, in).value; }

float Bsdf::Density(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const { return Respond(out, in).density; }

Bsdf::Draw Bsdf::Sample(const Eigen::Vector3f& out, float choice, float u, float v) const {
  const Side side = SideOf(out);
  Draw draw;
  if (choice < side.facet_share) {
    const Eigen::Vector3f half = facets_.SampleVisible(side.out, u, v);
    draw.in = (2.0F * side.out.dot(half) * half - side.out).normalized();
  } else {
    draw.in = CosineDirection(u, v);
    const float rest = (choice - side.facet_share) / (1.0F - side.facet_share);
    if (rest < through_share_) draw.in.z() = -draw.in.z();
  }
  const Response response = RespondFrom(side, draw.in);
  draw.density = response.density;
  draw.weight = response.density > 0.0F ? (response.value / response.density).eval() : LinearRgb::Zero().eval();
  return draw;
}

}  // namespace annulus
