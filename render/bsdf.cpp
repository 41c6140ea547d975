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
constexpr float kSoftest = 0.8F;

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
      mean_left_over_ = 1.0F - table_->MirrorMean(row_);
      SetMetal(held);
      break;
    case Finish::kBrushed:
      kind_ = Kind::kBrushed;
      facets_ = Facets::Brushed(material.roughness);
      brushed_ = &BrushedTable::Get();
      brushed_row_ = brushed_->RowOf(material.roughness);
      mean_left_over_ = 1.0F - brushed_row_.mean;
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
  softness_ = kSoftest * colour.cwiseProduct(colour);
  const GlossTable::CoatMeans means = table_->MeansOf(coat_, GlossTable::RowOf(roughness));
  softness_slope_ = 1.5F * (1.0F - coverage_ * means.first) / (1.0F - coverage_ * means.second);
}

void Bsdf::SetMetal(const LinearRgb& colour) {
  specular_ = colour;
  // Mean of Schlick's reflectance over the hemisphere; each further bounce between the facets costs it once more.
  const Eigen::Array3f mean = colour.array() + (1.0F - colour.array()) / 21.0F;
  body_ = (mean.square() * (1.0F - mean_left_over_) / (1.0F - mean * mean_left_over_)).matrix();
  body_luminance_ = LuminanceOf(body_);
  albedo_ = mean.matrix();
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
  const bool is_metal = kind_ == Kind::kPolished || kind_ == Kind::kBrushed;
  const float facets = is_metal ? (1.0F - side.left_over) * LuminanceOf(specular_) + 1e-4F : 1.0F - side.left_over;
  side.facet_share = facets / (facets + side.left_over * body_luminance_);
  return side;
}

LinearRgb Bsdf::SoftnessOf(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const {
  const float both = (1.0F - softness_slope_ * out.z()) * (1.0F - softness_slope_ * in.z());
  const float towards_source = kBackwards * (out.x() * in.x() + out.y() * in.y());
  return (1.0F + towards_source - both * softness_.array()).matrix();
}

Bsdf::Response Bsdf::RespondFrom(const Side& side, const Eigen::Vector3f& in) const {
  Response response;
  const Eigen::Vector3f& out = side.out;
  const float body_density = (1.0F - side.facet_share) * std::abs(in.z()) * kInversePi;
  if (!(in.z() > 0.0F)) {
    response.density = through_share_ * body_density;
    if (through_share_ > 0.0F && in.z() < 0.0F) {
      response.value = side.left_over * LeftOver(in) * -in.z() * kInversePi / mean_left_over_ * through_;
    }
  } else {
    response.density = (1.0F - through_share_) * body_density;
    const float passed = kind_ == Kind::kMatte ? 1.0F : side.left_over * LeftOver(in) / mean_left_over_;
    response.value = passed * in.z() * kInversePi * body_;
    if (kind_ == Kind::kSkin) response.value = response.value.cwiseProduct(SoftnessOf(out, in));
  }
  if (kind_ == Kind::kMatte) return response;

  Eigen::Vector3f half = out + in;
  const float length = half.squaredNorm();
  if (!(half.z() > 0.0F && length > 0.0F)) return response;
  half /= std::sqrt(length);
  const float stretch_out = facets_.Stretch(out);
  // Smith's G1 · D / (4 cos): the density with which a facet seen from `out` mirrors to `in`.
  const float mirrored = facets_.Distribution(half) * 0.5F / (out.z() + stretch_out);
  response.density += side.facet_share * mirrored;
  if (in.z() <= 0.0F) return response;
  const float lit =
      mirrored * (stretch_out + out.z()) * in.z() / (stretch_out * in.z() + facets_.Stretch(in) * out.z());
  const float cosine = std::min(1.0F, out.dot(half));
  if (kind_ == Kind::kPolished || kind_ == Kind::kBrushed) {
    response.value += lit * (specular_ + FifthPower(1.0F - cosine) * (LinearRgb::Ones() - specular_));
  } else {
    response.value.array() += lit * coverage_ * DielectricReflectance(cosine, IndexOf(coat_));
  }
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
