// [store] and [console] of a station's configuration.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "station/config.h"

namespace annulus {
namespace {

TEST(ConsoleConfigSection, HasDefaultsThatReachNobody) {
  const auto config = ParseConfig("", "empty.toml");
  ASSERT_TRUE(config);
  EXPECT_EQ(config->console.port, 8437);
  EXPECT_TRUE(config->console.addresses.empty());
  EXPECT_TRUE(config->console.host_names.empty());
  EXPECT_EQ(config->store.keep_days, 90);
  EXPECT_EQ(config->language, "en");
  EXPECT_EQ(config->units, "mm");
}

TEST(ConsoleConfigSection, ReadsEveryKey) {
  const auto config = ParseConfig(R"(
[station]
language = "ja"
units = "cm"
[store]
folder = "/var/lib/annulus/store"
key_file = "/etc/annulus/station.key"
backup_folder = "/backup"
recordings = "/var/lib/annulus/recordings"
keep_days = 30
[console]
port = 443
addresses = ["192.0.2.7", "2001:db8::7"]
host_names = ["booth3.shop.example"]
)",
                                  "test.toml");
  ASSERT_TRUE(config) << config.error().Text();
  EXPECT_EQ(config->language, "ja");
  EXPECT_EQ(config->store.folder, "/var/lib/annulus/store");
  EXPECT_EQ(config->store.key_file, "/etc/annulus/station.key");
  EXPECT_EQ(config->store.backup_folder, "/backup");
  EXPECT_EQ(config->store.recordings, "/var/lib/annulus/recordings");
  EXPECT_EQ(config->store.keep_days, 30);
  EXPECT_EQ(config->console.port, 443);
  EXPECT_EQ(config->console.addresses, (std::vector<std::string>{"192.0.2.7", "2001:db8::7"}));
  EXPECT_EQ(config->console.host_names, std::vector<std::string>{"booth3.shop.example"});
}

TEST(ConsoleConfigSection, WhatIsWrongIsNamedWithItsLine) {
  for (const char* wrong :
       {"port = 0", "port = 70000", "port = \"8437\"", "addresses = \"192.0.2.7\"", "addresses = [\"booth3\"]",
        "addresses = [\"192.0.2.7 \"]", "host_names = [\"a:8437\"]", "host_names = [\"\"]", "adresses = []"}) {
    const auto config = ParseConfig(std::string("[console]\n") + wrong, "test.toml");
    ASSERT_FALSE(config) << wrong;
    EXPECT_NE(config.error().seen.find("line 2"), std::string::npos) << config.error().Text();
  }
  for (const char* wrong : {"keep_days = 0", "keep_days = 1.5", "folder = 3", "url = \"x\""}) {
    EXPECT_FALSE(ParseConfig(std::string("[store]\n") + wrong, "test.toml")) << wrong;
  }
  EXPECT_FALSE(ParseConfig("[station]\nlanguage = \"de\"", "test.toml"));
  EXPECT_FALSE(ParseConfig("[station]\nunits = \"furlong\"", "test.toml"));
}

}  // namespace
}  // namespace annulus
