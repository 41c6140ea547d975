// Landmarks on heads that differ as people's do and whose eyes, ears and nose are known exactly.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "modeling/landmarks/face_points.h"
#include "modeling/landmarks/head_without_ears.h"
#include "modeling/landmarks/nose_flank.h"
#include "sim/random_head.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A head, its surface, and what was found on it.
struct KnownHead {
  sim::HeadVariation variation;
  sim::ParametricBody body;
  sim::FaceTruth truth;
  SurfaceModel model;
  FaceAndEars found;

  [[nodiscard]] const SplineSurface& surface() const { return model.main().surface; }
  [[nodiscard]] Vector3d right() const {
    return {std::cos(variation.placement.yaw_rad), std::sin(variation.placement.yaw_rad), 0.0};
  }
  [[nodiscard]] Vector3d forward() const { return {-right().y(), right().x(), 0.0}; }
};

/// 20 heads; ANNULUS_LONG: 200.
const std::vector<std::unique_ptr<KnownHead>>& Heads() {
  static const std::vector<std::unique_ptr<KnownHead>> all = [] {
    const std::uint64_t count = std::getenv("ANNULUS_LONG") != nullptr ? 200 : 20;
    std::vector<std::unique_ptr<KnownHead>> heads;
    for (std::uint64_t seed = 1; seed <= count; ++seed) {
      const sim::HeadVariation variation = sim::DrawHeadVariation(seed);
      const sim::ParametricBody body = sim::MakeVariedHead(variation);
      SurfaceModel model = test::HeadSurface(body);
      const SplineSurface& surface = model.main().surface;
      auto found = FindFaceAndEars(surface, HeadGrid(surface, kHeadDepth));
      EXPECT_TRUE(found) << seed;
      if (!found) continue;
      heads.push_back(
          std::make_unique<KnownHead>(KnownHead{variation, body, body.face(), std::move(model), std::move(*found)}));
    }
    return heads;
  }();
  return all;
}

/// Sizes of errors over the heads, printed; the largest of them.
class Errors {
 public:
  explicit Errors(std::string what) : what_(std::move(what)) {}
  void Add(double error) { sizes_.push_back(std::abs(error)); }
  [[nodiscard]] double Largest() {
    std::sort(sizes_.begin(), sizes_.end());
    const auto at = [&](double share) { return sizes_[static_cast<std::size_t>(share * double(sizes_.size() - 1))]; };
    std::printf("%-44s median %.2f, 95 %% %.2f, largest %.2f (%zu)\n", what_.c_str(), at(0.5), at(0.95), at(1.0),
                sizes_.size());
    return sizes_.back();
  }

 private:
  std::string what_;
  std::vector<double> sizes_;
};

TEST(RandomHeads, HavePupillaryDistancesWithinHalfAMillimetre) {
  Errors both("pupillary distance, mm");
  Errors one("monocular, from the sellion, mm");
  for (const auto& head : Heads()) {
    const FacePoints& face = head->found.face;
    const auto across = [&](const Vector3d& a, const Vector3d& b) { return head->right().dot(a - b); };
    both.Add(across(face.eye_right.position, face.eye_left.position) -
             across(head->truth.right_eye, head->truth.left_eye));
    one.Add(across(face.eye_right.position, face.sellion.position) -
            across(head->truth.right_eye, head->truth.sellion));
    one.Add(across(face.eye_left.position, face.sellion.position) - across(head->truth.left_eye, head->truth.sellion));
    EXPECT_EQ(face.eye_right.source, LandmarkSource::kDetected);
    EXPECT_TRUE(head->found.eyeballs.right && head->found.eyeballs.left);
  }
  EXPECT_LE(both.Largest(), 0.5);
  EXPECT_LE(one.Largest(), 0.5);
}

TEST(RandomHeads, HaveEyeHeightsWithinHalfAMillimetre) {
  Errors height("eye height, mm");
  Errors depth("cornea's apex, forwards, mm");
  for (const auto& head : Heads()) {
    for (const auto& [found, truth] : {std::pair{head->found.face.eye_right.position, head->truth.right_eye},
                                       std::pair{head->found.face.eye_left.position, head->truth.left_eye}}) {
      height.Add(found.z() - truth.z());
      depth.Add(head->forward().dot(found - truth));
    }
  }
  EXPECT_LE(height.Largest(), 0.5);
  EXPECT_LE(depth.Largest(), 0.2);
}

TEST(RandomHeads, HaveTheRestOfTheTempleWithinHalfAMillimetre) {
  Errors height("top of the ear, upwards, mm");
  Errors along("top of the ear, forwards, mm");
  for (const auto& head : Heads()) {
    for (const auto& [found, truth] : {std::pair{head->found.face.ear_right.position, head->truth.right_ear_top},
                                       std::pair{head->found.face.ear_left.position, head->truth.left_ear_top}}) {
      height.Add(found.z() - truth.z());
      along.Add(head->forward().dot(found - truth));
    }
  }
  EXPECT_LE(height.Largest(), 0.5);
  EXPECT_LE(along.Largest(), 0.5);
}

TEST(RandomHeads, HaveSellionAndPronasaleOnTheRidge) {
  Errors sellion_up("sellion, upwards, mm");
  Errors sellion_across("sellion, across, mm");
  Errors pronasale_up("pronasale, upwards, mm");
  Errors pronasale_across("pronasale, across, mm");
  for (const auto& head : Heads()) {
    const Vector3d sellion = head->found.face.sellion.position - head->truth.sellion;
    const Vector3d pronasale = head->found.face.pronasale.position - head->truth.pronasale;
    sellion_up.Add(sellion.z());
    sellion_across.Add(head->right().dot(sellion));
    pronasale_up.Add(pronasale.z());
    pronasale_across.Add(head->right().dot(pronasale));
  }
  EXPECT_LE(sellion_up.Largest(), 0.3);
  // The rule is midway between the flanks, the truth the most forward place: unlike flanks part them.
  EXPECT_LE(sellion_across.Largest(), 0.5);
  EXPECT_LE(pronasale_up.Largest(), 0.3);
  EXPECT_LE(pronasale_across.Largest(), 0.6);
}

TEST(RandomHeads, AreKnownBeneathTheirEars) {
  Errors before("head beneath the ear, in front of it, mm");
  Errors above("head beneath the ear, above it, mm");
  for (const auto& head : Heads()) {
    const sim::ParametricBody bare = sim::MakeVariedHeadWithoutEars(head->variation);
    const HeadWithoutEars beneath(head->surface(), head->found.ear_right, head->found.ear_left);
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const Vector3d top = side == 0 ? head->truth.right_ear_top : head->truth.left_ear_top;
      const double sign = side == 0 ? 1.0 : -1.0;
      const double theta = std::atan2(top.y(), top.x());
      const double middle = head->variation.eye_z + head->variation.ear_above[side];
      double largest_before = 0.0;
      double largest_above = 0.0;
      for (double up = -45.0; up <= 50.0; up += 2.5) {
        for (double turn = -0.45; turn <= 0.45; turn += 0.03) {
          const double at = theta + sign * turn;
          const double truth = test::RadiusAboutAxis(bare, at, middle + up);
          const double error = std::abs(beneath.surface().Radius(at, middle + up) - truth);
          if (turn > 0.1) largest_before = std::max(largest_before, error);
          if (up > head->variation.ear_half_height[side] - 5.0) largest_above = std::max(largest_above, error);
          const double relief = test::RadiusAboutAxis(head->body, at, middle + up) - truth;
          if (relief > 0.5 && relief < 1.5) continue;
          EXPECT_EQ(beneath.IsOnEar(at, middle + up), relief > 1.0) << turn << " " << up;
        }
      }
      before.Add(largest_before);
      above.Add(largest_above);
    }
    // The face is as it was measured.
    EXPECT_EQ(beneath.surface().Radius(1.2, head->variation.eye_z), head->surface().Radius(1.2, head->variation.eye_z));
    EXPECT_FALSE(beneath.IsOnEar(1.57, head->variation.eye_z));
  }
  EXPECT_LE(before.Largest(), 0.5);
  EXPECT_LE(above.Largest(), 0.5);
}

/// The lateral at which the head is `ahead` forwards on one side of its ridge, by bisection on the exact head.
double TrueLateral(const KnownHead& head, double z, double from, double sign, double ahead) {
  const auto at = [&](double lateral) {
    double low = 0.8;
    double high = 2.34;
    for (int k = 0; k < 50; ++k) {
      const double theta = 0.5 * (low + high);
      const Vector3d p = PointFromCylindrical(theta, test::RadiusAboutAxis(head.body, theta, z), z);
      (head.right().dot(p) > lateral ? low : high) = theta;
    }
    return head.forward().dot(PointFromCylindrical(low, test::RadiusAboutAxis(head.body, low, z), z));
  };
  double beside = 0.0;
  while (beside < 25.0 && at(from + sign * beside) > ahead) beside += 0.5;
  double low = beside - 0.5;
  double high = beside;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (low + high);
    (at(from + sign * middle) > ahead ? low : high) = middle;
  }
  return from + sign * low;
}

TEST(RandomHeads, HaveNoseFlanksWhereTheyAre) {
  Errors across("place on the nose's flank, across, mm");
  Errors breadth("breadth of the nose 7 mm behind its ridge, mm");
  for (const auto& head : Heads()) {
    const double z = head->truth.sellion.z() - 9.0;
    const auto nose = CutNose(head->surface(), head->found.plane, head->found.face, z);
    ASSERT_TRUE(nose);
    // On the exact head, as far forwards as the flanks that were found.
    const double ahead = head->forward().dot(nose->crest) - 7.0;
    const double crest = head->right().dot(nose->crest);
    const double true_right = TrueLateral(*head, z, crest, 1.0, ahead);
    const double true_left = TrueLateral(*head, z, crest, -1.0, ahead);
    for (const BodySide side : {BodySide::kRight, BodySide::kLeft}) {
      const auto flank = FindNoseFlank(head->surface(), head->found.plane, *nose, side, 7.0);
      ASSERT_TRUE(flank);
      across.Add(head->right().dot(flank->point) - (side == BodySide::kRight ? true_right : true_left));
      EXPECT_NEAR(flank->half_width, 8.0, 2.5);
      EXPECT_NEAR(DegreesFromRadians(flank->splay), 30.0, 15.0);
      EXPECT_NEAR(DegreesFromRadians(flank->frontal_angle), 20.0, 16.0);
      EXPECT_NEAR(flank->normal.norm(), 1.0, 1e-12);
      EXPECT_TRUE(std::isnan(flank->sigma));
    }
    const auto found = NoseBreadth(head->surface(), head->found.plane, *nose, 7.0);
    ASSERT_TRUE(found);
    breadth.Add(*found - (true_right - true_left));
    // A furrow on either side, between nose and eye.
    const double reach = 0.5 * (head->variation.eye_lateral[0] + head->variation.eye_lateral[1]);
    EXPECT_GT(head->right().dot(nose->valley_right - nose->crest), 9.0);
    EXPECT_LT(head->right().dot(nose->valley_right - nose->crest), reach);
    EXPECT_LT(head->right().dot(nose->valley_left - nose->crest), -9.0);
    EXPECT_FALSE(FindNoseFlank(head->surface(), head->found.plane, *nose, BodySide::kRight, 40.0));
  }
  // The plane's yaw errs by up to 0.6 degrees, which is 0.07 mm of "behind" at 7 mm across.
  EXPECT_LE(across.Largest(), 0.2);
  EXPECT_LE(breadth.Largest(), 0.2);
}

TEST(RandomHeads, HaveARidgeFromTheirRootToTheirTip) {
  for (const auto& head : Heads()) {
    const std::vector<NoseSection> sections = NoseSections(head->surface(), head->found.plane, head->found.face, 2.0);
    ASSERT_GE(sections.size(), 15U);
    EXPECT_LT(sections.back().z, head->truth.pronasale.z() + 4.0);
    double least = 1e9;
    double least_z = 0.0;
    for (const NoseSection& section : sections) {
      const double ahead = head->forward().dot(section.crest);
      if (ahead >= least) continue;
      least = ahead;
      least_z = section.z;
    }
    EXPECT_NEAR(least_z, head->truth.sellion.z(), 2.1);
  }
  EXPECT_TRUE(NoseSections(Heads()[0]->surface(), Heads()[0]->found.plane, Heads()[0]->found.face, 0.0).empty());
  EXPECT_FALSE(CutNose(Heads()[0]->surface(), Heads()[0]->found.plane, Heads()[0]->found.face, -1e6));
}

}  // namespace
}  // namespace annulus
