#pragma once

#include <optional>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/elastic/elastic_script.h"
#include "modeling/elastic/skin_maps.h"
#include "modeling/elastic/surface_change.h"

namespace annulus {

/// A horizontal girth before and after. nan where the segment cannot tell (outside it, or unknown places).
struct GirthChange {
  double z = 0.0;                                        ///< mm
  double perimeter_before = 0.0, perimeter_after = 0.0;  ///< mm, of the section's curve.
  double tape_before = 0.0, tape_after = 0.0;            ///< mm, of its convex hull.
};

/// What a band did.
struct BandResult {
  BandLoad band;
  double girth_before = 0.0;      ///< mm, tape in the band's middle plane.
  double girth_after = 0.0;       ///< mm, on the changed surface.
  double tension = 0.0;           ///< N, of the whole band.
  double pressure_largest = 0.0;  ///< N/mm²
  double pressure_mean = 0.0;     ///< N/mm², where it presses.
  double contact_area = 0.0;      ///< mm²
};

/// What a load did.
struct LoadResult {
  double movement = 0.0;  ///< mm, outward, mean weighted with the bump.
  double force = 0.0;     ///< N, outward: what the load puts on the skin.
};

/// The elastic part of an edit.
struct ElasticOutcome {
  ElasticRegion region;
  ElasticSolution solution;
  SkinMaps maps;
  std::vector<LoadResult> loads;
  std::vector<BandResult> bands;
  double largest_displacement = 0.0;  ///< mm, of the skin.
};

/// A model whose shape was changed, and what that did.
struct ElasticEdit {
  SurfaceModel model;
  std::size_t segment = 0;
  double volume_before = 0.0, volume_after = 0.0;  ///< mm³, ∬ r²/2 over the segment.
  std::vector<GirthChange> girths;
  std::vector<ChangedSegment> edits;      ///< Free ones, in order; without their segments' matrices.
  std::optional<ElasticOutcome> elastic;  ///< If there are loads or bands.
  std::optional<ChangedSegment> written;  ///< How the displaced skin became a surface.
};

/// Carries out a script on a model: first the free edits, one after the other (paper 001, §4: the designer moves
/// control points), then loads and bands together on the elastic region. The result's provenance says that it was
/// edited. Fails as MakeElasticRegion, SolveElastic, GrowRadius, and on an unknown segment.
[[nodiscard]] Result<ElasticEdit> EditElastically(const SurfaceModel& model, const ElasticScript& script,
                                                  const TaskContext& task);

}  // namespace annulus
