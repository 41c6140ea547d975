#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "fitting/surface_model.h"
#include "render/eye_view.h"
#include "render/gaze_chart.h"
#include "station/inside_glasses.h"

namespace annulus {

/// What a picture from inside shows.
struct InsideViewOptions {
  std::vector<Eye> eyes{Eye::kLeft, Eye::kRight};  ///< Not empty.
  std::vector<Gaze> gazes{Gaze{}};                 ///< One row each; not empty, at most 8.
  GazeSceneKind scene = GazeSceneKind::kShop;
  double pupil_diameter = 4.0;  ///< mm, 0 … 9; 0: all sharp.
  EyeViewOptions view;          ///< Of one eye's picture.
  LensFinish finish;            ///< Tint and coating of the lenses.
  Material frame = PlasticMaterial(LinearFromHex(0x2b1a12));
};

/// "LEFT,UP[;LEFT,UP…]" in degrees, the wearer's left and up positive; each at most 60. Fails on anything else.
[[nodiscard]] Result<std::vector<Gaze>> ParseGazes(std::string_view text);

/// What the wearer sees: the left eye's picture at the left, a row for each gaze, a line of text under each. `model`
/// (the head, for nose and brow) is borrowed and may be null. Fails as RenderEyeView.
[[nodiscard]] Result<RgbImage> DrawInsideView(const InsideGlasses& glasses, const SurfaceModel* model,
                                              const InsideViewOptions& options, const TaskContext& task);

/// The numbers: {"format": "annulus-inside-view", "version": 1, "notes": […], "right": {"order": …, "field": {"left":
/// {"gaze_deg", "object_deg", "beside_deg", "gap_deg"}, …, "gaze_sr", "object_sr"}, "within": {"0.25_d": share, …},
/// "gaze": [{point}, …], "grid": {"step_deg", "points": [{point}, …]}}, "left": {…}}, a point being {"left_deg",
/// "up_deg", "path", "mean_error_d", "astigmatism_d", "axis_deg", "worst_error_d", "prism_cm_m": {"left", "up"},
/// "chromatic_cm_m", "thickness_mm", "object_left_deg", "object_up_deg", "magnification_percent", "lens_x_mm",
/// "lens_y_mm"}; of a line of sight that is not through the lens without the numbers. "left" and "up" of a prism are
/// where its base lies.
[[nodiscard]] nlohmann::ordered_json InsideReport(const InsideGlasses& glasses, const std::vector<Eye>& eyes,
                                                  const std::vector<Gaze>& gazes);

}  // namespace annulus
