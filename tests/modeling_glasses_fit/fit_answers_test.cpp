// What a fit answers to what it is asked.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "modeling/glasses/glasses_fit.h"
#include "sim/random_head.h"
#include "tests/modeling_glasses_fit/test_frames.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

class FitAnswers : public testing::Test {
 protected:
  FitAnswers()
      : body_(sim::MakeRandomHead(3)),
        model_(test::HeadSurface(body_)),
        measured_(MeasuredSurface::FromModel(model_).value()) {}

  [[nodiscard]] Result<GlassesFit> Fit(const FrameDesign& design, const GlassesFitOptions& options = {}) const {
    return FitGlasses(measured_, design, options);
  }
  static const FitGoal& Goal(const GlassesFit& fit, const std::string& id) {
    for (const FitGoal& goal : fit.goals) {
      if (goal.id == id) return goal;
    }
    ADD_FAILURE() << "no goal " << id;
    return fit.goals.front();
  }

  sim::ParametricBody body_;
  SurfaceModel model_;
  MeasuredSurface measured_;
};

TEST_F(FitAnswers, BalancesTheWeightBetweenNoseAndEars) {
  GlassesFitOptions options;
  options.lens_mass_g = {9.0, 6.0};
  const auto fit = Fit(test::LibraryDesign("panto", "medium"), options);
  ASSERT_TRUE(fit) << fit.error().Text();
  EXPECT_EQ(fit->balance.lenses_g, 15.0);
  EXPECT_GT(fit->balance.frame_g, 2.0);
  ASSERT_EQ(fit->contacts.size(), 4U);
  double sum = 0.0;
  double moment = 0.0;
  const Vector3d forward = Vector3d::UnitY();
  for (const FrameContact& contact : fit->contacts) {
    sum += contact.load_share;
    EXPECT_GE(contact.load_share, 0.0);
    moment += contact.load_share * contact.position.dot(forward);
    EXPECT_NEAR(contact.normal.norm(), 1.0, 1e-9);
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  // Moments about any line across: the loads at their places balance the weight at its centre. Right and left of a pair
  // are not quite at the same depth, and the head's forward is not quite the station's.
  EXPECT_NEAR(moment, fit->balance.centre_of_gravity.dot(forward), 1.0);
}

TEST_F(FitAnswers, TakesPupillaryDistancesFromAPerson) {
  GlassesFitOptions options;
  const auto found = Fit(test::LibraryDesign("panto", "medium"), options);
  ASSERT_TRUE(found);
  const double apart = (found->worn.face.eye_right.position - found->worn.face.eye_left.position).norm();
  options.face.pd_right = 0.5 * apart + 1.0;
  options.face.pd_left = 0.5 * apart + 2.0;
  const auto given = Fit(test::LibraryDesign("panto", "medium"), options);
  ASSERT_TRUE(given) << given.error().Text();
  const double pd = Goal(*given, "pd_right").value + Goal(*given, "pd_left").value;
  EXPECT_NEAR(pd, apart + 3.0, 0.35);  // along the lenses, which are turned by the face form
  EXPECT_EQ(given->worn.face.eye_right.source, LandmarkSource::kGiven);
}

TEST_F(FitAnswers, TakesAWantedPupilHeight) {
  GlassesFitOptions options;
  const auto found = Fit(test::LibraryDesign("panto", "medium"), options);
  ASSERT_TRUE(found);
  const double height = Goal(*found, "pupil_height_right").value + 1.5;
  options.pupil_height = {height, height};
  const auto lower = Fit(test::LibraryDesign("panto", "medium"), options);
  ASSERT_TRUE(lower);
  EXPECT_NEAR(Goal(*lower, "pupil_height_right").value, height, 1.0);
  EXPECT_NEAR(Goal(*lower, "pupil_height_right").low, height - 1.0, 1e-6);
}

TEST_F(FitAnswers, SaysThatABridgeIsTooNarrow) {
  FrameDesign narrow = test::LibraryDesign("wellington", "medium");
  narrow.details.bridge_gap = narrow.bridge_gap() - 9.0;
  const auto fit = Fit(narrow);
  ASSERT_TRUE(fit) << fit.error().Text();
  EXPECT_FALSE(fit->wearable);
  EXPECT_FALSE(Goal(*fit, "dbl").met);
  EXPECT_THAT(Goal(*fit, "dbl").advice, HasSubstr("too narrow for this nose"));
  EXPECT_THAT(fit->advice, testing::Contains(Goal(*fit, "dbl").advice));
  EXPECT_LE(fit->penetration, 0.05);
}

TEST_F(FitAnswers, MadeToMeasureMeetsMoreTargetsThanAFrameOfTheWrongSize) {
  FrameDesign narrow = test::LibraryDesign("wellington", "medium");
  narrow.details.bridge_gap = narrow.bridge_gap() - 5.0;
  GlassesFitOptions free;
  free.size = FitSize::kMadeToMeasure;
  const auto kept = Fit(narrow);
  const auto made = Fit(narrow, free);
  ASSERT_TRUE(kept && made);
  EXPECT_GT(made->score, kept->score);
  EXPECT_GT(made->worn.design.bridge_gap(), narrow.bridge_gap() + 1.0);
}

TEST_F(FitAnswers, EveryPartHasItsDistances) {
  const auto fit = Fit(test::LibraryDesign("panto", "medium"));
  ASSERT_TRUE(fit);
  std::set<std::string> parts;
  for (const Clearance& place : fit->clearance) parts.insert(place.part);
  for (const char* part : {"rim_right", "rim_left", "bridge", "pad_right", "pad_left", "temple_right", "temple_left",
                           "lens_right", "lens_left"}) {
    EXPECT_TRUE(parts.contains(part)) << part;
  }
}

TEST_F(FitAnswers, RefusesWhatCannotBe) {
  const FrameDesign design = test::LibraryDesign("panto", "medium");
  GlassesFitOptions options;
  options.face.points = {{"eye_middle", Vector3d(0, 100, 1580), 1.0}};
  auto fit = Fit(design, options);
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().Text(), HasSubstr("eye_right"));
  options = {};
  options.face.points = {{"eye_right", Vector3d(std::nan(""), 100, 1580), 1.0}};
  EXPECT_FALSE(Fit(design, options));
  options = {};
  options.face.pd_right = 70.0;
  EXPECT_FALSE(Fit(design, options));
  options = {};
  options.lens_mass_g = {-1.0, 0.0};
  EXPECT_FALSE(Fit(design, options));
  options = {};
  options.pupil_height = {500.0, 500.0};
  EXPECT_FALSE(Fit(design, options));
  options = {};
  options.frame_density = std::nan("");
  EXPECT_FALSE(Fit(design, options));
  FrameDesign bad = design;
  bad.parameters.height = -3.0;
  EXPECT_FALSE(Fit(bad));
}

}  // namespace
}  // namespace annulus
