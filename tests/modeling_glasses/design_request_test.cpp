#include "modeling/glasses/design_request.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "modeling/glasses/boxing.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_fields.h"
#include "modeling/glasses/wall_check.h"
#include "modeling/mesh/triangle_mesh.h"

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
  const DesignRequest request{
      "example2", "", {{"upper-outer", "middle"}, {"bridge-height", "middle"}, {"height", "48"}, {"width", "60"}}};
  const auto composed = ComposeDesign(BuiltInFrameLibrary(), request);
  ASSERT_TRUE(composed) << composed.error().Text();
  EXPECT_DOUBLE_EQ(composed->file.design.parameters.upper_outer, 0.16 * 48.0);
  EXPECT_DOUBLE_EQ(composed->file.design.parameters.bridge_height, 0.6 * 48.0);
}

TEST(DesignRequest, TakesTheLaterOfTwoWishes) {
  const DesignRequest request{"boston", "", {{"pads", "none"}, {"pads", "adjustable"}}};
  EXPECT_EQ(ComposeDesign(BuiltInFrameLibrary(), request)->file.design.details.pads, PadForm::kAdjustable);
}

TEST(DesignRequest, AdjustsExtremesAndSaysSo) {
  const DesignRequest request{"example2", "", {{"upper-outer", "49"}, {"frame-curve", "99"}}};
  const auto composed = ComposeDesign(BuiltInFrameLibrary(), request);
  ASSERT_TRUE(composed) << composed.error().Text();
  EXPECT_TRUE(Validate(composed->file.design));
  EXPECT_THAT(composed->messages, testing::Contains(HasSubstr("upper-outer: 49.000 mm given")));
  EXPECT_THAT(composed->messages, testing::Contains(HasSubstr("frame-curve")));
}

TEST(DesignRequest, CompletesAGrooveAndAHinge) {
  const DesignRequest request{"example1", "", {{"groove-depth", "0.5"}, {"hinge", "barrel"}, {"arm-width", "4"}}};
  const auto composed = ComposeDesign(BuiltInFrameLibrary(), request);
  ASSERT_TRUE(composed) << composed.error().Text();
  EXPECT_THAT(composed->messages, testing::IsEmpty());
  EXPECT_EQ(composed->file.design.details.groove_depth, 0.5);
  EXPECT_EQ(composed->file.design.details.groove_width, 1.0);
  EXPECT_EQ(composed->file.design.details.end_piece, 5.0);
  // And a hinge that is taken away takes its end piece with it.
  const auto bare = ComposeDesign(BuiltInFrameLibrary(), {"boston", "", {{"hinge", "none"}}});
  ASSERT_TRUE(bare) << bare.error().Text();
  EXPECT_THAT(bare->messages, testing::IsEmpty());
}

TEST(DesignRequest, GivesEveryStyleEverySize) {
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    for (const SoldSize& size : style.sizes) {
      const auto composed = ComposeDesign(BuiltInFrameLibrary(), {style.name, size.name, {}});
      ASSERT_TRUE(composed) << style.name << " " << size.name << ": " << composed.error().Text();
      EXPECT_THAT(composed->messages, testing::IsEmpty()) << style.name;
      const auto frame = BuildFrame(composed->file.design, composed->file.adjustment.value());
      ASSERT_TRUE(frame) << style.name << " " << size.name << ": " << frame.error().Text();
      // Sections are the same in all sizes: one of them is looked at (it takes 0.1 s).
      const Status walls = size.name == "medium" ? CheckWalls(*frame, UsualWallLimits(style.material)) : Status{};
      EXPECT_TRUE(walls) << style.name << " " << size.name << ": " << (walls ? "" : walls.error().Text());
      const FrameBoxing boxing = BoxingOf(*frame);
      EXPECT_NEAR(boxing.a, size.a, 1e-6) << style.name;
      EXPECT_NEAR(boxing.dbl, size.dbl, 1e-6) << style.name;
      EXPECT_NEAR(frame->arm_right.overall_length, size.temple, 1e-6) << style.name;
      EXPECT_NEAR(frame->arm_left.overall_length, size.temple, 1e-6) << style.name;
      EXPECT_EQ(SizeText(boxing, size.temple), fmt::format("{}□{}-{}", size.a, size.dbl, size.temple));
      for (const FrameMesh& part : TessellateFrameParts(*frame, {.along = 4, .around = 3})) {
        EXPECT_GT(SignedVolume(part.mesh), 0.0) << style.name << " " << part.name;
      }
    }
  }
}

TEST(DesignRequest, TakesASizeInNumbersAndKeepsAnAskedHeight) {
  const DesignRequest plain{"boston", "50-18-145", {}};
  const auto composed = ComposeDesign(BuiltInFrameLibrary(), plain);
  ASSERT_TRUE(composed) << composed.error().Text();
  const FrameBoxing boxing = BoxingOf(composed->file.design).value();
  EXPECT_NEAR(boxing.a, 50.0, 1e-6);
  EXPECT_NEAR(boxing.dbl, 18.0, 1e-6);
  const DesignRequest taller{"boston", "50-18-145", {{"height", "50"}}};
  const auto tall = ComposeDesign(BuiltInFrameLibrary(), taller);
  ASSERT_TRUE(tall) << tall.error().Text();
  const FrameBoxing box = BoxingOf(tall->file.design).value();
  EXPECT_NEAR(box.a, 50.0, 1e-6);
  EXPECT_NEAR(box.b, BoxingOf(ComposeDesign(BuiltInFrameLibrary(), {"boston", "", {{"height", "50"}}})->file.design)->b,
              1e-6);
}

TEST(DesignRequest, RefusesSizesThatContradictOrDoNotExist) {
  const FrameLibrary& library = BuiltInFrameLibrary();
  EXPECT_THAT(ComposeDesign(library, {"boston", "50-18-145", {{"width", "60"}}}).error().Text(), HasSubstr("width"));
  EXPECT_THAT(ComposeDesign(library, {"boston", "huge", {}}).error().advice,
              HasSubstr("small, medium, large, or give"));
  EXPECT_THAT(ComposeDesign(library, {"boston", "5-18-145", {}}).error().Text(), HasSubstr("a_mm is 5"));
}

TEST(DesignRequest, NamesWhatItDoesNotKnow) {
  EXPECT_THAT(ComposeDesign(BuiltInFrameLibrary(), {"baroque", "", {}}).error().advice, HasSubstr("boston"));
  const auto colour = ComposeDesign(BuiltInFrameLibrary(), {"boston", "", {{"colour", "red"}}});
  EXPECT_THAT(colour.error().Text(), HasSubstr("colour"));
}

}  // namespace
}  // namespace annulus
