#include "station/console/booth_link.h"

#include "station/console/booth_live.h"
#include "tests/console_booth/console_parts.h"
#include "tests/station/served_booth.h"

namespace annulus {
namespace {

using test::FreshFolder;
using test::kSoon;
using test::RecordingHub;
using test::ServedBooth;
using testing::HasSubstr;

/// A link whose events go to a hub.
class LinkedHub {
 public:
  explicit LinkedHub(const std::string& socket) : live_(hub, clock_), link_(BoothLink::Make(socket, live_.events())) {
    live_.Attach(*link_);
  }
  RecordingHub hub;
  BoothLink& link() { return *link_; }
  bool WaitConnected() { return WaitState(true); }
  bool WaitLost() { return WaitState(false); }

 private:
  bool WaitState(bool connected) {
    const auto message = hub.WaitFor([&](const RecordingHub::Sent& one) {
      return one.message.at("type") == "status" && one.message.at("connected") == connected;
    });
    return !message.is_null();
  }
  SystemClock clock_;
  BoothLive live_;
  std::unique_ptr<BoothLink> link_;
};

/// A booth at a given place, served while this lives.
class BoothAt {
 public:
  explicit BoothAt(const std::string& path) : levels_(std::move(*LevelMailbox::Make())) {
    server_ = std::move(*BoothServer::Make(std::move(*BoothSocket::Listen(path)), port_, *levels_));
    EXPECT_TRUE(port_.Tell(ScanEventKind::kResetTaken));
    thread_ = std::jthread([this](const std::stop_token& stop) { server_->Serve(stop); });
  }
  ~BoothAt() {
    thread_.request_stop();
    thread_.join();
  }
  test::MachinePort& port() { return port_; }

 private:
  test::MachinePort port_;
  std::unique_ptr<LevelMailbox> levels_;
  std::unique_ptr<BoothServer> server_;
  std::jthread thread_;
};

auto InState(const std::string& state) {
  return [state](const RecordingHub::Sent& one) {
    return one.message.at("type") == "status" && one.message.at("connected") == true &&
           one.message.at("status").at("state") == state;
  };
}

TEST(BoothLink, TellsStatusAndDescriptionOnceItIsThere) {
  ServedBooth booth;
  LinkedHub linked(booth.path());
  ASSERT_TRUE(linked.WaitConnected());
  ASSERT_TRUE(linked.link().booth());
  EXPECT_EQ(linked.link().booth()->station_id, "test");
  ASSERT_TRUE(linked.link().status());
  EXPECT_EQ(linked.link().status()->scanner.state, ScanState::kIdle);
  EXPECT_EQ(linked.link().why(), "");
}

TEST(BoothLink, RefusesOrdersAtOnceWhileNobodyIsThere) {
  FreshFolder folder;
  LinkedHub linked(folder / "nobody.sock");
  ASSERT_TRUE(linked.WaitLost());
  const Status refused = linked.link().Ask(HomeOrder{});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().advice, HasSubstr("nothing was sent"));
  EXPECT_FALSE(linked.link().status());
  EXPECT_NE(linked.link().why(), "");
}

TEST(BoothLink, ComesBackAfterBoothdHasBeenAway) {
  FreshFolder folder;
  const std::string path = folder / "booth.sock";
  auto booth = std::make_unique<BoothAt>(path);
  LinkedHub linked(path);
  ASSERT_TRUE(linked.WaitConnected());
  linked.hub.Forget();
  booth.reset();
  ASSERT_TRUE(linked.WaitLost());
  EXPECT_FALSE(linked.link().Ask(HomeOrder{}));
  linked.hub.Forget();
  BoothAt again(path);
  ASSERT_TRUE(linked.WaitConnected());
  const Status ordered = linked.link().Ask(HomeOrder{});
  EXPECT_TRUE(ordered) << ordered.error().Text();
  EXPECT_EQ(again.port().status().state, ScanState::kHoming);
}

TEST(BoothLink, BecomesATechnicianToJogAndAnOperatorAgain) {
  ServedBooth booth;
  LinkedHub linked(booth.path());
  ASSERT_TRUE(linked.WaitConnected());
  const Status refused = linked.link().Ask(JogOrder{Scanner::JogDirection::kDown});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("operator"));
  for (int beat = 0; beat < 5; ++beat) {
    ASSERT_TRUE(linked.link().AskAsTechnician(JogOrder{Scanner::JogDirection::kDown}));
  }
  EXPECT_EQ(booth.port().status().state, ScanState::kJog);
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kJogReleased));
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kStopped));
  EXPECT_TRUE(linked.link().Ask(HomeOrder{})) << "a technician may do what an operator may";
  EXPECT_EQ(booth.port().status().state, ScanState::kHoming);
}

TEST(BoothLink, LooksOnWhileAnotherProgramControlsAndTakesOverAfterwards) {
  ServedBooth booth;
  auto other = std::make_unique<BoothClient>(booth.Operator());
  LinkedHub linked(booth.path());
  ASSERT_TRUE(linked.WaitConnected());
  const Status refused = linked.link().Ask(HomeOrder{});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("only looks on"));
  other.reset();
  const auto begin = SystemClock().Now();
  Status taken = linked.link().Ask(HomeOrder{});
  while (!taken && SystemClock().Now() - begin < kSoon) taken = linked.link().Ask(HomeOrder{});
  EXPECT_TRUE(taken);
}

// RELIABILITY U3: whatever it does, cancel gets through, and on a connection of its own.
TEST(BoothLink, CancelsWhateverTheBoothDoes) {
  ServedBooth booth;
  LinkedHub linked(booth.path());
  ASSERT_TRUE(linked.WaitConnected());
  EXPECT_TRUE(linked.link().Cancel()) << "nothing to stop is no error";
  EXPECT_EQ(booth.port().status().state, ScanState::kIdle);

  ASSERT_TRUE(linked.link().Ask(HomeOrder{}));
  EXPECT_TRUE(linked.link().Cancel());
  EXPECT_EQ(booth.port().status().state, ScanState::kStopping);
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kStopped));

  ASSERT_TRUE(linked.link().Ask(HomeOrder{}));
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kHomed));
  ASSERT_TRUE(linked.link().Ask(ArmOrder{"body", {}, false, "a.mcap", "K-1", "C-1"}));
  EXPECT_TRUE(linked.link().Cancel());
  EXPECT_EQ(booth.port().status().state, ScanState::kIdle);

  ASSERT_TRUE(linked.link().Ask(ArmOrder{"body", {}, false, "b.mcap", "K-1", "C-1"}));
  ASSERT_TRUE(linked.link().Ask(StartOrder{booth.port().status().version}));
  ASSERT_EQ(booth.port().status().state, ScanState::kScanning);
  const auto begin = SystemClock().Now();
  EXPECT_TRUE(linked.link().Cancel());
  EXPECT_EQ(booth.port().status().state, ScanState::kStopping);
  EXPECT_LT(SystemClock().Now() - begin, std::chrono::milliseconds(500));
}

TEST(BoothLink, KnowsThatTheStartKeyWasPressedSinceTheBoothWasArmed) {
  ServedBooth booth;
  LinkedHub linked(booth.path());
  ASSERT_TRUE(linked.WaitConnected());
  ASSERT_TRUE(linked.link().Ask(HomeOrder{}));
  booth.port().Change([](ScannerStatus& status) { status.start_presses = 1; });
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kHomed));
  ASSERT_TRUE(linked.link().Ask(ArmOrder{"body", {}, false, "a.mcap", "K-1", "C-1"}));
  ASSERT_FALSE(linked.hub.WaitFor(InState("ARMED")).is_null());
  EXPECT_FALSE(linked.link().start_agreed()) << "what was pressed before does not count";
  booth.port().Change([](ScannerStatus& status) { status.start_presses = 2; });
  const auto pressed = linked.hub.WaitFor([](const RecordingHub::Sent& one) {
    return one.message.at("type") == "status" && one.message.at("status").at("start_presses") == 2;
  });
  ASSERT_FALSE(pressed.is_null());
  EXPECT_TRUE(linked.link().start_agreed());
}

TEST(BoothLive, PassesLevelsAsDistancesFromTheAxis) {
  ServedBooth booth;
  LinkedHub linked(booth.path());
  ASSERT_TRUE(linked.WaitConnected());
  ScanLevel level{7, 1, std::chrono::nanoseconds(5), {}};
  for (int sensor = 0; sensor < 180; ++sensor) level.readings.push_back({400.0 + sensor, 1000.0, 200});
  level.readings[3].range_mm = std::nan("");
  booth.levels().Put(level);
  const auto sent = linked.hub.WaitForType("level");
  ASSERT_FALSE(sent.is_null());
  EXPECT_EQ(sent.at("level"), 7);
  EXPECT_EQ(sent.at("sweep"), 1);
  EXPECT_EQ(sent.at("sensor_step"), 1);
  ASSERT_EQ(sent.at("radius_mm").size(), 180U);
  // The booth of the test has a ring of 600 mm.
  EXPECT_EQ(sent.at("radius_mm")[0], 200.0);
  EXPECT_EQ(sent.at("radius_mm")[10], 190.0);
  EXPECT_TRUE(sent.at("radius_mm")[3].is_null());
}

}  // namespace
}  // namespace annulus
