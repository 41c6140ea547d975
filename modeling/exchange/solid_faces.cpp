#include "modeling/exchange/solid_faces.h"

#include <fmt/format.h>

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopAbs_ShapeEnum.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <array>
#include <cmath>
#include <gp_Pln.hxx>
#include <optional>
#include <vector>

namespace annulus {
namespace {

using Eigen::Vector3d;

/// What is shorter than this has no length, mm.
constexpr double kPole = 1e-6;
/// Control points this near a plane lie in it, mm.
constexpr double kFlat = 1e-7;
/// Edges of neighbouring faces this near each other are one, mm.
constexpr double kSew = 1e-5;

gp_Pnt ToPoint(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

using Edge = std::array<Vector3d, 4>;

/// The four sides, each where the last one ended.
std::array<Edge, 4> EdgesOf(const BezierPatch& patch) {
  const auto& q = patch.control_net();
  return {{{q[0][0], q[1][0], q[2][0], q[3][0]},
           {q[3][0], q[3][1], q[3][2], q[3][3]},
           {q[3][3], q[2][3], q[1][3], q[0][3]},
           {q[0][3], q[0][2], q[0][1], q[0][0]}}};
}

bool IsPole(const Edge& edge) {
  for (const Vector3d& p : edge) {
    if ((p - edge[0]).norm() > kPole) return false;
  }
  return true;
}

/// The plane of a patch with its normal along S_u × S_v; nothing if it is curved.
std::optional<gp_Pln> PlaneOf(const BezierPatch& patch) {
  const Vector3d normal = patch.Normal(0.5, 0.5);
  const Vector3d origin = patch.Point(0.5, 0.5);
  for (const auto& row : patch.control_net()) {
    for (const Vector3d& p : row) {
      if (std::abs(normal.dot(p - origin)) > kFlat) return std::nullopt;
    }
  }
  return gp_Pln(ToPoint(origin), gp_Dir(normal.x(), normal.y(), normal.z()));
}

TopoDS_Face FlatFace(const BezierPatch& patch, const gp_Pln& plane) {
  BRepBuilderAPI_MakeWire wire;
  for (const Edge& edge : EdgesOf(patch)) {
    if (IsPole(edge)) continue;
    TColgp_Array1OfPnt poles(1, 4);
    for (int k = 0; k < 4; ++k) poles.SetValue(k + 1, ToPoint(edge[static_cast<std::size_t>(k)]));
    wire.Add(BRepBuilderAPI_MakeEdge(Handle(Geom_BezierCurve)(new Geom_BezierCurve(poles))).Edge());
  }
  return BRepBuilderAPI_MakeFace(plane, wire.Wire()).Face();
}

TopoDS_Face CurvedFace(const BezierPatch& patch) {
  TColgp_Array2OfPnt poles(1, 4, 1, 4);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      poles.SetValue(i + 1, j + 1,
                     ToPoint(patch.control_point(static_cast<std::size_t>(i), static_cast<std::size_t>(j))));
    }
  }
  TColStd_Array1OfReal knots(1, 2);
  knots.SetValue(1, 0.0);
  knots.SetValue(2, 1.0);
  TColStd_Array1OfInteger multiplicities(1, 2);
  multiplicities.Init(4);
  const Handle(Geom_BSplineSurface)
      surface(new Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 3, 3));
  return BRepBuilderAPI_MakeFace(surface, kPole).Face();
}

TopoDS_Face FaceOf(const BezierPatch& patch) {
  const std::optional<gp_Pln> plane = PlaneOf(patch);
  return plane ? FlatFace(patch, *plane) : CurvedFace(patch);
}

TopoDS_Shape MakeSolid(const PatchShell& shell) {
  BRepBuilderAPI_Sewing sewing(kSew);
  for (const ShellPatch& piece : shell.patches) sewing.Add(FaceOf(piece.patch));
  sewing.Perform();
  const TopoDS_Shape sewn = sewing.SewedShape();
  if (sewn.IsNull() || sewn.ShapeType() != TopAbs_SHELL || sewing.NbFreeEdges() > 0) return {};
  TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(TopoDS::Shell(sewn)).Solid();
  GProp_GProps properties;
  BRepGProp::VolumeProperties(solid, properties);
  if (properties.Mass() < 0.0) solid.Reverse();
  return solid;
}

}  // namespace

Result<TopoDS_Shape> SolidOfShell(const PatchShell& shell) {
  const std::string attempted = fmt::format("make a solid of {}", shell.name);
  const char* advice = "choose another design, and report this one";
  try {
    const TopoDS_Shape solid = MakeSolid(shell);
    if (solid.IsNull()) return Fail(attempted, "its faces do not close", advice);
    if (!BRepCheck_Analyzer(solid).IsValid()) return Fail(attempted, "Open CASCADE finds the solid invalid", advice);
    return solid;
  } catch (const Standard_Failure& failure) {
    return Fail(attempted, fmt::format("Open CASCADE says {}", failure.GetMessageString()), advice);
  }
}

}  // namespace annulus
