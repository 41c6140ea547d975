#include "modeling/clay/clay_json.h"

#include <gtest/gtest.h>

#include <string>

#include "modeling/clay/clay_script.h"
#include "modeling/clay/clay_shapes.h"
#include "tests/modeling_clay/clay_check.h"

namespace annulus {
namespace {

constexpr const char* kScript = R"({"mirrored": false, "masks": [{"patch": 0, "radius_mm": 0.4}], "operations": [
  {"op": "push", "model": 1, "patch": 21, "u": 0.3, "v": 0.5, "depth_mm": 0.3, "radius_mm": 0.8},
  {"op": "pull", "patch": 14, "depth_mm": 0.1, "radius_mm": 0.5, "rho_mm": 0.9, "tool": "hand"},
  {"op": "twist", "angle_deg": 20, "from": [-3, 0, -1], "to": {"patch": 35, "u": 1, "v": 0.5}},
  {"op": "line", "path": [{"patch": 7}, {"patch": 28}], "depth_mm": 0.03, "radius_mm": 0.3}]})";

ClayFile Shaped() {
  ClayFile file{std::move(*ClayBody::Make(ClayBlock())), {kScript}};
  const auto script = ClayScriptFromJson(kScript, "ops.json");
  EXPECT_TRUE(script) << (script ? "" : script.error().Text());
  for (const ClayStep& step : script->steps) {
    const auto report = Perform(file.body, step, script->practice);
    EXPECT_TRUE(report) << (report ? "" : report.error().Text());
  }
  return file;
}

TEST(ClayScript, ReplaysToTheByte) { EXPECT_EQ(ClayToJson(Shaped()), ClayToJson(Shaped())); }

TEST(ClayJson, ReadsBackToTheByteAndGoesOn) {
  ClayFile file = Shaped();
  const std::string text = ClayToJson(file);
  auto back = ClayFromJson(text, "clay.json");
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_EQ(ClayToJson(*back), text);
  EXPECT_EQ(test::Unsound(back->body.mesh(), 1e-9), "");
  ToolHold hold;
  hold.at = {16, 0.5, 0.5};
  hold.radius_mm = 0.5;
  const PushAct act{hold, 0.2, 2, 2.0};
  ASSERT_TRUE(Perform(file.body, act));
  ASSERT_TRUE(Perform(back->body, act));
  EXPECT_NEAR(back->body.volume(), file.body.volume(), 1e-11);
}

TEST(ClayScript, HoldsAToolWhereTheSkinIsNearestToAPoint) {
  const auto script = ClayScriptFromJson(
      R"({"operations": [{"op": "push", "near_mm": [0.3, -1.2, 4], "depth_mm": 0.2, "radius_mm": 0.6}]})", "ops.json");
  ASSERT_TRUE(script) << script.error().Text();
  ClayBody body = std::move(*ClayBody::Make(ClayBlock()));
  ASSERT_TRUE(Perform(body, script->steps[0], script->practice));
  // x = 0.3, y = -1.2 of the top are in the cell (3, 1): patch 6 + 3, u = 0.3, v = 0.8.
  EXPECT_NEAR(body.Point({9, 0.3, 0.8}).z(), -0.2, 1e-3);
  EXPECT_NEAR(body.Point({20, 0.5, 0.5}).z(), 0.0, 1e-12);
}

TEST(ClayScript, NamesWhatItDoesNotKnow) {
  const auto seen = [](const std::string& operation) {
    const auto script = ClayScriptFromJson("{\"operations\": [" + operation + "]}", "ops.json");
    EXPECT_FALSE(script);
    return script ? std::string() : script.error().seen;
  };
  EXPECT_EQ(seen(R"({"op": "push", "patch": 1, "dpth_mm": 3})"), "'operations[0].dpth_mm' is not known here");
  EXPECT_NE(seen(R"({"op": "psh"})").find("'operations[0].op' is 'psh', none of add, ball"), std::string::npos);
  EXPECT_NE(seen(R"({"op": "push", "patch": 1, "tool": "nippers"})").find("none of finger, hand, spatula"),
            std::string::npos);
  EXPECT_NE(seen(R"({"op": "push", "patch": -1})").find("whole number"), std::string::npos);
  EXPECT_NE(seen(R"({"op": "push"})").find("'operations[0].patch' is missing"), std::string::npos);
  EXPECT_NE(seen("3").find("not an object"), std::string::npos);
  EXPECT_FALSE(ClayScriptFromJson("", "ops.json"));
  EXPECT_FALSE(ClayScriptFromJson("{}", "ops.json"));
}

TEST(ClayJson, RefusesWhatIsDamaged) {
  const std::string text = ClayToJson({std::move(*ClayBody::Make(ClayBlock())), {}});
  const auto broken = [&text](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    return static_cast<bool>(ClayFromJson(changed, "clay.json"));
  };
  EXPECT_FALSE(broken("\"level\":0", "\"level\":1"));
  EXPECT_FALSE(broken("\"edge\":3", "\"edge\":2"));
  EXPECT_FALSE(broken("\"ratio\":1.0", "\"ratio\":-1.0"));
  EXPECT_FALSE(broken("\"vertex\":[", "\"vertex\":[7,"));
  EXPECT_FALSE(broken("\"net\":[-3.0", "\"net\":[null"));
  EXPECT_FALSE(broken("\"net\":[-3.0", "\"net\":[-3.1"));
  EXPECT_FALSE(broken("\"kept_volume_mm3\":1", "\"kept_volume_mm3\":-1"));
  EXPECT_FALSE(ClayFromJson(text.substr(0, text.size() / 2), "clay.json"));
}

}  // namespace
}  // namespace annulus
