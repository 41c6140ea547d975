#include "station/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>

#include "render/canvas.h"
#include "render/scene.h"

namespace annulus {
namespace {

constexpr int kMargin = 12;
constexpr int kGap = 10;
constexpr int kCaptionHeight = 26;
constexpr int kTitleHeight = 34;
/// Widest character of the canvas' small text, pixels: what a caption is cut by.
constexpr double kCharacter = 8.0;

/// Where things stand on the sheet, pixels.
struct Plan {
  int cell_width = 0;
  int cell_height = 0;
  int columns = 1;
  int top = kMargin;
  int width = 0;
  int height = 0;

  [[nodiscard]] int Left(std::size_t k) const {
    return kMargin + static_cast<int>(k % static_cast<std::size_t>(columns)) * (cell_width + kGap);
  }
  [[nodiscard]] int Top(std::size_t k) const {
    return top + static_cast<int>(k / static_cast<std::size_t>(columns)) * (cell_height + kCaptionHeight + kGap);
  }
};

Result<Plan> PlanOf(const std::vector<ContactTile>& tiles, const ContactSheetOptions& options) {
  const auto refuse = [](std::string seen, std::string advice) {
    return Fail("lay out a contact sheet", std::move(seen), std::move(advice));
  };
  if (tiles.empty()) return refuse("there is no picture", "give at least one view");
  if (options.columns < 1 || options.columns > 64) {
    return refuse(fmt::format("{} columns are out of range", options.columns), "ask for 1 to 64");
  }
  Plan plan;
  plan.columns = std::min(options.columns, static_cast<int>(tiles.size()));
  for (const ContactTile& tile : tiles) {
    const RgbImage& image = tile.image;
    const bool is_whole =
        image.width > 0 && image.height > 0 &&
        image.rgb.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (!is_whole) return refuse("a picture has no pixels", "draw it again");
    plan.cell_width = std::max(plan.cell_width, image.width);
    plan.cell_height = std::max(plan.cell_height, image.height);
  }
  if (!options.title.empty()) plan.top += kTitleHeight;
  const std::size_t rows =
      (tiles.size() + static_cast<std::size_t>(plan.columns) - 1) / static_cast<std::size_t>(plan.columns);
  // In double: the product of large pictures and many rows may not fit an int.
  const double width = 2.0 * kMargin + plan.columns * (1.0 * plan.cell_width + kGap) - kGap;
  const double height =
      plan.top + static_cast<double>(rows) * (1.0 * plan.cell_height + kCaptionHeight + kGap) - kGap + kMargin;
  if (width > kMaxImageSize || height > kMaxImageSize) {
    return refuse(
        fmt::format("it would have {:.0f} x {:.0f} pixels, more than {} a side", width, height, kMaxImageSize),
        "ask for smaller or fewer views");
  }
  plan.width = static_cast<int>(width);
  plan.height = static_cast<int>(height);
  return plan;
}

/// Copies the picture's pixels as they are: a canvas would round them to bytes.
void Put(RgbImage& sheet, const RgbImage& image, int left, int top) {
  for (int y = 0; y < image.height; ++y) {
    const auto from = image.rgb.begin() + static_cast<std::ptrdiff_t>(image.Index(0, y));
    std::copy(from, from + image.width, sheet.rgb.begin() + static_cast<std::ptrdiff_t>(sheet.Index(left, top + y)));
  }
}

}  // namespace

Result<RgbImage> ContactSheet(const std::vector<ContactTile>& tiles, const ContactSheetOptions& options) {
  const Result<Plan> plan = PlanOf(tiles, options);
  if (!plan) return Fail(plan);
  Canvas canvas(plan->width, plan->height);
  if (!options.title.empty()) {
    canvas.Text(options.title, {0.5 * plan->width, kMargin + 20.0}, kTitleText, Anchor::kCentre);
  }
  const auto longest = static_cast<std::size_t>(plan->cell_width / kCharacter);
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    std::string caption = tiles[k].caption;
    if (caption.size() > longest) caption.resize(longest);
    canvas.Text(caption, {plan->Left(k) + 0.5 * plan->cell_width, plan->Top(k) + plan->cell_height + 17.0}, kSmallText,
                Anchor::kCentre);
  }
  RgbImage sheet = canvas.ToImage();
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    const RgbImage& image = tiles[k].image;
    Put(sheet, image, plan->Left(k) + (plan->cell_width - image.width) / 2,
        plan->Top(k) + (plan->cell_height - image.height) / 2);
  }
  return sheet;
}

}  // namespace annulus
