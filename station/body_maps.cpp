#include "station/body_maps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/ensure.h"
#include "modeling/measure/curvature.h"
#include "modeling/measure/surface_derivatives.h"
#include "modeling/mesh/tessellate.h"
#include "station/picture_parts.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct NamedKind {
  MapKind kind;
  std::string_view name;
};
constexpr std::array<NamedKind, 13> kNames{{{MapKind::kResidual, "residual"},
                                            {MapKind::kMeanCurvature, "curvature"},
                                            {MapKind::kGaussianCurvature, "gaussian"},
                                            {MapKind::kLargestCurvature, "largest-curvature"},
                                            {MapKind::kSmallestCurvature, "smallest-curvature"},
                                            {MapKind::kClearance, "clearance"},
                                            {MapKind::kAreaStrain, "strain"},
                                            {MapKind::kLargestStrain, "largest-strain"},
                                            {MapKind::kSmallestStrain, "smallest-strain"},
                                            {MapKind::kKnowledge, "knowledge"},
                                            {MapKind::kSigma, "sigma"},
                                            {MapKind::kDifference, "difference"},
                                            {MapKind::kValues, "values"}}};

/// Whether a place lies between the ends of a surface and something is known of it.
bool IsKnown(const MeasuredSurface& body, double theta, double z) {
  return z >= body.surface().z_min() && z <= body.surface().z_max() &&
         body.KnowledgeAt(theta, z) != Knowledge::kUnknown;
}

std::function<bool(const BodyPlace&)> HatchInferred(const MeasuredSurface& body) {
  return [&body](const BodyPlace& place) {
    return place.segment == 0 && body.KnowledgeAt(place.theta, place.z) == Knowledge::kInferred;
  };
}

/// Areas around vertices: a third of each face.
std::vector<double> VertexAreas(const TriangleMesh& mesh) {
  std::vector<double> areas(mesh.vertices.size(), 0.0);
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    const double area = (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a).norm() / 2.0;
    for (const std::uint32_t corner : face) areas[corner] += area / 3.0;
  }
  return areas;
}

/// Fills in values and hatch of a mesh whose vertices lie on a segment.
MapMesh WithValues(TriangleMesh mesh, const SurfaceSegment& segment, std::size_t index, const BodyField& field) {
  MapMesh item;
  item.values.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices) {
    const Eigen::Vector2d from_axis = p.head<2>() - segment.axis.At(p.z());
    const BodyPlace place{index, WrapAngle(std::atan2(from_axis.y(), from_axis.x())),
                          std::clamp(p.z(), segment.surface.z_min(), segment.surface.z_max())};
    item.values.push_back(field.value(place));
    if (field.hatched) item.hatch.push_back(field.hatched(place) ? 1.0F : 0.0F);
  }
  item.mesh = std::move(mesh);
  return item;
}

}  // namespace

std::string_view MapKindName(MapKind kind) {
  for (const NamedKind& named : kNames) {
    if (named.kind == kind) return named.name;
  }
  return "";
}

BodyField CurvatureField(const MeasuredSurface& body, MapKind kind) {
  BodyField field;
  field.unit = "1/m";
  field.share = 0.9;  // edges and ears bend a hundred times as much as the rest
  const std::string positive = " Positive where the surface bulges outward; a sphere of radius 100 mm has 10 1/m.";
  double (*pick)(const SurfaceCurvature&) = nullptr;
  switch (kind) {
    case MapKind::kMeanCurvature:
      field.title = "Mean curvature";
      field.definition = "Half the sum of the principal curvatures of the fitted surface." + positive;
      pick = [](const SurfaceCurvature& c) { return 1e3 * c.mean.value; };
      break;
    case MapKind::kGaussianCurvature:
      field.title = "Gaussian curvature";
      field.unit = "1/m²";
      field.definition =
          "Product of the principal curvatures of the fitted surface: positive on bowls and domes, negative on "
          "saddles.";
      pick = [](const SurfaceCurvature& c) { return 1e6 * c.gaussian.value; };
      break;
    case MapKind::kLargestCurvature:
      field.title = "Largest principal curvature";
      field.definition = "The larger principal curvature of the fitted surface." + positive;
      pick = [](const SurfaceCurvature& c) { return 1e3 * c.largest; };
      break;
    case MapKind::kSmallestCurvature:
      field.title = "Smallest principal curvature";
      field.definition = "The smaller principal curvature of the fitted surface." + positive;
      pick = [](const SurfaceCurvature& c) { return 1e3 * c.smallest; };
      break;
    default:
      ENSURE(false, "the kind is one of curvature");
  }
  field.value = [&body, pick](const BodyPlace& place) {
    if (place.segment != 0 || !IsKnown(body, place.theta, place.z)) return kNan;
    const auto curvature = CurvatureAt(body, {place.theta, place.z});
    return curvature ? pick(*curvature) : kNan;
  };
  field.hatched = HatchInferred(body);
  field.hatch_label = "inferred";
  return field;
}

Result<BodyField> SigmaField(const MeasuredSurface& body) {
  if (body.segment().normal_matrix.nonZeros() == 0) {
    return Fail("draw the sd of the radius", "the model carries no normal matrix",
                "fit it again without --no-covariance");
  }
  BodyField field;
  field.title = "Standard uncertainty of the radius";
  field.unit = "mm";
  field.definition =
      "One sd of the radius at each place, from noise, smoothing and detail that the fit does not follow; errors of "
      "the ring and of the subject's sway are not in it.";
  field.map = ColourMap::kSequential;
  field.rule = ScaleRule::kFromZero;
  field.value = [&body](const BodyPlace& place) {
    return place.segment == 0 && IsKnown(body, place.theta, place.z) ? body.RadiusSigma(place.theta, place.z) : kNan;
  };
  field.hatched = HatchInferred(body);
  field.hatch_label = "inferred";
  return field;
}

BodyField KnowledgeField(const SurfaceModel& model) {
  BodyField field;
  field.title = "What is known of the surface";
  field.definition =
      "Measured: accepted returns lie in or next to the place. Inferred: the smooth surface bridges between returns. "
      "Unknown: too far from any; no number is given there.";
  // Blue, amber and grey stay apart for all common kinds of colour blindness, and in grey print.
  field.categories = {{"measured", LinearFromHex(0x4a8fb8)},
                      {"inferred", LinearFromHex(0xf2c14e)},
                      {"unknown", LinearFromHex(0x6e6e6e)}};
  field.value = [&model](const BodyPlace& place) {
    const KnowledgeMap& known = model.segments[place.segment].knowledge;
    if (known.rows() == 0) return 0.0;
    switch (known.At(place.theta, place.z)) {
      case Knowledge::kMeasured:
        return 0.0;
      case Knowledge::kInferred:
        return 1.0;
      case Knowledge::kUnknown:
        break;
    }
    return 2.0;
  };
  return field;
}

SurfaceStretch StretchAt(const SplineSurface& before, const SplineSurface& after, const SurfacePlace& place) {
  const auto first_form = [&place](const SplineSurface& surface) {
    const SurfaceDerivatives d = DerivativesAt(surface, place);
    Eigen::Matrix2d form;
    form << d.by_theta.squaredNorm(), d.by_theta.dot(d.by_z), d.by_theta.dot(d.by_z), d.by_z.squaredNorm();
    return form;
  };
  const Eigen::Matrix2d a = first_form(before);
  const Eigen::Matrix2d b = first_form(after);
  // Eigenvalues of A⁻¹B by trace and determinant; both are real and positive.
  const double determinant = b.determinant() / a.determinant();
  const double half_trace = 0.5 * (a(1, 1) * b(0, 0) + a(0, 0) * b(1, 1) - 2.0 * a(0, 1) * b(0, 1)) / a.determinant();
  const double apart = std::sqrt(std::max(0.0, half_trace * half_trace - determinant));
  const double largest = half_trace + apart;
  return {std::sqrt(largest), std::sqrt(determinant / largest)};
}

BodyField StrainField(const MeasuredSurface& before, const MeasuredSurface& after, MapKind kind) {
  BodyField field;
  field.unit = "%";
  const std::string how =
      " Each place of the first model is taken to the place of the same theta and height of the second: what slides "
      "along the skin is not seen.";
  double (*pick)(const SurfaceStretch&) = nullptr;
  switch (kind) {
    case MapKind::kAreaStrain:
      field.title = "Change of area";
      field.definition = "Area of the skin in the second model over that in the first, less 1." + how;
      pick = [](const SurfaceStretch& s) { return 100.0 * (s.largest * s.smallest - 1.0); };
      break;
    case MapKind::kLargestStrain:
      field.title = "Largest principal strain";
      field.definition = "The largest stretch of any direction along the skin, less 1." + how;
      pick = [](const SurfaceStretch& s) { return 100.0 * (s.largest - 1.0); };
      break;
    case MapKind::kSmallestStrain:
      field.title = "Smallest principal strain";
      field.definition = "The smallest stretch of any direction along the skin, less 1." + how;
      pick = [](const SurfaceStretch& s) { return 100.0 * (s.smallest - 1.0); };
      break;
    default:
      ENSURE(false, "the kind is one of strain");
  }
  field.value = [&before, &after, pick](const BodyPlace& place) {
    const bool known =
        place.segment == 0 && IsKnown(before, place.theta, place.z) && IsKnown(after, place.theta, place.z);
    if (!known) return kNan;
    const double value = pick(StretchAt(before.surface(), after.surface(), {place.theta, place.z}));
    return std::isfinite(value) ? value : kNan;
  };
  field.hatched = [&before, &after](const BodyPlace& place) {
    return place.segment == 0 && (before.KnowledgeAt(place.theta, place.z) == Knowledge::kInferred ||
                                  after.KnowledgeAt(place.theta, place.z) == Knowledge::kInferred);
  };
  field.hatch_label = "inferred in one of them";
  return field;
}

std::vector<MapMesh> MapMeshes(const SurfaceModel& model, const BodyField& field, BodyParts parts) {
  std::vector<MapMesh> meshes;
  for (std::size_t k = 0; k < model.segments.size(); ++k) {
    const SurfaceSegment& segment = model.segments[k];
    if (parts == BodyParts::kSeen && k == 0) {
      meshes.push_back(WithValues(ModelItem(model, {}).mesh, segment, k, field));
      continue;
    }
    TessellationOptions options;
    options.skip_unknown = parts == BodyParts::kSeen;
    options.max_z_spacing_mm = std::clamp((segment.surface.z_max() - segment.surface.z_min()) / 300.0, 1.0, 4.0);
    meshes.push_back(WithValues(TessellateSurface(segment, options), segment, k, field));
  }
  return meshes;
}

std::vector<WeightedValue> AreaWeighted(const std::vector<MapMesh>& meshes) {
  std::vector<WeightedValue> weighted;
  for (const MapMesh& item : meshes) {
    if (item.values.empty()) continue;
    const std::vector<double> areas = VertexAreas(item.mesh);
    for (std::size_t k = 0; k < areas.size(); ++k) weighted.push_back({item.values[k], areas[k]});
  }
  return weighted;
}

UnrolledMap Unroll(const SurfaceModel& model, const BodyField& field, Eigen::Index columns, Eigen::Index rows) {
  const SplineSurface& surface = model.main().surface;
  UnrolledMap map{
      Eigen::MatrixXd(rows, columns), Eigen::MatrixXd::Zero(rows, columns), {}, surface.z_min(), surface.z_max()};
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double down = (static_cast<double>(row) + 0.5) / static_cast<double>(rows);
    const double z = map.z_max + (map.z_min - map.z_max) * down;
    for (Eigen::Index column = 0; column < columns; ++column) {
      const BodyPlace place{0, kTwoPi * (static_cast<double>(column) + 0.5) / static_cast<double>(columns), z};
      map.values(row, column) = field.value(place);
      if (field.hatched && field.hatched(place)) map.hatch(row, column) = 1.0;
      const SurfaceDerivatives d = DerivativesAt(surface, {place.theta, z});
      map.weighted.push_back({map.values(row, column), d.by_theta.cross(d.by_z).norm()});
    }
  }
  return map;
}

}  // namespace annulus
