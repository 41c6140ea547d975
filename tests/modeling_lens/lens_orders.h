#pragma once

#include "modeling/glasses/lens_design.h"
#include "tests/modeling_lens/lens_shapes.h"

namespace annulus::test {

/// A confirmed order of two spheres, refracted at 12 mm, PD 32 mm, height 20 mm.
inline Prescription Order(double right, double left) {
  Prescription rx;
  rx.date = "2026-05-04";
  rx.prescriber = "Dr. Example";
  rx.refracted_vertex = 12.0;
  rx.centration_confirmed_by = "A. Optician";
  rx.right.sphere = right;
  rx.left.sphere = left;
  for (EyePrescription* eye : {&rx.right, &rx.left}) {
    eye->pd = 32.0;
    eye->height = 20.0;
  }
  return rx;
}

/// 50 □ 18, 36 mm high, pantoscopic 9°, face form 4°, 12 mm.
inline FrameForLenses UsualFrame(std::size_t points = 360) {
  FrameForLenses frame;
  frame.right.outline = frame.left.outline = Ellipse(50.0, 36.0, points);
  frame.right.position = frame.left.position = {12.0, RadiansFromDegrees(9.0), RadiansFromDegrees(4.0)};
  frame.dbl = 18.0;
  return frame;
}

/// A material of the catalogue.
inline LensMaterial Material(const char* name) { return *FindLensMaterial(name); }

}  // namespace annulus::test
