#include "modeling/glasses/wall_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "modeling/glasses/frame_walls.h"
#include "modeling/mesh/bvh.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr ShellTessellation kSampling{.along = 12, .around = 8, .straight = 2};
/// The solid's share of the control polygon's depth s (a cubic Bezier U of depth 1 is 0.75 deep).
constexpr double kSolidShare = 0.75;
/// A ray goes on this far behind a face that it met, mm.
constexpr double kStep = 1e-6;
constexpr double kFarthest = 500.0;  // mm; no frame is larger
/// Faces whose normals have a smaller cosine are opposite sides of a wall.
constexpr double kOpposite = -0.5;
/// What is thinner on less of a shell than this is an edge, mm².
constexpr double kSmallestWall = 1.0;
/// A groove's shoulder is held by the rim behind it: it may be thinner by this.
constexpr double kShoulderShare = 0.5;
/// Measured walls may fall short by this share: triangles cut corners off a curved surface.
constexpr double kMeshShare = 0.02;

/// A body's skin as one tree: shells overlap, so what lies inside counts how many.
class BodySkin {
 public:
  explicit BodySkin(const FrameBody& body) {
    TriangleMesh whole;
    for (const PatchShell& shell : body.shells) {
      meshes_.push_back(Tessellate(shell, kSampling));
      Append(whole, meshes_.back());
    }
    tree_.emplace(whole);
  }

  [[nodiscard]] const std::vector<TriangleMesh>& meshes() const { return meshes_; }

  /// Number of shells that hold a point.
  [[nodiscard]] int Depth(const Vector3d& p, const Vector3d& direction) const {
    int depth = 0;
    Walk(p, direction, [&depth](double, const MeshHit& hit, const Vector3d& way) {
      depth += hit.normal.dot(way) > 0.0 ? 1 : -1;
      return true;
    });
    return depth;
  }

  /// From a face with this outward normal through the body; nothing if the far side is not opposite.
  [[nodiscard]] std::optional<double> Thickness(const Vector3d& p, const Vector3d& normal) const {
    int depth = 1;
    std::optional<double> thickness;
    Walk(p - kStep * normal, -normal, [&](double distance, const MeshHit& hit, const Vector3d& way) {
      depth += hit.normal.dot(way) > 0.0 ? -1 : 1;
      if (depth > 0) return true;
      if (hit.normal.dot(normal) < kOpposite) thickness = distance + kStep;
      return false;
    });
    return thickness;
  }

 private:
  /// Calls `visit` with every face along a ray until it returns false.
  template <class Visit>
  void Walk(const Vector3d& origin, const Vector3d& direction, const Visit& visit) const {
    double travelled = 0.0;
    while (const auto hit = tree_->Cast({origin + travelled * direction, direction}, kFarthest)) {
      if (!visit(travelled + hit->distance_mm, *hit, direction)) return;
      travelled += hit->distance_mm + kStep;
    }
  }

  std::vector<TriangleMesh> meshes_;
  std::optional<Bvh> tree_;
};

/// A place with its share of the surface.
struct Sample {
  WallPlace wall;
  double area;  ///< mm²
};

std::optional<WallPlace> ThinnestOf(const BodySkin& skin, const TriangleMesh& mesh) {
  std::vector<Sample> samples;
  for (const auto& face : mesh.faces) {
    const Vector3d& a = mesh.vertices[face[0]];
    const Vector3d& b = mesh.vertices[face[1]];
    const Vector3d& c = mesh.vertices[face[2]];
    const Vector3d cross = (b - a).cross(c - a);
    if (!(cross.norm() > 1e-9)) continue;
    const Vector3d normal = cross.normalized();
    const Vector3d middle = (a + b + c) / 3.0;
    if (skin.Depth(middle + kStep * normal, normal) > 0) continue;
    const std::optional<double> thickness = skin.Thickness(middle, normal);
    if (thickness) samples.push_back({{"", "", middle, *thickness}, 0.5 * cross.norm()});
  }
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.wall.thickness < b.wall.thickness; });
  double thinner = 0.0;
  for (const Sample& sample : samples) {
    thinner += sample.area;
    if (thinner > kSmallestWall) return sample.wall;
  }
  return std::nullopt;
}

bool IsFitting(const std::string& shell) {
  return shell.starts_with("knuckle") || shell.starts_with("leaf") || shell.starts_with("pad_wire") ||
         shell.starts_with("mount");
}

/// `part` is a shell's or one of WallsOf.
double LeastOf(const WallLimits& limits, const std::string& part) {
  if (IsFitting(part) || part == "lens_screw") return limits.fittings;
  if (part == "groove_shoulder") return kShoulderShare * limits.frame;
  return part.starts_with("pad") ? limits.pads : limits.frame;
}

/// What to change so that `part`, which is `thickness` mm thick, is `least` mm thick.
std::string AdviceFor(const Frame& frame, const std::string& part, double thickness, double least) {
  const FrameDetails& details = frame.design.details;
  if (part == "groove_shoulder" || (part.starts_with("rim_") && details.groove_depth > 0.0 && part != "rim_depth")) {
    return fmt::format(
        "make the groove smaller (it is {:.1f} mm wide and {:.1f} mm deep), or the rim thicker or deeper, or give the "
        "smaller --min-wall of your process",
        details.groove_width, details.groove_depth);
  }
  if (part == "rim_top") return "choose a larger --upper-thickness, or give the smaller --min-wall of your process";
  if (part == "rim_nose" || part == "rim_bottom" || part == "rim_temple") {
    return "choose larger --upper-thickness and --lower-thickness, or give the smaller --min-wall of your process";
  }
  if (IsFitting(part) || part == "lens_screw") {
    return "choose fixed pads and no hinge if it is to be made in one piece, or give the smaller --min-wall of the "
           "process that makes this part";
  }
  if (part.starts_with("pad")) {
    return "choose larger or adjustable pads, or give the smaller --min-wall of your process";
  }
  const double depth = frame.design.depth();
  return fmt::format(
      "design it deeper (--depth {:.2f}; it is {:.2f}, of which the solid is 0.75) or thicker, or give the smaller "
      "--min-wall of your process",
      std::ceil(100.0 * (depth + (least - thickness) / kSolidShare)) / 100.0, depth);
}

}  // namespace

std::vector<WallPlace> ThinnestWalls(const std::vector<FrameBody>& bodies) {
  std::vector<WallPlace> places;
  for (const FrameBody& body : bodies) {
    const BodySkin skin(body);
    for (std::size_t k = 0; k < body.shells.size(); ++k) {
      std::optional<WallPlace> place = ThinnestOf(skin, skin.meshes()[k]);
      if (!place) continue;
      place->body = body.name;
      place->shell = body.shells[k].name;
      places.push_back(*place);
    }
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const WallPlace& a, const WallPlace& b) { return a.thickness < b.thickness; });
  return places;
}

WallLimits UsualWallLimits(std::optional<DesignMaterial> material) {
  if (!material) return {};
  return *material == DesignMaterial::kAcetate ? WallLimits{0.8, 0.6, 0.0} : WallLimits{0.5, 0.5, 0.0};
}

Status CheckWalls(const Frame& frame, const WallLimits& limits) {
  const auto refuse = [&frame](const std::string& part, double thickness, double least, const std::string& where) {
    return Fail(fmt::format("check that every wall is {:.2f} mm thick", least),
                fmt::format("{} is {:.2f} mm thick{}", part, thickness, where),
                AdviceFor(frame, part, thickness, least));
  };
  std::vector<Wall> designed = WallsOf(frame);
  std::stable_sort(designed.begin(), designed.end(),
                   [](const Wall& a, const Wall& b) { return a.thickness < b.thickness; });
  for (const Wall& wall : designed) {
    const double least = LeastOf(limits, wall.name);
    if (wall.thickness < least) return refuse(wall.name, wall.thickness, least, "");
  }
  for (const WallPlace& wall : ThinnestWalls(FrameBodies(frame))) {
    const double least = LeastOf(limits, wall.shell);
    if (wall.thickness >= least * (1.0 - kMeshShare)) continue;
    const Vector3d& p = wall.place;
    return refuse(wall.shell, wall.thickness, least,
                  fmt::format(" at x {:.1f}, y {:.1f}, z {:.1f} mm", p.x(), p.y(), p.z()));
  }
  return {};
}

}  // namespace annulus
