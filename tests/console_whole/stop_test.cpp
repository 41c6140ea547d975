/// STOP, whatever else the console is busy with.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>

#include "tests/console_whole/whole_station.h"
#include "tests/station_http/http_fixture.h"
#include "tests/station_store/raw_database.h"

namespace annulus::test {
namespace {

using std::chrono::milliseconds;

std::size_t StopsInAudit(Store& store) {
  const auto lines = store.AuditLines(1, 1000);
  if (!lines) return 0;
  return static_cast<std::size_t>(
      std::count_if(lines->begin(), lines->end(), [](const AuditLine& line) { return line.action == "stop"; }));
}

/// Every worker of the console waits for the store, which another program has locked, and more requests wait behind
/// them.
TEST(ConsoleStop, IsAnsweredAndStopsTheBoothWhileEveryWorkerIsBusy) {
  constexpr std::size_t kRequests = 12;  // three times as many as there are workers
  constexpr milliseconds kStopWithin{500};
  WholeStation station;
  ConsoleBrowser browser = station.Browser();
  ASSERT_EQ(browser.LogIn("anna").status, 200);
  const StartedScan scan = station.StartScan(browser, "long");
  RawDatabase other(station.DatabasePath());
  ASSERT_EQ(other.Try("BEGIN IMMEDIATE"), "");
  std::vector<std::unique_ptr<RawClient>> slow;
  for (std::size_t i = 0; i < kRequests; ++i) {
    slow.push_back(RawClient::Connect(station.target()));
    ASSERT_NE(slow.back(), nullptr);
    ASSERT_TRUE(slow.back()->Send(browser.PostText("/api/customers", {{"name", "Waits"}})));
  }
  // The page needs a worker and nothing else: while it does not come, none is free.
  const auto page = RawClient::Connect(station.target());
  ASSERT_NE(page, nullptr);
  page->SetPatience(milliseconds(300));
  ASSERT_TRUE(page->Send(browser.GetText("/")));
  ASSERT_EQ(page->Receive(), "") << "a worker was free";

  // Neither the first, of who is logged in, nor those after it, of anybody, wait for the lines of the audit.
  const ConsoleBrowser::Answer first = browser.Post("/api/stop");
  EXPECT_EQ(first.status, 200);
  EXPECT_LE(first.took, kStopWithin);
  const auto asked = station.booth().Taken().size();
  const ConsoleBrowser::Answer second = station.Browser().Post("/api/stop");
  EXPECT_EQ(second.status, 200);
  EXPECT_LE(second.took, kStopWithin);
  const ConsoleBrowser::Answer third = station.Browser().Post("/api/stop");
  EXPECT_EQ(third.status, 200);
  EXPECT_LE(third.took, kStopWithin);
  std::printf("STOP beside %zu requests that wait: %lld, %lld, %lld ms\n", kRequests,
              static_cast<long long>(first.took.count()), static_cast<long long>(second.took.count()),
              static_cast<long long>(third.took.count()));
  page->SetPatience(milliseconds(0));
  EXPECT_EQ(page->Receive(), "") << "the workers were busy all the time";
  station.booth().Wait("stop", IsIdle);
  ASSERT_TRUE(station.booth().status().scan);
  EXPECT_FALSE(station.booth().status().scan->complete);
  EXPECT_LE(station.booth().Taken().size(), asked + 20);

  ASSERT_EQ(other.Try("ROLLBACK"), "");
  for (const auto& client : slow) {
    client->SetPatience(std::chrono::seconds(60));
    EXPECT_THAT(client->ReadAnswer().status, testing::AnyOf(200, 503));
  }
  ASSERT_FALSE(station.WaitTakenIn(scan).id.empty());
  EXPECT_TRUE(Eventually([&] { return StopsInAudit(station.console().store()) == 3; })) << "written later";
}

}  // namespace
}  // namespace annulus::test
