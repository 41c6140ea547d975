#include <fmt/format.h>

#include <algorithm>

#include "base/markup_text.h"
#include "station/document.h"

namespace annulus {
namespace {

constexpr const char* kStyleSheet = R"css(
:root { color-scheme: light; --text:#1d2430; --soft:#5b6675; --line:#d9dee4; --band:#f5f7f9; --accent:#0f5f74;
  --good:#1a7f4b; --doubtful:#a35c00; --bad:#b32a1f; }
* { box-sizing: border-box; }
body { margin:0; background:#eef0f2; color:var(--text); font:15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width:60rem; margin:1.5rem auto; padding:2.5rem 3rem 3rem; background:#fff; border:1px solid var(--line); }
h1 { font-size:1.9rem; margin:0 0 1.2rem; padding-left:.8rem; border-left:.5rem solid var(--accent); letter-spacing:-.01em; }
h2 { font-size:1.25rem; margin:2.4rem 0 .7rem; padding-top:1rem; border-top:1px solid var(--line); break-after:avoid; }
p { margin:.5rem 0; max-width:50rem; } p.note { color:var(--soft); font-size:.86rem; }
table { border-collapse:collapse; width:100%; margin:.8rem 0; font-size:.88rem; font-variant-numeric:tabular-nums; }
th, td { padding:.32rem .6rem; border-bottom:1px solid var(--line); vertical-align:top; text-align:left; }
th { color:var(--soft); font-weight:600; border-bottom:2px solid var(--soft); vertical-align:bottom; }
tbody tr:nth-child(odd) { background:var(--band); } tr.total td { font-weight:600; border-top:2px solid var(--soft); }
tr { break-inside:avoid; } .right { text-align:right; } td.right { white-space:nowrap; } .centre { text-align:center; }
.good { color:var(--good); font-weight:600; } .doubtful { color:var(--doubtful); font-weight:600; }
.bad { color:var(--bad); font-weight:600; }
.notice { margin:1rem 0; padding:.7rem 1rem; border-left:.4rem solid var(--accent); background:var(--band); break-inside:avoid; }
.notice b { display:block; font-size:1.12rem; } .notice.good { border-color:var(--good); font-weight:400; }
.notice.doubtful { border-color:var(--doubtful); font-weight:400; } .notice.bad { border-color:var(--bad); font-weight:400; }
.notice span { color:var(--text); }
figure { margin:1rem 0; break-inside:avoid; } figure svg { display:block; width:100%; height:auto; }
figcaption { color:var(--soft); font-size:.86rem; margin-top:.3rem; max-width:50rem; }
.sign { display:flex; gap:3rem; margin:4rem 0 1rem; } .sign span { flex:1; border-top:1px solid var(--text);
  padding-top:.2rem; color:var(--soft); font-size:.86rem; }
.page { border-top:3px solid var(--accent); margin:3rem 0 2rem; }
@page { size:A4; margin:14mm; }
@media print { body { background:#fff; font-size:9.5pt; print-color-adjust:exact; -webkit-print-color-adjust:exact; }
  main { margin:0; padding:0; border:0; max-width:none; } .page { break-before:page; border:0; margin:0; } }
@media (max-width:44rem) { main { padding:1.2rem; margin:0; } .scroll { overflow-x:auto; } }
)css";

const char* ClassOf(DocumentMark mark) {
  switch (mark) {
    case DocumentMark::kGood:
      return "good";
    case DocumentMark::kDoubtful:
      return "doubtful";
    case DocumentMark::kBad:
      return "bad";
    case DocumentMark::kNone:
      break;
  }
  return "";
}

const char* ClassOf(SheetText::Align align) {
  switch (align) {
    case SheetText::Align::kRight:
      return "right";
    case SheetText::Align::kCentre:
      return "centre";
    case SheetText::Align::kLeft:
      break;
  }
  return "";
}

/// A class attribute of the names that are not empty.
std::string Classes(const std::string& first, const std::string& second) {
  const std::string both = first + (first.empty() || second.empty() ? "" : " ") + second;
  return both.empty() ? "" : fmt::format(" class=\"{}\"", both);
}

/// Writes one block.
struct HtmlWriter {
  std::string& html;

  void operator()(const DocumentHeading& heading) const { html += "<h2>" + MarkupText(heading.text) + "</h2>\n"; }
  void operator()(const DocumentParagraph& paragraph) const {
    const bool note = paragraph.size == DocumentParagraph::Size::kNote;
    html += fmt::format("<p{}>{}</p>\n", Classes(note ? "note" : "", ""), MarkupText(paragraph.text));
  }
  void operator()(const DocumentNotice& notice) const {
    html += fmt::format("<div{}><b>{}</b><span>{}</span></div>\n", Classes("notice", ClassOf(notice.mark)),
                        MarkupText(notice.title), MarkupText(notice.text));
  }
  void operator()(const DocumentTable& table) const {
    html += "<div class=\"scroll\"><table>\n";
    const bool head = std::any_of(table.columns.begin(), table.columns.end(),
                                  [](const DocumentColumn& column) { return !column.title.empty(); });
    if (head) {
      html += "<thead><tr>";
      for (const DocumentColumn& column : table.columns) {
        html += fmt::format("<th{}>{}</th>", Classes(ClassOf(column.align), ""), MarkupText(column.title));
      }
      html += "</tr></thead>\n";
    }
    html += "<tbody>\n";
    for (const auto& row : table.rows) {
      const bool total = table.last_row == DocumentTable::LastRow::kTotal && &row == &table.rows.back();
      html += total ? "<tr class=\"total\">" : "<tr>";
      for (std::size_t k = 0; k < row.size(); ++k) {
        html += fmt::format("<td{}>{}</td>", Classes(ClassOf(table.columns[k].align), ClassOf(row[k].mark)),
                            MarkupText(row[k].text));
      }
      html += "</tr>\n";
    }
    html += "</tbody></table></div>\n";
  }
  void operator()(const DocumentFigure& figure) const {
    html +=
        "<figure>" + figure.figure.ToSvg() + "<figcaption>" + MarkupText(figure.caption) + "</figcaption></figure>\n";
  }
  void operator()(const DocumentPageBreak& /*unused*/) const { html += "<div class=\"page\"></div>\n"; }
  void operator()(const DocumentSignature& signature) const {
    html += "<div class=\"sign\">";
    for (const std::string& under : signature.under) html += "<span>" + MarkupText(under) + "</span>";
    html += "</div>\n";
  }
};

}  // namespace

std::string DocumentHtml(const Document& document) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"{}\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n<style>",
      document.language, MarkupText(document.title));
  html += kStyleSheet;
  html += "</style>\n</head>\n<body>\n<main>\n<h1>" + MarkupText(document.title) + "</h1>\n";
  for (const auto& block : document.blocks) std::visit(HtmlWriter{html}, block);
  html += "<p class=\"note\">" + MarkupText(document.footer) + "</p>\n";
  return html + "</main>\n</body>\n</html>\n";
}

}  // namespace annulus
