#include "station/map_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "render/canvas.h"
#include "station/chart.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Align = SheetText::Align;
using Weight = SheetText::Weight;

constexpr double kMargin = 6.0;       // mm around everything
constexpr double kTitleSize = 11.0;   // pt
constexpr double kTextSize = 8.0;     // pt
constexpr double kTitleHeight = 9.0;  // mm
constexpr double kScaleBar = 6.5;     // mm of a scale bar under a panel
constexpr double kNarrowest = 58.0;   // mm of a panel with its caption
constexpr double kGap = 5.0;          // mm between panels
constexpr double kLegend = 25.0;      // mm of width
constexpr double kBar = 5.0;          // mm of the legend's bar
constexpr double kLine = 3.9;         // mm between lines of text
constexpr double kLetter = 1.40;      // mm: mean width of a letter of kTextSize
constexpr double kLabelGap = 4.0;     // mm between labels
constexpr double kLabelAway = 3.0;    // mm between a panel and its labels
constexpr double kAxes = 15.0;        // mm left of an unrolled map
constexpr double kUnder = 8.0;        // mm of axes below it

constexpr SheetColour kInk = chart_colour::kInk;
constexpr SheetColour kSoft = chart_colour::kSoft;

SheetColour SheetColourOf(const LinearRgb& rgb) {
  const auto encoded = [&rgb](Eigen::Index k) { return SrgbFromLinear(static_cast<double>(rgb[k])); };
  return {encoded(0), encoded(1), encoded(2)};
}

/// A colour between that of a line and white.
SheetColour Faint(const SheetColour& c) { return {0.5 + 0.5 * c.red, 0.5 + 0.5 * c.green, 0.5 + 0.5 * c.blue}; }

double WidthOf(const std::string& text) {
  const auto letters = std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
  return kLetter * static_cast<double>(letters);
}

/// The text in lines of about `width` mm.
std::vector<std::string> Wrapped(const std::string& text, double width) {
  std::vector<std::string> lines(1);
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = std::min(text.find(' ', start), text.size());
    const std::string word = text.substr(start, end - start);
    if (!lines.back().empty() && WidthOf(lines.back() + " " + word) > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    start = end + 1;
  }
  return lines;
}

/// Where one panel and its labels stand, mm.
struct PlacedPanel {
  const MapPanel* panel = nullptr;
  Vector2d corner = Vector2d::Zero();
  Vector2d size = Vector2d::Zero();
  double left_room = 0.0;   ///< For labels or an axis.
  double right_room = 0.0;  ///< For labels.
  std::vector<std::string> caption{};

  /// Height of what stands between the image and the caption.
  [[nodiscard]] double Under() const {
    if (panel->unrolled) return kUnder;
    return panel->pixels_per_mm > 0.0 ? kScaleBar : 0.0;
  }
};

/// Labels of one side in their order from the top.
struct LabelColumns {
  std::vector<PanelLabel> left;
  std::vector<PanelLabel> right;
};

/// To the nearer side, as far as both columns hold them.
LabelColumns SidesOf(const MapPanel& panel, std::size_t most) {
  LabelColumns columns;
  if (panel.unrolled) return {{}, panel.labels};  // the axis stands at the left
  for (const PanelLabel& label : panel.labels) {
    (label.at.x() < 0.5 * panel.image.width ? columns.left : columns.right).push_back(label);
  }
  const auto outward = [](const PanelLabel& a, const PanelLabel& b) { return a.at.x() < b.at.x(); };
  // What is nearest to the middle moves where there is more room.
  const auto move = [&](std::vector<PanelLabel>& from, std::vector<PanelLabel>& to, bool last) {
    while (from.size() > to.size() + 1 && from.size() > most) {
      const auto next = last ? std::max_element(from.begin(), from.end(), outward)
                             : std::min_element(from.begin(), from.end(), outward);
      to.push_back(*next);
      from.erase(next);
    }
  };
  move(columns.left, columns.right, true);
  move(columns.right, columns.left, false);
  return columns;
}

double RoomFor(const std::vector<PanelLabel>& labels) {
  std::vector<std::string> texts;
  for (const PanelLabel& label : labels) texts.push_back(label.text);
  return LabelRoom(texts);
}

/// One figure in the making.
class FigureMaker {
 public:
  FigureMaker(const std::vector<MapPanel>& panels, const std::optional<MapLegend>& legend, const MapFigureText& text,
              double pixels_per_mm)
      : legend_(legend), text_(text), scale_(pixels_per_mm) {
    ENSURE(!panels.empty() && pixels_per_mm > 0.0, "a figure shows something");
    for (const MapPanel& panel : panels) Place(panel);
  }

  Figure Draw();

 private:
  [[nodiscard]] double Whole(double mm) const { return std::round(mm * scale_) / scale_; }  // to a pixel's edge
  [[nodiscard]] std::size_t MostLabels(double height) const { return static_cast<std::size_t>(height / kLabelGap); }
  void Place(const MapPanel& panel);
  void DrawPanel(Figure& figure, const PlacedPanel& placed) const;
  void DrawOverlay(Figure& figure, const PlacedPanel& placed) const;
  void DrawLabels(Figure& figure, const PlacedPanel& placed, const std::vector<PanelLabel>& labels, bool left) const;
  void DrawAxes(Figure& figure, const PlacedPanel& placed) const;
  void DrawScaleBar(Figure& figure, const PlacedPanel& placed) const;
  void DrawLegend(Figure& figure, const Vector2d& corner, double height) const;
  void DrawBar(Figure& figure, const Vector2d& corner, double height) const;
  [[nodiscard]] double LegendKeys(Figure& figure, Vector2d at) const;

  const std::optional<MapLegend>& legend_;
  const MapFigureText& text_;
  double scale_;
  double right_ = kMargin;                  ///< Of what is placed, mm.
  double bottom_ = kMargin + kTitleHeight;  ///< Likewise, with captions.
  double image_bottom_ = 0.0;               ///< Likewise, without.
  std::vector<PlacedPanel> panels_;
};

void FigureMaker::Place(const MapPanel& panel) {
  PlacedPanel placed;
  placed.panel = &panel;
  placed.size = Vector2d(panel.image.width, panel.image.height) / scale_;
  const LabelColumns columns = SidesOf(panel, MostLabels(placed.size.y()));
  placed.left_room = Whole(std::max({RoomFor(columns.left), panel.label_room_mm, panel.unrolled ? kAxes : 0.0}));
  placed.right_room = std::max(RoomFor(columns.right), panel.label_room_mm);
  const double lacking = kNarrowest - placed.left_room - placed.size.x() - placed.right_room;
  if (lacking > 0.0) {
    placed.left_room += Whole(0.5 * lacking);
    placed.right_room += Whole(0.5 * lacking);
  }
  const double width = placed.left_room + placed.size.x() + placed.right_room;
  placed.caption = Wrapped(panel.caption, width);
  const double start = right_ + (panels_.empty() ? 0.0 : kGap) + placed.left_room;
  placed.corner = {Whole(start), Whole(kMargin + kTitleHeight)};
  right_ = placed.corner.x() + placed.size.x() + placed.right_room;
  image_bottom_ = std::max(image_bottom_, placed.corner.y() + placed.size.y());
  const double captions = 2.0 + kLine * static_cast<double>(placed.caption.size());
  bottom_ = std::max(bottom_, placed.corner.y() + placed.size.y() + placed.Under() + captions);
  panels_.push_back(std::move(placed));
}

void FigureMaker::DrawScaleBar(Figure& figure, const PlacedPanel& placed) const {
  const double figure_mm = placed.panel->pixels_per_mm / scale_;  // of the figure per mm of body
  const double most = 0.3 * placed.size.x() / figure_mm;
  double length = NiceStep(most, 1);
  while (length > most) length = NiceStep(0.4 * length, 1);  // 50, 20, 10, 5, …
  const double y = placed.corner.y() + placed.size.y() + 2.4;
  const double from = placed.corner.x() + 0.5 * (placed.size.x() - length * figure_mm);
  const double to = from + length * figure_mm;
  figure.Stroke({{from, y - 0.9}, {from, y}, {to, y}, {to, y - 0.9}}, {0.25, kInk});
  figure.Text({0.5 * (from + to), y + 3.6}, NumberText(length, length) + " mm",
              {kTextSize, kSoft, Weight::kRegular, Align::kCentre});
}

void FigureMaker::DrawAxes(Figure& figure, const PlacedPanel& placed) const {
  ChartStyle style;
  style.corner = placed.corner;
  style.size = placed.size;
  style.x_to = 360.0;
  style.y_from = (*placed.panel->unrolled)[0];
  style.y_to = (*placed.panel->unrolled)[1];
  const Vector2d end = placed.corner + placed.size;
  const SheetText centred{kTextSize, kSoft, Weight::kRegular, Align::kCentre};
  const Chart chart(figure, style);
  static constexpr std::array<const char*, 5> kSides{"right", "front", "left", "back", "right"};
  for (std::size_t k = 0; k < kSides.size(); ++k) {
    const double x = chart.X(90.0 * static_cast<double>(k));
    figure.Stroke({{x, end.y()}, {x, end.y() + 1.0}}, {0.2, kInk});
    figure.Text({x, end.y() + 4.2}, fmt::format("{}°", 90 * k), centred);
    figure.Text({x, end.y() + 7.8}, kSides[k], centred);
  }
  const std::vector<double> ticks = Ticks(style.y_from, style.y_to, 8);
  for (const double tick : ticks) {
    const double y = chart.Y(tick);
    figure.Stroke({{placed.corner.x() - 1.0, y}, {placed.corner.x(), y}}, {0.2, kInk});
    figure.Text({placed.corner.x() - 1.8, y + 1.0}, NumberText(tick, ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0),
                {kTextSize, kSoft, Weight::kRegular, Align::kRight});
  }
  figure.TextUpwards({placed.corner.x() - 11.5, placed.corner.y() + 0.5 * placed.size.y()}, "z [mm]", centred);
  chart.Frame();
}

void FigureMaker::DrawOverlay(Figure& figure, const PlacedPanel& placed) const {
  const auto place = [&](const Vector2d& pixels) -> Vector2d { return placed.corner + pixels / scale_; };
  // What is hidden first, then the white edges of what is seen, then its lines: no edge covers a line.
  enum class Coat { kHidden, kEdge, kInside };
  for (const Coat coat : {Coat::kHidden, Coat::kEdge, Coat::kInside}) {
    for (const PanelLine& line : placed.panel->lines) {
      if (line.run.visible == (coat == Coat::kHidden)) continue;
      std::vector<Vector2d> points;
      for (const Vector2d& p : line.run.points) points.push_back(place(p));
      if (coat == Coat::kHidden) figure.Stroke(points, {0.22, Faint(line.colour), SheetStroke::Dash::kDashed});
      if (coat == Coat::kEdge) figure.Stroke(points, {0.85, {1.0, 1.0, 1.0}});
      if (coat == Coat::kInside) figure.Stroke(points, {0.45, line.colour});
    }
  }
  for (const PanelPoint& point : placed.panel->points) {
    if (point.visible) {
      figure.FillDisc(place(point.at), 0.95, {1.0, 1.0, 1.0});
      figure.FillDisc(place(point.at), 0.65, point.colour);
    } else {
      figure.StrokeCircle(place(point.at), 0.6, {0.2, Faint(point.colour)});
    }
  }
}

void FigureMaker::DrawLabels(Figure& figure, const PlacedPanel& placed, const std::vector<PanelLabel>& labels,
                             bool left) const {
  std::vector<double> wanted;
  for (const PanelLabel& label : labels) wanted.push_back(placed.corner.y() + label.at.y() / scale_);
  const std::vector<double> at =
      SpreadLabels(wanted, kLabelGap, placed.corner.y() + 1.0, placed.corner.y() + placed.size.y() - 1.0);
  const double edge = left ? placed.corner.x() : placed.corner.x() + placed.size.x();
  const double away = left ? -kLabelAway : kLabelAway;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    const Vector2d anchor = placed.corner + labels[k].at / scale_;
    figure.Stroke({anchor, {edge, at[k]}, {edge + 0.8 * away, at[k]}}, {0.14, labels[k].colour});
    figure.Text({edge + away, at[k] + 1.0}, labels[k].text,
                {kTextSize, labels[k].colour, Weight::kRegular, left ? Align::kRight : Align::kLeft});
  }
}

void FigureMaker::DrawPanel(Figure& figure, const PlacedPanel& placed) const {
  const MapPanel& panel = *placed.panel;
  figure.Cells(placed.corner, placed.size, panel.image);
  const LabelColumns columns = SidesOf(panel, MostLabels(placed.size.y()));
  // Leaders lie under the lines that they lead to.
  DrawLabels(figure, placed, columns.left, true);
  DrawLabels(figure, placed, columns.right, false);
  DrawOverlay(figure, placed);
  if (panel.unrolled) DrawAxes(figure, placed);
  if (panel.pixels_per_mm > 0.0) DrawScaleBar(figure, placed);
  const double middle = placed.corner.x() + 0.5 * (placed.size.x() + placed.right_room - placed.left_room);
  double y = placed.corner.y() + placed.size.y() + placed.Under() + 4.6;
  for (const std::string& line : placed.caption) {
    figure.Text({middle, y}, line, {kTextSize, kInk, Weight::kRegular, Align::kCentre});
    y += kLine;
  }
}

void FigureMaker::DrawBar(Figure& figure, const Vector2d& corner, double height) const {
  const ValueScale& scale = legend_->colours.scale;
  const auto pixels = static_cast<int>(std::lround(height * scale_));
  RgbImage bar = RgbImage::Filled(1, pixels, LinearRgb::Zero());
  for (int y = 0; y < pixels; ++y) {
    bar.rgb[bar.Index(0, y)] = MapColour(scale.map, 1.0 - (y + 0.5) / pixels);
  }
  figure.Cells(corner, {kBar, height}, std::move(bar));
  const Vector2d end = corner + Vector2d(kBar, height);
  figure.Stroke({corner, {end.x(), corner.y()}, end, {corner.x(), end.y()}, corner}, {0.2, kInk});
  // Points say that values lie beyond the end.
  const double middle = corner.x() + 0.5 * kBar;
  if (legend_->range.above > 0.0 || scale.over) {
    const std::vector<Vector2d> tip{
        {corner.x(), corner.y() - 0.6}, {end.x(), corner.y() - 0.6}, {middle, corner.y() - 4.0}};
    figure.FillPolygon(tip, SheetColourOf(scale.over.value_or(MapColour(scale.map, 1.0))));
    figure.Stroke({tip[0], tip[1], tip[2], tip[0]}, {0.2, kInk});
    if (scale.over) figure.Text({end.x() + 1.4, corner.y() - 2.0}, legend_->over_label, {kTextSize, kSoft});
  }
  if (legend_->range.below > 0.0 || scale.under) {
    const std::vector<Vector2d> tip{{corner.x(), end.y() + 0.6}, {end.x(), end.y() + 0.6}, {middle, end.y() + 4.0}};
    figure.FillPolygon(tip, SheetColourOf(scale.under.value_or(MapColour(scale.map, 0.0))));
    figure.Stroke({tip[0], tip[1], tip[2], tip[0]}, {0.2, kInk});
    if (scale.under) figure.Text({end.x() + 1.4, end.y() + 4.2}, legend_->under_label, {kTextSize, kSoft});
  }
  const std::vector<double> ticks = Ticks(scale.minimum, scale.maximum, 8);
  for (const double tick : ticks) {
    const double y = end.y() - (tick - scale.minimum) / (scale.maximum - scale.minimum) * height;
    figure.Stroke({{end.x(), y}, {end.x() + 1.0, y}}, {0.2, kInk});
    std::string number = NumberText(tick, ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0);
    if (number.front() == '-') number = "−" + number.substr(1);
    figure.Text({end.x() + 1.8, y + 1.0}, number, {kTextSize, kSoft});
  }
}

/// What is not on the bar; returns the height taken.
double FigureMaker::LegendKeys(Figure& figure, Vector2d at) const {
  const double start = at.y();
  const auto key = [&](const SheetColour& colour, const std::string& label, bool hatched) {
    const Vector2d corner(at.x(), at.y() - 2.6);
    figure.FillRectangle(corner, {kBar, 3.2}, colour);
    for (double x = 0.6; hatched && x < kBar; x += 1.6) {
      figure.Stroke({corner + Vector2d(x, 3.2), corner + Vector2d(std::min(x + 2.2, kBar), 0.2)}, {0.2, kInk});
    }
    figure.Stroke(
        {corner, corner + Vector2d(kBar, 0.0), corner + Vector2d(kBar, 3.2), corner + Vector2d(0.0, 3.2), corner},
        {0.2, kInk});
    for (const std::string& line : Wrapped(label, kLegend - kBar - 2.0)) {
      figure.Text({at.x() + kBar + 1.8, at.y()}, line, {kTextSize, kSoft});
      at.y() += kLine;
    }
    at.y() += 1.2;
  };
  for (const MapCategory& category : legend_->colours.categories) {
    key(SheetColourOf(category.colour), category.label, false);
  }
  if (!legend_->hatch_label.empty()) key({0.88, 0.88, 0.88}, legend_->hatch_label, true);
  if (legend_->grey) key(SheetColourOf(kNoDataColour), "no value", false);
  return at.y() - start;
}

void FigureMaker::DrawLegend(Figure& figure, const Vector2d& corner, double height) const {
  if (!legend_->colours.categories.empty()) {
    static_cast<void>(LegendKeys(figure, corner + Vector2d(0.0, 4.0)));
    return;
  }
  const double keys = (legend_->hatch_label.empty() ? 0.0 : 10.0) + (legend_->grey ? 6.0 : 0.0) + 14.0;
  const double bar = std::clamp(height - keys, 25.0, 90.0);
  figure.Text(corner + Vector2d(0.0, 2.6), legend_->unit, {kTextSize, kInk, Weight::kBold});
  const Vector2d top(corner.x(), Whole(corner.y() + 8.5));
  DrawBar(figure, top, bar);
  static_cast<void>(LegendKeys(figure, top + Vector2d(0.0, bar + 10.5)));
}

Figure FigureMaker::Draw() {
  const double panels_right = right_;
  double width = panels_right + kMargin + (legend_ ? kGap + kLegend : 0.0);
  width = std::max(width, 100.0);
  std::vector<std::string> lines;
  for (const std::string& note : text_.notes) {
    for (std::string& line : Wrapped(note, width - 2.0 * kMargin)) lines.push_back(std::move(line));
  }
  const double notes_top = bottom_ + 4.0;
  const double legend_least = kMargin + kTitleHeight + 60.0;
  const double body = legend_ ? std::max(notes_top, legend_least) : notes_top;
  const double height = body + kLine * static_cast<double>(lines.size()) + 0.5 * kMargin;
  Figure figure(Whole(width), Whole(height), text_.title);
  figure.FillRectangle(Vector2d::Zero(), {width, height}, {1.0, 1.0, 1.0});
  figure.Text({kMargin, kMargin + 3.6}, text_.title, {kTitleSize, kInk, Weight::kBold});
  for (const PlacedPanel& placed : panels_) DrawPanel(figure, placed);
  if (legend_) {
    DrawLegend(figure, {panels_right + kGap, kMargin + kTitleHeight}, image_bottom_ - kMargin - kTitleHeight);
  }
  double y = body + 1.0;
  for (const std::string& line : lines) {
    figure.Text({kMargin, y}, line, {kTextSize, kSoft});
    y += kLine;
  }
  return figure;
}

}  // namespace

double LabelRoom(const std::vector<std::string>& texts) {
  double room = 0.0;
  for (const std::string& text : texts) room = std::max(room, WidthOf(text) + kLabelAway + 2.0);
  return room;
}

Figure MapFigure(const std::vector<MapPanel>& panels, const std::optional<MapLegend>& legend, const MapFigureText& text,
                 double pixels_per_mm) {
  return FigureMaker(panels, legend, text, pixels_per_mm).Draw();
}

}  // namespace annulus
