#include "station/sheet_canvas.h"

#include <cairo-pdf.h>
#include <pango/pangocairo.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace annulus {
namespace {

constexpr double kPoint = 72.0 / 25.4;  // per mm
/// Both scripts in one design; the second where only Debian's smallest set is installed.
constexpr const char* kFamily = "Noto Sans CJK JP, DejaVu Sans";
constexpr double kLineSpacing = 1.35;  // of the size

struct Release {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(PangoLayout* layout) const { g_object_unref(layout); }
  void operator()(PangoFontDescription* font) const { pango_font_description_free(font); }
};
using Surface = std::unique_ptr<cairo_surface_t, Release>;
using Context = std::unique_ptr<cairo_t, Release>;
using Layout = std::unique_ptr<PangoLayout, Release>;
using Font = std::unique_ptr<PangoFontDescription, Release>;

cairo_status_t Collect(void* bytes, const unsigned char* data, unsigned int length) {
  auto& all = *static_cast<std::vector<std::byte>*>(bytes);
  const auto* first = reinterpret_cast<const std::byte*>(data);
  all.insert(all.end(), first, first + length);
  return CAIRO_STATUS_SUCCESS;
}

/// The linear value of each byte of a picture.
std::array<float, 256> LinearBytes() {
  std::array<float, 256> linear{};
  for (std::size_t k = 0; k < linear.size(); ++k) {
    linear[k] = static_cast<float>(LinearFromSrgb(static_cast<double>(k) / 255.0));
  }
  return linear;
}

}  // namespace

struct SheetCanvas::State {
  std::vector<std::byte> bytes;
  Surface surface;
  Context context;
  std::string unknown;  ///< The first text with a letter that no font has.

  /// Makes the context of the surface, in which one unit is one mm.
  void Begin(double per_mm) {
    context.reset(cairo_create(surface.get()));
    cairo_scale(context.get(), per_mm, per_mm);
    cairo_set_line_join(context.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_cap(context.get(), CAIRO_LINE_CAP_ROUND);
    cairo_set_fill_rule(context.get(), CAIRO_FILL_RULE_EVEN_ODD);
    // Metrics must not depend on the scale, or widths would jump with the device's hinting.
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_set_font_options(context.get(), options);
    cairo_font_options_destroy(options);
  }

  /// An error that stands in the way of finishing, if any.
  [[nodiscard]] Status Check(const char* attempted) const {
    if (!unknown.empty()) {
      return Fail("set the text '" + unknown + "'", "no font on this machine has all of its letters",
                  "install Debian's fonts-noto-cjk, or take another language");
    }
    const cairo_status_t status = cairo_surface_status(surface.get());
    if (status == CAIRO_STATUS_SUCCESS) return {};
    return Fail(attempted, cairo_status_to_string(status), "check the memory of this machine, and report this");
  }

  void Colour(const SheetColour& c) const { cairo_set_source_rgb(context.get(), c.red, c.green, c.blue); }

  void Path(const std::vector<Eigen::Vector2d>& points) const {
    for (std::size_t k = 0; k < points.size(); ++k) {
      (k == 0 ? cairo_move_to : cairo_line_to)(context.get(), points[k].x(), points[k].y());
    }
  }

  void Draw(const SheetStroke& stroke) const {
    constexpr double kDashes[] = {0.9, 0.7};
    Colour(stroke.colour);
    cairo_set_line_width(context.get(), stroke.width_mm);
    cairo_set_dash(context.get(), kDashes, stroke.dash == SheetStroke::Dash::kDashed ? 2 : 0, 0.0);
    cairo_stroke(context.get());
  }

  /// The text set in mm: one unit of the layout is one mm.
  Layout Set(const std::string& text, const SheetText& style) {
    Layout layout(pango_cairo_create_layout(context.get()));
    // One unit is one mm: letters must not be rounded to whole ones.
    pango_context_set_round_glyph_positions(pango_layout_get_context(layout.get()), FALSE);
    const Font font(pango_font_description_from_string(kFamily));
    const bool bold = style.weight == SheetText::Weight::kBold;
    pango_font_description_set_weight(font.get(), bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
    pango_font_description_set_absolute_size(font.get(), style.size_pt / kPoint * PANGO_SCALE);
    pango_layout_set_font_description(layout.get(), font.get());
    pango_layout_set_text(layout.get(), text.c_str(), -1);
    if (pango_layout_get_unknown_glyphs_count(layout.get()) > 0 && unknown.empty()) unknown = text;
    return layout;
  }
};

SheetCanvas::SheetCanvas(const std::string& title, PageTurn turn) : state_(std::make_unique<State>()) {
  const double width = turn == PageTurn::kUpright ? kWidth : kHeight;
  const double height = turn == PageTurn::kUpright ? kHeight : kWidth;
  state_->surface.reset(cairo_pdf_surface_create_for_stream(Collect, &state_->bytes, width * kPoint, height * kPoint));
  cairo_pdf_surface_set_metadata(state_->surface.get(), CAIRO_PDF_METADATA_TITLE, title.c_str());
  cairo_pdf_surface_set_metadata(state_->surface.get(), CAIRO_PDF_METADATA_CREATOR, "annulus");
  cairo_pdf_surface_set_metadata(state_->surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
  state_->Begin(kPoint);
}

SheetCanvas::SheetCanvas(const Eigen::Vector2d& size_mm, double pixels_per_mm) : state_(std::make_unique<State>()) {
  const auto pixels = [pixels_per_mm](double mm) { return static_cast<int>(std::lround(mm * pixels_per_mm)); };
  state_->surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, pixels(size_mm.x()), pixels(size_mm.y())));
  state_->Begin(pixels_per_mm);
  FillRectangle(Eigen::Vector2d::Zero(), size_mm + Eigen::Vector2d::Ones(), {1.0, 1.0, 1.0});
}

SheetCanvas::~SheetCanvas() = default;

void SheetCanvas::NextPage() { cairo_show_page(state_->context.get()); }

void SheetCanvas::Fill(const std::vector<std::vector<Eigen::Vector2d>>& loops, const SheetColour& colour) {
  for (const auto& loop : loops) {
    state_->Path(loop);
    cairo_close_path(state_->context.get());
  }
  state_->Colour(colour);
  cairo_fill(state_->context.get());
}

void SheetCanvas::FillRectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const SheetColour& colour) {
  cairo_rectangle(state_->context.get(), corner.x(), corner.y(), size.x(), size.y());
  state_->Colour(colour);
  cairo_fill(state_->context.get());
}

void SheetCanvas::FillDisc(const Eigen::Vector2d& centre, double radius_mm, const SheetColour& colour) {
  cairo_new_path(state_->context.get());
  cairo_arc(state_->context.get(), centre.x(), centre.y(), radius_mm, 0.0, 2.0 * std::numbers::pi);
  state_->Colour(colour);
  cairo_fill(state_->context.get());
}

void SheetCanvas::Stroke(const std::vector<Eigen::Vector2d>& points, const SheetStroke& stroke) {
  state_->Path(points);
  state_->Draw(stroke);
}

void SheetCanvas::StrokeCircle(const Eigen::Vector2d& centre, double radius_mm, const SheetStroke& stroke) {
  cairo_new_path(state_->context.get());
  cairo_arc(state_->context.get(), centre.x(), centre.y(), radius_mm, 0.0, 2.0 * std::numbers::pi);
  cairo_close_path(state_->context.get());
  state_->Draw(stroke);
}

void SheetCanvas::Text(const Eigen::Vector2d& at, const std::string& text, const SheetText& style) {
  const Layout layout = state_->Set(text, style);
  PangoRectangle extent;
  pango_layout_get_extents(layout.get(), nullptr, &extent);
  const double width = static_cast<double>(extent.width) / PANGO_SCALE;
  double x = at.x();
  if (style.align == SheetText::Align::kRight) x -= width;
  if (style.align == SheetText::Align::kCentre) x -= 0.5 * width;
  state_->Colour(style.colour);
  cairo_move_to(state_->context.get(), x, at.y());
  pango_cairo_show_layout_line(state_->context.get(), pango_layout_get_line_readonly(layout.get(), 0));
  cairo_new_path(state_->context.get());
}

void SheetCanvas::TextUpwards(const Eigen::Vector2d& at, const std::string& text, const SheetText& style) {
  cairo_save(state_->context.get());
  cairo_translate(state_->context.get(), at.x(), at.y());
  cairo_rotate(state_->context.get(), -0.5 * std::numbers::pi);
  Text(Eigen::Vector2d::Zero(), text, style);
  cairo_restore(state_->context.get());
}

void SheetCanvas::Cells(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const RgbImage& image) {
  const Surface pixels(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  unsigned char* bytes = cairo_image_surface_get_data(pixels.get());
  const std::ptrdiff_t stride = cairo_image_surface_get_stride(pixels.get());
  for (int y = 0; y < image.height; ++y) {
    auto* row = reinterpret_cast<std::uint32_t*>(bytes + y * stride);
    for (int x = 0; x < image.width; ++x) {
      const LinearRgb& rgb = image.rgb[image.Index(x, y)];
      row[x] = static_cast<std::uint32_t>(SrgbByteFromLinear(rgb[0])) << 16U |
               static_cast<std::uint32_t>(SrgbByteFromLinear(rgb[1])) << 8U |
               static_cast<std::uint32_t>(SrgbByteFromLinear(rgb[2]));
    }
  }
  cairo_surface_mark_dirty(pixels.get());
  cairo_t* context = state_->context.get();
  cairo_save(context);
  cairo_translate(context, corner.x(), corner.y());
  cairo_scale(context, size.x() / image.width, size.y() / image.height);
  cairo_set_source_surface(context, pixels.get(), 0.0, 0.0);
  cairo_pattern_set_filter(cairo_get_source(context), CAIRO_FILTER_NEAREST);
  cairo_rectangle(context, 0.0, 0.0, image.width, image.height);
  cairo_fill(context);
  cairo_restore(context);
}

double SheetCanvas::Paragraph(const Eigen::Vector2d& at, double width_mm, const std::string& text,
                              const SheetText& style) {
  const Layout layout = state_->Set(text, style);
  pango_layout_set_width(layout.get(), static_cast<int>(width_mm * PANGO_SCALE));
  pango_layout_set_wrap(layout.get(), PANGO_WRAP_WORD_CHAR);
  const double step = kLineSpacing * style.size_pt / kPoint;
  const int lines = pango_layout_get_line_count(layout.get());
  state_->Colour(style.colour);
  for (int k = 0; k < lines; ++k) {
    PangoLayoutLine* line = pango_layout_get_line_readonly(layout.get(), k);
    PangoRectangle extent;
    pango_layout_line_get_extents(line, nullptr, &extent);
    const double room = width_mm - static_cast<double>(extent.width) / PANGO_SCALE;
    double x = at.x();
    if (style.align == SheetText::Align::kRight) x += room;
    if (style.align == SheetText::Align::kCentre) x += 0.5 * room;
    cairo_move_to(state_->context.get(), x, at.y() + k * step);
    pango_cairo_show_layout_line(state_->context.get(), line);
  }
  cairo_new_path(state_->context.get());
  return lines * step;
}

double SheetCanvas::ParagraphHeight(double width_mm, const std::string& text, const SheetText& style) {
  const Layout layout = state_->Set(text, style);
  pango_layout_set_width(layout.get(), static_cast<int>(width_mm * PANGO_SCALE));
  pango_layout_set_wrap(layout.get(), PANGO_WRAP_WORD_CHAR);
  return pango_layout_get_line_count(layout.get()) * kLineSpacing * style.size_pt / kPoint;
}

double SheetCanvas::TextWidth(const std::string& text, const SheetText& style) {
  PangoRectangle extent;
  pango_layout_get_extents(state_->Set(text, style).get(), nullptr, &extent);
  return static_cast<double>(extent.width) / PANGO_SCALE;
}

Result<std::vector<std::byte>> SheetCanvas::Finish() {
  cairo_surface_finish(state_->surface.get());
  RETURN_IF_ERROR(state_->Check("make a PDF"));
  return std::move(state_->bytes);
}

Result<RgbImage> SheetCanvas::FinishPicture() {
  cairo_surface_flush(state_->surface.get());
  RETURN_IF_ERROR(state_->Check("make a picture"));
  const std::array<float, 256> linear = LinearBytes();
  const unsigned char* bytes = cairo_image_surface_get_data(state_->surface.get());
  const std::ptrdiff_t stride = cairo_image_surface_get_stride(state_->surface.get());
  RgbImage image = RgbImage::Filled(cairo_image_surface_get_width(state_->surface.get()),
                                    cairo_image_surface_get_height(state_->surface.get()), LinearRgb::Zero());
  for (int y = 0; y < image.height; ++y) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(bytes + y * stride);
    for (int x = 0; x < image.width; ++x) {
      image.rgb[image.Index(x, y)] =
          LinearRgb(linear[row[x] >> 16U & 255U], linear[row[x] >> 8U & 255U], linear[row[x] & 255U]);
    }
  }
  return image;
}

}  // namespace annulus
