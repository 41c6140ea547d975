#include "modeling/flatten/flat_material.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

namespace annulus {

Eigen::Matrix3d Stiffness(const FlatMaterial& material) {
  // Compliance of an orthotropic sheet (weft, warp, shear): symmetric because poisson / e_warp serves both ways.
  Eigen::Matrix3d compliance = Eigen::Matrix3d::Zero();
  compliance(0, 0) = 1.0 / material.e_weft;
  compliance(1, 1) = 1.0 / material.e_warp;
  compliance(0, 1) = compliance(1, 0) = -material.poisson / material.e_warp;
  const double shear = material.shear > 0.0
                           ? material.shear
                           : std::sqrt(material.e_warp * material.e_weft) / (2.0 + 2.0 * material.poisson);
  compliance(2, 2) = 1.0 / shear;
  return material.thickness_mm * compliance.inverse();
}

Status CheckMaterial(const FlatMaterial& material) {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0.0; };
  if (positive(material.e_warp) && positive(material.e_weft) && positive(material.thickness_mm) &&
      std::isfinite(material.shear) && material.shear >= 0.0 && material.poisson > -1.0 &&
      material.poisson * material.poisson * material.e_weft < material.e_warp) {
    return {};
  }
  return Fail("take the material",
              fmt::format("e_warp {:g}, e_weft {:g}, poisson {:g}, shear {:g}, thickness {:g} store no positive energy",
                          material.e_warp, material.e_weft, material.poisson, material.shear, material.thickness_mm),
              "moduli and thickness must be over 0, poisson over -1 and poisson^2 * e_weft under e_warp");
}

}  // namespace annulus
