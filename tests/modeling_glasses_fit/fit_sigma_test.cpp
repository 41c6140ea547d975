// The sigmas of a fit against what fits of perturbed heads scatter.

#include "modeling/glasses/fit_sigma.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "modeling/glasses/glasses_fit.h"
#include "sim/random_head.h"
#include "tests/modeling_glasses_fit/test_frames.h"
#include "tests/support/scanned_head.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// The model with other coefficients and without a covariance.
SurfaceModel Perturbed(const SurfaceModel& model, const Eigen::VectorXd& deviation) {
  const SurfaceSegment& segment = model.main();
  const SplineSurface surface(segment.surface.theta_basis(), segment.surface.z_basis(),
                              segment.surface.coefficients() + deviation);
  SurfaceModel perturbed;
  perturbed.segments.push_back({segment.name, surface, segment.knowledge, {}});
  return perturbed;
}

class Scatter {
 public:
  void Add(double value) {
    ++count_;
    sum_ += value;
    squares_ += value * value;
  }
  [[nodiscard]] double sd() const { return std::sqrt((squares_ - sum_ * sum_ / count_) / (count_ - 1.0)); }

 private:
  double count_ = 0.0;
  double sum_ = 0.0;
  double squares_ = 0.0;
};

TEST(FitSigma, IsWhatFitsOfPerturbedHeadsScatter) {
  for (const std::uint64_t seed : {21U, 22U}) {
    const auto scanned = test::ScannedHead(sim::MakeRandomHead(seed), seed);
    ASSERT_TRUE(scanned) << scanned.error().Text();
    const auto measured = MeasuredSurface::FromModel(scanned->model);
    ASSERT_TRUE(measured);
    const auto head = WearerHead::Look(*measured, {});
    ASSERT_TRUE(head) << head.error().Text();
    // A frame of the wearer's size, so that no target is at the end of its range, where sigmas are one-sided.
    GlassesFitOptions to_measure;
    to_measure.size = FitSize::kMadeToMeasure;
    to_measure.detail = FitDetail::kRanking;
    const auto made = FitGlasses(*head, test::LibraryDesign("panto", "medium"), to_measure);
    ASSERT_TRUE(made) << made.error().Text();
    const FrameDesign design = made->worn.design;
    const auto fit = FitGlasses(*head, design, {});
    ASSERT_TRUE(fit);

    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const std::vector<Eigen::VectorXd>& deviations = measured->Deviations();
    ASSERT_FALSE(deviations.empty());
    const double tilt = std::asin(head->station_from_head().linear()(2, 1));
    std::map<std::string, Scatter> scatter;
    constexpr int kDraws = 60;
    for (int k = 0; k < kDraws; ++k) {
      const double sign = k % 2 == 0 ? 1.0 : -1.0;
      const SurfaceModel model =
          Perturbed(scanned->model, sign * deviations[static_cast<std::size_t>(k / 2) % deviations.size()]);
      const auto surface = MeasuredSurface::FromModel(model);
      ASSERT_TRUE(surface);
      GlassesFitOptions options;
      options.detail = FitDetail::kRanking;
      options.face.head_tilt = tilt + head->level_sigma() * normal(random);
      const auto moved = [&](const char* name, const FacePoint& point) {
        const Eigen::LDLT<Eigen::Matrix3d> root(point.covariance);
        const Eigen::Vector3d scale = root.vectorD().cwiseMax(0.0).cwiseSqrt();
        const Vector3d draw = scale.cwiseProduct(Vector3d(normal(random), normal(random), normal(random)));
        const Vector3d step = root.transpositionsP().transpose() * Vector3d(root.matrixL() * draw);
        options.face.points.push_back({name, point.position + step, 0.0});
      };
      moved("eye_right", head->EyePoint(Eye::kRight));
      moved("eye_left", head->EyePoint(Eye::kLeft));
      moved("ear_right", head->EarPoint(Eye::kRight));
      moved("ear_left", head->EarPoint(Eye::kLeft));
      const auto again = FitGlasses(*surface, design, options);
      ASSERT_TRUE(again) << again.error().Text();
      for (const FitGoal& goal : again->goals) scatter[goal.id].Add(goal.value);
    }
    for (const FitGoal& goal : fit->goals) {
      // dbl and the shares are the frame's own; clearances have no sigma of their own.
      if (!goal.id.starts_with("pd_") && !goal.id.starts_with("pupil_height") &&
          !goal.id.starts_with("temple_length")) {
        continue;
      }
      const double sd = scatter[goal.id].sd();
      EXPECT_NEAR(goal.sigma / sd, 1.0, 0.3) << seed << " " << goal.id << " sigma " << goal.sigma << " scatter " << sd;
    }
  }
}

}  // namespace
}  // namespace annulus
