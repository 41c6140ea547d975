#include "modeling/exchange/solid_model.h"

#include <fmt/format.h>

#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Poly_Triangulation.hxx>
#include <ShapeFix_Shape.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "modeling/exchange/solid_faces.h"
#include "modeling/mesh/float_mesh.h"
#include "modeling/mesh/overlap_volume.h"

namespace annulus {
namespace {

/// A union whose volume is this far from that of the shells' union has lost or gained a piece.
constexpr double kVolumeShare = 1e-3;
/// Pitch of the lines by which the shells' overlap is measured, mm.
constexpr double kOverlapPitch = 0.05;
/// Pitch by which is found whether two shells overlap at all, mm.
constexpr double kJoinPitch = 0.1;
constexpr ShellTessellation kOverlapMesh{.along = 32, .around = 24, .straight = 2};
constexpr double kVolumeError = 1e-6;  // relative, of Open CASCADE's integration

double VolumeOf(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumePropertiesGK(shape, properties, kVolumeError, false, false);
  return properties.Mass();
}

std::vector<TopoDS_Shape> SolidsOf(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> solids;
  for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next()) solids.push_back(at.Current());
  return solids;
}

/// A way to unite solids.
struct FusionWay {
  const char* name;
  double fuzzy;     ///< mm; faces nearer than this touch.
  bool one_by_one;  ///< Pairwise in turn, else all at once.
};
constexpr std::array<FusionWay, 5> kWays{{{"at once", 0.0, false},
                                          {"at once, 1e-5 mm", 1e-5, false},
                                          {"one by one", 0.0, true},
                                          {"one by one, 1e-4 mm", 1e-4, true},
                                          {"at once, 1e-3 mm", 1e-3, false}}};

TopoDS_Shape FuseTwo(const TopTools_ListOfShape& arguments, const TopTools_ListOfShape& tools, double fuzzy) {
  BRepAlgoAPI_Fuse fuse;
  fuse.SetArguments(arguments);
  fuse.SetTools(tools);
  fuse.SetFuzzyValue(fuzzy);
  fuse.SetRunParallel(false);  // same input, same bytes
  fuse.Build();
  return fuse.HasErrors() ? TopoDS_Shape() : fuse.Shape();
}

TopoDS_Shape Fuse(const std::vector<TopoDS_Shape>& solids, const FusionWay& way) {
  TopTools_ListOfShape first;
  first.Append(solids.front());
  TopTools_ListOfShape others;
  TopoDS_Shape whole = solids.front();
  for (std::size_t k = 1; k < solids.size(); ++k) {
    if (!way.one_by_one) {
      others.Append(solids[k]);
      continue;
    }
    TopTools_ListOfShape left;
    left.Append(whole);
    TopTools_ListOfShape right;
    right.Append(solids[k]);
    whole = FuseTwo(left, right, way.fuzzy);
    if (whole.IsNull()) return whole;
  }
  return way.one_by_one ? whole : FuseTwo(first, others, way.fuzzy);
}

/// What the union of some shells must be, found without Open CASCADE.
struct Expected {
  double volume = 0.0;     ///< mm³
  std::size_t pieces = 0;  ///< At most: shells may hang together by less than CountPieces sees.
};

/// What is wrong with a union; "" if nothing is.
std::string FaultOf(const TopoDS_Shape& shape, const Expected& expected) {
  if (shape.IsNull()) return "failed";
  const std::size_t solids = SolidsOf(shape).size();
  if (solids == 0 || solids > expected.pieces) return fmt::format("is {} pieces of {}", solids, expected.pieces);
  if (!BRepCheck_Analyzer(shape).IsValid()) return "is invalid";
  const double volume = VolumeOf(shape);
  if (!(std::abs(volume - expected.volume) <= kVolumeShare * expected.volume)) {
    return fmt::format("has {:.1f} mm3 of {:.1f}", volume, expected.volume);
  }
  return "";
}

/// How many pieces meshes form that hang together where they overlap.
std::size_t CountPieces(const std::vector<TriangleMesh>& meshes) {
  std::vector<std::size_t> piece(meshes.size());
  std::iota(piece.begin(), piece.end(), std::size_t{0});
  for (std::size_t a = 0; a < meshes.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (piece[a] == piece[b] || !(OverlapVolume({meshes[a], meshes[b]}, kJoinPitch) > 0.0)) continue;
      std::replace(piece.begin(), piece.end(), std::max(piece[a], piece[b]), std::min(piece[a], piece[b]));
    }
  }
  std::sort(piece.begin(), piece.end());
  return static_cast<std::size_t>(std::unique(piece.begin(), piece.end()) - piece.begin());
}

/// Exact volumes of the shells less their overlap.
Expected UnionOf(const ShellBody& body) {
  std::vector<TriangleMesh> meshes;
  Expected expected;
  for (const PatchShell& shell : body.shells) {
    expected.volume += Volume(shell);
    meshes.push_back(Tessellate(shell, kOverlapMesh));
  }
  expected.volume -= OverlapVolume(meshes, kOverlapPitch);
  expected.pieces = CountPieces(meshes);
  return expected;
}

/// The union, and how it was had or why not.
std::pair<TopoDS_Shape, std::string> Unite(const std::vector<TopoDS_Shape>& solids, const Expected& expected) {
  std::string faults;
  for (const FusionWay& way : kWays) {
    TopoDS_Shape whole;
    std::string fault;
    try {
      whole = Fuse(solids, way);
      fault = FaultOf(whole, expected);
      if (fault == "is invalid") {
        ShapeFix_Shape fix(whole);
        fix.Perform();
        whole = fix.Shape();
        fault = FaultOf(whole, expected);
      }
    } catch (const Standard_Failure& failure) {
      fault = fmt::format("failed ({})", failure.GetMessageString());
    }
    if (fault.empty()) return {whole, way.name};
    faults += fmt::format("{}{}: the union {}", faults.empty() ? "" : "; ", way.name, fault);
  }
  return {TopoDS_Shape(), faults};
}

/// Largest angle between neighbouring triangles of a skin, rad.
constexpr double kSkinAngle = 0.2;

/// Appends the triangles of a meshed face, outward; false if it has none.
bool AppendFace(const TopoDS_Face& face, TriangleMesh& mesh) {
  TopLoc_Location location;
  const Handle(Poly_Triangulation) triangles = BRep_Tool::Triangulation(face, location);
  if (triangles.IsNull()) return false;
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int k = 1; k <= triangles->NbNodes(); ++k) {
    const gp_Pnt p = triangles->Node(k).Transformed(location);
    mesh.vertices.emplace_back(p.X(), p.Y(), p.Z());
  }
  const auto index = [base](int node) { return base + static_cast<std::uint32_t>(node - 1); };
  for (int k = 1; k <= triangles->NbTriangles(); ++k) {
    std::array<int, 3> node{};
    triangles->Triangle(k).Get(node[0], node[1], node[2]);
    if (face.Orientation() == TopAbs_REVERSED) std::swap(node[1], node[2]);
    mesh.faces.push_back({index(node[0]), index(node[1]), index(node[2])});
  }
  return true;
}

}  // namespace

std::size_t SolidBody::pieces() const { return shapes_->size(); }

Result<SolidBody> SolidBodyOf(const ShellBody& body) {
  std::vector<TopoDS_Shape> solids;
  for (const PatchShell& shell : body.shells) {
    const Result<TopoDS_Shape> solid = SolidOfShell(shell);
    if (!solid) return Fail(solid);
    solids.push_back(*solid);
  }
  SolidBody made;
  made.name_ = body.name;
  made.fused_ = solids.size() == 1;
  if (solids.size() > 1) {
    auto [whole, note] = Unite(solids, UnionOf(body));
    made.note_ = note;
    made.fused_ = !whole.IsNull();
    if (made.fused_) solids = SolidsOf(whole);
  }
  for (const TopoDS_Shape& solid : solids) made.volume_ += VolumeOf(solid);
  made.shapes_ = std::make_shared<const std::vector<TopoDS_Shape>>(std::move(solids));
  return made;
}

Result<TriangleMesh> SkinOf(const SolidBody& body, double deflection) {
  const std::string attempted = fmt::format("mesh the solid of {}", body.name());
  TriangleMesh skin;
  try {
    for (const TopoDS_Shape& shape : body.shapes()) {
      // A copy: Open CASCADE keeps a mesh in the shape that it is of.
      const TopoDS_Shape solid = BRepBuilderAPI_Copy(shape).Shape();
      const BRepMesh_IncrementalMesh mesh(solid, deflection, false, kSkinAngle, false);
      if (!mesh.IsDone()) return Fail(attempted, "Open CASCADE does not mesh it", "export without --fused");
      for (TopExp_Explorer at(solid, TopAbs_FACE); at.More(); at.Next()) {
        if (!AppendFace(TopoDS::Face(at.Current()), skin)) {
          return Fail(attempted, "Open CASCADE leaves out a face", "export without --fused");
        }
      }
    }
  } catch (const Standard_Failure& failure) {
    return Fail(attempted, std::string("Open CASCADE says ") + failure.GetMessageString(), "export without --fused");
  }
  skin = InFloats(skin);
  if (const std::size_t open = CountOpenEdges(skin); open > 0) {
    return Fail(attempted, fmt::format("the mesh has {} open edges", open), "export without --fused");
  }
  return skin;
}

}  // namespace annulus
