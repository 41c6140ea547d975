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

/// A goal of the fitter as WORN.json keeps it in "fit".
struct SavedGoal {
  std::string id;    ///< "vertex_distance_right"
  std::string term;  ///< The field's English term.
  std::string unit;  ///< "mm", "deg", "%"
  double value = 0.0;
  std::optional<double> sigma;  ///< Absent: not known.
  double low = 0.0;             ///< The usual range.
  double high = 0.0;
  bool met = false;
};
/// All of them; empty for a design, and for a worn frame that was not fitted.
[[nodiscard]] std::vector<SavedGoal> GoalsOf(const GlassesSource& source);

/// How the lens of an eye sits: from the goals, else the tilt, the face form, and 13 mm.
[[nodiscard]] WornPosition PositionOf(const GlassesSource& source, Eye eye);

/// "52□18-140".
[[nodiscard]] std::string SizeMark(const Frame& frame);

/// Where an eye looks through its lens plane when the wearer looks straight ahead, and how the lens sits before it.
struct PupilPlace {
  double pd = 0.0;           ///< Monocular: sideways from the bridge's middle, mm.
  double height = 0.0;       ///< Over the lower side of the lens' box, mm.
  Eigen::Vector3d in_frame;  ///< On the lens' plane, frame frame, mm.
};
/// From the face points of a worn frame; nothing without them.
[[nodiscard]] std::optional<PupilPlace> PupilOf(const GlassesSource& source, Eye eye);

}  // namespace annulus
