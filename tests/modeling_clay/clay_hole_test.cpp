#include "modeling/clay/clay_hole.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "modeling/clay/clay_girths.h"
#include "modeling/clay/clay_joins.h"
#include "modeling/clay/clay_json.h"
#include "modeling/clay/clay_script.h"
#include "modeling/clay/clay_tessellate.h"
#include "tests/modeling_clay/clay_check.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Through the block's top, downwards, in its inner patches.
HoleAct Through(std::uint32_t patch, double radius) {
  HoleAct act;
  act.how = HoleAct::How::kThrough;
  act.hold.at = {patch, 0.3, 0.4};
  act.hold.radius_mm = radius;
  return act;
}

/// V − E + F: 2 of a ball, 0 of a ring, −2 of a body with two holes.
long Euler(const ClayMesh& mesh) {
  long vertices = 0;
  for (VertexIndex vertex = 0; vertex < mesh.vertex_slots(); ++vertex)
    vertices += mesh.vertex(vertex).corners.empty() ? 0 : 1;
  long half_edges = 0;
  for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
    if (!mesh.alive(index)) continue;
    for (const ClayJoin& join : mesh.patch(index).join) {
      half_edges += join.kind == ClayJoin::Kind::kEqual ? 1 : 0;
      half_edges += join.kind == ClayJoin::Kind::kCoarser ? 2 : 0;
    }
  }
  return vertices - half_edges / 2 + static_cast<long>(mesh.leaf_count());
}

long EulerOf(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& triangle : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto ends = std::minmax(triangle[k], triangle[(k + 1) % 3]);
      ++edges[{ends.first, ends.second}];
    }
  }
  for (const auto& [ends, count] : edges) EXPECT_EQ(count, 2);
  return static_cast<long>(mesh.vertices.size()) - static_cast<long>(edges.size()) +
         static_cast<long>(mesh.faces.size());
}

TEST(ClayHole, MakesARingOfABlock) {
  ClayBody body = std::move(*ClayBody::Make(ClayBlock()));
  EXPECT_EQ(Euler(body.mesh()), 2);
  const double radius = 0.5;
  const auto report = Perform(body, Through(21, radius));
  ASSERT_TRUE(report) << report.error().Text();
  EXPECT_EQ(Euler(body.mesh()), 0);
  EXPECT_EQ(EulerOf(Tessellate(body.mesh(), 3)), 0);
  EXPECT_EQ(test::Unsound(body.mesh(), 1e-12), "");
  EXPECT_NEAR(body.volume(), 108.0, 1e-12 * 108.0);
  EXPECT_EQ(report->moved_mm3, 0.0);
  // A square hole of the area πr² through 3 mm, and the whole swollen to the old volume: on a level through the middle
  // the outline of the block and that of the hole.
  const double scale = std::cbrt(108.0 / (108.0 - 3.0 * std::numbers::pi * radius * radius));
  const Vector3d low = body.Point({36, 0.0, 0.0});
  const ClayGirths girths(body, {low.z() + 1.4});
  EXPECT_NEAR(girths.Perimeter(0), scale * (24.0 + 4.0 * std::sqrt(std::numbers::pi) * radius), 1e-9);
  EXPECT_NEAR(girths.Tape(0), scale * 24.0, 1e-9);
}

TEST(ClayHole, IsRefusedAsAPlaceAndKeepsTheAddressesOfTheRest) {
  ClayBody body = std::move(*ClayBody::Make(ClayBlock()));
  const Vector3d beside = body.Point({22, 0.5, 0.5});
  ASSERT_TRUE(Perform(body, Through(14, 0.5)));
  EXPECT_LT((body.Point({22, 0.5, 0.5}) - beside).norm(), 0.1);
  ToolHold hold;
  hold.at = {14, 0.3, 0.4};
  hold.radius_mm = 0.5;
  const auto report = Perform(body, PushAct{hold, 0.1, 1, 2.0});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().seen.find("patch 14 at u 0.3, v 0.4 is in a hole"), std::string::npos);
  hold.at = {15, 0.8, 0.4};
  const auto pushed = Perform(body, PushAct{hold, 0.05, 1, 2.0});
  EXPECT_TRUE(pushed) << pushed.error().Text();
}

TEST(ClayHole, GoesThroughABentBodyTwiceAndBearsOperations) {
  ClayBody body = std::move(*ClayBody::Make(test::RoundBlock()));
  const double start = body.volume();
  for (const std::uint32_t patch : {14U, 27U}) {
    const auto report = Perform(body, Through(patch, 0.35));
    ASSERT_TRUE(report) << report.error().Text();
    ASSERT_EQ(test::Unsound(body.mesh(), 1e-9), "");
  }
  EXPECT_EQ(Euler(body.mesh()), -2);
  std::mt19937_64 random(3);
  const auto even = [&random] { return static_cast<double>(random() >> 11U) * 0x1.0p-53; };
  int done = 0;
  for (int n = 0; n < 60; ++n) {
    ToolHold hold;
    // The walls' patches, too: they come after the 144 of the block.
    hold.at = {static_cast<std::uint32_t>(n % 3 == 0 ? 144 + random() % (body.mesh().base_count() - 144)
                                                     : 7 + 6 * (random() % 4) + random() % 4),
               even(), even()};
    hold.radius_mm = 0.5 + 0.3 * even();
    const auto report = Perform(body, PushAct{hold, 0.04 * (even() - 0.5), random() % 2 == 0 ? 1 : 2, 2.0});
    if (!report) continue;
    ++done;
    ASSERT_LE(std::abs(report->volume_after_mm3 / start - 1.0), 1e-12);
    ASSERT_EQ(test::Unsound(body.mesh(), 1e-9), "") << n;
  }
  EXPECT_GT(done, 40);
  ASSERT_TRUE(Perform(body, KneadAct{0.05, 4.0, 3}));
  ASSERT_TRUE(Perform(body, TwistAct{{Vector3d(-1.5, 0, -1.5), Vector3d(1.5, 0, -1.5)}, 0.2}));
  EXPECT_EQ(test::Unsound(body.mesh(), 1e-9), "");
  EXPECT_EQ(Euler(body.mesh()), -2);
  EXPECT_LE(MeasureJoins(body.mesh()).largest_kink_rad, 1e-6);
  EXPECT_LE(MeasureJoins(body.mesh()).largest_kink_elsewhere_rad, 1e-3);
}

TEST(ClayHole, IsWidenedAndNarrowed) {
  ClayBody body = std::move(*ClayBody::Make(ClayBlock()));
  ASSERT_TRUE(Perform(body, Through(21, 0.4)));
  const auto girth = [&body] { return ClayGirths(body, {-1.5}).Perimeter(0); };
  const double outline = 4.0 * std::sqrt(std::numbers::pi);
  HoleAct act;
  act.hold.at = {21, 0.4, 0.4};
  double radius = 0.4;
  for (const auto& [how, factor] : {std::pair{HoleAct::How::kWiden, 1.5}, {HoleAct::How::kClose, 3.0}}) {
    act.how = how;
    act.factor = factor;
    const auto report = Perform(body, act);
    ASSERT_TRUE(report) << report.error().Text();
    radius *= how == HoleAct::How::kWiden ? factor : 1.0 / factor;
    EXPECT_EQ(test::Unsound(body.mesh(), 1e-9), "");
    EXPECT_NEAR(body.volume(), 108.0, 1e-10);
    // The block swells by what the hole takes: on the way there by less than 2 %.
    EXPECT_NEAR(girth(), 24.0 + outline * radius, 0.02 * 24.0);
    EXPECT_NEAR(LineOf(body, 0).radius_mm, radius, 0.02 * radius);
  }
  EXPECT_EQ(Euler(body.mesh()), 0);
}

TEST(ClayHole, IsRefusedWhereThereIsNoFarSide) {
  ClayBody body = std::move(*ClayBody::Make(ClayBlock()));
  const std::string before = ClayToJson({body, {}});
  HoleAct act = Through(21, 0.5);
  act.hold.direction = Vector3d(0.0, 0.0, 1.0);
  const auto outwards = Perform(body, act);
  ASSERT_FALSE(outwards);
  EXPECT_NE(outwards.error().seen.find("no far side"), std::string::npos) << outwards.error().Text();
  act = Through(21, 0.5);
  act.how = HoleAct::How::kThrough;
  // Along the top: it would come out where it went in.
  act.hold.direction = Vector3d(1.0, 0.0, -1e-9);
  EXPECT_FALSE(Perform(body, act));
  EXPECT_EQ(ClayToJson({body, {}}), before);
}

constexpr const char* kScript = R"({"operations": [
  {"op": "push", "patch": 20, "depth_mm": 0.1, "radius_mm": 0.8},
  {"op": "hole", "through": true, "patch": 14, "u": 0.4, "v": 0.4, "radius_mm": 0.4},
  {"op": "knead", "amplitude_mm": 0.1, "wavelength_mm": 4},
  {"op": "hole", "through": true, "patch": 27, "u": 0.6, "v": 0.7, "radius_mm": 0.4, "direction": [0.1, 0, -1]},
  {"op": "push", "patch": 150, "depth_mm": 0.02, "radius_mm": 0.2}]})";

ClayFile Pierced() {
  ClayFile file{std::move(*ClayBody::Make(ClayBlock())), {kScript}};
  const auto script = ClayScriptFromJson(kScript, "ops.json");
  EXPECT_TRUE(script) << (script ? "" : script.error().Text());
  for (const ClayStep& step : script->steps) {
    const auto report = Perform(file.body, step, script->practice);
    EXPECT_TRUE(report) << (report ? "" : report.error().Text());
  }
  return file;
}

TEST(ClayHole, ReplaysAndReadsBackToTheByte) {
  const ClayFile file = Pierced();
  const std::string text = ClayToJson(file);
  EXPECT_EQ(ClayToJson(Pierced()), text);
  EXPECT_NEAR(file.body.volume(), 108.0, 1e-10);
  auto back = ClayFromJson(text, "clay.json");
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_EQ(ClayToJson(*back), text);
  EXPECT_EQ(Euler(back->body.mesh()), -2);
  EXPECT_EQ(test::Unsound(back->body.mesh(), 1e-9), "");
  ToolHold hold;
  hold.at = {16, 0.5, 0.5};
  hold.radius_mm = 0.5;
  ASSERT_TRUE(Perform(back->body, PushAct{hold, 0.1, 2, 2.0}));
  for (const auto& [from, to] : {std::pair{"\"turn\":", "\"turn\":7"},
                                 {"\"segments\":", "\"segments\":9"},
                                 {"\"entry\":{\"patch\":", "\"entry\":{\"patch\":1"}}) {
    std::string broken = text;
    const std::size_t at = broken.find(from);
    ASSERT_NE(at, std::string::npos);
    broken.replace(at, std::string(from).size(), to);
    EXPECT_FALSE(ClayFromJson(broken, "clay.json")) << to;
  }
}

TEST(ClayHole, IsFilledAgain) {
  ClayFile file{std::move(*ClayBody::Make(ClayBlock())), {}};
  ClayBody& body = file.body;
  HoleAct act = Through(14, 0.5);
  ASSERT_TRUE(Perform(body, act));
  ASSERT_TRUE(Perform(body, Through(27, 0.4)));
  // Something that cuts walls and rims.
  ToolHold hold;
  hold.at = {15, 0.2, 0.5};
  hold.radius_mm = 0.6;
  const auto pushed = Perform(body, PushAct{hold, 0.03, 1, 2.0});
  ASSERT_TRUE(pushed) << pushed.error().Text();
  act.how = HoleAct::How::kFill;
  const auto report = Perform(body, act);
  ASSERT_TRUE(report) << report.error().Text();
  EXPECT_EQ(Euler(body.mesh()), 0);
  EXPECT_EQ(EulerOf(Tessellate(body.mesh(), 3)), 0);
  EXPECT_EQ(test::Unsound(body.mesh(), 1e-9), "");
  EXPECT_NEAR(body.volume(), 108.0, 1e-10);
  EXPECT_FALSE(Perform(body, act)) << "it is no more";
  // The place is one again, and the file knows.
  hold.at = act.hold.at;
  ASSERT_TRUE(Perform(body, PushAct{hold, 0.05, 2, 2.0}));
  const std::string text = ClayToJson(file);
  auto back = ClayFromJson(text, "clay.json");
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_EQ(ClayToJson(*back), text);
  act.hold.at = {27, 0.3, 0.4};
  ASSERT_TRUE(Perform(back->body, act));
  EXPECT_EQ(Euler(back->body.mesh()), 2);
  EXPECT_EQ(test::Unsound(back->body.mesh(), 1e-9), "");
}

TEST(ClayHole, OfABlockIsUndoneByFillingIt) {
  ClayBody body = std::move(*ClayBody::Make(ClayBlock()));
  HoleAct act = Through(21, 0.5);
  ASSERT_TRUE(Perform(body, act));
  act.how = HoleAct::How::kFill;
  ASSERT_TRUE(Perform(body, act));
  // A block again: flat, of the old size; and as many patches.
  EXPECT_EQ(body.mesh().leaf_count(), 144U);
  EXPECT_NEAR(body.Area(), 144.0, 1e-10);
  EXPECT_NEAR(body.Point({0, 0.0, 0.0}).z() - body.Point({36, 0.0, 0.0}).z(), 3.0, 1e-12);
  EXPECT_NEAR((body.Point({21, 0.5, 0.5}) - body.Point({0, 0.0, 0.0})).z(), 0.0, 1e-12);
}

TEST(ClayHole, ThatGoesThroughIsMadeAndClosed) {
  const auto seen = [](const std::string& operation) {
    const auto script = ClayScriptFromJson("{\"operations\": [" + operation + "]}", "ops.json");
    return script ? std::string() : script.error().seen;
  };
  EXPECT_EQ(seen(R"({"op": "hole", "how": "close", "through": true, "patch": 1})"), "");
  EXPECT_NE(seen(R"({"op": "hole", "how": "widen", "through": true, "patch": 1})").find("is for making and closing"),
            std::string::npos);
  EXPECT_NE(seen(R"({"op": "hole", "through": 1, "patch": 1})").find("neither true nor false"), std::string::npos);
}

}  // namespace
}  // namespace annulus
