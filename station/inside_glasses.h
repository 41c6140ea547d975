#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/glasses/lens_field.h"
#include "modeling/mesh/bvh.h"
#include "render/eye_view.h"
#include "station/glasses_export.h"
#include "station/glasses_source.h"

namespace annulus {

/// One eye and what stands before it, placed by the numbers that its lens was designed for (PositionOf): the lens in
/// its rim with the bevel in the groove, the frame fixed to it.
struct InsideEye {
  Eye eye{};
  LensForm form;
  LensOutline outline;
  LensPose pose;
  FieldGoal goal;                                ///< The order at the worn vertex distance.
  PowerMatrix correction = PowerMatrix::Zero();  ///< The order at the cornea, D.
  SpheroCylinder order;                          ///< As prescribed.
  std::optional<double> add;                     ///< Carried only: the lens is single vision.
  Eigen::Isometry3d lens_from_frame = Eigen::Isometry3d::Identity();
  std::shared_ptr<const Bvh> frame;  ///< Lens frame; shared by copies of this value.

  /// For following lines of sight; borrows `frame`.
  [[nodiscard]] LensSight Sight() const { return {form, outline, pose, frame.get()}; }
};

/// The glasses as their wearer has them before the eyes.
struct InsideGlasses {
  InsideEye right;
  InsideEye left;
  std::vector<FrameMesh> parts;  ///< Of the frame, frame frame.
  Eigen::Isometry3d station_from_frame = Eigen::Isometry3d::Identity();
  std::vector<std::string> notes;  ///< One line each.

  [[nodiscard]] const InsideEye& of(Eye eye) const { return eye == Eye::kRight ? right : left; }
};

/// From worn glasses and the order in `options`; without an order the lenses are plano, and a note says so. Fails if
/// nobody wears them or the lenses cannot be made.
[[nodiscard]] Result<InsideGlasses> InsideGlassesOf(const GlassesSource& source, const GlassesExportOptions& options);

/// What of frame and face stands before an eye, view frame (BeforeTheEye): the frame's parts and, with a model, what of
/// the face turns towards the eye (nose, brow, cheek), as the scan has it with the lids taken away. No lens.
[[nodiscard]] Scene NearScene(const InsideGlasses& glasses, Eye eye, const Material& frame, const SurfaceModel* model);

}  // namespace annulus
