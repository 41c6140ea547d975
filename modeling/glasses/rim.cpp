#include "modeling/glasses/rim.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// The radius of a base curve's sphere in mm is this over its dioptres (n = 1.53).
constexpr double kCurveNumerator = 530.0;

/// P1 … P4 (upper outer, upper inner, lower inner, lower outer) about the rim's centre (fig. 9).
std::array<Vector3d, 4> Rectangle(const FrameDesign& d) {
  const double x = 0.5 * d.parameters.width;
  const double z = 0.5 * d.parameters.height;
  return {Vector3d(x, 0.0, z), Vector3d(-x, 0.0, z), Vector3d(-x, 0.0, -z), Vector3d(x, 0.0, -z)};
}

/// Fig. 9 in the rim's own plane.
void PlaceOctagon(const FrameDesign& d, Rim& rim) {
  const std::array<Vector3d, 4> corner = Rectangle(d);
  const FrameParameters& p = d.parameters;
  const std::array<double, 4> cut{p.upper_outer, p.upper_inner, p.lower_inner, p.lower_outer};  // t0, t3, t6, t9
  const std::array<double, 4> thickness{p.upper_thickness, p.upper_thickness, p.lower_thickness, p.lower_thickness};
  // Outward normals of the sides P1P2, P2P3, P3P4, P4P1.
  const std::array<Vector3d, 4> normal{Vector3d::UnitZ(), -Vector3d::UnitX(), -Vector3d::UnitZ(), Vector3d::UnitX()};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d before = (corner[(k + 3) % 4] - corner[k]).normalized();
    const Vector3d after = (corner[(k + 1) % 4] - corner[k]).normalized();
    const Vector3d& normal_before = normal[(k + 3) % 4];
    const Vector3d& normal_after = normal[k];
    const Vector3d bisector = (normal_before + normal_after).normalized();
    const double half = 0.5 * thickness[k];
    // P_kM ⟂ the cut at 45°: it meets the two sides at √2·t from the corner.
    const double along = std::numbers::sqrt2 * cut[k];
    const std::size_t last = (3 * k + 11) % 12;
    rim.m[last] = corner[k] + along * before;
    rim.m[3 * k] = corner[k] - cut[k] * bisector;
    rim.m[3 * k + 1] = corner[k] + along * after;
    rim.half_width[last] = half * Mitre(normal_before, bisector);
    rim.half_width[3 * k] = half * bisector;
    rim.half_width[3 * k + 1] = half * Mitre(bisector, normal_after);
    for (const std::size_t i : {last, 3 * k, 3 * k + 1}) rim.thickness[i] = thickness[k];
  }
}

/// v in (0, 0.5) at which a section is `share` (0 … 0.75) of its half depth off the middle plane: 3v(1 - v) = share.
double DepthParameter(double share) { return 0.5 * (1.0 - std::sqrt(1.0 - 4.0 / 3.0 * share)); }
/// Place across the section at v, in half widths.
double PlaceAt(double v) { return -1.0 + 2.0 * v * v * (3.0 - 2.0 * v); }

void CutGroove(const FrameDesign& d, Rim& rim) {
  if (d.details.rim == RimForm::kRimless) {
    rim.lens_place.fill(0.0);
    return;
  }
  rim.lens_place.fill(-1.0);
  if (d.details.groove_depth <= 0.0) return;
  rim.groove_v = DepthParameter(d.details.groove_width / d.depth());
  const double lip = PlaceAt(rim.groove_v);
  for (std::size_t i = 0; i < 12; ++i) rim.lens_place[i] = lip + 2.0 * d.details.groove_depth / rim.thickness[i];
}

std::array<std::size_t, 4> Rows(std::size_t k) { return {3 * k, 3 * k + 1, 3 * k + 2, (3 * k + 3) % 12}; }

/// A curve of the rim's control sections along tube k at these places.
template <typename PlaceOfRow>
BezierCurve CurveAt(const Rim& rim, std::size_t k, const PlaceOfRow& place) {
  BezierCurve curve;
  for (std::size_t r = 0; r < 4; ++r) {
    const std::size_t i = Rows(k)[r];
    curve[r] = rim.m[i] + place(i) * rim.half_width[i];
  }
  return curve;
}

double BendAt(const std::array<double, 7>& bend, double u) {
  const std::size_t first = u < 0.5 ? 0 : 3;
  const std::array<double, 4> b = CubicBernstein(u < 0.5 ? 2.0 * u : 2.0 * u - 1.0);
  return b[0] * bend[first] + b[1] * bend[first + 1] + b[2] * bend[first + 2] + b[3] * bend[first + 3];
}

/// Bends the rim so that the lens' outline comes nearest to the sphere with its front-most point at y = 0 over the
/// rectangle's centre, then moves it so that the mean over M0, M3, M6, M9 is 0. Where pieces meet, the control value is
/// the mean of its neighbours, as the M_i are there: C1.
void BendToSphere(double radius, Rim& rim) {
  constexpr int kSteps = 16;
  using Unknowns = Eigen::Matrix<double, 16, 1>;
  // Unknowns 4k … 4k + 3: control values 1, 2, 4, 5 of tube k. Weights of all of them at a place:
  const auto row_at = [](std::size_t k, double u) {
    Unknowns row = Unknowns::Zero();
    const auto at = [&row](std::size_t i) -> double& { return row[static_cast<Eigen::Index>(i % 16)]; };
    const bool second = u >= 0.5;
    const std::array<double, 4> b = CubicBernstein(second ? 2.0 * u - 1.0 : 2.0 * u);
    const std::size_t first = 4 * k + (second ? 2 : 0);
    at(first + 15) += 0.5 * b[0];
    at(first) += 0.5 * b[0] + b[1];
    at(first + 1) += b[2] + 0.5 * b[3];
    at(first + 2) += 0.5 * b[3];
    return row;
  };
  Eigen::Matrix<double, 16, 16> normal = Eigen::Matrix<double, 16, 16>::Zero();
  Unknowns right = Unknowns::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const BezierCurve curve = LensCurve(rim, k);
    for (int step = 0; step <= kSteps; ++step) {
      const double u = static_cast<double>(step) / kSteps;
      // √(R² - ρ²) - R, also for the largest R.
      const double rho2 = CubicBezierPoint(curve, u).squaredNorm();
      const double sag = -rho2 / (radius + std::sqrt(radius * radius - rho2));
      const Unknowns row = row_at(k, u);
      normal += row * row.transpose();
      right += sag * row;
    }
  }
  const Unknowns y = normal.ldlt().solve(right);
  const auto value = [&y](std::size_t i) { return y[static_cast<Eigen::Index>(i % 16)]; };
  const auto joint = [&value](std::size_t next) { return 0.5 * (value(next + 15) + value(next)); };
  double mean = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t i = 4 * k;
    rim.bend[k] = {joint(i), value(i), value(i + 1), joint(i + 2), value(i + 2), value(i + 3), joint(i + 4)};
    mean += 0.25 * rim.bend[k][0];
  }
  for (auto& bend : rim.bend) {
    for (double& control : bend) control -= mean;
  }
  rim.sphere_front = -mean;
  rim.bent = true;
}

/// A stretch of one of the rim's tubes; of a bent rim within one half of it.
struct Stretch {
  std::size_t tube;
  double from;
  double to;
};

/// The same stretches cut where the pieces of a bend meet.
std::vector<Stretch> CutAtBends(const Rim& rim, const std::vector<Stretch>& stretches) {
  if (!rim.bent) return stretches;
  std::vector<Stretch> cut;
  for (const Stretch& s : stretches) {
    if (s.from < 0.5) cut.push_back({s.tube, s.from, std::min(s.to, 0.5)});
    if (s.to > 0.5) cut.push_back({s.tube, std::max(s.from, 0.5), s.to});
  }
  return cut;
}

/// What the bend adds to the four control sections of a stretch.
std::array<Vector3d, 4> BendOf(const Rim& rim, const Stretch& s) {
  const Vector3d normal = rim.half_depth.normalized();
  const std::size_t first = s.from < 0.5 ? 0 : 3;
  BezierCurve curve;
  for (std::size_t i = 0; i < 4; ++i) curve[i] = rim.bend[s.tube][first + i] * normal;
  const double from = 2.0 * s.from - (first > 0 ? 1.0 : 0.0);
  const double to = 2.0 * s.to - (first > 0 ? 1.0 : 0.0);
  if (to < 1.0) curve = Split(curve, to).first;
  if (from > 0.0) curve = Split(curve, from / to).second;
  return curve;
}

BezierCurve Sub(const BezierCurve& curve, const Stretch& s) {
  BezierCurve piece = curve;
  if (s.to < 1.0) piece = Split(piece, s.to).first;
  if (s.from > 0.0) piece = Split(piece, s.from / s.to).second;
  return piece;
}

/// The tube's sections over a stretch: centres and half widths are cut like curves, then bent.
BezierTube TubeOver(const Rim& rim, const Stretch& s) {
  const BezierCurve centre = Sub(RimCurve(rim, s.tube, 0.0), s);
  const BezierCurve outer = Sub(RimCurve(rim, s.tube, 1.0), s);
  BezierTube::Sections sections;
  const std::array<Vector3d, 4> bend =
      rim.bent ? BendOf(rim, s) : BezierCurve{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  for (std::size_t i = 0; i < 4; ++i) sections[i] = {centre[i] + bend[i], outer[i] - centre[i], rim.half_depth};
  return BezierTube(sections);
}

std::vector<BezierTube> TubesOver(const Rim& rim, const std::vector<Stretch>& stretches) {
  std::vector<BezierTube> tubes;
  for (const Stretch& stretch : CutAtBends(rim, stretches)) tubes.push_back(TubeOver(rim, stretch));
  return tubes;
}

BezierCurve Column(const BezierPatch& patch, std::size_t j) {
  const auto& net = patch.control_net();
  return {net[0][j], net[1][j], net[2][j], net[3][j]};
}

/// The skin of one stretch: A from the front lip to the outer seam, B from there to the back lip; the groove's bottom.
struct Skin {
  BezierPatch a;
  BezierPatch b;
  std::optional<BezierCurve> bottom;
};

Skin SkinOf(const Rim& rim, const Stretch& stretch) {
  const BezierTube tube = TubeOver(rim, stretch);
  if (rim.groove_v <= 0.0) return {tube.a(), tube.b(), std::nullopt};
  BezierCurve bottom = Sub(LensCurve(rim, stretch.tube), stretch);
  if (rim.bent) {
    const std::array<Vector3d, 4> bend = BendOf(rim, stretch);
    for (std::size_t i = 0; i < 4; ++i) bottom[i] += bend[i];
  }
  return {tube.a().Split(PatchDirection::kV, rim.groove_v).second,
          tube.b().Split(PatchDirection::kV, 1.0 - rim.groove_v).first, bottom};
}

void AppendSkin(const Skin& skin, PatchShell& shell) {
  shell.patches.push_back({skin.a, PatchDetail::kAlong, PatchDetail::kAround});
  shell.patches.push_back({skin.b, PatchDetail::kAlong, PatchDetail::kAround});
  if (!skin.bottom) return;
  shell.patches.push_back(
      {RuledPatch(Column(skin.b, 3), *skin.bottom).Flipped(), PatchDetail::kAlong, PatchDetail::kStraight});
  shell.patches.push_back(
      {RuledPatch(*skin.bottom, Column(skin.a, 0)).Flipped(), PatchDetail::kAlong, PatchDetail::kStraight});
}

/// The flat end of a half rim at row 0 of a skin (flipped: at row 3): two fans about the groove's bottom, or one ruled
/// patch.
std::vector<ShellPatch> FlatEnd(const Skin& skin, std::size_t row) {
  const BezierCurve& a = skin.a.control_net()[row];
  const BezierCurve& b = skin.b.control_net()[row];
  if (!skin.bottom) return {{RuledPatch(a, Backwards(b)).Flipped(), PatchDetail::kAround, PatchDetail::kStraight}};
  const Vector3d& bottom = (*skin.bottom)[row];
  const BezierCurve pole{bottom, bottom, bottom, bottom};
  return {{RuledPatch(pole, a), PatchDetail::kStraight, PatchDetail::kAround},
          {RuledPatch(pole, b), PatchDetail::kStraight, PatchDetail::kAround}};
}

}  // namespace

Vector3d Mitre(const Vector3d& a, const Vector3d& b) { return (a + b) / (1.0 + a.dot(b)); }

double RimDepthShare(double place) {
  double low = 0.0;
  double high = 1.0;
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (low + high);
    (PlaceAt(middle) < place ? low : high) = middle;
  }
  return 3.0 * low * (1.0 - low);
}

BezierCurve RimCurve(const Rim& rim, std::size_t k, double place) {
  ENSURE(k < 4, "a rim has four tubes");
  return CurveAt(rim, k, [place](std::size_t) { return place; });
}

double GrooveLip(double opening_share) { return PlaceAt(DepthParameter(opening_share)); }

double BridgeZ(const FrameDesign& d) { return d.parameters.bridge_height - 0.5 * d.parameters.height; }
double TempleZ(const FrameDesign& d) { return d.arm_height() - 0.5 * d.parameters.height; }

Rim MakeRim(const FrameDesign& design) {
  Rim rim;
  PlaceOctagon(design, rim);
  CutGroove(design, rim);
  if (design.details.frame_curve > 0.0) BendToSphere(kCurveNumerator / design.details.frame_curve, rim);
  rim.frame_from_rim = Eigen::Translation3d(0.5 * design.rim_spacing(), 0.0, 0.0) *
                       Eigen::AngleAxisd(-design.details.face_form, Vector3d::UnitZ());
  for (Vector3d& m : rim.m) m = rim.frame_from_rim * m;
  for (Vector3d& width : rim.half_width) width = rim.frame_from_rim.linear() * width;
  rim.half_depth = rim.frame_from_rim.linear() * Vector3d(0.0, 0.5 * design.depth(), 0.0);
  return rim;
}

std::vector<BezierTube> RimTubes(const Rim& rim) {
  if (rim.bent) return TubesOver(rim, {{0, 0.0, 1.0}, {1, 0.0, 1.0}, {2, 0.0, 1.0}, {3, 0.0, 1.0}});
  std::vector<BezierTube> tubes;
  for (std::size_t k = 0; k < 4; ++k) {
    BezierTube::Sections sections;
    for (std::size_t r = 0; r < 4; ++r) {
      const std::size_t i = Rows(k)[r];
      sections[r] = {rim.m[i], rim.half_width[i], rim.half_depth};
    }
    tubes.emplace_back(sections);
  }
  return tubes;
}

BezierCurve LensCurve(const Rim& rim, std::size_t k) {
  ENSURE(k < 4, "a rim has four tubes");
  return CurveAt(rim, k, [&rim](std::size_t i) { return rim.lens_place[i]; });
}

Vector3d RimBend(const Rim& rim, std::size_t k, double u) {
  return BendAt(rim.bend[k], u) * rim.half_depth.normalized();
}

Vector3d LensPoint(const Rim& rim, std::size_t k, double u) {
  return CubicBezierPoint(LensCurve(rim, k), u) + RimBend(rim, k, u);
}

BezierPatch RightLens(const FrameDesign& d, const Rim& rim) {
  const double place = d.details.rim == RimForm::kRimless ? 0.0 : -1.0;
  const Eigen::Isometry3d rim_from_frame = rim.frame_from_rim.inverse();
  std::array<double, 12> bend;
  for (std::size_t k = 0; k < 4; ++k) {
    // The cubic through the bend at 0, 1/3, 2/3 and 1.
    const auto at = [&](int third) { return BendAt(rim.bend[k], third / 3.0); };
    bend[3 * k] = at(0);
    bend[3 * k + 1] = (-5.0 * at(0) + 18.0 * at(1) - 9.0 * at(2) + 2.0 * at(3)) / 6.0;
    bend[3 * k + 2] = (2.0 * at(0) - 9.0 * at(1) + 18.0 * at(2) - 5.0 * at(3)) / 6.0;
  }
  const auto edge = [&](std::size_t i) -> Vector3d {
    return rim_from_frame * (rim.m[i % 12] + place * rim.half_width[i % 12]) + Vector3d(0.0, bend[i % 12], 0.0);
  };
  const Vector3d zero = Vector3d::Zero();
  BezierPatch::ControlNet net;
  net[0] = {edge(0), edge(1), edge(2), edge(3)};
  net[1] = {edge(11), zero, zero, edge(4)};
  net[2] = {edge(10), zero, zero, edge(5)};
  net[3] = {edge(9), edge(8), edge(7), edge(6)};
  // The inner four have the weight 9/64 each in the middle.
  double raise = 3.0 * d.depth();
  if (d.details.frame_curve > 0.0) raise = (rim.sphere_front - BezierPatch(net).Point(0.5, 0.5).y()) * 16.0 / 9.0;
  const std::array<Vector3d, 4> corner = Rectangle(d);
  for (std::size_t i = 1; i < 3; ++i) {
    for (std::size_t j = 1; j < 3; ++j) {
      net[i][j] = corner[0] + static_cast<double>(j) / 3.0 * (corner[1] - corner[0]) +
                  static_cast<double>(i) / 3.0 * (corner[3] - corner[0]) + Vector3d(0.0, raise, 0.0);
    }
  }
  for (auto& row : net) {
    for (Vector3d& point : row) point = rim.frame_from_rim * point;
  }
  return BezierPatch(net);
}

PatchShell RimShell(std::string name, const Rim& rim, const std::optional<HalfRimSpan>& span) {
  std::vector<Stretch> stretches{{0, 0.0, 1.0}, {1, 0.0, 1.0}, {2, 0.0, 1.0}, {3, 0.0, 1.0}};
  if (span) stretches = {{3, span->temple_start, 1.0}, {0, 0.0, 1.0}, {1, 0.0, span->nose_end}};
  PatchShell shell{std::move(name), {}};
  std::vector<Skin> skins;
  for (const Stretch& stretch : CutAtBends(rim, stretches)) skins.push_back(SkinOf(rim, stretch));
  for (const Skin& skin : skins) AppendSkin(skin, shell);
  if (!span) return shell;
  for (const ShellPatch& piece : FlatEnd(skins.front(), 0)) shell.patches.push_back(piece);
  for (const ShellPatch& piece : FlatEnd(skins.back(), 3)) {
    shell.patches.push_back({piece.patch.Flipped(), piece.v, piece.u});
  }
  return shell;
}

}  // namespace annulus
