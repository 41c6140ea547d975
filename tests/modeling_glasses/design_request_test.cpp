#include "modeling/glasses/design_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "modeling/glasses/frame_fields.h"

namespace annulus {
namespace {

using testing::HasSubstr;

TEST(DesignRequest, WithoutWishesGivesTheStyle) {
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    const auto composed = ComposeDesign(BuiltInFrameLibrary(), {style.name, "", {}});
    ASSERT_TRUE(composed) << composed.error().Text();
    EXPECT_EQ(composed->file.design, style.design) << style.name;
    EXPECT_EQ(composed->file.material, style.material);
    EXPECT_TRUE(composed->messages.empty());
  }
}

TEST(DesignRequest, TakesSharesOfTheFinalSizeWhateverTheOrder) {
  // 16 % of min(60, 48): the corner's word is read after width and height.
  const DesignRequest request{"example2", "", {{"upper-outer", "middle"}, {"bridge-height", "middle"}, {"height", "48"}, {"width", "60"}}};
  const auto composed = ComposeDesign(BuiltInFrameLibrary(), request);
  ASSERT_TRUE(composed) << composed.error().Text();
  EXPECT_DOUBLE_EQ(composed->file.design.parameters.upper_outer, 0.16 * 48.0);
  EXPECT_DOUBLE_EQ(composed->file.design.parameters.bridge_height, 0.6 * 48.0);
}

TEST(DesignRequest, TakesTheLaterOfTwoWishes) {
  const DesignRequest request{"boston", "", {{"pads", "none"}, {"pads", "adjustable"}}};
  EXPECT_EQ(ComposeDesign(BuiltInFrameLibrary(), request)->file.design.details.pads, PadForm::kAdjustable);
}

TEST(DesignRequest, NamesWhatItDoesNotKnow) {
  EXPECT_THAT(ComposeDesign(BuiltInFrameLibrary(), {"baroque", "", {}}).error().advice, HasSubstr("boston"));
  const auto colour = ComposeDesign(BuiltInFrameLibrary(), {"boston", "", {{"colour", "red"}}});
  EXPECT_THAT(colour.error().Text(), HasSubstr("colour"));
}

}  // namespace
}  // namespace annulus
