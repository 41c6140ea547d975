#include "modeling/glasses/frame_adjust.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "modeling/glasses/frame_limits.h"
#include "random_designs.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

constexpr std::array<double FrameParameters::*, 4> kCorners{
    &FrameParameters::upper_outer, &FrameParameters::upper_inner, &FrameParameters::lower_inner,
    &FrameParameters::lower_outer};

TEST(AdjustDesign, LeavesAValidDesignAlone) {
  for (const test::FrameStyle& style : test::FrameStyles()) {
    const Result<AdjustedDesign> adjusted = AdjustDesign(style.parameters);
    ASSERT_TRUE(adjusted);
    EXPECT_TRUE(adjusted->messages.empty()) << style.name;
    EXPECT_TRUE(adjusted->design == FrameDesign(style.parameters)) << style.name;
  }
}

TEST(AdjustDesign, SaysWhatWasGivenWhatIsUsedAndWhy) {
  FrameDesign design;
  design.parameters.bridge_height = 60.0;
  const Result<AdjustedDesign> adjusted = AdjustDesign(design);
  ASSERT_TRUE(adjusted);
  ASSERT_EQ(adjusted->messages.size(), 1U);
  // 40 - 8/√2 - 2.5/2 = 33.093.
  EXPECT_EQ(adjusted->messages[0],
            "bridge-height: 60.000 mm given, 33.093 mm used: bridge and temples start beside the rim's straight sides");
  EXPECT_NEAR(adjusted->design.parameters.bridge_height, 40.0 - 8.0 / std::numbers::sqrt2 - 1.25, 1e-12);
}

TEST(AdjustDesign, MovesTwoCornersThatDoNotFitTheirSideEqually) {
  FrameDesign design;
  design.parameters.height = 75.0;
  design.parameters.bridge_height = 30.0;
  design.parameters.upper_outer = 24.0;
  design.parameters.upper_inner = 20.0;
  const Result<AdjustedDesign> adjusted = AdjustDesign(design);
  ASSERT_TRUE(adjusted);
  // Their sum may be (50 - (√2 - 1)·2.5)/√2 = 34.623; both give 4.688.
  const double over = 0.5 * (44.0 - (50.0 - (std::numbers::sqrt2 - 1.0) * 2.5) / std::numbers::sqrt2);
  EXPECT_NEAR(adjusted->design.parameters.upper_outer, 24.0 - over, 1e-6);
  EXPECT_NEAR(adjusted->design.parameters.upper_inner, 20.0 - over, 1e-6);
  EXPECT_EQ(adjusted->design.parameters.lower_outer, 8.0);
}

TEST(AdjustDesign, FindsTheNearestCorners) {
  std::mt19937_64 random(20260806);
  for (int draw = 0; draw < 100; ++draw) {
    FrameDesign design;
    for (double FrameParameters::*corner : kCorners) design.parameters.*corner = Uniform(random, 0.0, 30.0);
    const Result<AdjustedDesign> adjusted = AdjustDesign(design);
    ASSERT_TRUE(adjusted);
    double distance = 0.0;
    for (double FrameParameters::*corner : kCorners) {
      distance += std::pow(adjusted->design.parameters.*corner - design.parameters.*corner, 2);
    }
    // Nothing valid in a hundred steps around it is nearer to what was asked.
    for (int step = 0; step < 100; ++step) {
      FrameDesign other = adjusted->design;
      double other_distance = 0.0;
      double high = 0.0;
      double low = 0.0;
      for (std::size_t k = 0; k < 4; ++k) {
        double& cut = other.parameters.*kCorners[k];
        cut += Uniform(random, -0.5, 0.5);
        other_distance += std::pow(cut - design.parameters.*kCorners[k], 2);
        (k < 2 ? high : low) = std::max(k < 2 ? high : low, cut);
      }
      // Any bridge height that these corners leave.
      other.parameters.bridge_height = 0.5 * (40.0 + (low - high) / std::numbers::sqrt2);
      if (!Validate(other)) continue;
      EXPECT_GE(other_distance, distance - 1e-6) << draw;
    }
  }
}

TEST(AdjustDesign, ReplacesWhatARimlessFrameCannotHave) {
  FrameDesign design;
  design.details.rim = RimForm::kRimless;
  design.details.bridge = BridgeForm::kKeyhole;
  design.details.pads = PadForm::kFixed;
  design.details.groove_depth = 0.7;
  design.details.groove_width = 1.2;
  EXPECT_FALSE(Validate(design));
  const Result<AdjustedDesign> adjusted = AdjustDesign(design);
  ASSERT_TRUE(adjusted);
  EXPECT_EQ(adjusted->design.details.bridge, BridgeForm::kSaddle);
  EXPECT_EQ(adjusted->design.details.pads, PadForm::kAdjustable);
  EXPECT_EQ(adjusted->design.details.groove_depth, 0.0);
  EXPECT_EQ(adjusted->messages.size(), 4U);
  EXPECT_TRUE(Validate(adjusted->design));
}

TEST(AdjustDesign, GivesAHingeAnEndPieceAndATempleThatHoldIt) {
  FrameDesign design;
  design.parameters.upper_thickness = 1.5;
  design.details.hinge = HingeForm::kBarrel;
  const Result<AdjustedDesign> adjusted = AdjustDesign(design);
  ASSERT_TRUE(adjusted);
  EXPECT_EQ(adjusted->design.details.arm_width, 2.5);
  // Half the depth of the solid, .6 and .6 of room, half a knuckle of 2.6: 0.375 · 2.5 + 1.2 + 1.3.
  EXPECT_NEAR(adjusted->design.details.end_piece, 3.4375, 1e-12);
}

TEST(AdjustDesign, TakesTheWildestFiniteNumbers) {
  const std::array<double, 6> values{0.0, -1.0, 1e-300, -1e300, 1e300, std::numeric_limits<double>::max()};
  std::mt19937_64 random(20260807);
  for (int draw = 0; draw < 3000; ++draw) {
    FrameDesign design = WildDesign(random);
    for (const FrameParameterField& field : FrameParameterFields()) {
      if (random() % 3 == 0) design.parameters.*field.member = values[random() % values.size()];
    }
    for (const DetailRule& rule : DetailRules()) {
      if (random() % 3 != 0) continue;
      const double value = values[random() % values.size()];
      if (rule.member != nullptr) {
        design.details.*rule.member = value;
      } else {
        design.details.*rule.optional_member = value;
      }
    }
    const Result<AdjustedDesign> adjusted = AdjustDesign(design);
    ASSERT_TRUE(adjusted);
    const Status valid = Validate(adjusted->design);
    ASSERT_TRUE(valid) << draw << ": " << valid.error().Text();
    const auto frame = BuildFrame(adjusted->design, StandardAdjustment(adjusted->design));
    ASSERT_TRUE(frame) << draw << ": " << frame.error().Text();
  }
}

TEST(AdjustDesign, RefusesWhatIsNotANumber) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    FrameDesign design;
    design.parameters.lower_inner = bad;
    EXPECT_FALSE(AdjustDesign(design));
    EXPECT_FALSE(Validate(design));
    design = FrameDesign();
    design.details.arm_height = bad;
    EXPECT_FALSE(AdjustDesign(design));
    EXPECT_FALSE(Validate(design));
    design = FrameDesign();
    design.details.tip_length = bad;
    EXPECT_FALSE(AdjustDesign(design));
    EXPECT_FALSE(Validate(design));
  }
}

}  // namespace
}  // namespace annulus
