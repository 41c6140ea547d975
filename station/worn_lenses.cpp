#include "station/worn_lenses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "modeling/glasses/boxing.h"
#include "modeling/glasses/rim.h"
#include "render/lens_coating.h"
#include "station/glasses_export.h"
#include "station/lens_choice.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPlanoBase = 4.0;  // D
constexpr double kNoticed = 0.1;    // mm that the groove may leave the edge without a note

/// The usual material of a power: thin enough to be sold so.
const char* UsualMaterial(double power) {
  if (std::abs(power) <= 4.0) return "cr39";
  return std::abs(power) <= 6.0 ? "1.60" : "1.67";
}

/// Where a lens without an order has its middle: before the pupil, or at the box' centre.
struct Centration {
  double pd = 0.0;
  double height = 0.0;
};
Centration CentrationOf(const GlassesSource& source, Eye eye, std::vector<std::string>& notes) {
  const LensOutline outline = LensOutlineOf(source.frame, eye);
  const LensBox box = BoxOf(outline);
  const double half_gap = 0.5 * BoxingOf(source.frame).dbl;
  const double turned = std::cos(source.design.design.details.face_form);
  if (const auto pupil = PupilOf(source, eye)) {
    const double inwards = 0.5 * box.a - (pupil->pd - half_gap) / turned;
    const Vector2d place(eye == Eye::kRight ? inwards : -inwards, pupil->height - 0.5 * box.b);
    if (Inside(outline, box.centre + place)) return {pupil->pd, pupil->height};
    notes.push_back(fmt::format("the {} pupil is not behind its lens: the optical centre is in the lens' middle",
                                eye == Eye::kRight ? "right" : "left"));
  }
  return {half_gap + 0.5 * box.a * turned, 0.5 * box.b};
}

/// The lenses of a look without an order.
Result<LensPair> PairOfPower(const GlassesSource& source, double power, std::vector<std::string>& notes) {
  Prescription order;
  order.date = "2000-01-01";
  order.prescriber = "look";
  order.refracted_vertex = kUsualRefractedVertex;
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    EyePrescription& side = eye == Eye::kRight ? order.right : order.left;
    const Centration centration = CentrationOf(source, eye, notes);
    side.sphere = power;
    side.pd = centration.pd;
    side.height = centration.height;
  }
  LensChoice choice;
  choice.material = UsualMaterial(power);
  choice.as_prescribed = true;
  if (power == 0.0) choice.base_curve = kPlanoBase;
  const auto material = MaterialOf(choice);
  if (!material) return Fail(material);
  const FrameForLenses frame{{LensOutlineOf(source.frame, Eye::kRight), PositionOf(source, Eye::kRight)},
                             {LensOutlineOf(source.frame, Eye::kLeft), PositionOf(source, Eye::kLeft)},
                             BoxingOf(source.frame).dbl};
  return DesignLensPair(order, *material, frame, LensOptionsOf(choice));
}

Result<LensPair> PairOf(const GlassesSource& source, const LensLook& look, const std::string& path,
                        std::vector<std::string>& notes) {
  if (source.worn) {
    const auto kept = KeptOrderOf(*source.worn, path);
    if (!kept) return Fail(kept);
    if (*kept) {
      GlassesExportOptions options;
      options.prescription = (*kept)->order;
      options.lenses = (*kept)->choice;
      const auto pair = LensesOf(source, options);
      if (!pair) return Fail(pair);
      return **pair;
    }
  }
  if (!(std::abs(look.power) <= 30.0)) {
    return Fail("make the lenses", fmt::format("their power is {} D", look.power), "give -30 to 30 D");
  }
  return PairOfPower(source, look.power, notes);
}

/// The rim's centre and turn on a side: Rim::frame_from_rim or, unmirrored, its image at x = 0.
Eigen::Isometry3d FrameFromRim(const Rim& rim, Eye eye) {
  if (eye == Eye::kRight) return rim.frame_from_rim;
  const Eigen::DiagonalMatrix<double, 3> mirror(-1.0, 1.0, 1.0);
  Eigen::Isometry3d mirrored;
  mirrored.linear() = mirror * rim.frame_from_rim.linear() * mirror;
  mirrored.translation() = mirror * rim.frame_from_rim.translation();
  mirrored.makeAffine();
  return mirrored;
}

SolidLens SolidOf(const LensDesign& design, const LensOutline& outline, const LensMaterial& material,
                  const LensLook& look) {
  SolidLens lens;
  lens.form = design.form;
  lens.outline = outline;
  lens.abbe = material.abbe;
  if (material.line == SpectralLine::kE) {
    const DLineGlass glass = FromELine(material.index, material.abbe);
    lens.form.index = glass.index;
    lens.abbe = glass.abbe;
  }
  double area = 0.0;
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    const Vector2d& a = outline.points[i];
    const Vector2d& b = outline.points[i + 1 == outline.points.size() ? 0 : i + 1];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  const double top = design.box.centre.y() + 0.5 * design.box.b;
  lens.finish = LensFinishOf(look, top, top - design.box.b, design.body.volume / area);
  lens.group = design.eye == Eye::kRight ? "lens_right" : "lens_left";
  return lens;
}

}  // namespace

std::vector<double> GrooveDepths(const Rim& rim, Eye eye, const Vector2d& centre, const std::vector<double>& angles) {
  constexpr int kSteps = 180;
  struct Place {
    double angle;
    double depth;
  };
  std::vector<Place> places;
  const Eigen::Isometry3d rim_from_frame = rim.frame_from_rim.inverse();
  for (std::size_t k = 0; k < 4; ++k) {
    for (int step = 0; step < kSteps; ++step) {
      const Vector3d p = rim_from_frame * LensPoint(rim, k, static_cast<double>(step) / kSteps);
      const Vector2d q = Vector2d(eye == Eye::kRight ? -p.x() : p.x(), p.z()) - centre;
      const double angle = std::atan2(q.y(), q.x());
      places.push_back({angle < 0.0 ? angle + kTwoPi : angle, p.y()});
    }
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.angle < b.angle; });
  places.insert(places.begin(), {places.back().angle - kTwoPi, places.back().depth});
  places.push_back({places[1].angle + kTwoPi, places[1].depth});
  std::vector<double> depths;
  for (const double angle : angles) {
    const auto after = std::upper_bound(places.begin() + 1, places.end() - 1, angle,
                                        [](double value, const Place& place) { return value < place.angle; });
    const Place& low = *(after - 1);
    const double share = (angle - low.angle) / std::max(after->angle - low.angle, 1e-12);
    depths.push_back(low.depth + std::clamp(share, 0.0, 1.0) * (after->depth - low.depth));
  }
  return depths;
}

LensSeat SeatOf(const Frame& frame, const LensDesign& design, double bevel_width) {
  std::vector<double> angles;
  for (const EdgePoint& point : design.edge.points) angles.push_back(point.angle);
  const std::vector<double> groove = GrooveDepths(frame.rim, design.eye, design.box.centre, angles);
  // z of the lens that comes to y = 0 of the rim: the groove is then at groove + seat of the lens.
  double wanted = 0.0;
  double lowest = -kInfinity;
  double highest = kInfinity;
  for (std::size_t i = 0; i < groove.size(); ++i) {
    wanted += (design.bevel.apex_z[i] - groove[i]) / static_cast<double>(groove.size());
    lowest = std::max(lowest, design.edge.points[i].back_z - groove[i]);
    highest = std::min(highest, design.edge.points[i].front_z - groove[i]);
  }
  const double inside = std::min(0.5 * bevel_width, 0.5 * (highest - lowest));
  const double seat =
      highest > lowest ? std::clamp(wanted, lowest + inside, highest - inside) : 0.5 * (lowest + highest);
  Eigen::Isometry3d rim_from_lens = Eigen::Isometry3d::Identity();
  rim_from_lens.linear() << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  rim_from_lens.translation() = Vector3d(0.0, -seat, 0.0);
  return {FrameFromRim(frame.rim, design.eye) * rim_from_lens, std::min(seat - lowest, highest - seat)};
}

Result<WornLensSet> WornLenses(const GlassesSource& source, const LensLook& look, const std::string& path) {
  WornLensSet set;
  auto pair = PairOf(source, look, path, set.notes);
  if (!pair) return Fail(pair);
  set.design = std::move(*pair);
  const Eigen::Isometry3d station_from_frame =
      source.worn ? source.worn->worn.station_from_frame : Eigen::Isometry3d::Identity();
  for (const LensDesign* design : {&set.design.right, &set.design.left}) {
    SolidLens lens = SolidOf(*design, LensOutlineOf(source.frame, design->eye), set.design.material, look);
    const LensSeat seat = SeatOf(source.frame, *design, BevelRule{}.width);
    lens.station_from_lens = station_from_frame * seat.frame_from_lens;
    if (seat.edge_margin < -kNoticed) {
      set.notes.push_back(
          fmt::format("the curve of the {} lens (base {:.2f} D) does not follow its rim ({:.2f} D): the groove leaves "
                      "the lens' edge by "
                      "{:.1f} mm",
                      design->eye == Eye::kRight ? "right" : "left", design->base,
                      source.design.design.details.frame_curve, -seat.edge_margin));
    }
    set.lenses.push_back(std::move(lens));
  }
  return set;
}

}  // namespace annulus
