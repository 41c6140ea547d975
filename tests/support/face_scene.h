#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/units.h"
#include "modeling/glasses/lens_form.h"
#include "modeling/glasses/lens_power.h"
#include "render/scene.h"
#include "sim/head.h"
#include "tests/support/head_mesh.h"

namespace annulus::test {

/// What the eyes of FaceScene look through.
struct FaceLenses {
  std::vector<SpheroCylinder> orders;  ///< None, the right eye's, or the right and the left eye's.
  double index = 1.6;
  LinearRgb transmittance = LinearRgb::Ones();
};

/// A lens of an elliptic outline (52 × 40 mm) whose optical centre is `reference`, lens frame.
inline Result<SolidLens> EllipticLens(const SpheroCylinder& order, double index, const Eigen::Vector2d& reference) {
  SolidLens lens;
  constexpr int kPoints = 180;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = kTwoPi * i / kPoints;
    lens.outline.points.emplace_back(26.0 * std::cos(angle), 20.0 * std::sin(angle));
  }
  LensFormSpec spec;
  spec.base = std::clamp(6.0 + 0.6 * order.sphere, 1.0, 10.0);
  spec.index = index;
  spec.reference = reference;
  const Result<LensForm> form =
      ThinnestLensForm(spec, {MatrixFrom(order), Eigen::Vector2d::Zero()}, lens.outline, ThicknessRule{});
  if (!form) return Fail(form);
  lens.form = *form;
  return lens;
}

inline Material Matte(const LinearRgb& colour) {
  Material material;
  material.finish = Finish::kMatte;
  material.colour = colour;
  return material;
}

/// Puts a lens upright before `eye` (station frame), its front `before` mm in front of the eye and tilted by 8 degrees.
inline void Place(SolidLens& lens, const Eigen::Vector3d& eye, double before) {
  Eigen::Matrix3d upright;
  upright.col(0) = -Eigen::Vector3d::UnitX();
  upright.col(1) = Eigen::Vector3d::UnitZ();
  upright.col(2) = Eigen::Vector3d::UnitY();
  lens.station_from_lens = Eigen::Isometry3d::Identity();
  lens.station_from_lens.linear() =
      upright * Eigen::AngleAxisd(RadiansFromDegrees(8.0), Eigen::Vector3d::UnitX()).toRotationMatrix();
  lens.station_from_lens.translation() = eye + before * Eigen::Vector3d::UnitY();
}

/// The simulated head of about 2 · columns · rows matte triangles with its lenses, for pictures that povray draws too.
inline Result<Scene> FaceScene(std::uint32_t columns, std::uint32_t rows, const FaceLenses& lenses) {
  const sim::ParametricBody head = sim::MakeHead({});
  Scene scene;
  SceneItem skin;
  skin.mesh = HeadMesh(head, columns, rows);
  skin.material = Matte(LinearRgb(0.72F, 0.51F, 0.42F));
  skin.group = "head";
  skin.normals = VertexNormals(skin.mesh);
  scene.items.push_back(std::move(skin));
  const sim::FaceTruth face = head.face();
  for (std::size_t k = 0; k < lenses.orders.size(); ++k) {
    Result<SolidLens> lens = EllipticLens(lenses.orders[k], lenses.index, Eigen::Vector2d::Zero());
    if (!lens) return Fail(lens);
    lens->finish.transmittance = lenses.transmittance;
    Place(*lens, k == 0 ? face.right_eye : face.left_eye, 22.0);
    scene.lenses.push_back(*std::move(lens));
  }
  return scene;
}

}  // namespace annulus::test
