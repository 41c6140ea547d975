#include "station/console/live_hub.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/station_console/console_desk.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using test::ListeningPeer;

class LiveHubTest : public testing::Test {
 protected:
  std::shared_ptr<ListeningPeer> Join(const std::string& user, StationRole role, const std::string& session) {
    auto peer = std::make_shared<ListeningPeer>();
    hub_->Join(peer, Caller{user, role, session, true, "::1"});
    return peer;
  }
  static Json Level() {
    Json level{{"type", "level"}, {"level", 1}, {"sensor_step", 1}, {"radius_mm", Json::array()}};
    for (int k = 0; k < 180; ++k) level["radius_mm"].push_back(k);
    return level;
  }

  std::unique_ptr<LiveHub> hub_ = LiveHub::Make();
};

TEST_F(LiveHubTest, SendsToTheRolesThatMaySee) {
  const auto nobody = Join("", StationRole::kNone, "");
  const auto anna = Join("anna", StationRole::kOperator, "s1");
  const auto root = Join("root", StationRole::kAdmin, "s2");
  hub_->Send({{"type", "status"}}, kEverybody);
  hub_->Send(Level(), kOperatorsTechnicians, true);
  EXPECT_EQ(nobody->texts.size(), 1U);
  EXPECT_EQ(anna->texts.size(), 2U);
  EXPECT_EQ(root->texts.size(), 1U);
}

TEST_F(LiveHubTest, EncodesOnceForAll) {
  const auto anna = Join("anna", StationRole::kOperator, "s1");
  const auto ben = Join("ben", StationRole::kOperator, "s2");
  hub_->Send(Level(), kOperators, true);
  EXPECT_EQ(anna->encoded[0], ben->encoded[0]);
}

TEST_F(LiveHubTest, ThinsLevelsToWhatEachClientWants) {
  const auto all = Join("anna", StationRole::kOperator, "s1");
  const auto few = Join("ben", StationRole::kOperator, "s2");
  hub_->Subscribe(few, 6);
  hub_->Send(Level(), kOperators, true);
  EXPECT_EQ(all->texts[0]["radius_mm"].size(), 180U);
  ASSERT_EQ(few->texts[0]["radius_mm"].size(), 30U);
  EXPECT_EQ(few->texts[0]["sensor_step"], 6);
  EXPECT_EQ(few->texts[0]["radius_mm"][7], 42) << "sensor 7·6";
}

TEST_F(LiveHubTest, LeavesLevelsOutForWhoDoesNotRead) {
  const auto slow = Join("anna", StationRole::kOperator, "s1");
  slow->queued = HttpLimits().socket_queue_bytes / 4 + 1;
  hub_->Send(Level(), kOperators, true);
  hub_->Send({{"type", "status"}}, kEverybody);
  ASSERT_EQ(slow->texts.size(), 1U);
  EXPECT_EQ(slow->texts[0]["type"], "status");
}

TEST_F(LiveHubTest, JobsAreForTheirOwnersBrowsersOnly) {
  const auto anna = Join("anna", StationRole::kOperator, "s1");
  const auto annas_other = Join("anna", StationRole::kOperator, "s2");
  const auto ben = Join("ben", StationRole::kOperator, "s3");
  const auto nobody = Join("", StationRole::kNone, "");
  hub_->SendTo("anna", {{"type", "job"}});
  hub_->SendTo("", {{"type", "job"}});
  hub_->SendToSession("s2", {{"type", "screen_wiped"}});
  hub_->SendToSession("", {{"type", "screen_wiped"}});
  EXPECT_EQ(anna->texts.size(), 1U);
  EXPECT_EQ(annas_other->texts.size(), 2U);
  EXPECT_TRUE(ben->texts.empty());
  EXPECT_TRUE(nobody->texts.empty());
}

TEST_F(LiveHubTest, AnEndedSessionsSocketsHearWhyAndNothingMore) {
  const auto anna = Join("anna", StationRole::kOperator, "s1");
  EndSession(*hub_, "s1", "logged out");
  hub_->Send({{"type", "status"}}, kEverybody);
  ASSERT_EQ(anna->texts.size(), 1U);
  EXPECT_EQ(anna->texts[0]["reason"], "logged out");
  EXPECT_TRUE(anna->closed);
}

TEST_F(LiveHubTest, WhoHasLeftHearsNothing) {
  const auto anna = Join("anna", StationRole::kOperator, "s1");
  hub_->Leave(anna);
  hub_->Send({{"type", "status"}}, kEverybody);
  EXPECT_TRUE(anna->texts.empty());
}

}  // namespace
}  // namespace annulus
