#include "station/sheet_figure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "station/body_figure.h"

namespace annulus {
namespace {

constexpr double kPixelsPerMm = 6.0;   // of the sheet
constexpr double kLabelRadius = 1.75;  // mm
constexpr double kLabelGap = 4.0;      // mm between label centres
constexpr double kLabelAway = 5.0;     // mm from the figure's side
constexpr double kTitleHeight = 5.0;   // mm under each figure
constexpr double kShownShare = 0.05;   // of a path; one that no view shows more of is drawn through the body
constexpr SheetColour kInk{0.25, 0.28, 0.32};

/// Light grey skin from its darkest to its lightest tone.
constexpr int kTones = 12;
SheetColour Tone(double light) {
  const auto between = [light](double dark, double bright) { return dark + light * (bright - dark); };
  return {between(0.66, 0.975), between(0.69, 0.978), between(0.73, 0.985)};
}

/// One view and where it stands on the sheet.
struct PlacedFigure {
  BodyFigure figure;
  Eigen::Vector2d origin;  ///< Sheet place of the figure's (0, 0).
  double scale;            ///< Sheet mm per body mm.

  [[nodiscard]] Eigen::Vector2d ToSheet(const Eigen::Vector2d& p) const {
    return {origin.x() + scale * p.x(), origin.y() - scale * p.y()};
  }
  [[nodiscard]] std::vector<Eigen::Vector2d> ToSheet(const std::vector<Eigen::Vector2d>& points) const {
    std::vector<Eigen::Vector2d> placed;
    for (const Eigen::Vector2d& p : points) placed.push_back(ToSheet(p));
    return placed;
  }
  [[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> ToSheet(
      const std::vector<std::vector<Eigen::Vector2d>>& loops) const {
    std::vector<std::vector<Eigen::Vector2d>> placed;
    for (const auto& loop : loops) placed.push_back(ToSheet(loop));
    return placed;
  }
};

/// A measurement's path in one view.
struct DrawnPath {
  std::vector<FigureRun> runs;
  double seen = 0.0;  ///< Visible length in the figure's plane, body mm.
  double all = 0.0;   ///< The whole.
};

double LengthOf(const std::vector<Eigen::Vector2d>& points) {
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) length += (points[k + 1] - points[k]).norm();
  return length;
}

DrawnPath PathIn(const BodyFigure& figure, const Measurement& measurement) {
  DrawnPath drawn;
  for (const auto& path : measurement.paths) {
    for (FigureRun& run : figure.Runs(path)) {
      const double length = LengthOf(run.points);
      drawn.all += length;
      if (run.visible) drawn.seen += length;
      drawn.runs.push_back(std::move(run));
    }
  }
  return drawn;
}

/// A number beside a figure, with a line to its tape.
struct Label {
  int number = 0;
  SheetColour colour;
  Eigen::Vector2d anchor;  ///< On the tape, sheet mm.
  double y = 0.0;          ///< Of the number's centre, sheet mm.
};

/// Moves labels of one column apart, as little as their order allows.
void Spread(std::vector<Label>& column, double lowest) {
  std::sort(column.begin(), column.end(), [](const Label& a, const Label& b) { return a.anchor.y() < b.anchor.y(); });
  for (std::size_t k = 0; k < column.size(); ++k) {
    column[k].y = column[k].anchor.y();
    if (k > 0) column[k].y = std::max(column[k].y, column[k - 1].y + kLabelGap);
  }
  double limit = lowest;
  for (auto label = column.rbegin(); label != column.rend(); ++label) {
    label->y = std::min(label->y, limit);
    limit = label->y - kLabelGap;
  }
}

void DrawBody(SheetCanvas& canvas, const PlacedFigure& placed) {
  const auto outline = placed.ToSheet(placed.figure.Outline());
  canvas.Fill(outline, Tone(0.0));
  for (int k = 1; k <= kTones; ++k) {
    const double light = static_cast<double>(k) / (kTones + 1);
    canvas.Fill(placed.ToSheet(placed.figure.Lit(0.25 + 0.75 * light)), Tone(light));
  }
  for (auto loop : outline) {
    if (loop.empty()) continue;
    loop.push_back(loop.front());
    canvas.Stroke(loop, {0.18, kInk});
  }
}

void DrawLabels(SheetCanvas& canvas, std::vector<Label>& column, double x, double lowest) {
  Spread(column, lowest);
  for (const Label& label : column) {
    const Eigen::Vector2d centre(x, label.y);
    const double side = label.anchor.x() < x ? -1.0 : 1.0;
    canvas.Stroke({label.anchor, centre + Eigen::Vector2d(side * kLabelRadius, 0.0)}, {0.1, label.colour});
    canvas.FillDisc(label.anchor, 0.4, label.colour);
    canvas.FillDisc(centre, kLabelRadius, label.colour);
    canvas.Text(centre + Eigen::Vector2d(0.0, 0.75), std::to_string(label.number),
                {6.0, {1.0, 1.0, 1.0}, SheetText::Weight::kBold, SheetText::Align::kCentre});
  }
}

/// The points among which a label's anchor is chosen: what is seen, or everything of a path through the body.
std::vector<Eigen::Vector2d> AnchorPoints(const DrawnPath& path, bool through) {
  std::vector<Eigen::Vector2d> points;
  for (const FigureRun& run : path.runs) {
    if (run.visible || through) points.insert(points.end(), run.points.begin(), run.points.end());
  }
  return points;
}

struct View {
  double azimuth_deg;  ///< Station theta of the viewer.
  std::string_view SheetWords::*title;
};
constexpr std::array<View, 3> kViews{
    {{90.0, &SheetWords::front}, {0.0, &SheetWords::side}, {270.0, &SheetWords::back}}};

/// All views of a sheet and what they show.
class FigureRow {
 public:
  FigureRow(SheetCanvas& canvas, const SheetBox& box) : canvas_(canvas), box_(box) {}

  /// Finds the scale and shrinks the box to the height that it needs.
  void Place(const TriangleMesh& mesh);
  [[nodiscard]] double height() const { return box_.size.y(); }
  void Draw(const std::vector<NumberedMeasurement>& measurements);
  void DrawTitles(SheetLanguage language);

 private:
  struct Columns {
    std::vector<Label> left;
    std::vector<Label> right;
  };
  void DrawPath(const NumberedMeasurement& numbered, std::vector<Columns>& columns);
  void AddLabel(const PlacedFigure& placed, const std::vector<Eigen::Vector2d>& points, Label label, Columns& columns);

  SheetCanvas& canvas_;
  SheetBox box_;
  std::vector<PlacedFigure> views_;
};

void FigureRow::Place(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& vertex : mesh.vertices) bounds.extend(vertex);
  const Eigen::Vector3d size = bounds.sizes();
  const std::array<double, 3> widths{size.x(), size.y(), size.x()};
  constexpr double kAir = 4.0 * kLabelAway;  // labels on both sides of each view
  constexpr double kAbove = kLabelRadius;    // room for a label at the top
  const double scale = std::min((box_.size.x() - 3.0 * kAir) / (2.0 * size.x() + size.y()),
                                (box_.size.y() - kTitleHeight - 2.0 * kLabelRadius) / size.z());
  // What is left of the width is shared by the three.
  const double spare = (box_.size.x() - scale * (2.0 * size.x() + size.y())) / 3.0;
  double left = box_.corner.x();
  for (std::size_t k = 0; k < kViews.size(); ++k) {
    BodyFigure figure(mesh, RadiansFromDegrees(kViews[k].azimuth_deg), 1.0 / (scale * kPixelsPerMm));
    const Eigen::Vector2d middle = 0.5 * (figure.low() + figure.high());
    const double width = scale * widths[k] + spare;
    const Eigen::Vector2d origin(left + 0.5 * width - scale * middle.x(),
                                 box_.corner.y() + kAbove + scale * figure.high().y());
    views_.push_back({std::move(figure), origin, scale});
    left += width;
  }
  box_.size.y() = kAbove + scale * size.z() + kLabelRadius + kTitleHeight;
}

void FigureRow::AddLabel(const PlacedFigure& placed, const std::vector<Eigen::Vector2d>& points, Label label,
                         Columns& columns) {
  const auto by_x = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() < b.x(); };
  const auto [leftmost, rightmost] = std::minmax_element(points.begin(), points.end(), by_x);
  const double middle = 0.5 * (placed.figure.low().x() + placed.figure.high().x());
  const double to_left = middle - leftmost->x();
  const double to_right = rightmost->x() - middle;
  // To the side that it reaches further, or to the emptier one.
  constexpr double kClearly = 15.0;  // body mm
  const bool left =
      std::abs(to_left - to_right) > kClearly ? to_left > to_right : columns.left.size() < columns.right.size();
  label.anchor = placed.ToSheet(left ? *leftmost : *rightmost);
  (left ? columns.left : columns.right).push_back(label);
}

void FigureRow::DrawPath(const NumberedMeasurement& numbered, std::vector<Columns>& columns) {
  const SheetColour colour = ColourOf(GroupOf(*numbered.measurement));
  std::vector<DrawnPath> drawn;
  std::size_t most_seen = 0;
  std::size_t longest = 0;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    drawn.push_back(PathIn(views_[k].figure, *numbered.measurement));
    if (drawn[k].seen > 1.02 * drawn[most_seen].seen) most_seen = k;
    if (drawn[k].all > 1.02 * drawn[longest].all) longest = k;
  }
  const bool through = drawn[most_seen].seen < kShownShare * drawn[longest].all;
  const std::size_t labelled = through ? longest : most_seen;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    for (const FigureRun& run : drawn[k].runs) {
      if (run.visible && !through) canvas_.Stroke(views_[k].ToSheet(run.points), {0.3, colour});
      if (through && k == labelled) {
        canvas_.Stroke(views_[k].ToSheet(run.points), {0.25, colour, SheetStroke::Dash::kDashed});
      }
    }
  }
  const std::vector<Eigen::Vector2d> points = AnchorPoints(drawn[labelled], through);
  if (!points.empty()) AddLabel(views_[labelled], points, {numbered.number, colour, {}, 0.0}, columns[labelled]);
}

void FigureRow::Draw(const std::vector<NumberedMeasurement>& measurements) {
  for (const PlacedFigure& placed : views_) DrawBody(canvas_, placed);
  std::vector<Columns> columns(views_.size());
  int drawn = 0;  // numbers rise; one that was drawn before is a second measurement on the same path
  for (const NumberedMeasurement& numbered : measurements) {
    if (numbered.number <= drawn) continue;
    DrawPath(numbered, columns);
    drawn = numbered.number;
  }
  const double lowest = box_.corner.y() + box_.size.y() - kTitleHeight - kLabelRadius;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const PlacedFigure& placed = views_[k];
    DrawLabels(canvas_, columns[k].left, placed.ToSheet(placed.figure.low()).x() - kLabelAway, lowest);
    DrawLabels(canvas_, columns[k].right, placed.ToSheet(placed.figure.high()).x() + kLabelAway, lowest);
  }
}

void FigureRow::DrawTitles(SheetLanguage language) {
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const BodyFigure& figure = views_[k].figure;
    const double x = views_[k].ToSheet(0.5 * (figure.low() + figure.high())).x();
    canvas_.Text({x, box_.corner.y() + box_.size.y() - 0.8}, std::string(WordsIn(language).*kViews[k].title),
                 {8.0, kInk, SheetText::Weight::kRegular, SheetText::Align::kCentre});
  }
}

/// A hand's breadth below the lowest path: legs are drawn no further.
double LowestShown(const std::vector<NumberedMeasurement>& measurements) {
  constexpr double kBelow = 120.0;  // mm
  double lowest = std::numeric_limits<double>::max();
  for (const NumberedMeasurement& numbered : measurements) {
    if (numbered.number == 0) continue;
    for (const auto& path : numbered.measurement->paths) {
      for (const Eigen::Vector3d& point : path) lowest = std::min(lowest, point.z());
    }
  }
  return lowest < std::numeric_limits<double>::max() ? lowest - kBelow : std::numeric_limits<double>::lowest();
}

}  // namespace

namespace {

/// Whether `skin` follows the section that `tape` goes around: in a picture they are one line.
bool IsSkinUnder(const Measurement& skin, const Measurement& tape) {
  constexpr std::string_view kSkin = "_perimeter";
  const std::string_view id = skin.id;
  return id.ends_with(kSkin) && tape.id == std::string(id.substr(0, id.size() - kSkin.size())) + "_girth";
}

}  // namespace

std::vector<NumberedMeasurement> NumberForSheet(const MeasurementTable& table) {
  std::vector<NumberedMeasurement> numbered;
  int last = 0;
  for (int group = 0; group < kSheetGroups; ++group) {
    for (const Measurement& m : table.measurements) {
      if (static_cast<int>(GroupOf(m)) != group) continue;
      int number = 0;
      if (!m.paths.empty() && GroupOf(m) != SheetGroup::kHeights) {
        const auto same = std::find_if(numbered.begin(), numbered.end(), [&](const NumberedMeasurement& other) {
          return other.number > 0 && (other.measurement->paths == m.paths || IsSkinUnder(m, *other.measurement));
        });
        number = same != numbered.end() ? same->number : ++last;
      }
      numbered.push_back({number, &m});
    }
  }
  return numbered;
}

SheetColour ColourOf(SheetGroup group) {
  switch (group) {
    case SheetGroup::kGirths:
      return {0.05, 0.36, 0.62};
    case SheetGroup::kLengths:
      return {0.72, 0.22, 0.16};
    case SheetGroup::kBreadths:
      return {0.10, 0.47, 0.33};
    case SheetGroup::kHeights:
      return {0.40, 0.33, 0.60};
    case SheetGroup::kHead:
      return {0.70, 0.42, 0.04};
    case SheetGroup::kAngles:
    case SheetGroup::kVolumes:
      return {0.33, 0.37, 0.42};
  }
  return {};
}

double DrawBodyFigures(SheetCanvas& canvas, const SheetBox& box, const SurfaceModel& model,
                       const std::vector<NumberedMeasurement>& measurements, SheetLanguage language) {
  const TriangleMesh mesh = FigureMesh(model, LowestShown(measurements));
  if (mesh.faces.empty()) return 0.0;
  FigureRow row(canvas, box);
  row.Place(mesh);
  row.Draw(measurements);
  row.DrawTitles(language);
  return row.height();
}

}  // namespace annulus
