/// A store that is damaged: row D9 of the fault matrix, on the whole console.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "tests/console_whole/whole_station.h"
#include "tests/support/dice.h"

namespace annulus::test {
namespace {

constexpr std::size_t kPage = 4096;

/// Fills all pages but the first with what they never held.
void DamagePages(const std::string& database) {
  Dice dice(9);
  std::fstream file(database, std::ios::in | std::ios::out | std::ios::binary);
  const auto bytes = std::filesystem::file_size(database);
  ASSERT_GT(bytes, kPage);
  file.seekp(kPage);
  for (std::size_t i = kPage; i < bytes; ++i) file.put(static_cast<char>(dice.Next()));
}

TEST(ConsoleRows, D9_WithADamagedDatabaseTheConsoleSaysSoShowsTheBoothAndStopsIt) {
  WholeStation station;
  ConsoleBrowser browser = station.Browser();
  ASSERT_EQ(browser.LogIn("anna").status, 200);
  static_cast<void>(station.StartScan(browser, "long"));
  station.RestartConsole([&] { DamagePages(station.DatabasePath()); });
  EXPECT_EQ(station.booth().status().state, ScanState::kScanning) << "the booth does not notice";

  ConsoleBrowser nobody = station.Browser();
  const auto session = nobody.Get("/api/session");
  EXPECT_EQ(session.status, 200);
  EXPECT_EQ(session.json["store"]["state"], "read_only");
  EXPECT_THAT(session.json["store"].value("problem", ""), testing::HasSubstr("damaged"));
  LiveListener live(nobody.OpenLive());
  EXPECT_FALSE(live.WaitFor("status").is_null());
  EXPECT_EQ(nobody.Post("/api/stop").status, 200);
  station.booth().Wait("stop", IsIdle);
  ASSERT_TRUE(station.booth().status().scan);
  EXPECT_FALSE(station.booth().status().scan->complete);
}

}  // namespace
}  // namespace annulus::test
