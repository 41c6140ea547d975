#include "modeling/clay/clay_exact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "modeling/clay/clay_to_surface.h"
#include "modeling/glasses/frame_library.h"
#include "tests/modeling_clay/clay_check.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A lumpy body on knots that are not even.
PaperSurface Lumpy() {
  std::vector<double> theta;
  for (int i = 0; i < 17; ++i) theta.push_back(2.0 * std::numbers::pi * (i + 0.2 * std::sin(2.0 * i)) / 17.0);
  std::vector<double> z;
  for (int j = 0; j < 9; ++j) z.push_back(1000.0 + 45.0 * j + 8.0 * std::cos(3.0 * j));
  Eigen::MatrixXd radius(9, 17);
  for (int j = 0; j < 9; ++j) {
    for (int i = 0; i < 17; ++i) radius(j, i) = 140.0 + 9.0 * std::sin(1.1 * i + 0.7 * j) + 6.0 * std::cos(2.0 * j);
  }
  auto surface = PaperSurface::Through(theta, z, radius);
  EXPECT_TRUE(surface) << (surface ? "" : surface.error().Text());
  return std::move(*surface);
}

/// The volume of a closed uniform B-spline's sections, from its control points alone. Area of a section with control
/// points V_i: ½∮(x dy − y dx) = Σ_i Σ_k d_k (V_i × V_{i+k}), d_k = ∫N(t) N'(t − k) dt = 245/720, 56/720, 1/720.
double VolumeFromControlPoints(const PaperSurface& surface) {
  const std::array<double, 5> x{0.04691007703066802, 0.23076534494715845, 0.5, 0.7692346550528415, 0.953089922969332};
  const std::array<double, 5> w{0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
                                0.11846344252809454};
  const std::array<double, 3> d{245.0 / 720.0, 56.0 / 720.0, 1.0 / 720.0};
  const std::size_t columns = surface.theta_knots().size();
  double volume = 0.0;
  for (std::size_t row = 0; row + 1 < surface.z_knots().size(); ++row) {
    for (std::size_t g = 0; g < 5; ++g) {
      const double t = x[g];
      const double s = 1.0 - t;
      const std::array<double, 4> n{s * s * s / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                                    (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0, t * t * t / 6.0};
      const std::array<double, 4> slope{-s * s / 2.0, (3.0 * t * t - 4.0 * t) / 2.0, (-3.0 * s * s + 4.0 * s) / 2.0,
                                        t * t / 2.0};
      std::vector<Vector3d> v(columns, Vector3d::Zero());
      double rise = 0.0;
      for (std::size_t j = 0; j < 4; ++j) {
        for (std::size_t i = 0; i < columns; ++i) v[i] += n[j] * surface.control()[(row + j) * columns + i];
        rise += slope[j] * surface.control()[(row + j) * columns].z();
      }
      double area = 0.0;
      for (std::size_t i = 0; i < columns; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const Vector3d& other = v[(i + k + 1) % columns];
          area += d[k] * (v[i].x() * other.y() - v[i].y() * other.x());
        }
      }
      volume += w[g] * area * rise;
    }
  }
  return volume;
}

TEST(ClayFromPaper, IsTheSurfaceItself) {
  const PaperSurface surface = Lumpy();
  const auto made = ClayFromPaper(surface, "body");
  ASSERT_TRUE(made) << made.error().Text();
  EXPECT_EQ(made->columns, 17U);
  EXPECT_EQ(made->rows, 8U);
  double off = 0.0;
  for (std::uint32_t n = 0; n < 17 * 8; ++n) {
    for (int k = 0; k < 121; ++k) {
      const double u = 0.1 * (k % 11);
      const double v = 0.1 * (k / 11);
      const Vector3d wanted = surface.PointAt({n % 17 + u, n / 17 + v});
      off = std::max(off, (made->body.Point({n, u, v}) - wanted).norm() / wanted.norm());
    }
  }
  EXPECT_LE(off, 1e-12);
  EXPECT_LE(made->largest_error_mm, 1e-9);
  EXPECT_NEAR(made->body.volume() / VolumeFromControlPoints(surface), 1.0, 1e-12);
  EXPECT_LE(std::abs(made->volume_error), 1e-10);
  EXPECT_EQ(test::Unsound(made->body.mesh(), 1e-9), "");
}

TEST(ClayFromPaper, ComesBackAsItsTensorForm) {
  const PaperSurface paper = Lumpy();
  const auto made = ClayFromPaper(paper, "body");
  ASSERT_TRUE(made);
  SurfaceSegment segment{
      "body", ApproximateByTensor(paper).surface, KnowledgeMap(1, 1, paper.z_min(), paper.z_max()), {}};
  const auto back = SurfaceFromClay(segment, *made, made->body);
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_EQ(back->segment.surface.coefficients(), segment.surface.coefficients());
  // The tensor form is within 0.01 mm.
  EXPECT_LE(std::abs(back->volume_error), 1e-5);
}

/// All shells of a frame by name; of some names there are several.
std::map<std::string, PatchShell> ShellsOf(const Frame& frame) {
  std::map<std::string, PatchShell> shells;
  for (const FrameBody& body : FrameBodies(frame)) {
    for (const PatchShell& shell : body.shells) {
      std::vector<ShellPatch>& patches = shells[shell.name].patches;
      patches.insert(patches.end(), shell.patches.begin(), shell.patches.end());
    }
  }
  return shells;
}

void ExpectSame(const ClayBody& body, const PatchShell& shell, const std::string& name) {
  double off = 0.0;
  double size = 0.0;
  for (std::uint32_t n = 0; n < shell.patches.size(); ++n) {
    for (int k = 0; k < 36; ++k) {
      const double u = 0.2 * (k % 6);
      const double v = 0.2 * (k / 6);
      const Vector3d wanted = shell.patches[n].patch.Point(u, v);
      size = std::max(size, wanted.norm());
      off = std::max(off, (body.Point({n, u, v}) - wanted).norm());
    }
  }
  EXPECT_LE(off, 1e-12 * size) << name;
  EXPECT_NEAR(body.volume() / Volume(shell), 1.0, 1e-12) << name;
}

TEST(FramePart, IsClayAsItIs) {
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    const Frame frame = BuildFrame(style.design, StandardAdjustment(style.design)).value();
    for (const auto& [name, shell] : ShellsOf(frame)) {
      const auto part = FramePart(frame, name);
      ASSERT_TRUE(part) << part.error().Text();
      ASSERT_EQ(part->patches.size(), shell.patches.size());
      const auto body = ClayBody::Make(*part);
      ASSERT_TRUE(body) << style.name << ", " << name << ": " << body.error().Text();
      ExpectSame(*body, shell, style.name + ", " + name);
    }
  }
}

TEST(FramePart, OfNoNameIsTheWholeFrame) {
  const FrameDesign& design = BuiltInFrameLibrary().Find("example1").value()->design;
  const Frame frame = BuildFrame(design, StandardAdjustment(design)).value();
  const auto whole = FramePart(frame, "");
  ASSERT_TRUE(whole);
  const auto body = ClayBody::Make(*whole);
  ASSERT_TRUE(body) << body.error().Text();
  double sum = 0.0;
  for (const auto& [name, shell] : ShellsOf(frame)) sum += Volume(shell);
  EXPECT_NEAR(body->volume() / sum, 1.0, 1e-12);
}

TEST(FramePart, RefusesWhatIsOpenOrNotThere) {
  const FrameDesign& design = BuiltInFrameLibrary().Find("example1").value()->design;
  const Frame frame = BuildFrame(design, StandardAdjustment(design)).value();
  const auto lens = FramePart(frame, "lens_left");
  ASSERT_TRUE(lens);
  const auto body = ClayBody::Make(*lens);
  ASSERT_FALSE(body);
  EXPECT_NE(body.error().Text().find("closed"), std::string::npos) << body.error().Text();
  const auto none = FramePart(frame, "rim_middle");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().advice.find("rim_right, "), std::string::npos) << none.error().Text();
}

}  // namespace
}  // namespace annulus
