#include "sim/person.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "base/units.h"
#include "modeling/mesh/convex_hull_2d.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus::sim {
namespace {

const ParametricBody& Standard() {
  static const ParametricBody person = MakePerson({});
  return person;
}

std::map<std::string, double> LevelsOf(const ParametricBody& body) {
  std::map<std::string, double> levels;
  for (const NamedLevel& level : body.levels()) levels[level.id] = level.z_mm;
  return levels;
}

// Length and area of a fine polygon through the surface, from Point alone; the square of the step is extrapolated away.
SectionTruth PolygonTruth(const StarTube& tube, double z) {
  const auto measure = [&](int count) {
    SectionTruth truth;
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < count; ++i) points.emplace_back(tube.Point(kTwoPi * i / count, z).head<2>());
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d& a = points[static_cast<std::size_t>(i)];
      const Eigen::Vector2d& b = points[static_cast<std::size_t>((i + 1) % count)];
      truth.perimeter_mm += (b - a).norm();
      truth.area_mm2 += 0.5 * (a.x() * b.y() - b.x() * a.y());
    }
    truth.tape_mm = ConvexHullPerimeter(points);
    return truth;
  };
  const SectionTruth coarse = measure(10000);
  const SectionTruth fine = measure(20000);
  return {z, (4.0 * fine.perimeter_mm - coarse.perimeter_mm) / 3.0, fine.tape_mm,
          (4.0 * fine.area_mm2 - coarse.area_mm2) / 3.0};
}

TEST(Person, HasTheProportionsOfAnAdult) {
  const auto levels = LevelsOf(Standard());
  ASSERT_EQ(levels.size(), 5U);
  EXPECT_LT(*Standard().heights().crotch_mm, levels.at("hip"));
  EXPECT_LT(levels.at("hip"), levels.at("waist"));
  EXPECT_LT(levels.at("waist"), levels.at("chest"));
  EXPECT_LT(levels.at("chest"), *Standard().heights().armpit_mm);
  EXPECT_LT(levels.at("neck"), levels.at("head"));
  const auto tape = [&](const char* id) { return Standard().TorsoSection(levels.at(id))->tape_mm; };
  EXPECT_NEAR(tape("head"), 560.0, 20.0);
  EXPECT_NEAR(tape("neck"), 345.0, 25.0);
  EXPECT_NEAR(tape("chest"), 860.0, 40.0);
  EXPECT_NEAR(tape("waist"), 710.0, 40.0);
  EXPECT_NEAR(tape("hip"), 950.0, 40.0);
  EXPECT_DOUBLE_EQ(Standard().top_mm(), 1700.0);
  EXPECT_DOUBLE_EQ(Standard().bottom_mm(), 0.0);
}

TEST(Person, HasItsLevelsAtExtremesOfTheGirth) {
  const auto levels = LevelsOf(Standard());
  const auto tape = [](double z) { return Standard().TorsoSection(z)->tape_mm; };
  for (const char* largest : {"head", "chest", "hip"}) {
    for (const double offset : {-6.0, 6.0}) {
      EXPECT_LT(tape(levels.at(largest) + offset), tape(levels.at(largest))) << largest;
    }
  }
  for (const char* smallest : {"neck", "waist"}) {
    for (const double offset : {-6.0, 6.0}) {
      EXPECT_GT(tape(levels.at(smallest) + offset), tape(levels.at(smallest))) << smallest;
    }
  }
}

TEST(Person, HasTheMeasuresOfAFinePolygon) {
  for (const ParametricBody::Part& part : Standard().parts()) {
    for (double z = part.tube.z_min() + 3.0; z < part.tube.z_max(); z += 47.0) {
      const SectionTruth truth = *Standard().PartSection(part.id, z);
      const SectionTruth polygon = PolygonTruth(part.tube, z);
      EXPECT_NEAR(truth.perimeter_mm, polygon.perimeter_mm, 1e-6 * polygon.perimeter_mm) << z;
      EXPECT_NEAR(truth.tape_mm, polygon.tape_mm, 1e-6 * polygon.tape_mm) << z;
      EXPECT_NEAR(truth.area_mm2, polygon.area_mm2, 1e-6 * polygon.area_mm2) << z;
    }
  }
}

TEST(Person, HasTheVolumeOfAFineMesh) {
  // Prisms between polygons of 720 corners, 0.25 mm high, with flat ends: second order in both, hence the tolerance.
  const double z0 = 850.0;
  const double z1 = 1450.0;
  const double step = 0.25;
  double volume = 0.0;
  for (double z = z0 + step / 2.0; z < z1; z += step) {
    double area = 0.0;
    for (int i = 0; i < 720; ++i)
      area += 0.5 * std::pow(Standard().torso().Radius(kTwoPi * i / 720.0, z), 2) * kTwoPi / 720.0;
    volume += area * step;
  }
  EXPECT_NEAR(Standard().TorsoVolume(z0, z1), volume, 1e-6 * volume);
  EXPECT_NEAR(Standard().TorsoVolume(0.0, 900.0) + Standard().TorsoVolume(900.0, 3000.0),
              Standard().torso().Volume(0.0, 3000.0), 1.0);
}

TEST(Person, StaysInTheRingAndHoldsItsArmsAway) {
  const auto levels = LevelsOf(Standard());
  for (double z = 2.0; z < 1700.0; z += 7.0) {
    for (int i = 0; i < 360; i += 2) {
      const double theta = RadiansFromDegrees(i);
      const auto hit =
          Standard().Cast({PointFromCylindrical(theta, 600.0, z), -PointFromCylindrical(theta, 1.0, 0.0)}, 0.0, 600.0);
      if (hit) {
        EXPECT_LT(600.0 - hit->distance_mm, 540.0);
      }
    }
  }
  for (const char* id : {"chest", "waist", "hip"}) {
    const double z = levels.at(id);
    double torso_side = 0.0;
    double arm_side = 1e9;
    for (int i = 0; i < 720; ++i) {
      const double theta = kTwoPi * i / 720.0;
      torso_side = std::max(torso_side, Standard().torso().Point(theta, z).x());
      for (const ParametricBody::Part& part : Standard().parts()) {
        if (part.id == BodyPart::kRightArm) arm_side = std::min(arm_side, part.tube.Point(theta, z).x());
      }
    }
    EXPECT_GT(arm_side - torso_side, 20.0) << id;
  }
}

TEST(Person, HasLegsInsideTheTorsoAtTheHip) {
  const double hip = LevelsOf(Standard()).at("hip");
  EXPECT_FALSE(Standard().PartSection(BodyPart::kRightLeg, hip));
  EXPECT_TRUE(Standard().PartSection(BodyPart::kRightLeg, 400.0));
  EXPECT_FALSE(Standard().TorsoSection(400.0));
}

TEST(Person, IsMirrored) {
  PersonOptions options;
  options.placement = {};
  const ParametricBody person = MakePerson(options);
  for (const double z : {30.0, 500.0, 900.0, 1250.0, 1550.0, 1584.0}) {
    for (const double y : {-40.0, 0.0, 30.0}) {
      const auto right = person.Cast({{600.0, y, z}, {-1, 0, 0}}, 0.0, 1200.0);
      const auto left = person.Cast({{-600.0, y, z}, {1, 0, 0}}, 0.0, 1200.0);
      ASSERT_EQ(right.has_value(), left.has_value());
      if (right) {
        EXPECT_NEAR(right->distance_mm, left->distance_mm, 1e-5);
      }
    }
  }
}

TEST(Person, IsMetWhereItsPlacementPutsIt) {
  PersonOptions options;
  options.placement = {12.0, -7.0, 0.1};
  const ParametricBody person = MakePerson(options);
  const double z = 1100.0;
  const Eigen::Vector3d p = person.StationFromBody(person.torso().Point(2.0, z));
  const Eigen::Vector3d inside =
      person.StationFromBody({person.torso().Centre(z).x(), person.torso().Centre(z).y(), z});
  const Eigen::Vector3d outwards = (p - inside).normalized();
  const auto hit = person.Cast({p + 60.0 * outwards, -outwards}, 3.0, 500.0);  // short of the arms
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance_mm, 60.0, 1e-6);
  EXPECT_NEAR((inside - Eigen::Vector3d(12.0, -7.0, z)).norm(), person.torso().Centre(z).norm(), 1e-9);
}

TEST(Person, ScalesWithItsHeightAndBuild) {
  PersonOptions tall;
  tall.height_mm = 1870.0;
  const ParametricBody person = MakePerson(tall);
  EXPECT_NEAR(person.TorsoSection(1100.0 * 1.1)->perimeter_mm, 1.1 * Standard().TorsoSection(1100.0)->perimeter_mm,
              1e-6);
  PersonOptions broad;
  broad.build = 1.1;
  EXPECT_GT(MakePerson(broad).TorsoSection(1100.0)->area_mm2, 1.2 * Standard().TorsoSection(1100.0)->area_mm2);
}

}  // namespace
}  // namespace annulus::sim
