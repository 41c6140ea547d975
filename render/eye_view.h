#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/progress.h"
#include "base/result.h"
#include "base/units.h"
#include "modeling/glasses/lens_power.h"
#include "modeling/glasses/lens_trace.h"
#include "render/gaze_chart.h"
#include "render/image.h"
#include "render/scene.h"
#include "render/solid_lens.h"

namespace annulus {

/// The entrance pupil behind the cornea, mm.
inline constexpr double kPupilBehindCornea = 3.0;

/// The eye that looks.
struct SeeingEye {
  Gaze gaze;                    ///< Each angle at most 60°.
  double pupil_diameter = 4.0;  ///< mm, 0 … 9; 0: everything is sharp, as through a pinhole.
  /// The correction that the eye needs at its cornea for distance, D; -40 … 40. It does not accommodate.
  PowerMatrix correction = PowerMatrix::Zero();
  double vertex_distance = 12.0;  ///< mm, of `lens` (LensPose).
};

/// What stands before it. View frame: x the wearer's left, y up, z forward, origin the eye's centre of rotation, mm.
struct BeforeTheEye {
  /// `station_from_lens` is view_from_lens here. Absent: the naked eye.
  std::optional<SolidLens> lens;
  Scene near;                        ///< Opaque things in the view frame: frame, nose.
  const GazeScene* world = nullptr;  ///< Borrowed; not null.
};

struct EyeViewOptions {
  int width = 960;                           ///< Pixels, 16 … 4096.
  int height = 640;                          ///< Pixels, 16 … 4096.
  double field = RadiansFromDegrees(100.0);  ///< Of the picture's width; 1° … 140°. Straight lines stay straight.
  int samples = 48;                          ///< Rays per pixel over the pupil, 1 … 1024.
  int threads = 0;                           ///< 0 means as many as the machine has. The picture does not depend on it.
};

/// What the eye sees: a camera at the entrance pupil, turned with it by Listing's law. Each pixel is the mean of rays
/// that leave the pupil so that they meet at the eye's far point, refracted by both real surfaces of the lens: blur by
/// what power is wrong, uncorrected blur beside the lens, the soft rim, distortion, prism, tint and loss of light are
/// all of one piece. In every direction the retina counts as conjugate to the far-point sphere: a place is as sharp as
/// it would be if the eye turned to it. The world is infinitely far; the frame is not refracted. Fails on values out of
/// range, a lens that is not valid, or a stop request.
[[nodiscard]] Result<RgbImage> RenderEyeView(const SeeingEye& eye, const BeforeTheEye& before,
                                             const EyeViewOptions& options, const TaskContext& task);

}  // namespace annulus
