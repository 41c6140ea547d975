#pragma once

#include <optional>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/elastic/elastic_edit.h"
#include "render/camera.h"
#include "render/image.h"
#include "station/elastic_maps.h"

namespace annulus {

struct ElasticPictureOptions {
  const ElasticMap* map = nullptr;  ///< Of the elastic region; null: how far the surface moved along its normal.
  std::optional<View> view{};       ///< Unless given, half from the side of what moved most.
  int height = 640;                 ///< Pixels of a panel.
};

/// Before, after and a map on the changed shape, side by side, seen by the same camera (as fig. 4.1 of paper 001): the
/// heights that moved and something above and below. Requires an elastic part where a map of it is asked for. Fails as
/// Render and RenderScalarMap.
[[nodiscard]] Result<RgbImage> DrawElasticEdit(const SurfaceModel& before, const ElasticEdit& edit,
                                               const ElasticPictureOptions& options, const TaskContext& task);

}  // namespace annulus
