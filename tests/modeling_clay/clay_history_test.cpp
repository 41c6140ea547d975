#include "modeling/clay/clay_history.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "modeling/clay/clay_shapes.h"

namespace annulus {
namespace {

const std::string kPush = R"({"op":"push","patch":21,"u":0.3,"v":0.5,"depth_mm":0.3,"radius_mm":0.8})";
const std::string kPull = R"({"op":"pull","patch":14,"depth_mm":0.1,"radius_mm":0.5,"model":2})";
const std::string kTwist = R"({"op":"twist","angle_deg":20,"from":[-3,0,-1],"to":{"patch":35,"u":1,"v":0.5}})";

std::string Script(const std::string& operations) { return "{\"mirrored\":true,\"operations\":[" + operations + "]}"; }

ClayBody Block() { return std::move(*ClayBody::Make(ClayBlock())); }

ClayFile Shaped(const std::vector<std::string>& scripts) {
  auto file = Replay(Block(), scripts);
  EXPECT_TRUE(file) << (file ? "" : file.error().Text());
  return std::move(*file);
}

TEST(ClayHistory, ReplaysToTheByteOverSeveralScripts) {
  const ClayFile whole = Shaped({Script(kPush), Script(kPull + "," + kTwist)});
  auto read = ClayFromJson(ClayToJson(whole), "clay.json");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(ClayToJson(*Replay(Block(), read->scripts)), ClayToJson(whole));
}

TEST(ClayHistory, IsCutBackToWhatWasBefore) {
  const ClayFile whole = Shaped({Script(kPush), Script(kPull + "," + kTwist)});
  const std::vector<std::vector<std::string>> before{
      {Script(kPush), Script(kPull + "," + kTwist)}, {Script(kPush), Script(kPull)}, {Script(kPush)}, {}};
  for (std::size_t count = 0; count < before.size(); ++count) {
    const auto undone = Undone(whole, Block(), count);
    ASSERT_TRUE(undone) << undone.error().Text();
    EXPECT_EQ(ClayToJson(*undone), ClayToJson(Shaped(before[count]))) << count;
  }
  const auto none = Undone(whole, Block(), 4);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().seen, "its history has 3 operations, not 4");
}

TEST(ClayHistory, KnowsTheBodyThatItBeganWith) {
  const ClayFile whole = Shaped({Script(kPush)});
  const ClayBody other = std::move(*ClayBody::Make(ClayBlock(6.0, 3.5)));
  const auto undone = Undone(whole, other, 1);
  ASSERT_FALSE(undone);
  EXPECT_NE(undone.error().seen.find("its history on that body leads"), std::string::npos) << undone.error().Text();
}

}  // namespace
}  // namespace annulus
