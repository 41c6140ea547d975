#include "station/loaded_model.h"

#include <utility>

#include "station/files.h"

namespace annulus {

Result<LoadedModel> LoadModel(CommandIo& io, const std::string& path) {
  auto model = ReadModelFile(io.storage(), path);
  if (!model) return Fail(model);
  auto owned = std::make_unique<const SurfaceModel>(std::move(*model));
  auto body = MeasuredSurface::FromModel(*owned);
  if (!body) return Fail(body);
  return LoadedModel{std::move(owned), *body};
}

}  // namespace annulus
