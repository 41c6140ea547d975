#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/units.h"
#include "fitting/spline_surface.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_design.h"
#include "modeling/landmarks/face_points.h"

namespace annulus {

/// How far the placed frame is from what steps 1, 2 and 4 of paper 000, §5 ask, measured on the finished frame, mm.
struct PlacementResiduals {
  double eye_right = 0.0;  ///< O0 against the eye centre in the frontal view (x, z).
  double eye_left = 0.0;
  double bridge = 0.0;     ///< C's y against the forehead point's y plus forward_shift.
  double ear_right = 0.0;  ///< Q30ᴬ against the ear point.
  double ear_left = 0.0;
};

/// A frame on a head: what WORN.json holds. Self-sufficient.
struct WornFrame {
  FrameDesign design;          ///< Scaled to the face, mm.
  FrameAdjustment adjustment;  ///< Bent for the face.
  Eigen::Isometry3d station_from_frame = Eigen::Isometry3d::Identity();
  FacePoints face;             ///< What it was placed on, station frame.
  double tilt = 0.0;           ///< Step 3's tilt about P3P4, rad; the lower edge is nearer to the face.
  double forward_shift = 0.0;  ///< mm along +y that ClearHead moved it.
  double clearance = 0.0;      ///< mm, smallest distance of rims and bridge to the head; 0 if ClearHead was not called.
  double l6_right = 0.0;       ///< mm.
  double l6_left = 0.0;
  PlacementResiduals residuals;
};

/// Step 3's tilt.
inline constexpr double kPaperTilt = RadiansFromDegrees(15.0);
/// The distance that ClearHead keeps between the head and rims and bridge, mm.
inline constexpr double kDefaultClearance = 1.0;

/// Places the frame by steps 1–4 of paper 000, §5: scaled so that O0 and O0' meet the eyes in the frontal view
/// (l1 = PD / 1.2), C at the forehead's y, tilted by `tilt`, temples to the ears. Steps 1 and 2 hold after the tilt
/// too: the equations are solved together, not one after the other. Eyes at different heights roll the frame.
[[nodiscard]] Result<WornFrame> PlaceFrame(const FrameDesign& design, const FacePoints& face, double tilt = kPaperTilt);

/// Moves the frame forward (+y only; temples follow) by the least amount that keeps rims and bridge `clearance` mm off
/// the head. Fails if 40 mm are not enough.
[[nodiscard]] Result<WornFrame> ClearHead(const WornFrame& worn, const SplineSurface& head,
                                          double clearance = kDefaultClearance);

/// The frame's geometry (frame frame). Fails only for a WornFrame made by hand with impossible values.
[[nodiscard]] Result<Frame> BuildWornFrame(const WornFrame& worn);

/// The five closed parts and the two lenses in the station frame, mm.
struct WornMeshes {
  std::vector<FrameMesh> parts;
  std::vector<FrameMesh> lenses;
};
[[nodiscard]] Result<WornMeshes> TessellateWornFrame(const WornFrame& worn, const ShellTessellation& tessellation,
                                                     std::size_t lens_steps);

/// WORN.json: {"format": "annulus-worn", "version": 1, "parameters": {…}, "station_from_frame": {"rotation": 3 × 3
/// rows, "translation_mm": […]}, "face_points": {…}, …}. Numbers read back to the same bits.
[[nodiscard]] std::string WornFrameToJson(const WornFrame& worn);
/// Reads WORN.json; `name` of the file is for messages.
[[nodiscard]] Result<WornFrame> WornFrameFromJson(std::string_view json, std::string_view name);

}  // namespace annulus
