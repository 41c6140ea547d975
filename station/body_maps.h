#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/measure/measured_surface.h"
#include "render/scalar_map.h"

namespace annulus {

/// What a map shows.
enum class MapKind {
  kResidual,           ///< A scan's returns minus the surface.
  kMeanCurvature,      ///< Half the sum of the principal curvatures.
  kGaussianCurvature,  ///< Their product.
  kLargestCurvature,
  kSmallestCurvature,
  kClearance,  ///< A worn frame to the head.
  kAreaStrain,
  kLargestStrain,
  kSmallestStrain,
  kKnowledge,   ///< Measured, inferred, unknown.
  kSigma,       ///< sd of the radius.
  kDifference,  ///< Another model minus this one.
  kValues,      ///< Numbers of a table.
};

/// "residual", "curvature", "gaussian", "largest-curvature", …: as --map takes it.
[[nodiscard]] std::string_view MapKindName(MapKind kind);

/// A place of a model.
struct BodyPlace {
  std::size_t segment = 0;
  double theta = 0.0;  ///< rad, about the segment's axis.
  double z = 0.0;      ///< mm
};

/// A number at every place of a model, and how it is to be drawn. What its functions borrow is said where it is made.
struct BodyField {
  std::string title;       ///< "Mean curvature"
  std::string unit;        ///< "1/m"; "" for classes.
  std::string definition;  ///< What the number is, in one or two sentences.
  ColourMap map = ColourMap::kDiverging;
  ScaleRule rule = ScaleRule::kAboutZero;
  double share = kScaleShare;                          ///< Of the area that the rule's scale holds.
  std::optional<std::array<double, 2>> usual_range{};  ///< Instead of the rule.
  std::optional<LinearRgb> under{};                    ///< As ValueScale::under; its meaning is `under_label`.
  std::string under_label{};
  std::optional<LinearRgb> over{};  ///< The same above.
  std::string over_label{};
  std::optional<double> isolines{};  ///< As MapColours::isolines.
  std::vector<MapCategory> categories{};
  std::function<double(const BodyPlace&)> value;    ///< nan: none. Of a class its number.
  std::function<bool(const BodyPlace&)> hatched{};  ///< Empty: nowhere.
  std::string hatch_label{};                        ///< "inferred", "not significant".
};

/// Curvature of the measured surface, 1/m (Gaussian 1/m²); positive where it bends away from the outside. Main segment
/// only. Borrows `body`. Requires a kind of curvature.
[[nodiscard]] BodyField CurvatureField(const MeasuredSurface& body, MapKind kind);

/// sd of the radius at one place, mm: the posterior's and the detail's. Main segment only. Borrows `body`. Fails if the
/// model carries no normal matrix.
[[nodiscard]] Result<BodyField> SigmaField(const MeasuredSurface& body);

/// Measured (0), inferred (1), unknown (2). Borrows `model`.
[[nodiscard]] BodyField KnowledgeField(const SurfaceModel& model);

/// Principal stretches of a surface that becomes another under the correspondence of equal (theta, z), both > 0: the
/// roots of the eigenvalues of A⁻¹B with the first fundamental forms A and B.
struct SurfaceStretch {
  double largest = 1.0;
  double smallest = 1.0;
};
[[nodiscard]] SurfaceStretch StretchAt(const SplineSurface& before, const SplineSurface& after,
                                       const SurfacePlace& place);

/// Strain from `before` to `after` in percent: largest or smallest principal stretch less 1, or their product (the
/// change of area) less 1. nan where one of the two is unknown or ends. Main segments. Borrows both. Requires a kind of
/// strain.
[[nodiscard]] BodyField StrainField(const MeasuredSurface& before, const MeasuredSurface& after, MapKind kind);

/// The meshes of a model with the field's values: as ModelItem draws it, or with all that is unknown too.
enum class BodyParts { kSeen, kAll };
[[nodiscard]] std::vector<MapMesh> MapMeshes(const SurfaceModel& model, const BodyField& field, BodyParts parts);

/// The values of meshes, weighted with the area around each vertex.
[[nodiscard]] std::vector<WeightedValue> AreaWeighted(const std::vector<MapMesh>& meshes);

/// The main segment unrolled: values at the middles of cells, row 0 at the top, column 0 from theta = 0; with the same
/// for the hatch (0 or 1).
struct UnrolledMap {
  Eigen::MatrixXd values;
  Eigen::MatrixXd hatch;
  std::vector<WeightedValue> weighted;  ///< By the cells' areas on the surface.
  double z_min = 0.0;
  double z_max = 0.0;
};
[[nodiscard]] UnrolledMap Unroll(const SurfaceModel& model, const BodyField& field, Eigen::Index columns,
                                 Eigen::Index rows);

}  // namespace annulus
