#include "station/picture_sources.h"

#include <utility>

#include "acquisition/recording.h"
#include "station/files.h"
#include "station/key_file.h"
#include "station/residual_map.h"

namespace annulus {

Result<PictureSources::Model*> PictureSources::ModelOf(const std::string& path) {
  const auto known = models_.find(path);
  if (known != models_.end()) return &known->second;
  auto read = ReadModelFile(storage_, path);
  if (!read) return Fail(read);
  Model model;
  model.model = std::make_unique<const SurfaceModel>(std::move(*read));
  model.studio = std::make_unique<PictureStudio>(*model.model);
  return &models_.emplace(path, std::move(model)).first->second;
}

Result<PictureStudio*> PictureSources::StudioOf(const std::string& model) {
  const auto found = ModelOf(model);
  if (!found) return Fail(found);
  return (*found)->studio.get();
}

Result<const MeasuredSurface*> PictureSources::BodyOf(const std::string& model) {
  const auto found = ModelOf(model);
  if (!found) return Fail(found);
  if (!(*found)->body) {
    auto body = MeasuredSurface::FromModel(*(*found)->model);
    if (!body) return Fail(body);
    (*found)->body = std::make_unique<const MeasuredSurface>(std::move(*body));
  }
  return (*found)->body.get();
}

Result<const GlassesSource*> PictureSources::WornOf(const std::string& path) {
  if (path.empty()) return nullptr;
  const auto known = worn_.find(path);
  if (known != worn_.end()) return &known->second;
  auto worn = ReadGlasses(storage_, path);
  if (!worn) return Fail(worn);
  return &worn_.emplace(path, std::move(*worn)).first->second;
}

Result<const std::vector<SurfaceSample>*> PictureSources::SamplesOf(const std::string& scan) {
  if (scan.empty()) return nullptr;
  const auto known = samples_.find(scan);
  if (known != samples_.end()) return &known->second;
  const auto keys = OpenKeys(key_file_);
  if (!keys) return Fail(keys);
  auto read = ReadRecording(storage_, scan, keys->get());
  if (!read) return Fail(read);
  std::vector<Scan> scans;
  scans.push_back(std::move(*read));
  return &samples_.emplace(scan, FittedSamples(scans)).first->second;
}

}  // namespace annulus
