#include "render/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/units.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Eigen::AlignedBox3d Box() { return {Eigen::Vector3d(-100.0, -60.0, 0.0), Eigen::Vector3d(80.0, 90.0, 1700.0)}; }

TEST(ParseView, KnowsTheNamesAsTheSubjectsSides) {
  EXPECT_DOUBLE_EQ(ParseView("front")->azimuth, kPi / 2.0);
  EXPECT_DOUBLE_EQ(ParseView("left45")->azimuth, 0.75 * kPi);
  EXPECT_DOUBLE_EQ(ParseView("right45")->azimuth, 0.25 * kPi);
  EXPECT_DOUBLE_EQ(ParseView("right45")->elevation, 0.0);
}

TEST(ParseView, ReadsDegrees) {
  const auto view = ParseView("-90, 12.5");
  ASSERT_TRUE(view.has_value());
  EXPECT_NEAR(view->azimuth, 1.5 * kPi, 1e-12);
  EXPECT_NEAR(view->elevation, 12.5 * kPi / 180.0, 1e-12);
  EXPECT_TRUE(ParseView("360,-90").has_value());
}

TEST(ParseView, RefusesEverythingElse) {
  for (const char* wrong : {"", "back", "Front", "90", "90,", ",10", "90,91", "90,-90.5", "nan,0", "90,inf", "a,b",
                            "90,1,2", "1e300,0", "90,0x"}) {
    const auto view = ParseView(wrong);
    ASSERT_FALSE(view.has_value()) << wrong;
    EXPECT_NE(view.error().Text().find("front"), std::string::npos);
  }
}

TEST(FrameCamera, TheSubjectsLeftIsOnTheRightOfAFrontPicture) {
  const auto camera = FrameCamera(Box(), {kPi / 2.0, 0.0}, {});
  ASSERT_TRUE(camera.has_value());
  // +x is the subject's right.
  EXPECT_LT(camera->ToCamera({50.0, 0.0, 850.0}).x(), camera->ToCamera({-50.0, 0.0, 850.0}).x());
  EXPECT_GT(camera->ToCamera({0.0, 0.0, 900.0}).y(), camera->ToCamera({0.0, 0.0, 800.0}).y());
  EXPECT_LT(camera->ToCamera({0.0, 50.0, 850.0}).z(), camera->ToCamera({0.0, -50.0, 850.0}).z());
}

TEST(FrameCamera, RotationIsRightHandedInEveryView) {
  for (const double elevation : {-kPi / 2.0, -0.4, 0.0, 1.1, kPi / 2.0}) {
    const auto camera = FrameCamera(Box(), {2.2, elevation}, {});
    ASSERT_TRUE(camera.has_value());
    const Eigen::Matrix3d& r = camera->camera_from_station;
    EXPECT_NEAR((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-14);
    // right x up points towards the eye, against the third row.
    EXPECT_NEAR(r.row(0).cross(r.row(1)).dot(r.row(2)), -1.0, 1e-14);
  }
}

TEST(FrameCamera, FillsThePictureUpToTheMargin) {
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    for (const double aspect : {0.45, 1.0, 2.0}) {
      for (const View view : {View{kPi / 2.0, 0.0}, View{0.3, 0.7}, View{4.0, -1.5}}) {
        Framing framing;
        framing.projection = projection;
        framing.aspect = aspect;
        framing.margin = 0.1;
        const auto camera = FrameCamera(Box(), view, framing);
        ASSERT_TRUE(camera.has_value());
        double largest = 0.0;
        for (int k = 0; k < 8; ++k) {
          const Eigen::Vector3d p = camera->ToCamera(Box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)));
          EXPECT_GT(p.z(), camera->near_mm);
          const double scale = projection == Projection::kPerspective ? 1.0 / p.z() : 1.0;
          largest = std::max({largest, std::abs(p.y()) * scale / camera->half_height,
                              std::abs(p.x()) * scale / (camera->half_height * aspect)});
        }
        EXPECT_NEAR(largest, 0.9, 1e-9);
      }
    }
  }
}

TEST(FrameCamera, RefusesWhatCannotBeFramed) {
  EXPECT_FALSE(FrameCamera(Eigen::AlignedBox3d(), {}, {}).has_value());
  EXPECT_FALSE(FrameCamera({Eigen::Vector3d::Zero(), Eigen::Vector3d(1.0, kNan, 1.0)}, {}, {}).has_value());
  EXPECT_FALSE(FrameCamera(Box(), {kNan, 0.0}, {}).has_value());
  EXPECT_FALSE(FrameCamera(Box(), {0.0, 2.0}, {}).has_value());
  Framing framing;
  framing.margin = 1.0;
  EXPECT_FALSE(FrameCamera(Box(), {}, framing).has_value());
  framing = Framing{};
  framing.aspect = 0.0;
  EXPECT_FALSE(FrameCamera(Box(), {}, framing).has_value());
}

TEST(FrameCamera, FramesASinglePoint) {
  const Eigen::Vector3d point(1.0, 2.0, 3.0);
  const auto camera = FrameCamera({point, point}, {1.0, 0.2}, {});
  ASSERT_TRUE(camera.has_value());
  EXPECT_NEAR(camera->ToCamera(point).head<2>().norm(), 0.0, 1e-12);
  EXPECT_GT(camera->ToCamera(point).z(), camera->near_mm);
}

}  // namespace
}  // namespace annulus
