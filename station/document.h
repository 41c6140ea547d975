#pragma once

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "base/result.h"
#include "station/figure.h"

namespace annulus {

/// How something is marked: in words and in colour, so that print without colour says it too.
enum class DocumentMark { kNone, kGood, kDoubtful, kBad };

/// One place of a table.
struct DocumentCell {
  std::string text;
  DocumentMark mark = DocumentMark::kNone;

  DocumentCell() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a row is written as a list of texts
  DocumentCell(std::string words, DocumentMark how = DocumentMark::kNone) : text(std::move(words)), mark(how) {}
  // NOLINTNEXTLINE(google-explicit-constructor): likewise
  DocumentCell(const char* words) : text(words) {}
};

struct DocumentColumn {
  std::string title;
  double share = 1.0;  ///< Of the width, relative to the other columns.
  SheetText::Align align = SheetText::Align::kLeft;
};

struct DocumentTable {
  std::vector<DocumentColumn> columns;          ///< Titles may all be empty: no head.
  std::vector<std::vector<DocumentCell>> rows;  ///< As many cells as columns.
  enum class LastRow { kPlain, kTotal } last_row = LastRow::kPlain;
};

struct DocumentHeading {
  std::string text;
};
struct DocumentParagraph {
  std::string text;
  enum class Size { kText, kNote } size = Size::kText;
};
/// A sentence that nobody may overlook.
struct DocumentNotice {
  std::string title;
  std::string text;
  DocumentMark mark = DocumentMark::kNone;
};
struct DocumentFigure {
  Figure figure;
  std::string caption;
  std::string file;  ///< Name of its own file, without ending.
};
struct DocumentPageBreak {};
/// A line to sign on, with what stands under it.
struct DocumentSignature {
  std::vector<std::string> under;
};

/// A document as a list of blocks: one value for the page (PDF) and the screen (HTML).
struct Document {
  std::string title;
  std::string footer;  ///< On every page of paper.
  std::string language = "en";
  std::vector<std::variant<DocumentHeading, DocumentParagraph, DocumentNotice, DocumentTable, DocumentFigure,
                           DocumentPageBreak, DocumentSignature>>
      blocks;
};

/// One page of HTML, well-formed as XML, that asks for nothing else. Same document, same bytes.
[[nodiscard]] std::string DocumentHtml(const Document& document);

/// A PDF of numbered A4 pages. Same document, same bytes. Fails as SheetCanvas::Finish.
[[nodiscard]] Result<std::vector<std::byte>> DocumentPdf(const Document& document);

}  // namespace annulus
