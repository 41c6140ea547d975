#include "modeling/exchange/dcs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "modeling/glasses/frame.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;

/// An ellipse with half axes a and b about `centre`.
LensOutline Ellipse(double a, double b, const Vector2d& centre, int points = 2000) {
  LensOutline outline;
  for (int k = 0; k < points; ++k) {
    const double t = 2.0 * kPi * k / points;
    outline.points.emplace_back(centre.x() + a * std::cos(t), centre.y() + b * std::sin(t));
  }
  return outline;
}

DcsJob JobOf(const LensOutline& right, const LensOutline& left) {
  const auto trace = TraceOutlines(right, left);
  EXPECT_TRUE(trace) << trace.error().Text();
  DcsJob job;
  job.job = "K-0042";
  job.dbl = 18.25;
  if (trace) {
    job.right = trace->right;
    job.left = trace->left;
  }
  return job;
}

/// Distance of a point from a closed polygon, all of its sides looked at.
double Distance(const Vector2d& p, const std::vector<Vector2d>& polygon) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector2d& a = polygon[k];
    const Vector2d along = polygon[(k + 1) % polygon.size()] - a;
    const double share = std::min(1.0, std::max(0.0, (p - a).dot(along) / along.squaredNorm()));
    nearest = std::min(nearest, (p - a - share * along).norm());
  }
  return nearest;
}

/// Hausdorff distance of an outline and radii about its box centre, both ways, middles of sides included. Only every
/// `stride`-th point is looked at.
double Hausdorff(const LensOutline& outline, const std::vector<double>& radii, std::size_t stride) {
  Vector2d low = outline.points.front();
  Vector2d high = low;
  for (const Vector2d& p : outline.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vector2d centre = 0.5 * (low + high);
  std::vector<Vector2d> trace;
  for (std::size_t k = 0; k < radii.size(); ++k) {
    const double t = 2.0 * kPi * static_cast<double>(k) / static_cast<double>(radii.size());
    trace.emplace_back(centre.x() + radii[k] * std::cos(t), centre.y() + radii[k] * std::sin(t));
  }
  double largest = 0.0;
  const auto one_way = [&largest, stride](const std::vector<Vector2d>& from, const std::vector<Vector2d>& to) {
    for (std::size_t k = 0; k < from.size(); k += stride) {
      largest = std::max(largest, Distance(from[k], to));
      largest = std::max(largest, Distance(0.5 * (from[k] + from[(k + 1) % from.size()]), to));
    }
  };
  one_way(outline.points, trace);
  one_way(trace, outline.points);
  return largest;
}

TEST(Dcs, AnEllipseHasItsHalfAxesAsRadii) {
  const DcsJob job = JobOf(Ellipse(26.0, 19.0, {3.0, -2.0}), Ellipse(26.0, 19.0, {-3.0, -2.0}));
  EXPECT_EQ(job.right.hbox, 52.0);
  EXPECT_EQ(job.right.vbox, 38.0);
  EXPECT_EQ(job.right.fed, 52.0);
  // scipy.special.ellipe(1 - (19/26)**2) * 4 * 26 = 142.229
  EXPECT_NEAR(job.right.circ, 142.23, 0.011);
  const std::size_t n = job.right.radii.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double t = 2.0 * kPi * static_cast<double>(i) / static_cast<double>(n);
    const double radius = 1.0 / std::hypot(std::cos(t) / 26.0, std::sin(t) / 19.0);
    EXPECT_NEAR(job.right.radii[i], radius, 0.0051) << i;
  }
}

TEST(Dcs, ReadsBackToTheSameJob) {
  DcsJob job = JobOf(Ellipse(25.5, 17.3, {1.0, 0.5}), Ellipse(25.0, 18.0, {0.0, 0.0}));
  job.frame = DcsFrame::kMetal;
  job.edge = DcsEdge::kGroove;
  job.lens_name = "1.67 single vision";
  job.confirmed_by = "M. Sato";
  job.right.ipd = 31.5;
  job.left.ipd = 32.25;
  job.right.ocht = 20.0;
  job.right.sphere = -4.0;
  job.left.sphere = 2.25;
  job.right.cylinder = -0.75;
  job.right.axis_deg = 90.0;
  job.right.add = 2.0;
  job.right.prism = 1.5;
  job.right.base_deg = 270.0;
  job.right.frame_curve = 4.0;
  const std::string text = DcsText(job);
  const auto read = DcsFromText(text, "t");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(*read, job);
  EXPECT_EQ(DcsText(*read), text);
}

TEST(Dcs, IsAsciiInRecordsOfTenRadiiWithCrLf) {
  DcsJob job = JobOf(Ellipse(25.5, 17.3, {0.0, 0.0}), Ellipse(25.5, 17.3, {0.0, 0.0}));
  job.job = "山田;=\r\n1";
  job.right.sphere = -4.0;
  const std::string text = DcsText(job);
  EXPECT_EQ(text.rfind("REQ=FIL\r\nJOB=??????????1\r\nDO=B\r\n", 0), 0U);
  EXPECT_NE(text.find("\r\nSPH=-4.00;\r\n"), std::string::npos);
  EXPECT_NE(text.find("\r\nDBL=18.25\r\n"), std::string::npos);
  EXPECT_NE(text.find("\r\nHBOX=51.00;51.00\r\nVBOX=34.60;34.60\r\n"), std::string::npos);
  EXPECT_NE(text.find("\r\nTRCFMT=1;400;E;R;F\r\nR=2550;"), std::string::npos);
  std::size_t lines = 0;
  for (std::size_t at = text.find("\r\nR="); at != std::string::npos; at = text.find("\r\nR=", at + 1)) ++lines;
  EXPECT_EQ(lines, 80U);
  for (std::size_t k = 0; k < text.size(); ++k) {
    EXPECT_TRUE((text[k] >= ' ' && text[k] <= '~') || text[k] == '\r' || text[k] == '\n');
    EXPECT_EQ(text[k] == '\n', k > 0 && text[k - 1] == '\r');
  }
}

/// What "Must hold" says of a frame's trace.
void CheckFrame(const FrameParameters& parameters, std::size_t stride, const std::string& what) {
  const auto frame = BuildFrame(parameters, StandardAdjustment(parameters));
  ASSERT_TRUE(frame) << what;
  const LensOutline right = LensOutlineOf(*frame, Eye::kRight);
  const LensOutline left = LensOutlineOf(*frame, Eye::kLeft);
  const DcsJob job = JobOf(right, left);
  const auto read = DcsFromText(DcsText(job), what);
  ASSERT_TRUE(read) << what << ": " << read.error().Text();
  const std::vector<double>& r = read->right.radii;
  const std::vector<double>& l = read->left.radii;
  EXPECT_LE(Hausdorff(right, r, stride), 0.01) << what << " n " << r.size();
  EXPECT_LE(Hausdorff(left, l, stride), 0.01) << what;
  ASSERT_EQ(r.size(), l.size());
  Vector2d low(1e9, 1e9);
  Vector2d high = -low;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double t = 2.0 * kPi * static_cast<double>(i) / static_cast<double>(r.size());
    const Vector2d p(r[i] * std::cos(t), r[i] * std::sin(t));
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    // The frame is symmetric: one front view for both eyes.
    EXPECT_EQ(l[(r.size() + r.size() / 2 - i) % r.size()], r[i]) << what << " " << i;
  }
  EXPECT_NEAR(high.x() - low.x(), read->right.hbox, 0.02) << what;
  EXPECT_NEAR(high.y() - low.y(), read->right.vbox, 0.02) << what;
}

TEST(Dcs, EveryStyleReproducesItsBoxAndItsOutline) {
  for (const test::FrameStyle& style : test::FrameStyles()) CheckFrame(style.parameters, 1, std::string(style.name));
}

/// Valid parameters: cuts between the smallest that leaves the inner outline an edge and 0.3 of the shorter side.
FrameParameters RandomParameters(std::mt19937_64& random) {
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (;;) {
    FrameParameters p;
    p.width = uniform(36.0, 62.0);
    p.height = p.width * uniform(0.5, 1.1);
    p.upper_thickness = uniform(1.5, 6.0);
    p.lower_thickness = uniform(1.5, 6.0);
    const double shorter = std::min(p.width, p.height);
    for (double FrameParameters::*cut : {&FrameParameters::upper_outer, &FrameParameters::upper_inner,
                                         &FrameParameters::lower_outer, &FrameParameters::lower_inner}) {
      p.*cut = uniform(0.02, 0.34) * shorter;
    }
    p.bridge_height = p.height * uniform(0.4, 0.8);
    if (Validate(p)) return p;
  }
}

TEST(Dcs, ThousandRandomFramesReproduceTheirBoxAndOutline) {
  std::mt19937_64 random(20260807);
  for (int k = 0; k < 1000 && !testing::Test::HasFailure(); ++k) {
    CheckFrame(RandomParameters(random), 41, "random frame " + std::to_string(k));
  }
}

TEST(Dcs, ASharpCornerTakesMoreRadiiAndStillReadsBack) {
  LensOutline square;
  constexpr int kSide = 50;
  for (int k = 0; k < 4 * kSide; ++k) {
    const double along = 40.0 * (k % kSide) / kSide - 20.0;
    const int side = k / kSide;
    square.points.push_back(side == 0   ? Vector2d(20.0, along)
                            : side == 1 ? Vector2d(-along, 20.0)
                            : side == 2 ? Vector2d(-20.0, -along)
                                        : Vector2d(along, -20.0));
  }
  // Turned, so that no radius of any count meets the corners.
  const double turn = 0.1234;
  for (Vector2d& p : square.points) {
    p = Vector2d(p.x() * std::cos(turn) - p.y() * std::sin(turn), p.x() * std::sin(turn) + p.y() * std::cos(turn));
  }
  const auto trace = TraceOutlines(square, Mirrored(square));
  ASSERT_TRUE(trace) << trace.error().Text();
  EXPECT_GE(trace->right.radii.size(), 4000U);
  EXPECT_LE(Hausdorff(square, trace->right.radii, 1), 0.01);
}

TEST(Dcs, AnOutlineThatIsNoneIsRefused) { EXPECT_FALSE(TraceOutlines({}, {})); }

TEST(Dcs, DamageIsRefusedWithItsLine) {
  const std::string good = DcsText(JobOf(Ellipse(25.5, 17.3, {0.0, 0.0}), Ellipse(25.5, 17.3, {0.0, 0.0})));
  const auto changed = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::vector<std::pair<std::string, std::string>> damaged = {
      {changed("R=2550;", "R=255O;"), "line 12: a radius"},
      {changed("R=2550;", "R=;"), "line 12: a radius"},
      {changed("R=2550;", "R=0;"), "line 12: a radius"},
      {changed("R=2550;", "R=2550;2550;"), "more than 400"},
      {changed("TRCFMT=1;400;E;R;F", "TRCFMT=1;410;E;R;F"), "400 of 410"},
      {changed("TRCFMT=1;400;E;R;F", "TRCFMT=1;12;E;R;F"), "line 11: a trace has 90"},
      {changed("TRCFMT=1;400;E;R;F", "TRCFMT=1;400;U;R;F"), "line 11: TRCFMT"},
      {changed("TRCFMT=1;400;E;L;F", "TRCFMT=1;400;E;R;F"), "twice"},
      {changed("TRCFMT=1;400;E;R;F", "_X=1"), "radii come before TRCFMT"},
      {changed("HBOX=51.00;51.00", "HBOX=51.10;51.00"), "the right radii give a box of 51.00"},
      {changed("HBOX=51.00;51.00", "HBOX=51.00"), "right;left"},
      {changed("HBOX=51.00;51.00", "HBOX=nan;51.00"), "HBOX is not a number"},
      {changed("HBOX=51.00;51.00", "HBOX=1e1;51.00"), "HBOX is not a number"},
      {changed("HBOX=51.00;51.00\r\n", ""), "it has no HBOX"},
      {changed("DBL=18.25", "DBL=18.25\r\nDBL=18.25"), "DBL is there twice"},
      {changed("DO=B", "DO=R"), "DO is not B"},
      {changed("ETYP=1", "ETYP=9"), "ETYP"},
      {changed("JOB=", "job="), "no record"},
      {changed("JOB=", "JOB=\x01"), "printable ASCII"},
      {"", "it has no HBOX"},
      {good.substr(0, good.rfind("R=")), "390 of 400 radii are there"},
  };
  for (const auto& [text, message] : damaged) {
    const auto read = DcsFromText(text, "t.dcs");
    ASSERT_FALSE(read) << message;
    EXPECT_NE(read.error().Text().find(message), std::string::npos) << read.error().Text() << " lacks " << message;
  }
}

TEST(Dcs, LabelsThatWeDoNotKnowAndLineFeedsAloneAreTaken) {
  const DcsJob job = JobOf(Ellipse(25.5, 17.3, {0.0, 0.0}), Ellipse(25.5, 17.3, {0.0, 0.0}));
  std::string text = "VEN=ACME\r\n" + DcsText(job);
  std::erase(text, '\r');
  const auto read = DcsFromText(text, "t.dcs");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(*read, job);
}

}  // namespace
}  // namespace annulus
