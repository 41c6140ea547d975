#include "sim/varied_head.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/ensure.h"
#include "base/units.h"
#include "modeling/mesh/convex_hull_2d.h"
#include "sim/head_shape.h"

namespace annulus::sim {
namespace {

using Eigen::Vector3d;

constexpr double kFront = kPi / 2.0;
constexpr double kEyeRow = 1584.0;      // height of the eyes in HeadRows(1)
constexpr double kFaceRadius = 92.0;    // mm: turns a feature's extent across the face into an angle
constexpr double kSideRadius = 76.0;    // mm, the same for the ears
constexpr double kFifthOfFlat = 1.593;  // sigmas at which a flat-topped bump has sunk to a fifth
constexpr std::array<double, 2> kSigns{1.0, -1.0};

double BumpHeight(const TubeBump& bump, double theta, double z) {
  const double u = (z - bump.z) / bump.sigma_z;
  const double exponent = 0.5 * u * u + (1.0 - std::cos(theta - bump.theta)) / (bump.sigma_theta * bump.sigma_theta);
  return bump.amplitude * std::exp(bump.power == 2 ? -exponent * exponent : -exponent);
}

// A feature's extent, mm.
struct Extent {
  double across;
  double up;
};

// A bump whose amplitude is chosen so that the surface goes through a point.
struct Shaped {
  TubeBump bump;
  Vector3d target;  // body coordinates
};

// Builds the tube of a varied head: bumps of known size first, then those that are shaped by points on the surface.
class HeadBuilder {
 public:
  explicit HeadBuilder(const HeadVariation& variation)
      : v_(variation), skull_(Rows(), {}, Caps()), sellion_z_(v_.eye_z + v_.sellion_above) {
    sellion_y_ = skull_.Point(kFront, sellion_z_).y() + v_.sellion_forward;
    AddLowerFace();
    AddNose();
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      AddEye(side);
      AddBrowAndCheek(side);
    }
    Shape();
  }

  [[nodiscard]] StarTube Tube(const std::vector<TubeBump>& ears) const {
    std::vector<TubeBump> bumps = bumps_;
    bumps.insert(bumps.end(), ears.begin(), ears.end());
    return {Rows(), bumps, Caps(), balls_};
  }
  [[nodiscard]] std::vector<TubeBump> Ear(std::size_t side) const;
  [[nodiscard]] FaceTruth Face(const StarTube& tube) const;
  [[nodiscard]] std::vector<NamedLevel> Levels(const StarTube& tube) const;
  [[nodiscard]] double Crown() const { return Caps().top_tip; }

 private:
  // A height given above the eyes of a middling head.
  [[nodiscard]] double Height(double above_eyes) const { return v_.eye_z + v_.size * above_eyes; }
  [[nodiscard]] TubeCaps Caps() const { return {Height(-190.0), Height(-160.0), Height(30.0), Height(116.0)}; }
  [[nodiscard]] std::vector<TubeRow> Rows() const;
  // The angle at which the skull is `right` mm beside the mid-plane in front.
  [[nodiscard]] double FrontAngle(double right, double z) const;
  // The angle at which the skull's side is `behind` mm behind the body's frontal plane.
  [[nodiscard]] double SideAngle(double behind, double z, std::size_t side) const;
  [[nodiscard]] TubeBump Bump(double right, double z, double amplitude, Extent extent) const {
    return {FrontAngle(right, z), z, amplitude, extent.across / kFaceRadius, extent.up};
  }
  void AddLowerFace();
  void AddNose();
  void AddEye(std::size_t side);
  void AddBrowAndCheek(std::size_t side);
  // A bump at the point (right, forward, z), of such amplitude that the surface goes through it.
  void ShapeAt(const Vector3d& target, Extent extent) {
    shaped_.push_back({Bump(target.x(), target.z(), 1.0, extent), target});
  }
  void Shape();

  const HeadVariation& v_;
  StarTube skull_;
  double sellion_z_;
  double sellion_y_ = 0.0;
  std::vector<TubeBump> bumps_;
  std::vector<TubeBall> balls_;
  std::vector<Shaped> shaped_;
};

std::vector<TubeRow> HeadBuilder::Rows() const {
  std::vector<TubeRow> rows{{1396, 70, 52, -82, 0, 0, 0}, {1420, 62, 46, -74, 0, 0, 0}};
  for (const TubeRow& row : HeadRows(1.0)) rows.push_back(row);
  for (TubeRow& row : rows) {
    row.z = Height(row.z - kEyeRow);
    row.half_width *= v_.size * v_.breadth;
    row.front *= v_.size;
    row.back *= v_.size * v_.depth;
  }
  return rows;
}

double HeadBuilder::FrontAngle(double right, double z) const {
  double theta = kFront;  // the radius hardly changes from step to step
  for (int k = 0; k < 8; ++k) theta = kFront - std::asin(right / skull_.Radius(theta, z));
  return theta;
}

double HeadBuilder::SideAngle(double behind, double z, std::size_t side) const {
  double angle = 0.0;
  for (int k = 0; k < 8; ++k) {
    angle = std::asin((behind + skull_.Centre(z).y()) / skull_.Radius(-angle, z));
  }
  return side == 0 ? -angle : kPi + angle;
}

void HeadBuilder::AddLowerFace() {
  const double s = v_.size;
  bumps_.push_back(Bump(0.0, Height(-71.0), 5.0 * s, {17.0 * s, 7.0 * s}));   // mouth
  bumps_.push_back(Bump(0.0, Height(-96.0), 6.0 * s, {15.0 * s, 9.0 * s}));   // chin
  bumps_.push_back(Bump(0.0, Height(-67.0), 1.8 * s, {12.0 * s, 2.6 * s}));   // upper lip
  bumps_.push_back(Bump(0.0, Height(-76.0), 2.2 * s, {12.0 * s, 2.8 * s}));   // lower lip
  bumps_.push_back(Bump(0.0, Height(-71.5), -1.6 * s, {16.0 * s, 1.5 * s}));  // between them
  bumps_.push_back(Bump(0.0, Height(-86.0), -2.5 * s, {14.0 * s, 4.5 * s}));  // fold above the chin
}

void HeadBuilder::AddNose() {
  const double length = v_.nose_length;
  const double tip_z = sellion_z_ - length;
  // The part with a flat top and steep sides, from root to tip.
  TubeBump flat = Bump(0.5 * (v_.root_right + v_.tip_right), sellion_z_ - 0.45 * length, 20.0 * v_.ridge_flatness,
                       {0.42 * (v_.root_width + v_.tip_width), 0.5 * length});
  flat.power = 2;
  bumps_.push_back(flat);
  for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
    bumps_.push_back(Bump(v_.tip_right + kSigns[side] * 13.5, tip_z - 2.0, 6.5, {5.5, 6.0}));  // wings
    bumps_.push_back(
        Bump(v_.root_right + kSigns[side] * 9.0, sellion_z_ - 0.3 * length, v_.flank_bulge[side], {4.5, 9.0}));
  }
  // The ridge, as a share of the way from sellion to pronasale: measured on faces, concave above and round at the tip.
  constexpr std::array<double, 6> kForward{0.0, 0.13, 0.34, 0.60, 0.86, 1.0};
  for (std::size_t k = 0; k < kForward.size(); ++k) {
    const double down = static_cast<double>(k) / (kForward.size() - 1.0);
    const double forward = kForward[k] * v_.nose_protrusion + v_.nose_hump * std::sin(kPi * down);
    const double right = v_.root_right + down * (v_.tip_right - v_.root_right);
    const double width = v_.root_width + down * (v_.tip_width - v_.root_width);
    ShapeAt({right, sellion_y_ + forward, sellion_z_ - down * length}, {width, 0.17 * length});
  }
  ShapeAt({v_.tip_right, sellion_y_ + v_.nose_protrusion - 11.0, tip_z - 8.0}, {8.0, 5.0});
  ShapeAt({0.0, sellion_y_ + v_.glabella_forward, sellion_z_ + 15.0}, {15.0, 8.0});
}

void HeadBuilder::AddEye(std::size_t side) {
  const double right = kSigns[side] * v_.eye_lateral[side];
  const double z = v_.eye_z + v_.eye_above[side];
  const double cornea = sellion_y_ + v_.eye_forward[side];
  balls_.push_back({{right, cornea - v_.eyeball_radius, z}, v_.eyeball_radius, 2.5});
  // The socket about it: towards the nose, towards the temple, under the brow, above the cheek, behind the ball.
  const double inner = kSigns[side] * (0.5 * v_.eye_lateral[side] + 0.5);
  const double outer = right + kSigns[side] * 13.0;
  ShapeAt({inner, cornea - v_.socket_depth, z}, {6.0, 10.0});
  ShapeAt({outer, cornea - 8.5, z}, {10.0, 12.0});
  ShapeAt({right, cornea - 1.0, z + 13.5}, {12.0, 7.0});
  ShapeAt({right, cornea - 1.5, z - 14.0}, {12.0, 7.0});
  ShapeAt({right, cornea - 6.0, z}, {7.0, 6.5});
  // The lids' edges, on the ball.
  for (const auto& [above, share] : {std::pair{5.5, 1.0}, std::pair{-6.0, 0.6}}) {
    TubeBump lid = Bump(right, z + above, share * v_.lid_fold, {8.0, 1.8});
    lid.over_balls = true;
    bumps_.push_back(lid);
  }
}

void HeadBuilder::AddBrowAndCheek(std::size_t side) {
  const double s = v_.size;
  const double z = v_.eye_z + v_.eye_above[side];
  bumps_.push_back(Bump(kSigns[side] * 24.0 * s, z + 23.0 * s, v_.brow[side], {15.0 * s, 7.0 * s}));
  bumps_.push_back(Bump(kSigns[side] * 46.0 * s, z - 25.0 * s, v_.cheek[side], {14.0 * s, 12.0 * s}));
}

// The radius is linear in the amplitudes: a small system gives those with which the surface goes through the points.
void HeadBuilder::Shape() {
  const auto count = static_cast<Eigen::Index>(shaped_.size());
  Eigen::MatrixXd heights(count, count);
  Eigen::VectorXd missing(count);
  for (Eigen::Index row = 0; row < count; ++row) {
    const Vector3d& target = shaped_[static_cast<std::size_t>(row)].target;
    const Eigen::Vector2d from_centre = target.head<2>() - skull_.Centre(target.z());
    const double theta = std::atan2(from_centre.y(), from_centre.x());
    missing[row] = from_centre.norm() - skull_.Radius(theta, target.z());
    for (const TubeBump& bump : bumps_) {
      if (!bump.over_balls) missing[row] -= BumpHeight(bump, theta, target.z());
    }
    for (Eigen::Index column = 0; column < count; ++column) {
      heights(row, column) = BumpHeight(shaped_[static_cast<std::size_t>(column)].bump, theta, target.z());
    }
  }
  const Eigen::VectorXd amplitudes = heights.partialPivLu().solve(missing);
  for (Eigen::Index k = 0; k < count; ++k) {
    TubeBump bump = shaped_[static_cast<std::size_t>(k)].bump;
    bump.amplitude = amplitudes[k];
    bumps_.push_back(bump);
  }
}

std::vector<TubeBump> HeadBuilder::Ear(std::size_t side) const {
  const double z = v_.eye_z + v_.ear_above[side];
  const double half = v_.ear_half_height[side] / kFifthOfFlat;
  const auto bump = [&](double forward, double above, double amplitude, Extent extent) {
    return TubeBump{SideAngle(v_.ear_behind[side] - forward, z, side), z + above, amplitude,
                    extent.across / kSideRadius, extent.up};
  };
  TubeBump shell = bump(0.0, 0.0, v_.ear_protrusion[side], {9.0, half});
  shell.power = 2;
  return {shell, bump(6.0, -24.0, 3.0, {7.0, 8.0}), bump(4.0, -4.0, -5.0, {4.5, 9.0})};
}

FaceTruth HeadBuilder::Face(const StarTube& tube) const {
  const auto forward = [&](double theta, double z) { return tube.Point(theta, z).y(); };
  const auto ridge = [&](double z) {
    return FindMaximum([&](double theta) { return forward(theta, z); }, kFront - 0.05, kFront + 0.05);
  };
  const double sellion =
      FindMaximum([&](double z) { return -forward(ridge(z), z); }, sellion_z_ - 7.0, sellion_z_ + 9.0);
  const double tip_z = sellion_z_ - v_.nose_length;
  const double pronasale = FindMaximum([&](double z) { return forward(ridge(z), z); }, tip_z - 7.0, tip_z + 9.0);
  const double glabella =
      FindMaximum([&](double z) { return forward(kFront, z); }, sellion_z_ + 6.0, sellion_z_ + 30.0);
  const auto eye = [&](std::size_t side) -> Vector3d {
    const Vector3d& centre = balls_[side].centre;
    const double aside = std::atan2(centre.x(), 90.0);
    const double theta =
        FindMaximum([&](double angle) { return -std::abs(tube.Point(angle, centre.z()).x() - centre.x()); },
                    kFront - aside - 0.15, kFront - aside + 0.15);
    return tube.Point(theta, centre.z());
  };
  const auto ear_top = [&](std::size_t side) -> Vector3d {
    const std::vector<TubeBump> ear = Ear(side);
    const double theta = ear.front().theta;
    const auto relief = [&](double turn, double z) {
      double sum = 0.0;
      for (const TubeBump& bump : ear) sum += BumpHeight(bump, theta + turn, z);
      return sum;
    };
    const double middle = ear.front().z;
    const double half = v_.ear_half_height[side];
    double largest = 0.0;
    for (double z = middle - half; z <= middle + half; z += 0.5) {
      for (double turn = -0.2; turn <= 0.2; turn += 0.01) largest = std::max(largest, relief(turn, z));
    }
    const double z = FindMaximum([&](double at) { return -std::abs(relief(0.0, at) - 0.2 * largest); },
                                 middle + 0.4 * half, middle + 1.5 * half);
    return tube.Point(theta, z);
  };
  return {eye(0),
          eye(1),
          ear_top(0),
          ear_top(1),
          tube.Point(kFront, glabella),
          tube.Point(ridge(sellion), sellion),
          tube.Point(ridge(pronasale), pronasale)};
}

std::vector<NamedLevel> HeadBuilder::Levels(const StarTube& tube) const {
  const auto tape = [&](double z) {
    constexpr int kDirections = 360;
    std::vector<Eigen::Vector2d> loop;
    for (int k = 0; k < kDirections; ++k) loop.emplace_back(tube.Point(kTwoPi * k / kDirections, z).head<2>());
    return ConvexHullPerimeter(loop);
  };
  return {{"head", FindMaximum(tape, Height(21.0), Height(76.0))},
          {"neck", FindMaximum([&](double z) { return -tape(z); }, Height(-148.0), Height(-114.0))}};
}

bool IsIn(const Sides& sides, double low, double high) {
  return std::all_of(sides.begin(), sides.end(), [&](double x) { return x >= low && x <= high; });
}

void CheckRanges(const HeadVariation& v) {
  ENSURE(v.eye_z >= 1400.0 && v.eye_z <= 1800.0, "eye_z out of range");
  ENSURE(IsIn({v.size, v.size}, 0.92, 1.08) && IsIn({v.breadth, v.depth}, 0.92, 1.08), "skull out of range");
  ENSURE(IsIn(v.eye_lateral, 25.0, 39.0) && IsIn(v.eye_forward, -15.0, -6.0) && IsIn(v.eye_above, -1.5, 1.5) &&
             IsIn({v.eyeball_radius, v.eyeball_radius}, 11.0, 13.5),
         "eyes out of range");
  ENSURE(v.nose_length >= 30.0 && v.nose_length <= 50.0 && v.nose_protrusion >= 13.0 && v.nose_protrusion <= 29.0,
         "nose out of range");
  ENSURE(IsIn(v.ear_half_height, 26.0, 36.0) && IsIn(v.ear_protrusion, 11.0, 22.0), "ears out of range");
}

ParametricBody MakeHeadOf(const HeadVariation& variation, const HeadBuilder& builder, StarTube tube,
                          const FaceTruth& face) {
  ParametricBody::Description description;
  description.name = "head";
  description.levels = builder.Levels(tube);
  description.heights.crown_mm = builder.Crown();
  description.face = face;
  description.placement = variation.placement;
  description.parts.push_back({BodyPart::kTorso, std::move(tube)});
  return ParametricBody(std::move(description));
}

StarTube WithEars(const HeadBuilder& builder) {
  std::vector<TubeBump> ears = builder.Ear(0);
  for (const TubeBump& bump : builder.Ear(1)) ears.push_back(bump);
  return builder.Tube(ears);
}

}  // namespace

ParametricBody MakeVariedHead(const HeadVariation& variation) {
  CheckRanges(variation);
  const HeadBuilder builder(variation);
  const StarTube tube = WithEars(builder);
  return MakeHeadOf(variation, builder, tube, builder.Face(tube));
}

ParametricBody MakeVariedHeadWithoutEars(const HeadVariation& variation) {
  CheckRanges(variation);
  const HeadBuilder builder(variation);
  const StarTube tube = builder.Tube({});
  return MakeHeadOf(variation, builder, tube, builder.Face(tube));
}

}  // namespace annulus::sim
