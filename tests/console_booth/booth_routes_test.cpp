#include <thread>

#include "tests/console_booth/console_parts.h"

namespace annulus {
namespace {

using nlohmann::json;
using test::Answer;
using test::ConsoleParts;
using test::RouteCaller;
using test::ServedBooth;
using testing::HasSubstr;

/// The booth's routes on a served state machine, with somebody who has consented.
class BoothRoutes : public testing::Test {
 protected:
  BoothRoutes() : parts_(booth_.path(), "/bin/false") {
    AddBoothRoutes(routes_.table, parts_.context());
    std::tie(customer_, consent_) = parts_.Somebody();
    EXPECT_FALSE(parts_.hub.WaitForType("status").is_null());
  }
  json ArmBody() { return {{"customer_id", customer_}, {"consent_id", consent_}, {"profile", "body"}}; }
  void Home() {
    ASSERT_EQ(routes_.Post("/api/booth/home").status, 200);
    ASSERT_TRUE(booth_.port().Tell(ScanEventKind::kHomed));
  }
  std::uint64_t Version() { return booth_.port().status().version; }
  RouteCaller As(StationRole role) {
    RouteCaller caller = routes_;
    caller.caller.role = role;
    return caller;
  }

  ServedBooth booth_;
  ConsoleParts parts_;
  RouteCaller routes_;
  std::string customer_;
  std::string consent_;
};

TEST_F(BoothRoutes, ShowTheBoothInBothLanguages) {
  const Answer english = routes_.Get("/api/booth");
  ASSERT_EQ(english.status, 200);
  EXPECT_EQ(english.json.at("connected"), true);
  EXPECT_EQ(english.json.at("booth").at("station_id"), "test");
  EXPECT_EQ(english.json.at("status").at("state"), "IDLE");
  EXPECT_FALSE(english.json.at("status").contains("type"));
  EXPECT_EQ(english.json.at("plain").at("state_text"), "Waiting.");
  const Answer japanese = routes_.Get("/api/booth?language=ja");
  EXPECT_EQ(japanese.json.at("plain").at("state_text"), "待機中です。");
}

// RELIABILITY U1.
TEST_F(BoothRoutes, BindTheScanToCustomerAndConsentWhateverBecomesOfThem) {
  Home();
  const Answer armed = routes_.Post("/api/booth/arm", ArmBody());
  ASSERT_EQ(armed.status, 200) << armed.seen;
  Customer renamed = *parts_.store().GetCustomer(customer_);
  renamed.name = "Somebody else";
  ASSERT_TRUE(parts_.store().ChangeCustomer(renamed));
  ASSERT_EQ(routes_.Post("/api/booth/start", {{"version", Version()}}).status, 200);
  const ArmOrder order = booth_.port().armed();
  EXPECT_EQ(order.subject_id, customer_);
  EXPECT_EQ(order.consent, consent_);
  EXPECT_EQ(order.out, armed.json.at("scan_ticket").get<std::string>() + ".mcap");
  EXPECT_EQ(order.height, Millimetres(1620.0)) << "the customer's own";
}

TEST_F(BoothRoutes, DoNotArmWithoutAConsentThatCoversTheScan) {
  Home();
  json body = ArmBody();
  const auto [other, others_consent] = parts_.Somebody();
  body["consent_id"] = others_consent;
  EXPECT_EQ(routes_.Post("/api/booth/arm", body).field, "consent_id") << "somebody else's";
  const auto [head, glasses_only] = parts_.Somebody({"glasses"});
  body["customer_id"] = head;
  body["consent_id"] = glasses_only;
  EXPECT_EQ(routes_.Post("/api/booth/arm", body).field, "consent_id") << "does not cover the body";
  body["profile"] = "head";
  EXPECT_EQ(routes_.Post("/api/booth/arm", body).status, 200) << "but the head";
  ASSERT_TRUE(parts_.store().WithdrawConsent(consent_));
  const Answer withdrawn = routes_.Post("/api/booth/arm", ArmBody());
  EXPECT_EQ(withdrawn.status, 400);
  EXPECT_THAT(withdrawn.seen, HasSubstr("withdrawn"));
  body["customer_id"] = "K-999999";
  EXPECT_EQ(routes_.Post("/api/booth/arm", body).status, 404);
}

// RELIABILITY U2.
TEST_F(BoothRoutes, NameTheFieldThatIsOutOfRange) {
  Home();
  const auto field = [&](const char* key, const json& value) {
    json body = ArmBody();
    body[key] = value;
    const Answer answer = routes_.Post("/api/booth/arm", body);
    EXPECT_EQ(answer.status, 400) << key << " " << value.dump().substr(0, 80);
    return answer.field;
  };
  EXPECT_EQ(field("height_mm", 5), "height_mm");
  EXPECT_EQ(field("height_mm", 1e300), "height_mm");
  EXPECT_EQ(field("height_mm", "tall"), "height_mm");
  EXPECT_EQ(field("height_mm", std::nan("")), "height_mm");
  EXPECT_EQ(field("profile", "sideways"), "profile");
  EXPECT_EQ(field("profile", std::string(10'000'000, 'x')), "profile");
  EXPECT_EQ(field("customer_id", 7), "customer_id");
  EXPECT_EQ(field("hieght_mm", 1700), "hieght_mm") << "misspelt";
  EXPECT_EQ(routes_.Post("/api/booth/start", {{"version", -1}}).field, "version");
  EXPECT_EQ(routes_.Post("/api/booth/start", {{"version", 1.5}}).field, "version");
  EXPECT_EQ(routes_.Post("/api/booth/start").field, "version");
  EXPECT_EQ(booth_.port().scans(), 0U);
}

// RELIABILITY N2.
TEST_F(BoothRoutes, MakeOneScanOfTwoTabsThatRaceForTheStart) {
  Home();
  ASSERT_EQ(routes_.Post("/api/booth/arm", ArmBody()).status, 200);
  const json body{{"version", Version()}};
  std::atomic<int> accepted{0};
  std::atomic<int> refused{0};
  {
    std::vector<std::jthread> tabs;
    for (int tab = 0; tab < 8; ++tab) {
      tabs.emplace_back([&] {
        RouteCaller own = routes_;
        const Answer answer = own.Post("/api/booth/start", body);
        (answer.status == 200 ? accepted : refused) += answer.status == 200 || answer.status == 409 ? 1 : 0;
      });
    }
  }
  EXPECT_EQ(accepted, 1);
  EXPECT_EQ(refused, 7);
  EXPECT_EQ(booth_.port().scans(), 1U);
}

// RELIABILITY N3.
TEST_F(BoothRoutes, RefuseAStartForAStateThatIsPast) {
  Home();
  ASSERT_EQ(routes_.Post("/api/booth/arm", ArmBody()).status, 200);
  const std::uint64_t looked_at = Version();
  ASSERT_EQ(routes_.Post("/api/booth/arm", ArmBody()).status, 200) << "somebody else has armed it again";
  const Answer stale = routes_.Post("/api/booth/start", {{"version", looked_at}});
  EXPECT_EQ(stale.status, 409);
  EXPECT_THAT(stale.seen, HasSubstr("has changed"));
  EXPECT_EQ(booth_.port().scans(), 0U);
}

// RELIABILITY U3.
TEST_F(BoothRoutes, CancelInEveryState) {
  EXPECT_EQ(routes_.Post("/api/booth/cancel").status, 200);
  ASSERT_EQ(routes_.Post("/api/booth/home").status, 200);
  EXPECT_EQ(routes_.Post("/api/booth/cancel").status, 200);
  EXPECT_EQ(booth_.port().status().state, ScanState::kStopping);
  EXPECT_EQ(routes_.Post("/api/booth/cancel").status, 200);
  ASSERT_TRUE(booth_.port().Tell(ScanEventKind::kStopped));
  Home();
  ASSERT_EQ(routes_.Post("/api/booth/arm", ArmBody()).status, 200);
  EXPECT_EQ(routes_.Post("/api/booth/cancel").status, 200);
  EXPECT_EQ(booth_.port().status().state, ScanState::kIdle);
  ASSERT_EQ(routes_.Post("/api/booth/arm", ArmBody()).status, 200);
  ASSERT_EQ(routes_.Post("/api/booth/start", {{"version", Version()}}).status, 200);
  EXPECT_EQ(As(StationRole::kTechnician).Post("/api/booth/cancel").status, 200);
  EXPECT_EQ(booth_.port().status().state, ScanState::kStopping);
}

TEST_F(BoothRoutes, LetOnlyTheTechnicianAcknowledgeWhatServiceMust) {
  booth_.port().Fault({CauseCode::kBrakeSlip, "the axis sinks", "call service", {}});
  EXPECT_EQ(routes_.Post("/api/booth/acknowledge").status, 409);
  EXPECT_EQ(As(StationRole::kTechnician).Post("/api/booth/acknowledge").status, 200);
  EXPECT_EQ(booth_.port().status().state, ScanState::kIdle);
}

TEST_F(BoothRoutes, JogForTheTechnicianOnly) {
  EXPECT_EQ(routes_.Post("/api/booth/jog", {{"direction", "up"}}).status, 403);
  RouteCaller technician = As(StationRole::kTechnician);
  EXPECT_EQ(technician.Post("/api/booth/jog", {{"direction", "sideways"}}).field, "direction");
  EXPECT_EQ(technician.Post("/api/booth/jog", {{"direction", "down"}}).status, 200);
  EXPECT_EQ(booth_.port().status().state, ScanState::kJog);
}

TEST_F(BoothRoutes, AreStartedAndJoggedOnTheBoothsOwnScreenOnly) {
  for (const Route& route : routes_.table.routes()) {
    const bool moves_by_hand = route.pattern.ends_with("/start") || route.pattern.ends_with("/jog");
    EXPECT_EQ(route.local_only, moves_by_hand) << route.pattern;
    EXPECT_FALSE(route.roles.admin) << route.pattern;
    EXPECT_FALSE(route.roles.none) << route.pattern;
  }
}

TEST_F(BoothRoutes, DoNotArmWhatTheStoreCannotRemember) {
  Home();
  parts_.memory().away = true;
  EXPECT_EQ(routes_.Post("/api/booth/arm", ArmBody()).status, 503);
  EXPECT_EQ(booth_.port().status().state, ScanState::kIdle);
}

TEST_F(BoothRoutes, SayThatBoothdIsAway) {
  parts_.hub.Forget();
  booth_.End();
  const auto lost =
      parts_.hub.WaitFor([](const test::RecordingHub::Sent& one) { return one.message.at("connected") == false; });
  ASSERT_FALSE(lost.is_null());
  const Answer answer = routes_.Get("/api/booth");
  EXPECT_EQ(answer.json.at("connected"), false);
  EXPECT_NE(answer.json.at("why"), "");
  EXPECT_TRUE(answer.json.at("status").is_null());
  EXPECT_NE(answer.json.at("plain").at("lost_text"), "");
  for (const char* order : {"home", "acknowledge", "cancel"}) {
    EXPECT_EQ(routes_.Post(std::string("/api/booth/") + order).status, 503) << order;
  }
  EXPECT_EQ(routes_.Post("/api/booth/arm", ArmBody()).status, 503);
  EXPECT_EQ(routes_.Post("/api/booth/start", {{"version", 3}}).status, 503);
}

}  // namespace
}  // namespace annulus
