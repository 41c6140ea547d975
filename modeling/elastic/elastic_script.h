#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/elastic/elastic_region.h"
#include "modeling/elastic/elastic_solver.h"

namespace annulus {

/// A smooth bump about a place of the skin: its height falls as (1 − (d/radius)²)² with the distance d.
struct SkinBump {
  double theta = 0.0;    ///< rad
  double z = 0.0;        ///< mm
  double outward = 0.0;  ///< mm, at the place; negative: inwards.
  double radius = 0.0;   ///< mm, > 0: beyond it nothing is moved.

  /// 0 … 1 at distance `d`, mm.
  [[nodiscard]] double ShareAt(double d) const {
    const double rest = 1.0 - d * d / (radius * radius);
    return d < radius ? rest * rest : 0.0;
  }
};

/// A bump as a load.
struct BumpLoad {
  /// What is given: the bump's displacement at its nodes; the displacement in the mean (weighted with the bump), which
  /// a pressure of the bump's profile makes; or that pressure's total force.
  enum class As { kDisplacement, kPressure, kForce };
  SkinBump bump;
  As as = As::kDisplacement;
  double force = 0.0;  ///< N, outward, for kForce.
};

/// A band around the body.
struct BandLoad {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< Of its plane, unit, z > 0.
  double z = 0.0;                                     ///< mm, of the plane on the segment's axis.
  double width = 20.0;                                ///< mm
  double rest_length = 0.0;                           ///< mm; without `girth`.
  double stiffness = 0.0;                             ///< N per relative elongation of the whole band.
  std::optional<double> girth;                        ///< mm: the band is as tight as this takes.
};

/// A file of an elastic edit (docs/formats.md, "Elastic edit").
struct ElasticScript {
  std::optional<std::string> segment;  ///< Its name; the main one if absent.
  ElasticMaterial material;
  ElasticMethod method = ElasticMethod::kCorotational;
  std::optional<RegionRequest> region;  ///< Needed by loads and bands.
  std::vector<SkinBump> edits;          ///< Free editing, before all else.
  std::vector<BumpLoad> loads;
  std::vector<BandLoad> bands;
  std::vector<double> girths;  ///< Heights at which girths are told, mm.
};

/// Reads a script. `name` of the file is for messages, which name the key. Fails on what is missing, unknown or out of
/// range.
[[nodiscard]] Result<ElasticScript> ElasticScriptFromJson(std::string_view text, std::string_view name);

}  // namespace annulus
