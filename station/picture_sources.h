#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "base/surface_sample.h"
#include "modeling/measure/measured_surface.h"
#include "station/glasses_source.h"
#include "station/pictures.h"

namespace annulus {

/// Files that pictures are made of, each read once. What it returns lives as long as it. Thread-bound.
class PictureSources {
 public:
  /// Borrows `storage`. `key_file` opens encrypted recordings; may be empty.
  PictureSources(Storage& storage, std::string key_file) : storage_(storage), key_file_(std::move(key_file)) {}

  [[nodiscard]] Storage& storage() { return storage_; }
  /// The studio of MODEL.json.
  Result<PictureStudio*> StudioOf(const std::string& model);
  /// The same model, ready to be measured.
  Result<const MeasuredSurface*> BodyOf(const std::string& model);
  /// Null for an empty path.
  Result<const GlassesSource*> WornOf(const std::string& path);
  /// The returns of a recording as they are fitted; null for an empty path.
  Result<const std::vector<SurfaceSample>*> SamplesOf(const std::string& scan);

 private:
  struct Model {
    std::unique_ptr<const SurfaceModel> model;
    std::unique_ptr<PictureStudio> studio;        // borrows `model`
    std::unique_ptr<const MeasuredSurface> body;  // borrows `model`; made when it is asked for
  };
  Result<Model*> ModelOf(const std::string& path);

  Storage& storage_;
  std::string key_file_;
  std::map<std::string, Model> models_;
  std::map<std::string, GlassesSource> worn_;
  std::map<std::string, std::vector<SurfaceSample>> samples_;
};

}  // namespace annulus
