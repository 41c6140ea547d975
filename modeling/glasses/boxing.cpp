#include "modeling/glasses/boxing.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "modeling/glasses/frame_assembly.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Points on each of the rim's four tubes, as LensOutlineOf takes them: the same box to the last bit.
constexpr int kOutlineSteps = 180;
/// Where the search for a box stops, mm, and gives up.
constexpr double kSolved = 1e-9;
constexpr int kMostSteps = 100;

/// What of the boxing depends on the rim, without the outline's length and longest radius.
struct RimBox {
  double a = 0.0;
  double b = 0.0;
  double dbl = 0.0;
};

RimBox BoxOfRim(const Rim& rim) {
  const Eigen::Isometry3d rim_from_frame = rim.frame_from_rim.inverse();
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < 4; ++k) {
    for (int step = 0; step < kOutlineSteps; ++step) {
      box.extend(rim_from_frame * LensPoint(rim, k, static_cast<double>(step) / kOutlineSteps));
    }
  }
  return {box.sizes().x(), box.sizes().z(), DistanceBetweenLenses(rim)};
}

/// The shape of `design` in a rectangle of l1 × l2: corners as shares of the shorter side, heights as shares of l2.
FrameDesign Reshaped(const FrameDesign& design, double width, double height) {
  FrameDesign changed = design;
  const FrameParameters& from = design.parameters;
  FrameParameters& p = changed.parameters;
  const double corner = std::min(width, height) / std::min(from.width, from.height);
  const double vertical = height / from.height;
  p.width = width;
  p.height = height;
  for (double FrameParameters::*cut : {&FrameParameters::upper_outer, &FrameParameters::upper_inner,
                                       &FrameParameters::lower_outer, &FrameParameters::lower_inner}) {
    p.*cut *= corner;
  }
  p.bridge_height *= vertical;
  if (changed.details.arm_height) *changed.details.arm_height *= vertical;
  return changed;
}

tl::unexpected<Error> NoSuchBox(const WantedBox& wanted, std::string seen, std::string advice) {
  return Fail(fmt::format("size the frame to a lens width of {:.1f} mm", wanted.a), std::move(seen), std::move(advice));
}

/// "52" of "52□18-140"; removes it from `text`. Empty if no number is there.
std::optional<double> TakeNumber(std::string_view& text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  double value = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
  while (text.starts_with(' ')) text.remove_prefix(1);
  return value;
}

bool TakeMark(std::string_view& text, std::initializer_list<std::string_view> marks) {
  for (const std::string_view mark : marks) {
    if (!text.starts_with(mark)) continue;
    text.remove_prefix(mark.size());
    return true;
  }
  return false;
}

}  // namespace

double DistanceBetweenLenses(const Rim& rim) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k) {
    for (int step = 0; step < kOutlineSteps; ++step) {
      nearest = std::min(nearest, LensPoint(rim, k, static_cast<double>(step) / kOutlineSteps).x());
    }
  }
  return 2.0 * nearest;
}

FrameBoxing BoxingOf(const Frame& frame) {
  const LensBox box = BoxOf(LensOutlineOf(frame, Eye::kRight));
  const double dbl = DistanceBetweenLenses(frame.rim);
  return {box.a, box.b, box.ed, box.circumference, dbl, box.a + dbl, box.centre.y()};
}

Result<FrameBoxing> BoxingOf(const FrameDesign& design) {
  RETURN_IF_ERROR(Validate(design));
  const Result<Frame> frame = BuildFrame(design, StandardAdjustment(design));
  if (!frame) return Fail(frame);
  return BoxingOf(*frame);
}

std::string SizeText(const FrameBoxing& boxing, std::optional<double> temple) {
  const std::string lenses = fmt::format("{:.0f}□{:.0f}", std::round(boxing.a), std::round(boxing.dbl));
  return temple ? fmt::format("{}-{:.0f}", lenses, std::round(*temple)) : lenses;
}

Result<SoldSize> ParseSize(std::string_view text) {
  std::string_view rest = text;
  SoldSize size;
  size.name = text;
  const auto a = TakeNumber(rest);
  const bool square = a && TakeMark(rest, {"□", "-", "x", "/"});
  const auto dbl = square ? TakeNumber(rest) : std::nullopt;
  const bool dash = dbl && TakeMark(rest, {"-", "/"});
  const auto temple = dash ? TakeNumber(rest) : std::nullopt;
  if (!temple || !rest.empty()) {
    return Fail("read the size", fmt::format("'{}' is not a size", text),
                "give lens width, distance between lenses and temple length such as 50-18-145");
  }
  size.a = *a;
  size.dbl = *dbl;
  size.temple = *temple;
  RETURN_IF_ERROR(Validate(size));
  return size;
}

Result<FrameDesign> DesignForBox(const FrameDesign& design, const WantedBox& wanted) {
  RETURN_IF_ERROR(Validate(design));
  const RimBox start = BoxOfRim(MakeRim(design));
  const double b = wanted.b.value_or(wanted.a * start.b / start.a);
  if (!(wanted.a > 0.0) || !(b > 0.0) || !(wanted.dbl.value_or(1.0) > 0.0)) {
    return NoSuchBox(wanted, "a box has positive sides", "give A, B and DBL in mm");
  }
  double width = design.parameters.width * wanted.a / start.a;
  double height = design.parameters.height * b / start.b;
  FrameDesign sized = design;
  for (int step = 0; step < kMostSteps; ++step) {
    const std::optional<double> gap = sized.details.bridge_gap;
    sized = Reshaped(design, width, height);
    sized.details.bridge_gap = gap;
    const RimBox box = BoxOfRim(MakeRim(sized));
    const double miss_a = wanted.a - box.a;
    const double miss_b = b - box.b;
    const double miss_dbl = wanted.dbl ? *wanted.dbl - box.dbl : 0.0;
    if (std::max({std::abs(miss_a), std::abs(miss_b), std::abs(miss_dbl)}) < kSolved) {
      if (const Status valid = Validate(sized); !valid)
        return NoSuchBox(wanted, valid.error().seen, valid.error().advice);
      return sized;
    }
    // The box grows nearly as the rectangle does; what is left shrinks by 0.1 or less at every step.
    width += miss_a;
    height += miss_b;
    if (wanted.dbl) sized.details.bridge_gap = sized.bridge_gap() + miss_dbl;
    if (!(width > 1.0) || !(height > 1.0) || !(width < 1000.0) || !(height < 1000.0)) break;
  }
  return NoSuchBox(wanted, "no rim of this shape has such a box", "choose another size, or thinner rims");
}

Result<FrameDesign> ScaledToBox(const FrameDesign& design, double a) { return DesignForBox(design, {a, {}, {}}); }

Result<FrameAdjustment> AdjustmentForTemple(const FrameDesign& design, double length) {
  RETURN_IF_ERROR(Validate(design));
  FrameAdjustment adjustment = StandardAdjustment(design);
  const TubeSection root = TempleRoot(design, MakeRim(design));
  for (int step = 0; step < kMostSteps; ++step) {
    const Result<FrameArm> arm = MakeArm(design, root, adjustment.temple_right, "right");
    if (!arm) return Fail(arm);
    const double miss = length - arm->overall_length;
    if (std::abs(miss) < kSolved) return adjustment;
    adjustment.temple_right.ear.y() -= miss;
    adjustment.temple_left.ear.y() = adjustment.temple_right.ear.y();
  }
  return Fail("size the temples", fmt::format("no ear point makes them {:.1f} mm long", length),
              "choose another temple length or a shorter tip");
}

}  // namespace annulus
