#include "station/figure.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/markup_text.h"
#include "modeling/exchange/base64.h"
#include "render/png.h"

namespace annulus {
namespace {

constexpr double kPoint = 72.0 / 25.4;  // per mm

std::string HexOf(const SheetColour& colour) {
  const auto byte = [](double share) { return std::lround(share * 255.0); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(colour.red), byte(colour.green), byte(colour.blue));
}

std::string PointsOf(const std::vector<Eigen::Vector2d>& points) {
  std::string text;
  for (const Eigen::Vector2d& p : points) text += fmt::format("{}{:.2f},{:.2f}", text.empty() ? "" : " ", p.x(), p.y());
  return text;
}

std::string StrokeAttributes(const SheetStroke& stroke) {
  return fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"{:.2f}\"{}", HexOf(stroke.colour), stroke.width_mm,
                     stroke.dash == SheetStroke::Dash::kDashed ? " stroke-dasharray=\"0.9 0.7\"" : "");
}

/// Each pixel as a square of `factor` pixels: not all programs leave the edges of enlarged pixels sharp.
RgbImage Enlarged(const RgbImage& image, int factor) {
  RgbImage large = RgbImage::Filled(image.width * factor, image.height * factor, LinearRgb::Zero());
  for (int y = 0; y < large.height; ++y) {
    for (int x = 0; x < large.width; ++x) large.rgb[large.Index(x, y)] = image.rgb[image.Index(x / factor, y / factor)];
  }
  return large;
}

}  // namespace

Figure::Figure(double width_mm, double height_mm, std::string title)
    : width_mm_(width_mm), height_mm_(height_mm), title_(std::move(title)) {}

void Figure::FillRectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const SheetColour& colour) {
  const Eigen::Vector2d end = corner + size;
  FillPolygon({corner, {end.x(), corner.y()}, end, {corner.x(), end.y()}}, colour);
}

void Figure::FillPolygon(std::vector<Eigen::Vector2d> points, const SheetColour& colour) {
  items_.emplace_back(Area{std::move(points), colour});
}

void Figure::FillDisc(const Eigen::Vector2d& centre, double radius_mm, const SheetColour& colour) {
  items_.emplace_back(Disc{centre, radius_mm, colour});
}

void Figure::Stroke(std::vector<Eigen::Vector2d> points, const SheetStroke& stroke) {
  items_.emplace_back(Line{std::move(points), stroke});
}

void Figure::StrokeCircle(const Eigen::Vector2d& centre, double radius_mm, const SheetStroke& stroke) {
  items_.emplace_back(Circle{centre, radius_mm, stroke});
}

void Figure::Text(const Eigen::Vector2d& at, std::string text, const SheetText& style) {
  items_.emplace_back(Letters{at, std::move(text), style, Letters::Run::kRight});
}

void Figure::TextUpwards(const Eigen::Vector2d& at, std::string text, const SheetText& style) {
  items_.emplace_back(Letters{at, std::move(text), style, Letters::Run::kUp});
}

void Figure::Cells(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, RgbImage image) {
  items_.emplace_back(Picture{corner, size, std::move(image)});
}

/// Draws one item on a canvas, moved by `corner`.
struct Figure::OnCanvas {
  SheetCanvas& canvas;
  const Eigen::Vector2d& corner;

  [[nodiscard]] std::vector<Eigen::Vector2d> Moved(const std::vector<Eigen::Vector2d>& points) const {
    std::vector<Eigen::Vector2d> moved;
    moved.reserve(points.size());
    for (const Eigen::Vector2d& p : points) moved.emplace_back(p + corner);
    return moved;
  }
  void operator()(const Area& area) const { canvas.Fill({Moved(area.points)}, area.colour); }
  void operator()(const Disc& disc) const { canvas.FillDisc(disc.centre + corner, disc.radius_mm, disc.colour); }
  void operator()(const Line& line) const { canvas.Stroke(Moved(line.points), line.stroke); }
  void operator()(const Circle& circle) const {
    canvas.StrokeCircle(circle.centre + corner, circle.radius_mm, circle.stroke);
  }
  void operator()(const Letters& letters) const {
    if (letters.run == Letters::Run::kRight) {
      canvas.Text(letters.at + corner, letters.text, letters.style);
    } else {
      canvas.TextUpwards(letters.at + corner, letters.text, letters.style);
    }
  }
  void operator()(const Picture& picture) const { canvas.Cells(picture.corner + corner, picture.size, picture.image); }
};

/// Writes one item as an element.
struct Figure::AsSvg {
  std::string& svg;

  void operator()(const Area& area) const {
    svg += fmt::format("<polygon points=\"{}\" fill=\"{}\"/>\n", PointsOf(area.points), HexOf(area.colour));
  }
  void operator()(const Disc& disc) const {
    svg += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" fill=\"{}\"/>\n", disc.centre.x(),
                       disc.centre.y(), disc.radius_mm, HexOf(disc.colour));
  }
  void operator()(const Line& line) const {
    svg += fmt::format("<polyline points=\"{}\" {}/>\n", PointsOf(line.points), StrokeAttributes(line.stroke));
  }
  void operator()(const Circle& circle) const {
    svg += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" {}/>\n", circle.centre.x(), circle.centre.y(),
                       circle.radius_mm, StrokeAttributes(circle.stroke));
  }
  void operator()(const Letters& letters) const {
    using Align = SheetText::Align;
    const SheetText& style = letters.style;
    const char* anchor = style.align == Align::kLeft ? "start" : style.align == Align::kRight ? "end" : "middle";
    svg += fmt::format(
        "<text x=\"{0:.2f}\" y=\"{1:.2f}\" font-size=\"{2:.2f}\" fill=\"{3}\" text-anchor=\"{4}\"{5}{6}>{7}</text>\n",
        letters.at.x(), letters.at.y(), style.size_pt / kPoint, HexOf(style.colour), anchor,
        style.weight == SheetText::Weight::kBold ? " font-weight=\"bold\"" : "",
        letters.run == Letters::Run::kUp
            ? fmt::format(" transform=\"rotate(-90 {:.2f} {:.2f})\"", letters.at.x(), letters.at.y())
            : std::string(),
        MarkupText(letters.text));
  }
  void operator()(const Picture& picture) const {
    constexpr int kFactor = 8;
    const auto png = EncodePng(Enlarged(picture.image, kFactor));
    if (!png) return;  // an image without pixels shows nothing
    svg += fmt::format(
        "<image x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" preserveAspectRatio=\"none\" "
        "image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
        picture.corner.x(), picture.corner.y(), picture.size.x(), picture.size.y(), EncodeBase64(*png));
  }
};

void Figure::DrawOn(SheetCanvas& canvas, const Eigen::Vector2d& corner) const {
  for (const Item& item : items_) std::visit(OnCanvas{canvas, corner}, item);
}

std::string Figure::ToSvg() const {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.1f} {:.1f}\" role=\"img\" aria-label=\"{}\" "
      "stroke-linecap=\"round\" stroke-linejoin=\"round\" font-family=\"'DejaVu Sans', 'Segoe UI', sans-serif\">\n",
      width_mm_, height_mm_, MarkupText(title_));
  for (const Item& item : items_) std::visit(AsSvg{svg}, item);
  return svg + "</svg>\n";
}

Result<RgbImage> Figure::ToImage(double pixels_per_mm) const {
  SheetCanvas canvas = SheetCanvas::Picture({width_mm_, height_mm_}, pixels_per_mm);
  DrawOn(canvas, Eigen::Vector2d::Zero());
  return canvas.FinishPicture();
}

}  // namespace annulus
