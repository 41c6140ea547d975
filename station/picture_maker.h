#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "render/image.h"
#include "station/picture_sources.h"
#include "station/render_options.h"

namespace annulus {

/// A picture, or the frames of a film, and what is to be known of it.
struct MadePicture {
  std::vector<RgbImage> frames;    ///< One, or as many as the turntable has.
  Camera camera;                   ///< Of the first frame; of a picture that measures or is from inside the default.
  std::vector<std::string> notes;  ///< One line each.
  std::string numbers;             ///< JSON of what the picture shows, if it shows numbers.
};

/// Makes what a checked request wants: from outside, from inside, measuring, or turning. `options` are
/// PictureOptionsOf the request. Fails as the makers of each do.
[[nodiscard]] Result<MadePicture> MakePicture(const RenderRequest& request, const PictureOptions& options,
                                              PictureSources& sources, const TaskContext& task);

}  // namespace annulus
