#include "modeling/measure/section_svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>

#include "modeling/measure/section_arcs.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;
using testing::Not;

const std::vector<double> kBreaks{0.0, 20.0, 50.0, 70.0, 100.0};

/// r = 100 (1 + 0.2 cos 3θ): three lobes with hollows between.
SurfaceModel Clover() {
  return InterpolatedBody([](double theta, double) { return 100.0 * (1.0 + 0.2 * std::cos(3.0 * theta)); }, 360,
                          kBreaks);
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

std::string Svg(const SurfaceModel& model, const SectionSvgOptions& options = {}) {
  const auto svg = SectionSvg(Measured(model), 40.0, options);
  if (!svg) throw std::runtime_error(svg.error().Text());
  return *svg;
}

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// The d of the first path of a class.
std::string PathOf(const std::string& svg, const std::string& kind) {
  const std::string head = "<path class=\"" + kind + "\" d=\"";
  const std::size_t at = svg.find(head);
  if (at == std::string::npos) return "";
  return svg.substr(at + head.size(), svg.find('"', at + head.size()) - at - head.size());
}

Eigen::Vector2d PointOf(const SectionArc& arc, double t) {
  const double s = 1.0 - t;
  return s * s * s * arc[0] + 3.0 * s * s * t * arc[1] + 3.0 * s * t * t * arc[2] + t * t * t * arc[3];
}

TEST(SectionArcs, FollowACloverWithinAHundredthOfAMillimetre) {
  // At every point of the arcs r must be 100 (1 + 0.2 cos 3θ); the radial error is the larger one.
  const SurfaceModel model = Clover();
  const auto arcs = FitSectionArcs(model.main().surface, 40.0, 0.0, kTwoPi, 0.01);
  EXPECT_LT(arcs.size(), 100U);
  double turned = 0.0;
  for (std::size_t k = 0; k < arcs.size(); ++k) {
    EXPECT_LT((arcs[k][3] - arcs[(k + 1) % arcs.size()][0]).norm(), 1e-9);
    for (int step = 0; step <= 50; ++step) {
      const Eigen::Vector2d p = PointOf(arcs[k], step / 50.0);
      const double theta = std::atan2(p.y(), p.x());
      EXPECT_NEAR(p.norm(), 100.0 * (1.0 + 0.2 * std::cos(3.0 * theta)), 0.013);  // 0.01 mm along the normal
    }
    turned += std::acos(std::min(1.0, arcs[k][0].normalized().dot(arcs[k][3].normalized())));
  }
  EXPECT_NEAR(turned, kTwoPi, 1e-5);
}

TEST(SectionArcs, JoinInTheSameTangent) {
  const SurfaceModel model = Clover();
  const auto arcs = FitSectionArcs(model.main().surface, 40.0, 0.3, 2.0, 0.01);
  EXPECT_NEAR(std::atan2(arcs.front()[0].y(), arcs.front()[0].x()), 0.3, 1e-12);
  EXPECT_NEAR(std::atan2(arcs.back()[3].y(), arcs.back()[3].x()), 2.0, 1e-12);
  for (std::size_t k = 1; k < arcs.size(); ++k) {
    EXPECT_EQ(arcs[k][0], arcs[k - 1][3]);
    const Eigen::Vector2d before = (arcs[k - 1][3] - arcs[k - 1][2]).normalized();
    EXPECT_NEAR(before.dot((arcs[k][1] - arcs[k][0]).normalized()), 1.0, 1e-12);
  }
}

TEST(SectionSvg, OfACircleIsThatCircleInTrueScale) {
  // Radius 90 mm: 180 mm and twice the margin of 15 mm wide, in mm both on paper and in the view box.
  const std::string svg = Svg(InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks));
  EXPECT_THAT(svg, HasSubstr("width=\"210.000mm\""));
  EXPECT_THAT(svg, HasSubstr("viewBox=\"-105.000 -105.000 210.000 "));
  EXPECT_THAT(PathOf(svg, "measured"), testing::StartsWith("M90.0000,-0.0000 C90.0000,-"));
  EXPECT_EQ(Count(PathOf(svg, "measured"), "C"), 16U);
  EXPECT_THAT(PathOf(svg, "measured"), testing::EndsWith(" Z"));
  // A tape lies on a convex skin everywhere.
  EXPECT_EQ(Count(PathOf(svg, "tape"), "L"), 0U);
  EXPECT_THAT(svg, HasSubstr("perimeter 565.49 mm"));  // 2π·90
  EXPECT_THAT(svg, HasSubstr("area 25447 mm²"));       // π·90²
  EXPECT_THAT(svg, HasSubstr(">50 mm</text>"));
  for (const char* label : {">front<", ">back<", ">left<", ">right<"}) EXPECT_THAT(svg, HasSubstr(label));
  EXPECT_THAT(svg, Not(HasSubstr("±")));  // the model has no normal matrix
}

TEST(SectionSvg, PutsTheFrontUpAndTheSubjectsLeftOnTheLeft) {
  const std::string svg = Svg(Clover());
  const auto place = [&](const std::string& label) {
    std::smatch match;
    if (!std::regex_search(svg, match, std::regex("<text x=\"([-0-9.]+)\" y=\"([-0-9.]+)\"[^>]*>" + label + "<"))) {
      throw std::runtime_error("no label " + label);
    }
    return Eigen::Vector2d(std::stod(match[1]), std::stod(match[2]));
  };
  EXPECT_LT(place("front").y(), place("back").y());  // y of SVG points down
  EXPECT_LT(place("left").x(), place("right").x());
}

TEST(SectionSvg, SpansHollowsWithStraightTape) {
  const std::string tape = PathOf(Svg(Clover()), "tape");
  EXPECT_EQ(Count(tape, "L"), 3U);
  EXPECT_GE(Count(tape, "C"), 3U);
}

TEST(SectionSvg, ShowsWhatWasInferredAndLeavesGapsOpen) {
  SurfaceModel model = Clover();
  KnowledgeMap& map = model.segments.front().knowledge;  // 36 columns
  for (std::size_t row = 0; row < map.rows(); ++row) {
    for (const std::size_t column : {4U, 5U, 6U}) map.SetCell(column, row, Knowledge::kInferred);
  }
  std::string svg = Svg(model);
  EXPECT_EQ(Count(svg, "<path class=\"inferred\""), 1U);
  EXPECT_EQ(Count(svg, "<path class=\"measured\""), 1U);
  EXPECT_EQ(Count(svg, "<path class=\"tape\""), 1U);
  EXPECT_THAT(svg, HasSubstr("8.3 %"));  // 3 of 36
  EXPECT_THAT(PathOf(svg, "measured"), Not(HasSubstr("Z")));
  for (std::size_t row = 0; row < map.rows(); ++row) {
    for (const std::size_t column : {20U, 21U}) map.SetCell(column, row, Knowledge::kUnknown);
  }
  svg = Svg(model);
  EXPECT_EQ(Count(svg, "<path class=\"inferred\""), 1U);
  EXPECT_EQ(Count(svg, "<path class=\"measured\""), 2U);
  EXPECT_EQ(Count(svg, "<path class=\"tape\""), 0U);
  EXPECT_THAT(svg, HasSubstr("not one visible loop: 5.6 % was not seen"));
  EXPECT_THAT(svg, Not(HasSubstr("perimeter")));
}

TEST(SectionSvg, EscapesTheTitle) {
  const std::string svg = Svg(Clover(), {"waist <of> \"A & B\"\n"});
  EXPECT_THAT(svg, HasSubstr("waist &lt;of&gt; &quot;A &amp; B&quot; </text>"));
}

TEST(SectionSvg, IsRefusedOutsideTheScanAndWhereNothingWasSeen) {
  SurfaceModel model = Clover();
  const auto seen = [&](double z) {
    const auto svg = SectionSvg(Measured(model), z, {});
    return svg ? std::string("drawn") : svg.error().Text();
  };
  EXPECT_THAT(seen(101.0), HasSubstr("outside the scanned range"));
  EXPECT_THAT(seen(std::numeric_limits<double>::quiet_NaN()), HasSubstr("outside the scanned range"));
  KnowledgeMap& map = model.segments.front().knowledge;
  for (std::size_t k = 0; k < map.columns(); ++k) map.SetCell(k, 0, Knowledge::kUnknown);
  EXPECT_THAT(seen(0.5), HasSubstr("nothing of it was seen"));
  EXPECT_EQ(seen(50.0), "drawn");
}

}  // namespace
}  // namespace annulus
