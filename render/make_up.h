#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "base/result.h"
#include "modeling/landmarks/face_points.h"
#include "modeling/landmarks/face_relief.h"
#include "modeling/landmarks/mid_plane.h"
#include "render/look.h"

namespace annulus {

/// How much of each layer lies at a point of the skin, 0 … 1.
struct MakeUpCover {
  double lips = 0.0;
  double cheeks = 0.0;
  double brows = 0.0;
};

/// Where make-up lies on one face: lips between the borders that their relief shows, the cheeks' soft ovals below and
/// outside the eyes rising to the zygion, brows as arcs on the brow's ridge. Edges are soft: 2 mm of lips and brows, an
/// oval's whole radius of cheeks. A value; borrows nothing.
class MakeUpZones {
 public:
  /// Searches a head whose face points are known.
  [[nodiscard]] static MakeUpZones On(const SplineSurface& head, const FacePoints& face);

  /// The cover at a point of the skin (station frame, mm). Continuous; 0 away from the face's front. It may be asked
  /// for vertices of any mesh: between those of a mesh it is as smooth as the mesh is fine.
  [[nodiscard]] MakeUpCover At(const Eigen::Vector3d& p_in_station) const;

  [[nodiscard]] const Mouth& mouth() const { return mouth_; }

 private:
  struct Cheek {
    Eigen::Vector3d centre;  ///< On the skin, station frame.
    Eigen::Vector3d along;   ///< Long axis, up and outwards: unit.
    Eigen::Vector3d across;  ///< Unit.
  };
  struct Brow {
    double eye_lateral = 0.0;  ///< mm, positive.
    double height = 0.0;       ///< z of the arc above the eye, mm.
  };

  [[nodiscard]] double LipsAt(double lateral, double z) const;
  [[nodiscard]] double BrowAt(double lateral, double z) const;
  [[nodiscard]] double CheekAt(const Eigen::Vector3d& p, std::size_t side) const;

  MidPlane plane_;
  Mouth mouth_;
  double scale_ = 1.0;
  double front_ = 0.0;             ///< Forward distance behind which nothing lies, mm.
  double eyes_ = 0.0;              ///< Their mean height, mm.
  std::array<Cheek, 2> cheeks_{};  ///< [0] is the subject's right.
  std::array<Brow, 2> brows_{};
};

/// Factors on a skin of colour `skin` at the points `vertices` (station frame, mm), for SceneItem::colours; empty if no
/// layer has any strength: then nothing of the picture changes.
[[nodiscard]] std::vector<LinearRgb> MakeUpColours(const MakeUpZones& zones, const MakeUp& make_up,
                                                   const LinearRgb& skin, const std::vector<Eigen::Vector3d>& vertices);

}  // namespace annulus
