#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/mesh/triangle_mesh.h"
#include "render/camera.h"
#include "render/image.h"
#include "render/value_scale.h"

namespace annulus {

/// A body with a value at every vertex.
struct MapMesh {
  TriangleMesh mesh;                     ///< Station frame, mm. Both sides of a face are drawn.
  std::vector<Eigen::Vector3d> normals;  ///< Unit, per vertex; empty: area-weighted from the faces.
  /// Per vertex, in any unit; linear in between. nan: no value, grey. Empty: a thing that carries no map, drawn plain.
  std::vector<double> values;
  /// Per vertex, 0 … 1; where it exceeds 1/2 the map is hatched ("not significant", "inferred"). Empty: nowhere.
  std::vector<float> hatch{};
  LinearRgb plain = LinearRgb(0.62F, 0.62F, 0.60F);  ///< Of a thing without values.
};

/// What the values of a map become.
struct MapColours {
  ValueScale scale;
  /// Not empty: values are indices of classes, the nearest vertex' counts, and `scale` is not used.
  std::vector<MapCategory> categories{};
  std::optional<double> isolines{};  ///< Thin lines at its multiples, > 0.

  [[nodiscard]] LinearRgb ColourOf(double value) const;
};

struct MapPictureOptions {
  int width = 720;        ///< Pixels, 1 … kMaxImageSize.
  int height = 720;       ///< Pixels, 1 … kMaxImageSize.
  int supersampling = 3;  ///< Samples per pixel along each side, 1 … 8.
  int threads = 0;        ///< 0 means as many as the machine has. The picture does not depend on it.
};

/// A map on a body, on white, with what was drawn. The image's depth is that of the pixel's nearest sample, alpha the
/// share of the pixel that is covered.
struct MapPicture {
  RgbImage image;
  /// Per pixel: the value at the pixel's middle sample; nan where there is none.
  std::vector<float> value;
};

/// Draws the map: the colour of the interpolated value (not the interpolated colour), matte under one weak lamp beside
/// the viewer (kMapShade), with dark lines at outlines and steps of depth. Same input, same bytes. Fails on a size out
/// of range, a vertex that is not finite or further than 1 km away, a face with a missing vertex, normals, values or
/// hatch of another count, or a stop request.
[[nodiscard]] Result<MapPicture> RenderScalarMap(const std::vector<MapMesh>& meshes, const MapColours& colours,
                                                 const Camera& camera, const MapPictureOptions& options,
                                                 const TaskContext& task);

}  // namespace annulus
