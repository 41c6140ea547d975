#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "modeling/flatten/pattern_dxf.h"
#include "modeling/flatten/pattern_json.h"
#include "modeling/flatten/pattern_svg.h"
#include "tests/modeling_flatten/flat_bodies.h"

namespace annulus {
namespace {

/// A rectangle of 200 × 100 mm that is ready to be cut.
std::vector<DrawnPiece> Rectangle() {
  DrawnPiece piece;
  piece.id = "back";
  piece.label = {"Back (後ろ)"};
  piece.label_at = {100.0, 50.0};
  piece.cut = {{{0.0, 0.0}, {200.0, 0.0}, {200.0, 100.0}, {0.0, 100.0}}, DrawnChain::End::kClosed};
  piece.sew = {{{{10.0, 10.0}, {190.0, 10.0}}, DrawnChain::End::kOpen}};
  piece.grain = {{Eigen::Vector2d(100.0, 20.0), Eigen::Vector2d(100.0, 80.0)}};
  piece.notches = {{Eigen::Vector2d(10.0, 50.0), Eigen::Vector2d(0.0, 50.0)}};
  piece.high = {200.0, 100.0};
  return {piece};
}

/// Group codes and values, two lines each, as R12 wants them.
std::vector<std::pair<int, std::string>> Groups(const std::string& dxf) {
  std::vector<std::pair<int, std::string>> groups;
  std::istringstream lines(dxf);
  std::string code, value;
  while (std::getline(lines, code) && std::getline(lines, value)) groups.emplace_back(std::stoi(code), value);
  return groups;
}

TEST(PatternDxf, IsAnR12FileOfPolylinesLinesAndText) {
  const std::string dxf = PatternDxf(Rectangle());
  const auto groups = Groups(dxf);
  ASSERT_FALSE(groups.empty());
  EXPECT_EQ(groups.back(), std::pair(0, std::string("EOF")));
  std::map<std::string, int> entities;
  std::string entity;
  for (const auto& [code, value] : groups) {
    if (code == 0) entity = value;
    if (code == 8) ++entities[entity + " " + value];
  }
  EXPECT_EQ(entities["POLYLINE CUT"], 1);
  EXPECT_EQ(entities["VERTEX CUT"], 4);
  EXPECT_EQ(entities["POLYLINE SEW"], 1);
  EXPECT_EQ(entities["LINE GRAIN"], 1);
  EXPECT_EQ(entities["LINE NOTCH"], 1);
  EXPECT_EQ(entities["TEXT LABEL"], 1);
  EXPECT_NE(dxf.find("AC1009"), std::string::npos);
  for (const char c : dxf) EXPECT_LT(static_cast<unsigned char>(c), 128);
}

TEST(PatternSvg, IsInMillimetresWithACheckSquare) {
  const std::string svg = PatternSvg(Rectangle(), "a <b>");
  EXPECT_NE(svg.find("width=\"220.000mm\""), std::string::npos);
  EXPECT_NE(svg.find("viewBox=\"0 0 220.000"), std::string::npos);
  EXPECT_NE(svg.find("class=\"check\""), std::string::npos);
  EXPECT_NE(svg.find("a &lt;b&gt;"), std::string::npos);
}

TEST(PatternFromJson, RefusesWhatIsNoPattern) {
  const std::string head = R"({"format": "annulus pattern", "version": 1, "name": "x", )";
  for (const char* rest :
       {R"("lines": {}, "pieces": []})", R"("lines": {"a": {"places": [{"theta_deg": 0, "z_mm": 1}]}}, "pieces": []})",
        R"("lines": {"a": 3}, "pieces": [{"id": "p", "outline": ["a"]}]})",
        R"("lines": {}, "pieces": [{"id": "p", "outline": ["b"]}]})", R"("lines": {}, "pieces": [7]})",
        R"("element_mm": -1, "lines": {}, "pieces": []})",
        R"("lines": {"a": {"places": [{"theta_deg": 0, "z_mm": 1}, {"z_mm": 1}]}}, "pieces": []})", "}", ""}) {
    EXPECT_FALSE(PatternFromJson(head + rest, "bad.json")) << rest;
  }
}

}  // namespace
}  // namespace annulus
