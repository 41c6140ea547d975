#include "station/measurement_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "station/measurement_output.h"
#include "station/sheet_canvas.h"
#include "station/sheet_figure.h"

namespace annulus {
namespace {

// mm of the page
constexpr double kLeft = 16.0;
constexpr double kRight = SheetCanvas::kWidth - 16.0;
constexpr double kTop = 16.0;
constexpr double kBottom = SheetCanvas::kHeight - 14.0;
constexpr double kRowHeight = 5.1;
constexpr double kGroupHeight = 7.2;
constexpr double kFigureHeight = 128.0;
constexpr double kNotesHeight = 30.0;

constexpr SheetColour kInk{0.11, 0.13, 0.16};
constexpr SheetColour kSoft{0.42, 0.45, 0.49};
constexpr SheetColour kRule{0.80, 0.82, 0.85};
constexpr SheetColour kBand{0.955, 0.962, 0.970};
constexpr SheetColour kYes{0.10, 0.47, 0.33};
constexpr SheetColour kNo{0.72, 0.22, 0.16};

using Weight = SheetText::Weight;
using Align = SheetText::Align;

/// Columns of the table: right edges of numbers, left edges of texts.
constexpr double kNumberX = kLeft + 2.6;
constexpr double kTermX = kLeft + 7.5;
constexpr double kValueX = 118.0;
constexpr double kUnitX = 119.5;
constexpr double kHalfX = 146.0;
constexpr double kShareX = 164.0;
constexpr double kMarkX = 176.5;

std::string_view UnitName(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::kMillimetre:
      return "mm";
    case LengthUnit::kCentimetre:
      return "cm";
    case LengthUnit::kInch:
      return "inch";
  }
  return "mm";
}

/// The pages while they are being filled from top to bottom.
class SheetPages {
 public:
  SheetPages(SheetCanvas& canvas, const SheetOptions& options)
      : canvas_(canvas), options_(options), words_(WordsIn(options.language)) {}

  void Header(const Provenance& provenance);
  void Figures(const SurfaceModel& model, const std::vector<NumberedMeasurement>& measurements);
  void Group(SheetGroup group, const std::vector<NumberedMeasurement>& measurements);
  void Notes();
  void Footer();

 private:
  void TableHead();
  void Row(const NumberedMeasurement& numbered);
  void Mark(const Measurement& measurement);
  /// Begins a new page if less than `height` is left on this one.
  void Need(double height);

  SheetCanvas& canvas_;
  const SheetOptions& options_;
  const SheetWords& words_;
  double y_ = kTop;  ///< Upper edge of what comes next.
  int page_ = 1;
  int row_ = 0;
  bool table_begun_ = false;
};

void SheetPages::Header(const Provenance& provenance) {
  canvas_.FillRectangle({kLeft, y_}, {2.0, 11.0}, ColourOf(SheetGroup::kGirths));
  canvas_.Text({kLeft + 5.0, y_ + 8.6}, std::string(words_.title), {20.0, kInk, Weight::kBold});
  const SheetText small{8.0, kSoft, Weight::kRegular, Align::kRight};
  double line = y_ + 2.8;
  if (!options_.subject.empty()) {
    canvas_.Text({kRight, line}, fmt::format("{}: {}", words_.subject, options_.subject), small);
    line += 4.0;
  }
  if (!provenance.recording_hash.empty()) {
    // Enough of the hash to tell scans apart; the model has all of it.
    canvas_.Text({kRight, line}, fmt::format("{}: {}", words_.scan, provenance.recording_hash.substr(0, 23)), small);
    line += 4.0;
  }
  canvas_.Text({kRight, line}, fmt::format("{}: {}", words_.units, UnitName(options_.unit)), small);
  y_ += 14.0;
  canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.25, kRule});
  y_ += 3.0;
}

void SheetPages::Figures(const SurfaceModel& model, const std::vector<NumberedMeasurement>& measurements) {
  const SheetBox box{{kLeft, y_}, {kRight - kLeft, kFigureHeight}};
  const double used = DrawBodyFigures(canvas_, box, model, measurements, options_.language);
  if (used == 0.0) return;
  y_ += used + 3.5;
  y_ += canvas_.Paragraph({kLeft, y_}, kRight - kLeft, std::string(words_.levels_note), {7.0, kSoft});
}

void SheetPages::Need(double height) {
  if (y_ + height <= kBottom) return;
  Footer();
  canvas_.NextPage();
  ++page_;
  y_ = kTop;
  if (table_begun_) TableHead();
}

void SheetPages::TableHead() {
  const double base = y_ + 4.0;
  const SheetText left{7.5, kSoft, Weight::kBold};
  const SheetText right{7.5, kSoft, Weight::kBold, Align::kRight};
  canvas_.Text({kTermX, base}, std::string(words_.measurement), left);
  canvas_.Text({kValueX, base}, std::string(words_.value), right);
  canvas_.Text({kHalfX, base}, std::string(words_.half95), right);
  canvas_.Text({kShareX, base}, std::string(words_.measured), right);
  canvas_.Text({kMarkX - 1.0, base}, std::string(words_.within_limit), left);
  y_ += 5.5;
  canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.35, kSoft});
  y_ += 0.4;
}

void SheetPages::Mark(const Measurement& measurement) {
  const auto within = IntervalWithinLimit(measurement);
  if (!within) return;
  const Eigen::Vector2d centre(kMarkX + 0.5, y_ + 2.55);
  if (*within) {
    canvas_.FillDisc(centre, 1.1, kYes);
  } else {
    canvas_.StrokeCircle(centre, 1.0, {0.3, kNo});
  }
  // The limit is the standard's own number: always mm.
  canvas_.Text({kMarkX + 3.4, y_ + 3.65}, fmt::format("{:g} mm", measurement.iso20685_limit_mm), {7.5, kSoft});
}

void SheetPages::Row(const NumberedMeasurement& numbered) {
  Need(kRowHeight);
  const Measurement& m = *numbered.measurement;
  const double base = y_ + 3.65;
  if (row_++ % 2 == 0) canvas_.FillRectangle({kLeft, y_}, {kRight - kLeft, kRowHeight}, kBand);
  if (numbered.number > 0) {
    canvas_.FillDisc({kNumberX, y_ + 0.5 * kRowHeight}, 1.75, ColourOf(GroupOf(m)));
    canvas_.Text({kNumberX, y_ + 0.5 * kRowHeight + 0.75}, std::to_string(numbered.number),
                 {6.0, {1.0, 1.0, 1.0}, Weight::kBold, Align::kCentre});
  }
  const ValueText text = DescribeValue(m, options_.unit);
  canvas_.Text({kTermX, base}, TermIn(m, options_.language), {8.5, kInk});
  canvas_.Text({kValueX, base}, text.value, {9.0, kInk, Weight::kBold, Align::kRight});
  canvas_.Text({kUnitX, base}, text.unit, {7.5, kSoft});
  canvas_.Text({kHalfX, base}, text.half95, {8.5, kInk, Weight::kRegular, Align::kRight});
  canvas_.Text({kShareX, base}, fmt::format("{:.0f} %", std::floor(100.0 * m.measured_share + 1e-9)),
               {8.5, kInk, Weight::kRegular, Align::kRight});
  Mark(m);
  y_ += kRowHeight;
}

void SheetPages::Group(SheetGroup group, const std::vector<NumberedMeasurement>& measurements) {
  const auto in_group = [group](const NumberedMeasurement& m) { return GroupOf(*m.measurement) == group; };
  if (std::none_of(measurements.begin(), measurements.end(), in_group)) return;
  Need(kGroupHeight + 2.0 * kRowHeight + (table_begun_ ? 0.0 : 6.0));  // a title never stands alone
  if (!table_begun_) {
    TableHead();
    table_begun_ = true;
  }
  canvas_.Text({kLeft, y_ + 5.4}, std::string(GroupTitle(group, options_.language)),
               {9.0, ColourOf(group), Weight::kBold});
  y_ += kGroupHeight;
  row_ = 0;
  for (const NumberedMeasurement& numbered : measurements) {
    if (in_group(numbered)) Row(numbered);
  }
}

void SheetPages::Notes() {
  table_begun_ = false;
  Need(kNotesHeight);
  y_ += 3.0;
  canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.25, kRule});
  y_ += 4.5;
  for (const std::string_view note : {words_.interval_note, words_.share_note, words_.limit_note}) {
    y_ += canvas_.Paragraph({kLeft, y_}, kRight - kLeft, std::string(note), {7.0, kSoft}) + 0.8;
  }
}

void SheetPages::Footer() {
  canvas_.Text({kRight, SheetCanvas::kHeight - 8.0}, fmt::format("{} {}", words_.page, page_),
               {7.5, kSoft, Weight::kRegular, Align::kRight});
  canvas_.Text({kLeft, SheetCanvas::kHeight - 8.0}, "annulus", {7.5, kSoft});
}

}  // namespace

Result<std::vector<std::byte>> MeasurementSheet(const MeasurementTable& table, const SurfaceModel& model,
                                                const SheetOptions& options) {
  SheetCanvas canvas{std::string(WordsIn(options.language).title)};
  SheetPages pages(canvas, options);
  const std::vector<NumberedMeasurement> numbered = NumberForSheet(table);
  pages.Header(model.provenance);
  pages.Figures(model, numbered);
  for (int group = 0; group < kSheetGroups; ++group) pages.Group(static_cast<SheetGroup>(group), numbered);
  pages.Notes();
  pages.Footer();
  return canvas.Finish();
}

Status WriteMeasurementSheet(Storage& storage, const std::string& path, const MeasurementTable& table,
                             const SurfaceModel& model, const SheetOptions& options) {
  const auto bytes = MeasurementSheet(table, model, options);
  if (!bytes) return Fail(bytes);
  return WriteFileAtomically(storage, path, std::span<const std::byte>(*bytes));
}

}  // namespace annulus
