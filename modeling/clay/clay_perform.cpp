// Table 1 of paper 004: every operation as strokes, and every stroke as one deformation that keeps what it has to.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "modeling/clay/clay_closest.h"
#include "modeling/clay/clay_hole.h"
#include "modeling/clay/clay_operation.h"
#include "modeling/clay/clay_smooth.h"
#include "modeling/clay/clay_stroke.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kSpatulaLength = 3.0;  ///< Over its half width, where nothing else is said.
constexpr double kLeafOverRadius = 0.5;
constexpr double kMostSteps = 1000.0;  ///< Of a hole, and of a line in radii.

Status InAHole(const std::string& operation, const ClayAddress& at) {
  return Fail(fmt::format("perform '{}' on the clay", operation),
              fmt::format("patch {} at u {:g}, v {:g} is in a hole", at.patch, at.u, at.v), "give a place on the skin");
}

Status OutOfRange(const std::string& operation, const std::string& name, double value, const char* range) {
  return Fail(fmt::format("perform '{}' on the clay", operation), fmt::format("{} is {:g}", name, value),
              fmt::format("give a number {}", range));
}

/// Parameters held against their ranges; the first that is out of it is told.
class Ranges {
 public:
  explicit Ranges(std::string operation) : operation_(std::move(operation)) {}
  Ranges& Within(const char* name, double value, double low, double high) {
    if (status_ && !(value >= low && value <= high)) {
      status_ = OutOfRange(operation_, name, value, fmt::format("from {:g} to {:g}", low, high).c_str());
    }
    return *this;
  }
  /// Lengths and volumes: above 0, and below what would overflow.
  Ranges& Positive(const char* name, double value) {
    if (status_ && !(value > 0.0 && value <= 1e12)) status_ = OutOfRange(operation_, name, value, "above 0");
    return *this;
  }
  Ranges& Address(const ClayBody& body, const ClayAddress& at) {
    if (status_ && at.patch >= body.mesh().base_count()) {
      status_ = Fail(fmt::format("perform '{}' on the clay", operation_), fmt::format("there is no patch {}", at.patch),
                     fmt::format("give a number below {}", body.mesh().base_count()));
    }
    if (status_ && body.mesh().Locate(at).patch == kNoIndex) status_ = InAHole(operation_, at);
    return Within("u", at.u, 0.0, 1.0).Within("v", at.v, 0.0, 1.0);
  }
  Ranges& Hold(const ClayBody& body, const ToolHold& hold) {
    Address(body, hold.at).Positive("radius_mm", hold.radius_mm).Within("length_mm", hold.length_mm, 0.0, 1e6);
    if (status_ && hold.direction && !(hold.direction->norm() > 0.0 && hold.direction->allFinite())) {
      status_ = Fail(fmt::format("perform '{}' on the clay", operation_), "its direction has no length",
                     "give a direction, or none for the surface's own");
    }
    return *this;
  }
  [[nodiscard]] Status status() const { return status_; }

 private:
  std::string operation_;
  Status status_;
};

/// A hold as a place in space, `reach` mm deep.
ToolPlace PlaceOf(const ClayBody& body, const ToolHold& hold, double reach) {
  ToolPlace place;
  place.origin = body.Point(hold.at);
  place.out = hold.direction ? Vector3d(-hold.direction->normalized()) : body.Normal(hold.at);
  const ClayMesh::Leaf leaf = body.mesh().Locate(hold.at);
  const Vector3d along_u = BezierPatch(body.mesh().patch(leaf.patch).net).DerivativeU(leaf.u, leaf.v);
  Vector3d along = along_u - along_u.dot(place.out) * place.out;
  if (!(along.norm() > 1e-9 * (along_u.norm() + 1e-300))) along = place.out.unitOrthogonal();
  place.along = Eigen::AngleAxisd(hold.angle_rad, place.out) * along.normalized();
  const bool spatula = hold.tool == ClayTool::kSpatula;
  const double length = hold.length_mm > 0.0 ? 0.5 * hold.length_mm : kSpatulaLength * hold.radius_mm;
  place.radius_across = hold.radius_mm;
  place.radius_along = spatula ? std::max(length, hold.radius_mm) : hold.radius_mm;
  place.flatness = hold.tool == ClayTool::kFinger ? 1 : 3;
  place.reach = reach;
  return place;
}

StrokePlace AroundTool(const ToolHold& hold, const ToolPlace& place, double times) {
  return {hold.at, place.origin, times * std::max(place.radius_along, place.radius_across),
          kLeafOverRadius * std::min(place.radius_along, place.radius_across)};
}

/// Carries out acts on a body; what they report is gathered.
class Performer {
 public:
  Performer(ClayBody& body, const ClayPractice& practice)
      : body_(body), practice_(practice), mask_(body, practice.masks) {}

  Status operator()(const PushAct& act) {
    RETURN_IF_ERROR(Ranges(act.depth_mm < 0.0 ? "pull" : "push")
                        .Hold(body_, act.hold)
                        .Within("depth_mm", std::abs(act.depth_mm), 0.0, 1e4)
                        .Within("model", act.model, 1, 2)
                        .Within("rho", act.rho, 1.3, 100.0)
                        .status());
    const bool first_model = act.model == 1;
    const double times = first_model ? act.rho : 1.2;
    return Stroke(Holds(act.hold), [&](const ToolHold& hold, ClayStroke& stroke) {
      const double reach = std::max(2.0 * std::abs(act.depth_mm), times * hold.radius_mm);
      const ToolPlace place = PlaceOf(body_, hold, reach);
      stroke.places.push_back(AroundTool(hold, place, times));
      Add(stroke.direct, DentField(place, act.depth_mm));
      if (first_model) Add(stroke.indirect, RimField(place, act.rho));
    });
  }

  Status operator()(const HoleAct& act) {
    const std::size_t holes = body_.mesh().holes().size();
    const bool known = act.hold.at.patch < body_.mesh().base_count();
    const std::size_t hole = known ? body_.mesh().HoleAt(act.hold.at) : holes;
    if (act.how == HoleAct::How::kFill) return Fill(act, hole);
    const bool changes = act.how == HoleAct::How::kWiden || act.how == HoleAct::How::kClose;
    if (changes && hole < holes) return WidenThrough(act, hole);
    RETURN_IF_ERROR(Ranges("hole")
                        .Hold(body_, act.hold)
                        .Within("depth_mm", act.depth_mm, 0.0, 1e4)
                        .Within("factor", act.factor, 1.0 + 1e-9, 10.0)
                        .status());
    if (act.how == HoleAct::How::kThrough) return GoThrough(act);
    if (act.how != HoleAct::How::kMake) return Widen(act);
    // Step by step, as a finger does: each time the bottom is where the last step left it.
    const double step = 0.5 * act.hold.radius_mm;
    const double needed = std::max(1.0, std::ceil(act.depth_mm / step));
    RETURN_IF_ERROR(Ranges("hole").Within("depth_mm over half of radius_mm", needed, 1.0, kMostSteps).status());
    const int steps = static_cast<int>(needed);
    for (int n = 0; n < steps; ++n) {
      RETURN_IF_ERROR(Stroke(Holds(act.hold), [&](const ToolHold& hold, ClayStroke& stroke) {
        ToolPlace place = PlaceOf(body_, hold, 2.0 * act.hold.radius_mm);
        place.flatness = 3;
        stroke.places.push_back(AroundTool(hold, place, 1.2));
        Add(stroke.direct, DentField(place, act.depth_mm / steps));
      }));
    }
    return {};
  }

  Status operator()(const TwistAct& act) {
    RETURN_IF_ERROR(Ranges("twist").Within("angle_deg", act.angle_rad * 57.29577951308232, -360.0, 360.0).status());
    auto span = SpanOf("twist", act.axis);
    if (!span) return Fail(span);
    ClayStroke stroke;
    stroke.direct = TwistField(*span, act.angle_rad);
    stroke.indirect = GirthField(*span);
    return Do(stroke);
  }

  Status operator()(const BallAct& act) {
    RETURN_IF_ERROR(Ranges("ball").Within("amount", act.amount, 0.0, 1.0).status());
    ClayStroke stroke;
    const Eigen::AlignedBox3d box = Box();
    stroke.direct =
        BallField(box.center(), std::cbrt(3.0 * body_.kept_volume() / (4.0 * 3.14159265358979324)), act.amount);
    return Do(stroke);
  }

  Status operator()(const SpreadAct& act) {
    RETURN_IF_ERROR(Ranges("spread").Hold(body_, act.hold).Within("amount", act.amount, 0.0, 1.0).status());
    return Stroke(Holds(act.hold), [&](const ToolHold& hold, ClayStroke& stroke) {
      const ToolPlace place = PlaceOf(body_, hold, 2.0 * hold.radius_mm);
      stroke.places.push_back(AroundTool(hold, place, 2.0));
      Add(stroke.direct, FlattenField(place, act.amount));
      Add(stroke.indirect, WidenField(place, 1.0));
    });
  }

  Status operator()(const KneadAct& act) {
    RETURN_IF_ERROR(Ranges("knead")
                        .Within("amplitude_mm", act.amplitude_mm, 0.0, 1e4)
                        .Positive("wavelength_mm", act.wavelength_mm)
                        .status());
    ClayStroke stroke;
    stroke.direct = KneadField(act.amplitude_mm, act.wavelength_mm, act.seed);
    return Do(stroke);
  }

  Status operator()(const LineAct& act) {
    Ranges ranges("line");
    for (const ClayAddress& at : act.path) ranges.Address(body_, at);
    RETURN_IF_ERROR(ranges.Positive("radius_mm", act.radius_mm)
                        .Within("depth_mm", std::abs(act.depth_mm), 0.0, 1e4)
                        .Within("rho", act.rho, 1.3, 100.0)
                        .status());
    if (act.path.size() < 2) {
      return Fail("perform 'line' on the clay", fmt::format("its path has {} places", act.path.size()),
                  "give two or more");
    }
    double length = 0.0;
    for (std::size_t n = 0; n + 1 < act.path.size(); ++n) {
      length += (body_.Point(act.path[n + 1]) - body_.Point(act.path[n])).norm();
    }
    RETURN_IF_ERROR(
        Ranges("line").Within("its length over radius_mm", length / act.radius_mm, 0.0, kMostSteps).status());
    return act.how == LineAct::How::kDraw ? Draw(act) : Erase(act);
  }

  Status operator()(const AddAct& act) {
    RETURN_IF_ERROR(Ranges("add").Hold(body_, act.hold).Positive("volume_mm3", act.volume_mm3).status());
    const std::vector<ToolHold> holds = Holds(act.hold);
    const double kept = body_.kept_volume();
    body_.Keep(kept + act.volume_mm3 * static_cast<double>(holds.size()));
    // No direct motion: the bump is as high as its volume makes it.
    const Status done = Stroke(holds, [&](const ToolHold& hold, ClayStroke& stroke) {
      const ToolPlace place = PlaceOf(body_, hold, 4.0 * hold.radius_mm);
      stroke.places.push_back(AroundTool(hold, place, 1.2));
      Add(stroke.indirect, DentField(place, -1.0));
    });
    if (!done) body_.Keep(kept);
    return done;
  }

  Status operator()(const ShaveAct& act) {
    RETURN_IF_ERROR(Ranges("shave").Hold(body_, act.hold).Positive("depth_mm", act.depth_mm).status());
    return TakeOff(act.hold, act.depth_mm, {});
  }

  Status operator()(const TearAct& act) {
    RETURN_IF_ERROR(Ranges("tear").Hold(body_, act.hold).Positive("depth_mm", act.depth_mm).status());
    RETURN_IF_ERROR(TakeOff(act.hold, act.depth_mm, {}));
    if (act.hold.tool == ClayTool::kNippers) return {};
    return TakeOff(act.hold, 0.0, KneadField(0.15 * act.depth_mm, 0.7 * act.hold.radius_mm, act.seed));
  }

  Status operator()(const SmoothAct& act) {
    RETURN_IF_ERROR(Ranges("smooth")
                        .Hold(body_, act.hold)
                        .Within("amount", act.amount, 0.0, 1.0)
                        .Within("passes", act.passes, 1, 100)
                        .status());
    std::vector<SmoothSpot> spots;
    for (const ToolHold& hold : Holds(act.hold)) spots.push_back({hold.at, body_.Point(hold.at), hold.radius_mm});
    return Smooth(spots, act.amount, act.passes);
  }

  Status operator()(const StretchAct& act) {
    RETURN_IF_ERROR(Ranges("stretch").Within("factor", act.factor, 0.05, 20.0).status());
    auto span = SpanOf("stretch", act.axis);
    if (!span) return Fail(span);
    ClayStroke stroke;
    stroke.direct = StretchField(*span, act.factor);
    // What is longer gets thinner over the same clay, wherever that now is.
    stroke.indirect = GirthField(*span);
    return Do(stroke);
  }

  [[nodiscard]] const ClayReport& report() const { return report_; }

 private:
  [[nodiscard]] Eigen::AlignedBox3d Box() const {
    Eigen::AlignedBox3d box;
    for (const ClayPatch& patch : body_.mesh().patches()) {
      if (patch.node == kNoIndex) continue;
      for (const auto& row : patch.net) box.extend(row[0]).extend(row[3]);
    }
    return box;
  }

  static void Add(ClayField& sum, ClayField one) {
    if (!sum) {
      sum = std::move(one);
      return;
    }
    sum = [a = std::move(sum), b = std::move(one)](const Vector3d& place) {
      const PointMotion first = a(place);
      const PointMotion second = b(place);
      return PointMotion{first.move + second.move, first.gradient + second.gradient};
    };
  }

  /// The hold, and its image beyond x = 0 where the practice wants it.
  [[nodiscard]] std::vector<ToolHold> Holds(const ToolHold& hold) const {
    std::vector<ToolHold> holds{hold};
    if (!practice_.mirrored) return holds;
    const Vector3d mirror(-1.0, 1.0, 1.0);
    ToolHold image = hold;
    image.at = ClosestAddress(body_, body_.Point(hold.at).cwiseProduct(mirror));
    image.angle_rad = -hold.angle_rad;
    if (image.direction) image.direction = image.direction->cwiseProduct(mirror);
    holds.push_back(image);
    return holds;
  }

  template <class Fill>
  Status Stroke(const std::vector<ToolHold>& holds, Fill fill) {
    ClayStroke stroke;
    for (const ToolHold& hold : holds) fill(hold, stroke);
    return Do(stroke);
  }

  Status Do(const ClayStroke& stroke) {
    const auto change = Carry(body_, stroke, mask_);
    if (!change) return Fail(change);
    report_.k = change->k;
    report_.touched = std::max(report_.touched, change->patches_touched);
    return {};
  }

  Status Widen(const HoleAct& act) {
    const double factor = act.how == HoleAct::How::kWiden ? act.factor : 1.0 / act.factor;
    return Stroke(Holds(act.hold), [&](const ToolHold& hold, ClayStroke& stroke) {
      const ToolPlace place = PlaceOf(body_, hold, std::max(act.depth_mm, 2.0 * hold.radius_mm));
      StrokePlace around = AroundTool(hold, place, 2.0);
      around.radius_mm += 2.0 * place.reach;
      stroke.places.push_back(around);
      Add(stroke.direct, WidenField(place, factor - 1.0));
    });
  }

  Status GoThrough(const HoleAct& act) {
    for (const ToolHold& hold : Holds(act.hold)) {
      if (body_.mesh().Locate(hold.at).patch == kNoIndex) return InAHole("hole", hold.at);
      const auto plan = PlanHole(body_, hold.at, -PlaceOf(body_, hold, 1.0).out, hold.radius_mm);
      if (!plan) return Fail(plan);
      RETURN_IF_ERROR(body_.OpenHole(*plan));
      RETURN_IF_ERROR(SizeHole(body_.mesh().holes().size() - 1, hold.radius_mm));
    }
    return {};
  }

  /// A hole that goes through gets a radius, in steps that do not fold the skin around it; what it takes out or leaves
  /// free swells or shrinks the body.
  Status SizeHole(std::size_t hole, double radius) {
    constexpr int kSteps = 20;
    for (int step = 0; step < kSteps; ++step) {
      const HoleLine line = LineOf(body_, hole);
      const double now = line.radius_mm;
      if (!(now > 0.0)) break;
      const double factor = std::clamp(radius / now, 0.5, 1.25);
      ToolPlace place;
      place.origin = 0.5 * (line.from + line.to);
      place.out = (line.from - line.to).normalized();
      place.along = place.out.unitOrthogonal();
      place.radius_along = place.radius_across = factor > 1.0 ? now : 1.5 * now;
      place.reach = 0.6 * (line.to - line.from).norm() + now;
      ClayStroke stroke;
      stroke.places.push_back({line.middle, place.origin, 2.0 * place.reach + 6.0 * now, 1e12});
      if (factor > 1.0) {
        stroke.places.push_back({line.first, line.from, 6.0 * now, now});
        stroke.places.push_back({line.last, line.to, 6.0 * now, now});
        stroke.direct = MakeRoomField(place, factor - 1.0);
      } else {
        // What only comes nearer is fine enough.
        stroke.direct = WidenField(place, factor - 1.0);
      }
      RETURN_IF_ERROR(Do(stroke));
      if (factor == radius / now) return {};
    }
    return Fail("perform 'hole' on the clay", fmt::format("it does not get a radius of {:g} mm", radius),
                "take a tool nearer to the size of the hole, or another place");
  }

  /// Holes that go through are held by the places that they have taken out.
  Status WidenThrough(const HoleAct& act, std::size_t hole) {
    RETURN_IF_ERROR(CheckRims(hole));
    RETURN_IF_ERROR(Ranges("hole").Within("factor", act.factor, 1.0 + 1e-9, 10.0).status());
    const double factor = act.how == HoleAct::How::kWiden ? act.factor : 1.0 / act.factor;
    return SizeHole(hole, factor * LineOf(body_, hole).radius_mm);
  }

  [[nodiscard]] Status CheckRims(std::size_t hole) const {
    if (HasWholeRims(body_.mesh(), hole)) return {};
    return Fail("perform 'hole' on the clay", "another hole goes through its wall", "close that one first");
  }

  /// What fills it shrinks the body.
  Status Fill(const HoleAct& act, std::size_t hole) {
    if (hole >= body_.mesh().holes().size()) {
      return Fail("perform 'hole' on the clay",
                  fmt::format("no hole goes through at patch {}, u {:g}, v {:g}", act.hold.at.patch, act.hold.at.u,
                              act.hold.at.v),
                  "give a place that the hole has taken out, such as the one where it was made");
    }
    RETURN_IF_ERROR(CheckRims(hole));
    RETURN_IF_ERROR(body_.FillHole(hole));
    return Do({});
  }

  Status TakeOff(const ToolHold& hold, double depth, const ClayField& roughness) {
    return Stroke(Holds(hold), [&](const ToolHold& one, ClayStroke& stroke) {
      const ToolPlace place = PlaceOf(body_, one, 4.0 * (depth + one.radius_mm));
      stroke.places.push_back(AroundTool(one, place, 1.25));
      stroke.rule = VolumeRule::kFreed;
      if (roughness) {
        const ClayField dent = DentField(place, 1.0);
        Add(stroke.direct, [dent, roughness](const Vector3d& at) {
          const PointMotion share = dent(at);
          const double weight = share.move.norm();
          const PointMotion rough = roughness(at);
          return PointMotion{weight * rough.move, weight * rough.gradient};
        });
      } else {
        Add(stroke.direct, ShaveField(place, depth, 0.25 * depth));
      }
    });
  }

  Status Smooth(const std::vector<SmoothSpot>& spots, double amount, int passes) {
    for (int pass = 0; pass < passes; ++pass) {
      const auto change = SmoothOnce(body_, spots, amount, mask_);
      if (!change) return Fail(change);
      report_.k = change->k;
      report_.touched = std::max(report_.touched, change->patches_touched);
    }
    return {};
  }

  /// Places along the path, no farther apart than half the radius, on the surface.
  [[nodiscard]] std::vector<ClayAddress> PlacesAlong(const LineAct& act) const {
    std::vector<ClayAddress> places{act.path.front()};
    for (std::size_t n = 0; n + 1 < act.path.size(); ++n) {
      const Vector3d from = body_.Point(act.path[n]);
      const Vector3d to = body_.Point(act.path[n + 1]);
      const auto steps = static_cast<int>(std::ceil(2.0 * (to - from).norm() / act.radius_mm));
      for (int s = 1; s < steps; ++s) {
        places.push_back(ClosestAddress(body_, from + (to - from) * (static_cast<double>(s) / steps)));
      }
      places.push_back(act.path[n + 1]);
    }
    return places;
  }

  Status Draw(const LineAct& act) {
    std::vector<ToolHold> holds;
    for (const ClayAddress& at : PlacesAlong(act)) {
      ToolHold hold;
      hold.at = at;
      hold.radius_mm = act.radius_mm;
      for (const ToolHold& one : Holds(hold)) holds.push_back(one);
    }
    std::vector<ToolPlace> groove;
    ClayStroke stroke;
    for (const ToolHold& hold : holds) {
      ToolPlace place = PlaceOf(body_, hold, std::max(2.0 * std::abs(act.depth_mm), act.rho * act.radius_mm));
      place.flatness = act.tool == ClayTool::kFinger ? 1 : 3;
      stroke.places.push_back(AroundTool(hold, place, act.rho));
      groove.push_back(place);
    }
    // At each place the nearest piece of the line rules.
    const auto nearest = [groove](const Vector3d& at) -> const ToolPlace& {
      return *std::min_element(groove.begin(), groove.end(), [&at](const ToolPlace& a, const ToolPlace& b) {
        return (a.origin - at).squaredNorm() < (b.origin - at).squaredNorm();
      });
    };
    stroke.direct = [=, depth = act.depth_mm](const Vector3d& at) { return DentField(nearest(at), depth)(at); };
    stroke.indirect = [=, rho = act.rho](const Vector3d& at) { return RimField(nearest(at), rho)(at); };
    return Do(stroke);
  }

  Status Erase(const LineAct& act) {
    std::vector<SmoothSpot> spots;
    for (const ClayAddress& at : PlacesAlong(act)) {
      ToolHold hold;
      hold.at = at;
      for (const ToolHold& one : Holds(hold)) spots.push_back({one.at, body_.Point(one.at), 2.0 * act.radius_mm});
    }
    return Smooth(spots, 0.7, 12);
  }

  static Result<AxisSpan> SpanOf(const char* operation, const ClayAxis& axis) {
    const Vector3d way = axis.to - axis.from;
    if (!(way.norm() > 0.0) || !way.allFinite() || !axis.from.allFinite()) {
      return Fail(fmt::format("perform '{}' on the clay", operation), "its axis has no length",
                  "give two places that differ");
    }
    return AxisSpan{axis.from, way.normalized(), way.norm()};
  }

  ClayBody& body_;
  const ClayPractice& practice_;
  MaskWeight mask_;
  ClayReport report_;
};

/// One stroke is whole or nothing; what consists of several goes back to where it began.
bool HasSeveralStrokes(const ClayAct& act) {
  if (std::holds_alternative<HoleAct>(act)) return true;
  if (const auto* line = std::get_if<LineAct>(&act)) return line->how == LineAct::How::kErase;
  if (const auto* smooth = std::get_if<SmoothAct>(&act)) return smooth->passes > 1;
  return std::holds_alternative<TearAct>(act);
}

}  // namespace

Result<ClayReport> Perform(ClayBody& body, const ClayAct& act, const ClayPractice& practice) {
  Ranges masks(NameOf(act));
  for (const ClayMask& mask : practice.masks)
    masks.Address(body, mask.at).Positive("a mask's radius_mm", mask.radius_mm);
  RETURN_IF_ERROR(masks.Within("merge_mm", practice.merge_mm, 0.0, 1e3).status());
  const double volume = body.volume();
  const double kept = body.kept_volume();
  std::optional<ClayBody> safe;
  if (HasSeveralStrokes(act)) safe = body;
  Performer performer(body, practice);
  const Status done = std::visit(performer, act);
  if (!done && safe) body = std::move(*safe);
  body.MergeTouched(practice.merge_mm);
  if (!done) return Fail(done);
  ClayReport report = performer.report();
  report.volume_before_mm3 = volume;
  report.volume_after_mm3 = body.volume();
  report.moved_mm3 = body.kept_volume() - kept;
  report.patches = body.mesh().leaf_count();
  return report;
}

std::string NameOf(const ClayAct& act) {
  struct Namer {
    std::string operator()(const PushAct& push) const { return push.depth_mm < 0.0 ? "pull" : "push"; }
    std::string operator()(const HoleAct&) const { return "hole"; }
    std::string operator()(const TwistAct&) const { return "twist"; }
    std::string operator()(const BallAct&) const { return "ball"; }
    std::string operator()(const SpreadAct&) const { return "spread"; }
    std::string operator()(const KneadAct&) const { return "knead"; }
    std::string operator()(const LineAct&) const { return "line"; }
    std::string operator()(const AddAct&) const { return "add"; }
    std::string operator()(const ShaveAct&) const { return "shave"; }
    std::string operator()(const TearAct&) const { return "tear"; }
    std::string operator()(const SmoothAct&) const { return "smooth"; }
    std::string operator()(const StretchAct&) const { return "stretch"; }
  };
  return std::visit(Namer{}, act);
}

}  // namespace annulus
