#include "station/glasses_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "modeling/glasses/boxing.h"
#include "station/drawing_marks.h"
#include "station/glasses_views.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Align = SheetText::Align;
using Weight = SheetText::Weight;

constexpr SheetColour kInk{0.1, 0.12, 0.15};
constexpr SheetColour kSoft{0.38, 0.42, 0.48};
constexpr SheetColour kEstimate{0.72, 0.32, 0.06};

constexpr double kPageWidth = SheetCanvas::kHeight;  // landscape
constexpr double kPageHeight = SheetCanvas::kWidth;
constexpr double kMargin = 10.0;
constexpr double kTitleWidth = 84.0;
constexpr double kTitleHeight = 30.0;

std::string Millimetres(double value) { return fmt::format("{:.1f}", value); }

/// A view of the frame at its place on the page.
class PlacedView {
 public:
  PlacedView(SheetCanvas& canvas, FrameView view, const Vector2d& origin)
      : canvas_(canvas), view_(view), origin_(origin) {}

  [[nodiscard]] Vector2d OnPage(const Vector2d& p) const { return origin_ + Vector2d(p.x(), -p.y()); }
  [[nodiscard]] Vector2d At(const Vector3d& p) const { return OnPage(InView(view_, p)); }

  void Draw(const ViewLines& lines) const {
    for (const auto& [a, b] : lines.creases) canvas_.Stroke({OnPage(a), OnPage(b)}, {0.15, kInk});
    for (const auto& [a, b] : lines.outlines) canvas_.Stroke({OnPage(a), OnPage(b)}, {0.3, kInk});
  }

 private:
  SheetCanvas& canvas_;
  FrameView view_;
  Vector2d origin_;
};

/// The pages, one after the other.
class DrawingPages {
 public:
  DrawingPages(SheetCanvas& canvas, const GlassesSource& source, const GlassesExportOptions& options)
      : canvas_(canvas), marks_(canvas), source_(source), options_(options), boxing_(BoxingOf(source.frame)) {}

  void First();
  void Second();
  void Third();

 private:
  void Border(int page);
  void Front(const Vector2d& origin);
  void Pupil(const PlacedView& view, Eye eye, double y);
  void Side(double left, double top);
  void Top(double centre, double top);
  void Lens(const Vector2d& centre);
  void Facts(const Vector2d& corner);
  /// Corners of a lens' box in the front view, lower left and upper right as seen.
  [[nodiscard]] std::array<Vector2d, 2> BoxInFront(Eye eye) const;
  [[nodiscard]] std::string Name() const;
  /// A width of a lens in the front view; it is A only if the lens is not turned.
  [[nodiscard]] std::string WidthText(double width) const;

  SheetCanvas& canvas_;
  DrawingMarks marks_;
  const GlassesSource& source_;
  const GlassesExportOptions& options_;
  FrameBoxing boxing_;
};

std::string DrawingPages::Name() const {
  const std::string& style = source_.design.design.style;
  return style.empty() ? "frame" : style;
}

std::string DrawingPages::WidthText(double width) const {
  return (std::abs(width - boxing_.a) < 0.05 ? "A " : "") + Millimetres(width);
}

void DrawingPages::Border(int page) {
  const double right = kPageWidth - kMargin;
  const double bottom = kPageHeight - kMargin;
  canvas_.Stroke({{kMargin, kMargin}, {right, kMargin}, {right, bottom}, {kMargin, bottom}, {kMargin, kMargin}},
                 {0.35, kInk});
  const double left = right - kTitleWidth;
  const double top = bottom - kTitleHeight;
  canvas_.Stroke({{left, bottom}, {left, top}, {right, top}}, {0.35, kInk});
  canvas_.Stroke({{left, top + 11.0}, {right, top + 11.0}}, {0.18, kInk});
  canvas_.Stroke({{left, top + 20.5}, {right, top + 20.5}}, {0.18, kInk});
  canvas_.Text({left + 3.0, top + 7.6}, Name(), {14.0, kInk, Weight::kBold});
  canvas_.Text({right - 3.0, top + 7.6}, SizeMark(source_.frame), {14.0, kInk, Weight::kBold, Align::kRight});
  const auto field = [&](double x, double y, const std::string& label, const std::string& value) {
    canvas_.Text({x, y + 3.2}, label, {5.5, kSoft});
    canvas_.Text({x, y + 7.4}, value, {8.5, kInk});
  };
  const auto& material = source_.design.material;
  field(left + 3.0, top + 11.6, "material", material ? std::string(DesignMaterialWord(*material)) : "not given");
  field(left + 30.0, top + 11.6, "reference", options_.reference.empty() ? "–" : options_.reference);
  field(left + 3.0, top + 21.0, "scale", "1:1");
  field(left + 15.0, top + 21.0, "lengths", "mm");
  field(left + 30.0, top + 21.0, "projection", "third angle");
  field(left + 52.0, top + 21.0, "made by", "annulus");
  field(left + 70.0, top + 21.0, "sheet", fmt::format("{} of 3", page));
  marks_.ScaleBar({kMargin + 12.0, bottom - 6.0});
}

std::array<Vector2d, 2> DrawingPages::BoxInFront(Eye eye) const {
  const Frame& frame = source_.frame;
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : LensOutlineOf(frame, eye).points) {
    Vector3d at = frame.rim.frame_from_rim * Vector3d(eye == Eye::kRight ? -p.x() : p.x(), 0.0, p.y());
    if (eye == Eye::kLeft) at.x() = -at.x();
    box.extend(InView(FrameView::kFront, at));
  }
  return {box.min(), box.max()};
}

void DrawingPages::Pupil(const PlacedView& view, Eye eye, double y) {
  const auto pupil = PupilOf(source_, eye);
  if (!pupil) return;
  const Vector2d at = view.At(pupil->in_frame);
  marks_.Cross(at, 5.0);
  canvas_.StrokeCircle(at, 1.2, {0.2, kInk});
  const auto box = BoxInFront(eye);
  const Vector2d middle = view.OnPage({0.0, box[1].y()});
  marks_.Level({middle.x(), middle.y() - 1.0}, at, y, Millimetres(pupil->pd));
  const double x = at.x() + (eye == Eye::kRight ? 9.0 : -9.0);
  marks_.Upright(at, {at.x(), view.OnPage(box[0]).y()}, x, Millimetres(pupil->height));
}

void DrawingPages::Front(const Vector2d& origin) {
  const PlacedView view(canvas_, FrameView::kFront, origin);
  const ViewLines lines = VisibleLines(FrameBodies(source_.frame), FrameView::kFront);
  view.Draw(lines);
  const Vector2d low = view.OnPage(lines.box.min());
  const Vector2d high = view.OnPage(lines.box.max());
  marks_.CentreLine({origin.x(), high.y() - 3.0}, {origin.x(), low.y() + 3.0});
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    const auto box = BoxInFront(eye);
    const Vector2d a = view.OnPage(box[0]);
    const Vector2d b = view.OnPage(box[1]);
    const SheetStroke dashed{0.15, kSoft, SheetStroke::Dash::kDashed};
    canvas_.Stroke({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, dashed);
    Pupil(view, eye, high.y() - 7.0);
  }
  const auto right = BoxInFront(Eye::kRight);
  const auto left = BoxInFront(Eye::kLeft);
  const auto lower = [&view](const Vector2d& p) { return view.OnPage(p); };
  const double first = low.y() + 7.0;
  marks_.Level(lower(right[0]), lower({right[1].x(), right[0].y()}), first, WidthText(right[1].x() - right[0].x()));
  marks_.Level(lower({right[1].x(), right[0].y()}), lower(left[0]), first, "DBL " + Millimetres(boxing_.dbl));
  marks_.Level(lower(left[0]), lower({left[1].x(), left[0].y()}), first, WidthText(left[1].x() - left[0].x()));
  marks_.Level({low.x(), origin.y()}, {high.x(), origin.y()}, first + 7.5, Millimetres(lines.box.sizes().x()));
  marks_.Upright(lower(right[0]), lower({right[0].x(), right[1].y()}), low.x() - 6.0,
                 "B " + Millimetres(right[1].y() - right[0].y()));
  if (PupilOf(source_, Eye::kRight)) {
    const bool confirmed = !options_.confirmed_by.empty();
    canvas_.Text({origin.x(), high.y() - 12.5},
                 confirmed ? "PD and heights confirmed by " + options_.confirmed_by
                           : "PD and heights: estimate, confirm by optician",
                 {7.5, confirmed ? kInk : kEstimate, Weight::kRegular, Align::kCentre});
  }
}

void DrawingPages::Side(double left, double top) {
  const ViewLines lines = VisibleLines(FrameBodies(source_.frame), FrameView::kSide);
  const PlacedView view(canvas_, FrameView::kSide, {left - lines.box.min().x(), top + lines.box.max().y()});
  view.Draw(lines);
  const FrameArm& arm = source_.frame.arm_right;
  const Vector2d low = view.OnPage(lines.box.min());
  const Vector2d high = view.OnPage(lines.box.max());
  const Vector2d ear = view.At(arm.ear_point);
  marks_.Cross(ear, 4.0);
  canvas_.Text({ear.x() + 2.5, ear.y() + 4.0}, "rests on the ear", {7.0, kSoft});
  const double y = low.y() + 8.0;
  marks_.Level({low.x(), 0.5 * (low.y() + high.y()) + 10.0}, ear, y,
               Millimetres(arm.ear_point.y() - lines.box.min().x()));
  marks_.Level(ear, {high.x(), ear.y()}, y, Millimetres(lines.box.max().x() - arm.ear_point.y()));
  marks_.Level({low.x(), low.y()}, {high.x(), ear.y()}, y + 7.5, Millimetres(lines.box.sizes().x()));
  marks_.Upright({low.x() + 1.0, low.y()}, ear, low.x() - 6.0, Millimetres(arm.ear_point.z() - lines.box.min().y()));
  canvas_.Text({left, top - 3.0},
               fmt::format("right temple {:.1f}, of that {:.1f} from the hinge to the bend, along its middle",
                           arm.overall_length, arm.length_to_bend),
               {7.5, kInk});
}

void DrawingPages::Top(double centre, double top) {
  const ViewLines lines = VisibleLines(FrameBodies(source_.frame), FrameView::kTop);
  const PlacedView view(canvas_, FrameView::kTop, {centre, top + lines.box.max().y()});
  view.Draw(lines);
  const Vector2d low = view.OnPage(lines.box.min());
  const Vector2d high = view.OnPage(lines.box.max());
  marks_.CentreLine({centre, high.y()}, {centre, low.y() + 3.0});
  marks_.Level({low.x(), low.y() - 6.0}, {high.x(), low.y() - 6.0}, low.y() + 6.0, Millimetres(lines.box.sizes().x()));
  marks_.Upright({low.x(), high.y()}, {low.x() + 20.0, low.y()}, low.x() - 6.0, Millimetres(lines.box.sizes().y()));
  const Frame& frame = source_.frame;
  marks_.Level(view.At(frame.arm_right.ear_point), view.At(frame.arm_left.ear_point),
               view.At(frame.arm_right.ear_point).y() - 10.0,
               Millimetres(frame.arm_right.ear_point.x() - frame.arm_left.ear_point.x()) + " at the ears");
}

void DrawingPages::Lens(const Vector2d& centre) {
  const LensOutline outline = LensOutlineOf(source_.frame, Eye::kRight);
  const LensBox box = BoxOf(outline);
  const auto place = [&](const Vector2d& p) -> Vector2d {
    return centre + Vector2d(p.x() - box.centre.x(), box.centre.y() - p.y());
  };
  std::vector<Vector2d> closed;
  for (const Vector2d& p : outline.points) closed.push_back(place(p));
  closed.push_back(closed.front());
  canvas_.Stroke(closed, {0.3, kInk});
  const Vector2d half(0.5 * box.a, 0.5 * box.b);
  const Vector2d low = centre - half;
  const Vector2d high = centre + half;
  canvas_.Stroke({low, {high.x(), low.y()}, high, {low.x(), high.y()}, low}, {0.15, kSoft, SheetStroke::Dash::kDashed});
  canvas_.StrokeCircle(centre, 0.5 * box.ed, {0.15, kSoft, SheetStroke::Dash::kDashed});
  marks_.CentreLine(centre - Vector2d(half.x() + 4.0, 0.0), centre + Vector2d(half.x() + 4.0, 0.0));
  marks_.CentreLine(centre - Vector2d(0.0, half.y() + 4.0), centre + Vector2d(0.0, half.y() + 4.0));
  const double radius = 0.5 * box.ed;
  marks_.Level({low.x(), high.y()}, high, centre.y() + radius + 7.0, "A " + Millimetres(box.a));
  marks_.Upright({high.x(), low.y()}, high, centre.x() + radius + 7.0, "B " + Millimetres(box.b));
  canvas_.Text({centre.x(), centre.y() + radius + 15.0},
               fmt::format("ED {:.1f}   circumference {:.1f}", box.ed, box.circumference),
               {8.0, kInk, Weight::kRegular, Align::kCentre});
  canvas_.Text({centre.x(), centre.y() - radius - 8.5}, "right lens in its plane, from the front",
               {9.0, kInk, Weight::kBold, Align::kCentre});
  canvas_.Text({centre.x(), centre.y() - radius - 4.5},
               source_.design.design.details.groove_depth > 0.0 ? "apex of the bevel (bottom of the groove)"
                                                                : "inner outline of the rim (no groove)",
               {7.0, kSoft, Weight::kRegular, Align::kCentre});
}

void DrawingPages::Facts(const Vector2d& corner) {
  const FrameDesign& design = source_.design.design;
  const FrameDetails& details = design.details;
  std::vector<std::pair<std::string, std::string>> rows = {
      {"lens width A", Millimetres(boxing_.a)},
      {"lens height B", Millimetres(boxing_.b)},
      {"effective diameter ED", Millimetres(boxing_.ed)},
      {"distance between lenses DBL", Millimetres(boxing_.dbl)},
      {"lens circumference", Millimetres(boxing_.circumference)},
      {"temple right / left",
       fmt::format("{:.1f} / {:.1f}", source_.frame.arm_right.overall_length, source_.frame.arm_left.overall_length)},
      {"to bend right / left",
       fmt::format("{:.1f} / {:.1f}", source_.frame.arm_right.length_to_bend, source_.frame.arm_left.length_to_bend)},
      {"rim thickness above / below",
       fmt::format("{:.1f} / {:.1f}", design.parameters.upper_thickness, design.parameters.lower_thickness)},
      {"rim depth, front to back", fmt::format("{:.2f}", 0.75 * design.depth())},
      {"groove width × depth", details.groove_depth > 0.0
                                   ? fmt::format("{:.1f} × {:.1f}", details.groove_width, details.groove_depth)
                                   : "none"},
      {"frame curve", fmt::format("{:.1f} D", details.frame_curve)},
      {"face form angle", fmt::format("{:.1f}°", DegreesFromRadians(details.face_form))}};
  if (source_.worn)
    rows.emplace_back("tilt as worn",
                      fmt::format("{:.1f}°", DegreesFromRadians(PositionOf(source_, Eye::kRight).pantoscopic_tilt)));
  constexpr double kRow = 5.2;
  constexpr double kWidth = 74.0;
  canvas_.Text(corner, "sizes in mm, boxing system", {9.0, kInk, Weight::kBold});
  double y = corner.y() + 2.0;
  for (const auto& [label, value] : rows) {
    y += kRow;
    canvas_.Text({corner.x(), y}, label, {8.0, kInk});
    canvas_.Text({corner.x() + kWidth, y}, value, {8.5, kInk, Weight::kBold, Align::kRight});
    canvas_.Stroke({{corner.x(), y + 1.5}, {corner.x() + kWidth, y + 1.5}}, {0.1, kSoft});
  }
  canvas_.Paragraph(
      {corner.x(), y + 8.0}, kWidth,
      "Dashed: the box of each lens about the apex of its bevel, seen from the front; A and B are measured in "
      "the lens' plane. Hidden lines are left out. Print at 100 %, without fitting to the page.",
      {7.0, kSoft});
}

void DrawingPages::First() {
  Border(1);
  const Eigen::AlignedBox2d box = VisibleLines(FrameBodies(source_.frame), FrameView::kFront).box;
  Front({30.0 - box.min().x(), 36.0 + box.max().y()});
  Facts({209.0, 24.0});
}

void DrawingPages::Second() {
  Border(2);
  Side(34.0, 36.0);
  Lens({246.0, 74.0});
}

void DrawingPages::Third() {
  Border(3);
  const Eigen::AlignedBox2d box = VisibleLines(FrameBodies(source_.frame), FrameView::kTop).box;
  Top(23.0 - box.min().x(), 16.0);
}

/// Fails if a view does not fit on its page at 1:1.
Status CheckRoom(const GlassesSource& source) {
  constexpr double kWidest = 178.0;
  constexpr double kHighest = 160.0;
  for (const FrameView view : {FrameView::kFront, FrameView::kSide, FrameView::kTop}) {
    Eigen::AlignedBox2d box;
    for (const FrameBody& body : FrameBodies(source.frame)) {
      for (const PatchShell& shell : body.shells) {
        for (const ShellPatch& piece : shell.patches) {
          for (const auto& row : piece.patch.control_net()) {
            for (const Vector3d& p : row) box.extend(InView(view, p));
          }
        }
      }
    }
    const Vector2d size = box.sizes();
    if (size.x() <= kWidest && size.y() <= kHighest) continue;
    return Fail(
        "draw the frame 1:1",
        fmt::format("a view is {:.0f} × {:.0f} mm, A4 holds {:.0f} × {:.0f}", size.x(), size.y(), kWidest, kHighest),
        "export .step and draw it on a larger sheet");
  }
  return {};
}

}  // namespace

Result<ExportedFile> GlassesDrawing(const GlassesSource& source, const GlassesExportOptions& options) {
  RETURN_IF_ERROR(CheckRoom(source));
  SheetCanvas canvas("annulus frame drawing", PageTurn::kLandscape);
  DrawingPages pages(canvas, source, options);
  pages.First();
  canvas.NextPage();
  pages.Second();
  canvas.NextPage();
  pages.Third();
  const auto bytes = canvas.Finish();
  if (!bytes) return Fail(bytes);
  return ExportedFile{std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())};
}

}  // namespace annulus
