#pragma once

#include <string>
#include <vector>

#include "acquisition/scan.h"
#include "base/result.h"
#include "base/storage.h"
#include "fitting/surface_model.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/glasses/frame_library.h"
#include "modeling/glasses/placement.h"
#include "render/image.h"

namespace annulus {

/// Reading and writing our files by path, for the commands. Errors name the path.
Result<SurfaceModel> ReadModelFile(Storage& storage, const std::string& path);
Status WriteModelFile(Storage& storage, const std::string& path, const SurfaceModel& model);
Result<FrameFile> ReadFrameFile(Storage& storage, const std::string& path);
Result<FrameLibrary> ReadFrameLibraryFile(Storage& storage, const std::string& path);
Result<WornFrame> ReadWornFile(Storage& storage, const std::string& path);
Status WritePngFile(Storage& storage, const std::string& path, const RgbImage& image);

/// Fails if `path` is there already and `force` was not given: recordings are never replaced by accident.
enum class Replacing { kRefuse, kForce };
Status CheckReplacing(const Storage& storage, const std::string& path, Replacing replacing);
/// Fails if `output` is the file `input` itself: input files are never changed. Empty names are no files.
Status CheckNotItself(const std::string& input, const std::string& output);

}  // namespace annulus
