#include "modeling/flatten/pattern_svg.h"

#include <fmt/format.h>

#include "base/markup_text.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr double kMargin = 10.0;  ///< mm
constexpr double kSquare = 100.0;
constexpr double kTextHeight = 6.0;

/// Turns y upwards into y downwards.
class SvgWriter {
 public:
  explicit SvgWriter(double height) : height_(height) {}

  [[nodiscard]] Vector2d Down(const Vector2d& p) const { return {p.x() + kMargin, height_ - kMargin - p.y()}; }

  void Chain(const DrawnChain& chain, const char* kind) {
    std::string points;
    for (const Vector2d& point : chain.points) {
      const Vector2d p = Down(point);
      points += fmt::format("{}{:.3f},{:.3f}", points.empty() ? "" : " ", p.x(), p.y());
    }
    const bool closed = chain.end == DrawnChain::End::kClosed;
    text_ += fmt::format("<{} class=\"{}\" points=\"{}\"/>\n", closed ? "polygon" : "polyline", kind, points);
  }
  void Stroke(const DrawnStroke& stroke, const char* kind) { Chain({{stroke[0], stroke[1]}}, kind); }
  void Text(const Vector2d& at, const std::string& words) {
    const Vector2d p = Down(at);
    text_ += fmt::format("<text x=\"{:.3f}\" y=\"{:.3f}\">{}</text>\n", p.x(), p.y(), MarkupText(words));
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  double height_;
  std::string text_;
};

}  // namespace

std::string PatternSvg(const std::vector<DrawnPiece>& pieces, const std::string& title) {
  Eigen::Array2d high(kSquare, kSquare);
  for (const DrawnPiece& piece : pieces) high = high.max(piece.high.array());
  // The check square stands below the pieces.
  const double width = high.x() + 2.0 * kMargin;
  const double height = high.y() + kSquare + 4.0 * kMargin;
  SvgWriter svg(height - kSquare - 2.0 * kMargin);
  for (const DrawnPiece& piece : pieces) {
    svg.Chain(piece.cut, "cut");
    for (const DrawnChain& chain : piece.sew) svg.Chain(chain, "sew");
    for (const DrawnStroke& stroke : piece.grain) svg.Stroke(stroke, "grain");
    for (const DrawnStroke& stroke : piece.notches) svg.Stroke(stroke, "notch");
    for (std::size_t k = 0; k < piece.label.size(); ++k) {
      svg.Text(piece.label_at - 1.4 * kTextHeight * static_cast<double>(k) * Vector2d::UnitY(), piece.label[k]);
    }
  }
  const double foot = -2.0 * kMargin;
  svg.Chain(
      {{{0.0, foot}, {kSquare, foot}, {kSquare, foot - kSquare}, {0.0, foot - kSquare}}, DrawnChain::End::kClosed},
      "check");
  svg.Text({5.0, foot - 12.0}, "100 mm");
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.3f}mm\" height=\"{1:.3f}mm\" "
      "viewBox=\"0 0 {0:.3f} {1:.3f}\">\n<title>{2}</title>\n"
      "<style>polyline,polygon{{fill:none;stroke:#000;stroke-width:.3}}.sew{{stroke:#00c;stroke-dasharray:3 2}}"
      ".grain{{stroke:#080}}.notch{{stroke:#c00}}text{{font:{3:g}px 'DejaVu Sans',sans-serif}}</style>\n{4}</svg>\n",
      width, height, MarkupText(title), kTextHeight, svg.text());
}

}  // namespace annulus
