#include "station/contact_sheet.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/scene.h"

namespace annulus {
namespace {

const LinearRgb kRed(0.7F, 0.1F, 0.05F);
const LinearRgb kBlue(0.05F, 0.1F, 0.7F);

std::ptrdiff_t Count(const RgbImage& image, const LinearRgb& colour) {
  return std::count(image.rgb.begin(), image.rgb.end(), colour);
}

TEST(ContactSheet, KeepsEveryPixelOfItsPictures) {
  const auto sheet = ContactSheet({{RgbImage::Filled(120, 90, kRed), "one"}, {RgbImage::Filled(80, 100, kBlue), "two"}},
                                  {2, "a title"});
  ASSERT_TRUE(sheet.has_value()) << sheet.error().Text();
  EXPECT_EQ(Count(*sheet, kRed), 120 * 90);
  EXPECT_EQ(Count(*sheet, kBlue), 80 * 100);
}

TEST(ContactSheet, FillsRowsFromTheLeft) {
  std::vector<ContactTile> tiles(5, {RgbImage::Filled(60, 60, kRed), "a view"});
  const auto three = ContactSheet(tiles, {3, ""});
  const auto one = ContactSheet(tiles, {1, ""});
  ASSERT_TRUE(three.has_value() && one.has_value());
  EXPECT_GT(three->width, 3 * 60);
  EXPECT_LT(three->width, 4 * 60);
  EXPECT_GT(one->height, 5 * 60);
  // The last cell of the second row is empty: its right end shows no picture.
  for (int y = three->height / 2; y < three->height; ++y) {
    EXPECT_NE(three->rgb[three->Index(three->width - 20, y)], kRed);
  }
}

TEST(ContactSheet, CaptionsStandBelowTheirPictures) {
  const auto sheet = ContactSheet({{RgbImage::Filled(200, 50, LinearRgb::Ones()), "caption"}}, {1, ""});
  ASSERT_TRUE(sheet.has_value());
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < sheet->width; ++x) EXPECT_EQ(sheet->rgb[sheet->Index(x, y)], LinearRgb::Ones());
  }
  EXPECT_LT(Count(*sheet, LinearRgb::Ones()), sheet->width * sheet->height);
}

TEST(ContactSheet, RefusesWhatCannotBeLaidOut) {
  const ContactTile tile{RgbImage::Filled(60, 60, kRed), ""};
  EXPECT_FALSE(ContactSheet({}, {}).has_value());
  EXPECT_FALSE(ContactSheet({tile}, {0, ""}).has_value());
  EXPECT_FALSE(ContactSheet({{RgbImage{}, "none"}}, {}).has_value());
  EXPECT_FALSE(ContactSheet({{RgbImage::Filled(kMaxImageSize, 4, kRed), "wide"}}, {}).has_value());
  const auto many = ContactSheet(std::vector<ContactTile>(400, tile), {1, ""});
  ASSERT_FALSE(many.has_value());
  EXPECT_NE(many.error().Text().find("ask for smaller or fewer views"), std::string::npos);
}

}  // namespace
}  // namespace annulus
