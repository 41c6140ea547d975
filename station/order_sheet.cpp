#include "station/order_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "modeling/glasses/boxing.h"
#include "station/sheet_canvas.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Align = SheetText::Align;
using Weight = SheetText::Weight;

constexpr SheetColour kInk{0.1, 0.12, 0.15};
constexpr SheetColour kSoft{0.4, 0.44, 0.5};
constexpr SheetColour kRule{0.8, 0.83, 0.86};
constexpr SheetColour kBand{0.955, 0.965, 0.975};
constexpr SheetColour kAccent{0.08, 0.36, 0.55};
constexpr SheetColour kYes{0.1, 0.5, 0.28};
constexpr SheetColour kNo{0.76, 0.3, 0.05};
constexpr SheetColour kWarnFill{1.0, 0.945, 0.88};
constexpr SheetColour kGoodFill{0.9, 0.965, 0.92};

constexpr double kLeft = 16.0;
constexpr double kRight = SheetCanvas::kWidth - 16.0;
constexpr double kBottom = SheetCanvas::kHeight - 18.0;
constexpr double kRow = 5.6;

using Row = std::vector<std::string>;

std::string Dioptres(double value) { return fmt::format("{:+.2f}", value); }
std::string Millimetres(double value) { return fmt::format("{:.1f}", value); }
std::string OrDash(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:.1f}{}", *value, unit) : std::string("–");
}

std::string PrismText(const Prism& prism) {
  std::string text;
  const auto add = [&text](double size, const char* base) {
    if (size > 0.0) text += fmt::format("{}{:.2f} {}", text.empty() ? "" : ", ", size, base);
  };
  add(prism.in, "in");
  add(-prism.in, "out");
  add(prism.up, "up");
  add(-prism.up, "down");
  return text.empty() ? "–" : text;
}

const char* BridgeWord(BridgeForm form) {
  switch (form) {
    case BridgeForm::kStraight:
      return "straight";
    case BridgeForm::kSaddle:
      return "saddle";
    case BridgeForm::kKeyhole:
      return "keyhole";
  }
  return "";
}
const char* PadWord(PadForm form) {
  switch (form) {
    case PadForm::kNone:
      return "none";
    case PadForm::kFixed:
      return "fixed";
    case PadForm::kAdjustable:
      return "adjustable";
  }
  return "";
}
const char* RimWord(RimForm form) {
  switch (form) {
    case RimForm::kFull:
      return "full rim";
    case RimForm::kHalf:
      return "half rim";
    case RimForm::kRimless:
      return "rimless";
  }
  return "";
}

/// The sheet from the top down.
class OrderPages {
 public:
  OrderPages(SheetCanvas& canvas, const GlassesSource& source, const GlassesExportOptions& options)
      : canvas_(canvas), source_(source), options_(options) {}

  void Header();
  void FrameTable();
  void Order(const Prescription& order);
  void Lenses(const LensPair& pair);
  void Position();
  void Goals();
  void Messages(const LensPair& pair);
  void Signature();
  void Footer();

 private:
  void Need(double height);
  void Section(const std::string& title, const std::string& remark = "");
  /// Rows of cells under a head; the first column is left of `edges[0]`, the others end at the edges.
  void Table(const Row& head, const std::vector<Row>& rows, const std::vector<double>& edges);
  void Facts(const std::vector<std::pair<std::string, std::string>>& facts);
  [[nodiscard]] bool confirmed() const { return !options_.confirmed_by.empty(); }

  SheetCanvas& canvas_;
  const GlassesSource& source_;
  const GlassesExportOptions& options_;
  double y_ = 16.0;
  int page_ = 1;
};

void OrderPages::Need(double height) {
  if (y_ + height <= kBottom) return;
  Footer();
  canvas_.NextPage();
  ++page_;
  y_ = 18.0;
}

void OrderPages::Footer() {
  const double y = SheetCanvas::kHeight - 9.0;
  canvas_.Text({kLeft, y}, "annulus", {7.5, kSoft});
  canvas_.Text({kRight, y}, fmt::format("Page {}", page_), {7.5, kSoft, Weight::kRegular, Align::kRight});
}

void OrderPages::Header() {
  canvas_.FillRectangle({kLeft, y_}, {2.0, 11.0}, kAccent);
  canvas_.Text({kLeft + 5.0, y_ + 8.6}, "Glasses order", {20.0, kInk, Weight::kBold});
  const std::string reference = options_.reference.empty() ? "no reference" : "Reference: " + options_.reference;
  canvas_.Text({kRight, y_ + 4.0}, reference, {10.0, kInk, Weight::kBold, Align::kRight});
  canvas_.Text({kRight, y_ + 9.0}, "lengths in mm unless another unit is given",
               {7.5, kSoft, Weight::kRegular, Align::kRight});
  y_ += 15.0;
  const bool good = confirmed();
  canvas_.FillRectangle({kLeft, y_}, {kRight - kLeft, 10.0}, good ? kGoodFill : kWarnFill);
  canvas_.FillRectangle({kLeft, y_}, {1.2, 10.0}, good ? kYes : kNo);
  canvas_.Text(
      {kLeft + 4.0, y_ + 6.6},
      good ? "PDs and heights confirmed by " + options_.confirmed_by
           : "NOT CONFIRMED – estimate: PDs and heights must be confirmed by an optician before lenses are made",
      {9.0, good ? kYes : kNo, Weight::kBold});
  y_ += 13.0;
}

void OrderPages::Section(const std::string& title, const std::string& remark) {
  Need(20.0);
  y_ += 4.5;
  canvas_.Text({kLeft, y_ + 3.5}, title, {11.0, kAccent, Weight::kBold});
  if (!remark.empty()) {
    canvas_.Text({kRight, y_ + 3.5}, remark, {7.5, kSoft, Weight::kRegular, Align::kRight});
  }
  y_ += 5.5;
  canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.3, kAccent});
  y_ += 0.8;
}

void OrderPages::Table(const Row& head, const std::vector<Row>& rows, const std::vector<double>& edges) {
  const auto line = [&](const Row& cells, double size, const SheetColour& colour, Weight weight) {
    canvas_.Text({kLeft + 1.5, y_ + 4.0}, cells.front(), {size, colour, weight});
    for (std::size_t k = 1; k < cells.size(); ++k) {
      canvas_.Text({edges[k - 1], y_ + 4.0}, cells[k], {size, colour, weight, Align::kRight});
    }
  };
  line(head, 7.5, kSoft, Weight::kRegular);
  y_ += kRow;
  bool band = true;
  for (const Row& row : rows) {
    Need(kRow);
    if (band) canvas_.FillRectangle({kLeft, y_}, {kRight - kLeft, kRow}, kBand);
    band = !band;
    line(row, 9.0, kInk, Weight::kRegular);
    y_ += kRow;
  }
}

void OrderPages::Facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  const double half = 0.5 * (kRight - kLeft);
  for (std::size_t k = 0; k < facts.size(); ++k) {
    if (k % 2 == 0) Need(kRow);
    const double x = k % 2 == 0 ? kLeft : kLeft + half + 4.0;
    const double end = k % 2 == 0 ? kLeft + half - 4.0 : kRight;
    canvas_.Text({x + 1.5, y_ + 4.0}, facts[k].first, {8.0, kSoft});
    canvas_.Text({end - 1.5, y_ + 4.0}, facts[k].second, {9.0, kInk, Weight::kBold, Align::kRight});
    canvas_.Stroke({{x, y_ + kRow}, {end, y_ + kRow}}, {0.15, kRule});
    if (k % 2 == 1 || k + 1 == facts.size()) y_ += kRow;
  }
}

void OrderPages::FrameTable() {
  const FrameDesign& design = source_.design.design;
  const FrameDetails& details = design.details;
  const FrameBoxing boxing = BoxingOf(source_.frame);
  const Frame& frame = source_.frame;
  const auto& material = source_.design.material;
  Section("Frame");
  Facts({{"style", design.style.empty() ? "own design" : design.style},
         {"size", SizeMark(frame)},
         {"material", material ? std::string(DesignMaterialWord(*material)) : "not given"},
         {"rim, groove", details.groove_depth > 0.0 ? fmt::format("{}, {:.1f} wide, {:.1f} deep", RimWord(details.rim),
                                                                  details.groove_width, details.groove_depth)
                                                    : std::string(RimWord(details.rim))},
         {"lens width A × height B", fmt::format("{:.1f} × {:.1f}", boxing.a, boxing.b)},
         {"distance between lenses DBL", Millimetres(boxing.dbl)},
         {"effective diameter ED", Millimetres(boxing.ed)},
         {"circumference", Millimetres(boxing.circumference)},
         {"bridge, pads", fmt::format("{}, {}", BridgeWord(details.bridge), PadWord(details.pads))},
         {"frame curve, face form",
          fmt::format("{:.1f} D, {:.1f}°", details.frame_curve, DegreesFromRadians(details.face_form))},
         {"temple right: length, to bend",
          fmt::format("{:.1f}, {:.1f}", frame.arm_right.overall_length, frame.arm_right.length_to_bend)},
         {"temple left: length, to bend",
          fmt::format("{:.1f}, {:.1f}", frame.arm_left.overall_length, frame.arm_left.length_to_bend)}});
}

void OrderPages::Order(const Prescription& order) {
  Section("Prescription", fmt::format("{}, {}", order.date, order.prescriber));
  std::vector<Row> rows;
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    const EyePrescription& e = order.of(eye);
    rows.push_back({eye == Eye::kRight ? "right" : "left", Dioptres(e.sphere),
                    e.cylinder != 0.0 ? Dioptres(e.cylinder) : "–",
                    e.cylinder != 0.0 && e.axis_deg ? fmt::format("{:.0f}°", *e.axis_deg) : "–",
                    e.add ? Dioptres(*e.add) : "–", PrismText(e.prism), OrDash(e.pd, ""), OrDash(e.height, "")});
  }
  Table({"eye", "SPH D", "CYL D", "axis", "ADD D", "prism cm/m, base", "PD", "height"}, rows,
        {52.0, 72.0, 88.0, 106.0, 146.0, 166.0, kRight - 1.5});
  const auto& vertex = order.refracted_vertex;
  y_ += 1.0;
  canvas_.Text(
      {kLeft + 1.5, y_ + 3.2},
      fmt::format("PD: from the bridge's middle. Height: over the lower side of the lens' box. Refracted at {:.1f} "
                  "mm vertex distance{}.",
                  vertex.value_or(kUsualRefractedVertex), vertex ? "" : " (usual value, not given)"),
      {7.0, kSoft});
  y_ += 4.0;
}

void OrderPages::Lenses(const LensPair& pair) {
  Section("Lenses",
          fmt::format("{}: index {:.3f} ({} line), Abbe {:.0f}, {:.2f} g/cm³", pair.material.name, pair.material.index,
                      SpectralLineName(pair.material.line), pair.material.abbe, pair.material.density));
  const auto both = [&pair](const std::string& name, const auto& text) {
    return Row{name, text(pair.right), text(pair.left)};
  };
  const auto power = [](const LensPower& p) {
    return fmt::format("{} {} × {:.0f}°", Dioptres(p.power.sphere), Dioptres(p.power.cylinder),
                       DegreesFromRadians(p.power.axis));
  };
  Table(
      {"", "right", "left"},
      {both("base curve D", [](const LensDesign& l) { return fmt::format("{:.2f}", l.base); }),
       both("power to make (focimeter) D", [&](const LensDesign& l) { return power(l.power.to_surface); }),
       both("error as worn D (tolerance 0.13)",
            [](const LensDesign& l) {
              return fmt::format("{:.3f}{}", l.power.as_worn_error, l.power.within_tolerance ? "" : "  beyond");
            }),
       both("thinnest, thickest",
            [](const LensDesign& l) { return fmt::format("{:.2f}, {:.2f}", l.thinnest, l.thickest); }),
       both("edge thinnest, thickest",
            [](const LensDesign& l) { return fmt::format("{:.2f}, {:.2f}", l.edge.thinnest, l.edge.thickest); }),
       both("decentration in, up",
            [](const LensDesign& l) { return fmt::format("{:+.2f}, {:+.2f}", l.decentration_in, l.decentration.y()); }),
       both("blank at least, stocked",
            [](const LensDesign& l) {
              return fmt::format("{:.1f}, {}", l.blank.minimum,
                                 l.blank.stocked ? fmt::format("{:.0f}", *l.blank.stocked) : "none");
            }),
       both("weight g", [](const LensDesign& l) { return fmt::format("{:.1f}", l.body.weight); })},
      {135.0, kRight - 1.5});
}

void OrderPages::Position() {
  Section("Position as worn", source_.worn ? "from the scan" : "usual values: no worn frame was given");
  const WornPosition right = PositionOf(source_, Eye::kRight);
  const WornPosition left = PositionOf(source_, Eye::kLeft);
  const std::vector<SavedGoal> goals = GoalsOf(source_);
  const bool measured = std::any_of(goals.begin(), goals.end(),
                                    [](const SavedGoal& goal) { return goal.id.starts_with("vertex_distance"); });
  std::vector<std::pair<std::string, std::string>> facts = {
      {measured ? "vertex distance right / left" : "vertex distance (usual value)",
       fmt::format("{:.1f} / {:.1f}", right.vertex_distance, left.vertex_distance)},
      {"pantoscopic tilt", fmt::format("{:.1f}°", DegreesFromRadians(right.pantoscopic_tilt))},
      {"face form angle right / left", fmt::format("{:.1f}° / {:.1f}°", DegreesFromRadians(right.face_form_angle),
                                                   DegreesFromRadians(left.face_form_angle))}};
  const auto pupil_right = PupilOf(source_, Eye::kRight);
  const auto pupil_left = PupilOf(source_, Eye::kLeft);
  if (pupil_right && pupil_left) {
    facts.emplace_back("PD right / left (estimate)", fmt::format("{:.1f} / {:.1f}", pupil_right->pd, pupil_left->pd));
    facts.emplace_back("height right / left (estimate)",
                       fmt::format("{:.1f} / {:.1f}", pupil_right->height, pupil_left->height));
  }
  Facts(facts);
}

void OrderPages::Goals() {
  const std::vector<SavedGoal> goals = GoalsOf(source_);
  if (goals.empty()) return;
  Need(18.0 + kRow * static_cast<double>(goals.size()));
  Section("Fit", "95 % interval; a filled mark: within the usual range");
  std::vector<Row> rows;
  for (const SavedGoal& goal : goals) {
    const std::string unit = goal.unit == "deg" ? "°" : " " + goal.unit;
    rows.push_back({goal.term, fmt::format("{:.1f}{}", goal.value, unit),
                    goal.sigma ? fmt::format("± {:.1f}", 1.96 * *goal.sigma) : "–",
                    fmt::format("{:.1f} to {:.1f}", goal.low, goal.high), ""});
  }
  // The marks belong to the rows, wherever a new page begins: one row at a time.
  Table({"goal", "value", "interval", "usual range", ""}, {}, {112.0, 134.0, 166.0, kRight});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Need(kRow);
    if (k % 2 == 0) canvas_.FillRectangle({kLeft, y_}, {kRight - kLeft, kRow}, kBand);
    canvas_.Text({kLeft + 1.5, y_ + 4.0}, rows[k][0], {9.0, kInk});
    const std::array<double, 3> edges{112.0, 134.0, 166.0};
    for (std::size_t c = 0; c < 3; ++c) {
      canvas_.Text({edges[c], y_ + 4.0}, rows[k][c + 1], {9.0, kInk, Weight::kRegular, Align::kRight});
    }
    const Vector2d mark(kRight - 17.0, y_ + 0.5 * kRow);
    if (goals[k].met) {
      canvas_.FillDisc(mark, 1.2, kYes);
    } else {
      canvas_.StrokeCircle(mark, 1.1, {0.3, kNo});
    }
    canvas_.Text({kRight - 1.5, y_ + 4.0}, goals[k].met ? "met" : "not met",
                 {7.5, goals[k].met ? kYes : kNo, Weight::kRegular, Align::kRight});
    y_ += kRow;
  }
}

void OrderPages::Messages(const LensPair& pair) {
  std::vector<std::string> lines;
  for (const LensMessage& message : pair.messages) lines.push_back(message.text);
  for (const LensMessage& message : pair.right.messages) lines.push_back("right: " + message.text);
  for (const LensMessage& message : pair.left.messages) lines.push_back("left: " + message.text);
  if (lines.empty()) return;
  Section("Remarks on the lenses");
  for (const std::string& line : lines) {
    const SheetText style{8.0, kInk};
    Need(canvas_.ParagraphHeight(kRight - kLeft - 3.0, line, style) + 1.5);
    y_ += canvas_.Paragraph({kLeft + 1.5, y_ + 3.2}, kRight - kLeft - 3.0, line, style) + 1.0;
  }
}

void OrderPages::Signature() {
  Need(28.0);
  y_ = std::max(y_ + 14.0, y_);
  const double middle = kLeft + 0.62 * (kRight - kLeft);
  canvas_.Stroke({{kLeft, y_}, {middle - 6.0, y_}}, {0.25, kInk});
  canvas_.Stroke({{middle, y_}, {kRight, y_}}, {0.25, kInk});
  canvas_.Text({kLeft, y_ + 3.6}, "PDs, heights and order confirmed by (name, signature)", {7.5, kSoft});
  canvas_.Text({middle, y_ + 3.6}, "date", {7.5, kSoft});
  if (confirmed()) canvas_.Text({kLeft + 1.0, y_ - 1.5}, options_.confirmed_by, {10.0, kInk});
  y_ += 6.0;
}

}  // namespace

Result<ExportedFile> OrderSheet(const GlassesSource& source, const GlassesExportOptions& options) {
  const auto pair = LensesOf(source, options);
  if (!pair) return Fail(pair);
  SheetCanvas canvas("annulus glasses order");
  OrderPages pages(canvas, source, options);
  pages.Header();
  pages.FrameTable();
  if (const auto order = CentredPrescription(source, options)) pages.Order(*order);
  if (*pair) pages.Lenses(**pair);
  pages.Position();
  pages.Goals();
  if (*pair) pages.Messages(**pair);
  pages.Signature();
  pages.Footer();
  const auto bytes = canvas.Finish();
  if (!bytes) return Fail(bytes);
  return ExportedFile{std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())};
}

}  // namespace annulus
