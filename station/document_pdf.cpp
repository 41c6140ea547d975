#include <fmt/format.h>

#include <algorithm>

#include "station/chart.h"
#include "station/document.h"

namespace annulus {
namespace {

using Align = SheetText::Align;
using Weight = SheetText::Weight;

// mm of the page
constexpr double kLeft = 16.0;
constexpr double kRight = SheetCanvas::kWidth - 16.0;
constexpr double kWidth = kRight - kLeft;
constexpr double kTop = 16.0;
constexpr double kBottom = SheetCanvas::kHeight - 16.0;
constexpr double kCellPad = 1.6;

constexpr SheetColour kInk = chart_colour::kInk;
constexpr SheetColour kSoft = chart_colour::kSoft;
constexpr SheetColour kRule{0.82, 0.84, 0.87};
constexpr SheetColour kBand{0.958, 0.965, 0.972};

constexpr double kCellSize = 8.0;   // pt
constexpr double kTextSize = 9.0;   // pt
constexpr double kNoteSize = 7.5;   // pt
constexpr double kFirstLine = 3.1;  // mm from a text's upper edge to its first baseline, at about 9 pt

SheetColour ColourOf(DocumentMark mark) {
  switch (mark) {
    case DocumentMark::kGood:
      return {0.10, 0.47, 0.29};
    case DocumentMark::kDoubtful:
      return {0.64, 0.36, 0.0};
    case DocumentMark::kBad:
      return chart_colour::kBad;
    case DocumentMark::kNone:
      break;
  }
  return kInk;
}

/// Sets the blocks of a document from top to bottom of its pages.
class PdfWriter {
 public:
  /// `pages`: how many there will be; 0 while they are counted.
  PdfWriter(SheetCanvas& canvas, const Document& document, int pages)
      : canvas_(canvas), document_(document), pages_(pages) {}

  void Title();
  void Footer();
  [[nodiscard]] int page() const { return page_; }

  void operator()(const DocumentHeading& heading);
  void operator()(const DocumentParagraph& paragraph);
  void operator()(const DocumentNotice& notice);
  void operator()(const DocumentTable& table);
  void operator()(const DocumentFigure& figure);
  void operator()(const DocumentPageBreak& page_break);
  void operator()(const DocumentSignature& signature);

 private:
  void NextPage();
  /// Begins a new page if less than `height` is left on this one.
  void Need(double height);
  void DrawHeading();
  void TableHead(const DocumentTable& table);
  void Row(const DocumentTable& table, std::size_t index);
  [[nodiscard]] SheetText CellStyle(const DocumentTable& table, std::size_t row, std::size_t column) const;
  [[nodiscard]] double RowHeight(const DocumentTable& table, std::size_t row);
  void Cell(double x, double width, const std::string& text, const SheetText& style);

  SheetCanvas& canvas_;
  const Document& document_;
  int pages_;
  int page_ = 1;
  double y_ = kTop;      ///< Upper edge of what comes next.
  std::string heading_;  ///< Waits for what follows it: it never stands alone at the foot of a page.
};

std::vector<double> WidthsOf(const DocumentTable& table) {
  double sum = 0.0;
  for (const DocumentColumn& column : table.columns) sum += column.share;
  std::vector<double> widths;
  for (const DocumentColumn& column : table.columns) widths.push_back(kWidth * column.share / sum);
  return widths;
}

void PdfWriter::Title() {
  canvas_.FillRectangle({kLeft, y_}, {2.0, 11.0}, chart_colour::kAfter);
  canvas_.Text({kLeft + 5.0, y_ + 8.4}, document_.title, {19.0, kInk, Weight::kBold});
  y_ += 17.0;
}

void PdfWriter::Footer() {
  const double y = SheetCanvas::kHeight - 8.0;
  canvas_.Text({kLeft, y}, document_.footer, {6.0, kSoft});
  canvas_.Text({kRight, y}, pages_ > 0 ? fmt::format("page {} of {}", page_, pages_) : std::string(),
               {7.0, kSoft, Weight::kRegular, Align::kRight});
}

void PdfWriter::NextPage() {
  Footer();
  canvas_.NextPage();
  ++page_;
  y_ = kTop;
}

void PdfWriter::Need(double height) {
  constexpr double kHeadingHeight = 12.0;
  const double with_heading = height + (heading_.empty() ? 0.0 : kHeadingHeight);
  if (y_ + with_heading > kBottom && y_ > kTop) NextPage();
  DrawHeading();
}

void PdfWriter::DrawHeading() {
  if (heading_.empty()) return;
  if (y_ > kTop) y_ += 4.0;
  canvas_.Text({kLeft, y_ + 4.6}, heading_, {12.5, chart_colour::kAfter, Weight::kBold});
  y_ += 6.6;
  canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.25, kRule});
  y_ += 2.6;
  heading_.clear();
}

void PdfWriter::operator()(const DocumentHeading& heading) { heading_ = heading.text; }

void PdfWriter::operator()(const DocumentParagraph& paragraph) {
  const bool note = paragraph.size == DocumentParagraph::Size::kNote;
  const SheetText style{note ? kNoteSize : kTextSize, note ? kSoft : kInk};
  Need(canvas_.ParagraphHeight(kWidth, paragraph.text, style) + 1.6);
  y_ += canvas_.Paragraph({kLeft, y_ + kFirstLine}, kWidth, paragraph.text, style) + 1.6;
}

void PdfWriter::operator()(const DocumentNotice& notice) {
  const SheetText title{12.0, ColourOf(notice.mark), Weight::kBold};
  const SheetText text{kTextSize, kInk};
  constexpr double kInset = 5.0;
  const double title_height = canvas_.ParagraphHeight(kWidth - kInset - 2.0, notice.title, title);
  const double text_height =
      notice.text.empty() ? 0.0 : canvas_.ParagraphHeight(kWidth - kInset - 2.0, notice.text, text) + 0.6;
  const double height = title_height + text_height + 3.6;
  Need(height + 3.0);
  y_ += 0.8;
  canvas_.FillRectangle({kLeft, y_}, {kWidth, height}, kBand);
  canvas_.FillRectangle({kLeft, y_}, {1.6, height}, ColourOf(notice.mark));
  canvas_.Paragraph({kLeft + kInset, y_ + 1.2 + 4.4}, kWidth - kInset - 2.0, notice.title, title);
  if (!notice.text.empty()) {
    canvas_.Paragraph({kLeft + kInset, y_ + 1.8 + title_height + kFirstLine}, kWidth - kInset - 2.0, notice.text, text);
  }
  y_ += height + 2.6;
}

SheetText PdfWriter::CellStyle(const DocumentTable& table, std::size_t row, std::size_t column) const {
  const DocumentCell& cell = table.rows[row][column];
  const bool total = table.last_row == DocumentTable::LastRow::kTotal && row + 1 == table.rows.size();
  const bool bold = total || cell.mark != DocumentMark::kNone;
  return {kCellSize, ColourOf(cell.mark), bold ? Weight::kBold : Weight::kRegular, table.columns[column].align};
}

double PdfWriter::RowHeight(const DocumentTable& table, std::size_t row) {
  const std::vector<double> widths = WidthsOf(table);
  double height = 0.0;
  for (std::size_t k = 0; k < table.rows[row].size(); ++k) {
    height = std::max(
        height, canvas_.ParagraphHeight(widths[k] - 2.0 * kCellPad, table.rows[row][k].text, CellStyle(table, row, k)));
  }
  return height + 1.7;
}

void PdfWriter::Cell(double x, double width, const std::string& text, const SheetText& style) {
  canvas_.Paragraph({x + kCellPad, y_ + 3.75}, width - 2.0 * kCellPad, text, style);
}

void PdfWriter::TableHead(const DocumentTable& table) {
  const std::vector<double> widths = WidthsOf(table);
  double height = 0.0;
  for (std::size_t k = 0; k < widths.size(); ++k) {
    const SheetText style{7.5, kSoft, Weight::kBold, table.columns[k].align};
    height = std::max(height, canvas_.ParagraphHeight(widths[k] - 2.0 * kCellPad, table.columns[k].title, style));
  }
  if (std::all_of(table.columns.begin(), table.columns.end(),
                  [](const DocumentColumn& column) { return column.title.empty(); })) {
    return;
  }
  double x = kLeft;
  for (std::size_t k = 0; k < widths.size(); ++k) {
    Cell(x, widths[k], table.columns[k].title, {7.5, kSoft, Weight::kBold, table.columns[k].align});
    x += widths[k];
  }
  y_ += height + 1.6;
  canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.35, kSoft});
}

void PdfWriter::Row(const DocumentTable& table, std::size_t index) {
  const double height = RowHeight(table, index);
  if (y_ + height > kBottom) {
    NextPage();
    TableHead(table);
  }
  const bool total = table.last_row == DocumentTable::LastRow::kTotal && index + 1 == table.rows.size();
  if (index % 2 == 0) canvas_.FillRectangle({kLeft, y_}, {kWidth, height}, kBand);
  if (total) canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.35, kSoft});
  const std::vector<double> widths = WidthsOf(table);
  double x = kLeft;
  for (std::size_t k = 0; k < table.rows[index].size(); ++k) {
    Cell(x, widths[k], table.rows[index][k].text, CellStyle(table, index, k));
    x += widths[k];
  }
  y_ += height;
}

void PdfWriter::operator()(const DocumentTable& table) {
  if (table.rows.empty()) return;
  // A short table stays together; a long one begins with its head and two rows.
  constexpr double kHead = 9.0;
  constexpr double kTogether = 70.0;
  double all = kHead;
  for (std::size_t k = 0; k < table.rows.size(); ++k) all += RowHeight(table, k);
  Need(all < kTogether ? all : kHead + RowHeight(table, 0) + (table.rows.size() > 1 ? RowHeight(table, 1) : 0.0));
  TableHead(table);
  for (std::size_t k = 0; k < table.rows.size(); ++k) Row(table, k);
  canvas_.Stroke({{kLeft, y_}, {kRight, y_}}, {0.2, kRule});
  y_ += 3.2;
}

void PdfWriter::operator()(const DocumentFigure& figure) {
  const SheetText style{kNoteSize, kSoft};
  const double caption = canvas_.ParagraphHeight(kWidth, figure.caption, style);
  Need(figure.figure.height_mm() + caption + 4.0);
  figure.figure.DrawOn(canvas_, {kLeft, y_});
  y_ += figure.figure.height_mm() + 1.0;
  y_ += canvas_.Paragraph({kLeft, y_ + 2.7}, kWidth, figure.caption, style) + 3.0;
}

void PdfWriter::operator()(const DocumentPageBreak& /*page_break*/) { NextPage(); }

void PdfWriter::operator()(const DocumentSignature& signature) {
  constexpr double kHeight = 21.0;
  constexpr double kGap = 10.0;
  Need(kHeight);
  y_ += 14.0;
  const auto count = static_cast<double>(signature.under.size());
  const double width = (kWidth - kGap * (count - 1.0)) / count;
  double x = kLeft;
  for (const std::string& under : signature.under) {
    canvas_.Stroke({{x, y_}, {x + width, y_}}, {0.2, kInk});
    canvas_.Text({x, y_ + 3.6}, under, {kNoteSize, kSoft});
    x += width + kGap;
  }
  y_ += 7.0;
}

/// Draws the document; returns the number of its pages.
int Draw(SheetCanvas& canvas, const Document& document, int pages) {
  PdfWriter writer(canvas, document, pages);
  writer.Title();
  for (const auto& block : document.blocks) std::visit(writer, block);
  writer.Footer();
  return writer.page();
}

}  // namespace

Result<std::vector<std::byte>> DocumentPdf(const Document& document) {
  SheetCanvas counted(document.title);
  const int pages = Draw(counted, document, 0);
  SheetCanvas canvas(document.title);
  Draw(canvas, document, pages);
  return canvas.Finish();
}

}  // namespace annulus
