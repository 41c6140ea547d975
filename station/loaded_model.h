#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/measure/measured_surface.h"
#include "station/command_io.h"

namespace annulus {

/// A model and its measured surface, which borrows it. A light value.
struct LoadedModel {
  std::shared_ptr<const SurfaceModel> model;  ///< Shared by the copies, whose surfaces are the same.
  MeasuredSurface body;
};

/// Reads MODEL.json and readies it for queries. Fails if it cannot be read or its normal matrix is not positive
/// definite.
[[nodiscard]] Result<LoadedModel> LoadModel(CommandIo& io, const std::string& path);

}  // namespace annulus
