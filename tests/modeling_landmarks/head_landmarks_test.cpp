#include "modeling/landmarks/head_landmarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "base/frames.h"
#include "modeling/landmarks/head_features.h"
#include "modeling/landmarks/mid_plane.h"
#include "sim/head.h"
#include "sim/person.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

/// What the ring sees: the first hit of a ray towards the axis; 0 where nothing is hit.
double SeenRadius(const sim::Subject& subject, double theta, double z) {
  constexpr double kRing = 700.0;
  const Ray ray{PointFromCylindrical(theta, kRing, z), -PointFromCylindrical(theta, 1.0, 0.0)};
  const auto hit = subject.Cast(ray, 0.0, kRing);
  return hit ? kRing - hit->distance_mm : 0.0;
}

/// A surface through what the ring sees of the upper `depth` mm of a subject.
SurfaceModel Seen(const sim::ParametricBody& subject, double depth, double step) {
  const double top = subject.top_mm() - 1.0;
  return test::InterpolatedBody([&](double theta, double z) { return SeenRadius(subject, theta, z); }, 180,
                                UniformBreakpoints(top - depth, top, static_cast<std::size_t>(depth / step)));
}

SurfaceModel SeenHead(double stature, const sim::Placement& placement) {
  return Seen(sim::MakeHead({stature, placement}), 290.0 * stature / 1700.0, 2.0);
}

/// Independent errors on the coefficients.
SurfaceModel WithNoise(const SurfaceModel& model, double sd, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0.0, sd);
  SurfaceModel noisy = model;
  Eigen::VectorXd c = model.main().surface.coefficients();
  for (double& value : c) value += noise(engine);
  noisy.segments[0].surface = SplineSurface(model.main().surface.theta_basis(), model.main().surface.z_basis(), c);
  return noisy;
}

Landmarks Find(const SurfaceModel& model) { return FindHeadLandmarks(MeasuredSurface::FromModel(model).value()); }

double Miss(const Landmarks& landmarks, std::string_view id, const Vector3d& truth) {
  const Landmark* landmark = landmarks.Find(id);
  return landmark != nullptr ? (landmark->position - truth).norm() : 1e9;
}

TEST(HeadLandmarks, AreWhereTheSimulatedHeadsFaceIs) {
  for (const double stature : {1450.0, 1950.0}) {
    for (const double yaw : {-0.17, 0.17}) {
      const sim::ParametricBody head = sim::MakeHead({stature, {4.0, -6.0, yaw}});
      const sim::FaceTruth truth = head.face();
      const Landmarks found = Find(SeenHead(stature, {4.0, -6.0, yaw}));
      SCOPED_TRACE(std::to_string(stature) + " " + std::to_string(yaw));
      EXPECT_LT(Miss(found, "pronasale", truth.pronasale), 0.7);
      EXPECT_LT(Miss(found, "sellion", truth.sellion), 0.7);
      EXPECT_LT(Miss(found, "glabella", truth.glabella), 1.2);
      EXPECT_LT(Miss(found, "eye_right", truth.right_eye), 5.0);
      EXPECT_LT(Miss(found, "eye_left", truth.left_eye), 5.0);
      EXPECT_LT(Miss(found, "otobasion_superius_right", truth.right_ear_top), 5.0);
      EXPECT_LT(Miss(found, "otobasion_superius_left", truth.left_ear_top), 5.0);
      const Landmark* vertex = found.Find("vertex");
      ASSERT_NE(vertex, nullptr);
      EXPECT_NEAR(vertex->z.value, head.heights().crown_mm, 0.5);
      EXPECT_EQ(vertex->kind, LandmarkKind::kLevel);
    }
  }
}

TEST(HeadLandmarks, StayOnTheHeadWhereverItStands) {
  // The same head at the axis and shifted and turned: its landmarks shift and turn with it.
  const sim::Placement placement{9.0, -7.0, 0.17};
  const sim::ParametricBody moved = sim::MakeHead({1700.0, placement});
  const Landmarks rest = Find(SeenHead(1700.0, {0.0, 0.0, 0.0}));
  const Landmarks turned = Find(SeenHead(1700.0, placement));
  ASSERT_EQ(rest.found.size(), turned.found.size());
  for (std::size_t k = 0; k < rest.found.size(); ++k) {
    const Landmark& landmark = rest.found[k];
    EXPECT_EQ(landmark.id, turned.found[k].id);
    EXPECT_EQ(landmark.source, turned.found[k].source) << landmark.id;
    if (landmark.kind == LandmarkKind::kLevel) continue;
    const Vector3d miss = turned.found[k].position - moved.StationFromBody(landmark.position);
    // Three sd of placing in both directions of the surface.
    EXPECT_LT(miss.norm(), 3.0 * std::hypot(landmark.placing_across, landmark.placing_up) + 0.5) << landmark.id;
  }
}

TEST(HeadLandmarks, AreSymmetricOnASymmetricHead) {
  const Landmarks found = Find(SeenHead(1700.0, {0.0, 0.0, 0.0}));
  int pairs = 0;
  for (const Landmark& right : found.found) {
    const auto at = right.id.rfind("_right");
    if (at == std::string::npos) continue;
    const Landmark* left = found.Find(right.id.substr(0, at) + "_left");
    ASSERT_NE(left, nullptr) << right.id;
    EXPECT_GT(right.position.x(), 0.0) << right.id;
    EXPECT_NEAR(right.position.x(), -left->position.x(), 0.2) << right.id;
    EXPECT_NEAR(right.position.y(), left->position.y(), 0.5) << right.id;
    EXPECT_NEAR(right.position.z(), left->position.z(), 1.1) << right.id;
    ++pairs;
  }
  EXPECT_GE(pairs, 8);
  for (const std::string_view id : {"glabella", "sellion", "pronasale", "menton", "opisthocranion"}) {
    const Landmark* middle = found.Find(id);
    ASSERT_NE(middle, nullptr) << id;
    EXPECT_NEAR(middle->position.x(), 0.0, 0.1) << id;
  }
}

TEST(HeadLandmarks, LieInAHumanOrder) {
  const Landmarks found = Find(SeenHead(1700.0, {0.0, 0.0, 0.0}));
  const auto at = [&](std::string_view id) {
    const Landmark* landmark = found.Find(id);
    return landmark != nullptr ? landmark->position : Vector3d(1e9, 1e9, 1e9);
  };
  const std::array<std::string_view, 6> downwards{"glabella",       "sellion",   "eye_right",
                                                  "orbitale_right", "pronasale", "menton"};
  for (std::size_t k = 0; k + 1 < downwards.size(); ++k) {
    EXPECT_GT(at(downwards[k]).z(), at(downwards[k + 1]).z()) << downwards[k];
  }
  const std::array<std::string_view, 5> outwards{"pronasale", "alare_right", "eye_right", "temple_right",
                                                 "zygion_right"};
  for (std::size_t k = 0; k + 1 < outwards.size(); ++k) {
    EXPECT_LT(at(outwards[k]).x(), at(outwards[k + 1]).x()) << outwards[k];
  }
  EXPECT_GT(at("otobasion_superius_right").z(), at("tragion_right").z());
  EXPECT_GT(at("zygion_right").y(), at("tragion_right").y());
  EXPECT_GT(at("euryon_right").z(), at("otobasion_superius_right").z());
  EXPECT_LT(at("opisthocranion").y(), -90.0);
}

TEST(HeadLandmarks, HardlyMoveWithNoise) {
  const SurfaceModel clean = SeenHead(1700.0, {3.0, -2.0, 0.02});
  const Landmarks still = Find(clean);
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const Landmarks noisy = Find(WithNoise(clean, 0.15, seed));
    for (const Landmark& landmark : still.found) {
      const Landmark* moved = noisy.Find(landmark.id);
      ASSERT_NE(moved, nullptr) << landmark.id;
      EXPECT_EQ(moved->source, landmark.source) << landmark.id;
      EXPECT_LT((moved->position - landmark.position).norm(), 5.0) << landmark.id << " seed " << seed;
    }
  }
}

TEST(HeadLandmarks, CarryTheGradientsThatFiniteDifferencesGive) {
  // A bump of a smooth pattern on the surface, small and large: every Estimate follows it as its gradient says.
  const SurfaceModel model = SeenHead(1700.0, {3.0, -2.0, 0.02});
  const Landmarks found = Find(model);
  const Eigen::VectorXd& c = model.main().surface.coefficients();
  Eigen::VectorXd pattern(c.size());
  for (Eigen::Index k = 0; k < c.size(); ++k)
    pattern[k] = std::sin(0.9 * static_cast<double>(k % 180) + 0.02 * static_cast<double>(k));
  const auto along = [&](double step) {
    SurfaceModel changed = model;
    changed.segments[0].surface =
        SplineSurface(model.main().surface.theta_basis(), model.main().surface.z_basis(), c + step * pattern);
    return Find(changed);
  };
  constexpr double kStep = 1e-4;
  const Landmarks more = along(kStep);
  const Landmarks less = along(-kStep);
  // The ones that depend on nothing but vertices: the others also follow the mid-plane or a grid, see placing_*.
  for (const std::string_view id : {"pronasale", "sellion", "vertex"}) {
    const Landmark* landmark = found.Find(id);
    ASSERT_NE(landmark, nullptr) << id;
    const double by_z = (more.Find(id)->z.value - less.Find(id)->z.value) / (2.0 * kStep);
    EXPECT_NEAR(landmark->z.gradient.dot(pattern), by_z, 0.02 * std::abs(by_z) + 0.01) << id;
    if (landmark->kind == LandmarkKind::kLevel) continue;
    const double by_theta = (more.Find(id)->theta.value - less.Find(id)->theta.value) / (2.0 * kStep);
    EXPECT_NEAR(landmark->theta.gradient.dot(pattern), by_theta, 0.02 * std::abs(by_theta) + 1e-4) << id;
  }
}

TEST(HeadLandmarks, AreTheSameOnAStandingPerson) {
  sim::PersonOptions options;
  options.placement = {2.0, 3.0, 0.05};
  const sim::ParametricBody person = sim::MakePerson(options);
  const sim::FaceTruth truth = person.face();
  const Landmarks found = Find(Seen(person, 900.0, 5.0));
  EXPECT_LT(Miss(found, "pronasale", truth.pronasale), 4.0);
  EXPECT_LT(Miss(found, "sellion", truth.sellion), 4.0);
  EXPECT_LT(Miss(found, "eye_right", truth.right_eye), 8.0);
  EXPECT_LT(Miss(found, "otobasion_superius_left", truth.left_ear_top), 8.0);
  for (const Landmark& landmark : found.found) {
    EXPECT_GT(landmark.z.value, truth.pronasale.z() - 130.0) << landmark.id;  // above the neck
  }
}

TEST(HeadLandmarks, WithoutEarsArePlacedByProportionAndSaySo) {
  // An egg with a nose and a neck: r = (75 + 20 sin²θ) shaped in z, a Gaussian nose.
  const auto radius = [](double theta, double z) {
    const double across = AngleDifference(theta, RadiansFromDegrees(90.0)) / RadiansFromDegrees(7.0);
    const double along = (z - 1550.0) / 14.0;
    const double front = std::sin(theta);
    const double neck = 20.0 / (1.0 + std::exp((z - 1475.0) / 4.0));
    return 75.0 + 20.0 * front * front - neck + 18.0 * std::exp(-0.5 * (across * across + along * along));
  };
  const Landmarks found = Find(test::InterpolatedBody(radius, 180, UniformBreakpoints(1400.0, 1690.0, 145)));
  for (const std::string_view id : {"tragion_right", "tragion_left", "otobasion_superius_right", "eye_left"}) {
    const Landmark* landmark = found.Find(id);
    ASSERT_NE(landmark, nullptr) << id;
    EXPECT_EQ(landmark->source, LandmarkSource::kProportion) << id;
    EXPECT_LT(landmark->confidence, 0.3) << id;
    EXPECT_GE(landmark->placing_across, 5.0) << id;
  }
  // A cut-off cylinder shows no crown.
  EXPECT_EQ(found.Find("vertex"), nullptr);
  EXPECT_FALSE(found.omitted.empty());
}

TEST(HeadLandmarks, AreLeftOutWhereTheScanEndsOrSawNothing) {
  const sim::ParametricBody head = sim::MakeHead({});
  const Landmarks upper = Find(Seen(head, 180.0, 2.0));  // ends between nose and mouth
  ASSERT_NE(upper.Find("pronasale"), nullptr);
  EXPECT_EQ(upper.Find("menton"), nullptr);
  EXPECT_THAT(upper.omitted, Contains(HasSubstr("Menton")));
  // The back of the head was not seen.
  SurfaceModel model = Seen(head, 290.0, 2.0);
  KnowledgeMap& known = model.segments[0].knowledge;
  for (std::size_t row = 0; row < known.rows(); ++row) {
    for (std::size_t column = 25; column <= 29; ++column) known.SetCell(column, row, Knowledge::kUnknown);
  }
  const Landmarks front = Find(model);
  ASSERT_NE(front.Find("pronasale"), nullptr);
  EXPECT_EQ(front.Find("opisthocranion"), nullptr);
  EXPECT_THAT(front.omitted, Contains(HasSubstr("Opisthocranion: its place was not seen")));
}

TEST(HeadLandmarks, OfABodyWithoutAHeadAreOneSentence) {
  const auto trunk = [](double theta, double z) {
    return 150.0 + 20.0 * std::cos(2.0 * theta) + 10.0 * std::sin(z / 90.0);
  };
  const Landmarks none = Find(test::InterpolatedBody(trunk, 90, UniformBreakpoints(800.0, 1300.0, 100)));
  EXPECT_TRUE(none.found.empty());
  EXPECT_THAT(none.omitted, ElementsAre(HasSubstr("nose")));
  const Landmarks shallow = Find(test::InterpolatedBody(trunk, 90, UniformBreakpoints(800.0, 900.0, 20)));
  EXPECT_TRUE(shallow.found.empty());
  EXPECT_THAT(shallow.omitted, SizeIs(1));
}

TEST(HeadLandmarks, HaveDifferentIdsATermAndADefinition) {
  std::set<std::string_view> ids;
  for (const HeadLandmarkEntry& entry : HeadLandmarkCatalog()) {
    EXPECT_TRUE(ids.insert(entry.id).second) << entry.id;
    EXPECT_FALSE(entry.term.empty());
    EXPECT_EQ(entry.definition.back(), '.') << entry.id;
    EXPECT_GT(entry.placing_up, 0.0) << entry.id;
  }
}

TEST(MidPlane, IsFoundOnATurnedAndLeaningEgg) {
  // An ellipsoid of semi-axes 75, 95, 120 mm with a nose, turned by 0.1 rad about z and leaning to the right by the
  // angle whose tangent is 0.05.
  constexpr double kYaw = 0.1;
  constexpr double kLean = 0.05;
  const double longer = std::hypot(1.0, kLean);
  const Vector3d centre(4.0, -3.0, 1550.0);
  const auto is_outside = [&](const Vector3d& station) {
    Vector3d p = station - centre;
    p = Vector3d(std::cos(kYaw) * p.x() + std::sin(kYaw) * p.y(), -std::sin(kYaw) * p.x() + std::cos(kYaw) * p.y(),
                 p.z());
    p = Vector3d((p.x() - kLean * p.z()) / longer, p.y(), (kLean * p.x() + p.z()) / longer);
    const double nose = 18.0 * std::exp(-0.5 * (p.x() * p.x() / 100.0 + (p.z() + 20.0) * (p.z() + 20.0) / 200.0));
    const double y = p.y() > 0.0 ? p.y() * 95.0 / (95.0 + nose) : p.y();
    return p.x() * p.x() / 5625.0 + y * y / 9025.0 + p.z() * p.z() / 14400.0 > 1.0;
  };
  const auto radius = [&](double theta, double z) {
    double low = 0.0;
    double high = 200.0;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      (is_outside(PointFromCylindrical(theta, middle, z)) ? high : low) = middle;
    }
    return low;
  };
  const SurfaceModel model = test::InterpolatedBody(radius, 180, UniformBreakpoints(1450.0, 1640.0, 95));
  const HeadGrid grid(model.main().surface, kHeadDepth);
  const auto nose = FindNose(grid, NeckRow(grid));
  ASSERT_TRUE(nose);
  const MidPlane plane = FindMidPlane(grid, grid.Point(nose->degree, nose->row));
  EXPECT_NEAR(plane.yaw, kPi / 2.0 + kYaw, 0.01);
  EXPECT_NEAR(plane.lean, kLean, 0.01);
  EXPECT_LT(plane.spread, 0.3);
  // It passes through the egg's centre, and cuts the surface where it says.
  EXPECT_NEAR(plane.Lateral(centre), 0.0, 0.3);
  for (const double z : {1500.0, 1560.0, 1600.0}) {
    const SplineSurface& s = model.main().surface;
    const Vector3d front = s.Point(plane.FrontTheta(s, z), z);
    const Vector3d back = s.Point(plane.BackTheta(s, z), z);
    EXPECT_NEAR(plane.Lateral(front), 0.0, 1e-3);
    EXPECT_NEAR(plane.Lateral(back), 0.0, 1e-3);
    EXPECT_GT(plane.forward().dot(front), plane.forward().dot(back));
  }
}

}  // namespace
}  // namespace annulus
