#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/glasses/lens_design.h"

namespace annulus {

/// What an export begins with: FRAME.json or WORN.json, and the frame built from it.
struct GlassesSource {
  FrameFile design;              ///< With the adjustment that the frame was built with.
  std::optional<WornFile> worn;  ///< Of a WORN.json.
  Frame frame;
};

/// Reads either; what a file is, its `format` says. Fails on anything else, naming the path.
[[nodiscard]] Result<GlassesSource> ReadGlasses(Storage& storage, const std::string& path);

/// The design of the frame in numbers that are engraved and drawn.
struct GlassesBoxing {
  LensBox right;        ///< In the lens' plane, origin at the rim's centre.
  LensBox left;
  double dbl = 0.0;     ///< Distance between lenses in the front view, mm.
  double temple = 0.0;  ///< Overall length of the right temple, mm.
};
[[nodiscard]] GlassesBoxing BoxingOfFrame(const Frame& frame);

/// "52□18-140": A, DBL and temple, whole mm.
[[nodiscard]] std::string SizeMark(const GlassesBoxing& boxing);

/// Where an eye looks through its lens plane when the wearer looks straight ahead, and how the lens sits before it.
struct PupilPlace {
  double pd = 0.0;           ///< Monocular: sideways from the bridge's middle, mm.
  double height = 0.0;       ///< Over the lower side of the lens' box, mm.
  Eigen::Vector3d in_frame;  ///< On the lens' plane, frame frame, mm.
};
/// From the face points of a worn frame; nothing without them.
[[nodiscard]] std::optional<PupilPlace> PupilOf(const GlassesSource& source, Eye eye);

}  // namespace annulus
