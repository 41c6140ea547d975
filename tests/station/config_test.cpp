#include "station/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace annulus {
namespace {

using testing::HasSubstr;

TEST(Config, TheBuiltInOneIsASimulatedBoothWithABody) {
  PosixStorage storage;
  const auto config = ReadConfig(storage, "sim");
  ASSERT_TRUE(config) << config.error().Text();
  EXPECT_EQ(config->ring.bus, RingBus::kSimulated);
  EXPECT_TRUE(config->axis.simulated());
  EXPECT_TRUE(config->interlock.simulated);
  EXPECT_EQ(config->sim.subject, "body");
}

TEST(Config, ReadsEveryKeyOfItsSections) {
  const auto config = ParseConfig(R"(
[station]
id = "booth-3"
language = "de"
units = "mm"
[ring]
bus = "usb"
radius_mm = 610.5
boards = { 1001 = 0, 1002 = 15 }
[axis]
link = "/dev/ttyUSB0"
[profile.body]
z_top_mm = 1900
pitch_mm = 4
[profile.bust]
z_top_mm = "auto"
z_bottom_mm = 1200
pitch_mm = 2
speed_mm_s = 60
sweeps = 2
level_rate_hz = 30
[calibration]
file = "cal.json"
[sim]
seed = 42
subject = "head"
noise_mm = 0.25
dropout_rate = 0.02
outlier_rate = 0
sway = 1
breathing = 0.01
hair = true
spectacles = true
dark_patches = true
)",
                                  "test.toml");
  ASSERT_TRUE(config) << config.error().Text();
  EXPECT_EQ(config->station_id, "booth-3");
  EXPECT_EQ(config->ring.bus, RingBus::kUsb);
  EXPECT_EQ(config->ring.radius_mm, 610.5);
  EXPECT_EQ(config->ring.boards, (std::map<std::uint32_t, std::uint16_t>{{1001, 0}, {1002, 15}}));
  EXPECT_EQ(config->axis.LinkText(), "/dev/ttyUSB0");
  EXPECT_EQ(config->profiles.at("body").z_top_mm, 1900.0);
  EXPECT_FALSE(config->profiles.at("body").find_top);
  EXPECT_TRUE(config->profiles.at("bust").find_top);
  EXPECT_FALSE(config->profiles.at("bust").z_top_mm.has_value());
  EXPECT_EQ(config->profiles.at("bust").sweeps, 2U);
  EXPECT_EQ(config->calibration_file, "cal.json");
  EXPECT_EQ(config->sim.seed, 42U);
  EXPECT_EQ(config->sim.subject, "head");
  EXPECT_EQ(config->sim.noise_mm, 0.25);
  EXPECT_TRUE(config->sim.hair && config->sim.spectacles && config->sim.dark_patches);
}

/// The message of a configuration that must be refused.
std::string RefusalOf(const std::string& toml) {
  const auto config = ParseConfig(toml, "test.toml");
  return config ? "accepted" : config.error().Text();
}

TEST(Config, AnUnknownKeyIsRefusedWithItsLineAndTheKnownOnes) {
  const std::string text = RefusalOf("[station]\nid = \"a\"\n[ring]\nradius = 600\n");
  EXPECT_THAT(text, HasSubstr("test.toml"));
  EXPECT_THAT(text, HasSubstr("line 4"));
  EXPECT_THAT(text, HasSubstr("'radius'"));
  EXPECT_THAT(text, HasSubstr("radius_mm"));
}

TEST(Config, AnUnknownSectionIsRefusedWithItsLine) {
  EXPECT_THAT(RefusalOf("\n\n[rings]\nradius_mm = 600\n"), HasSubstr("line 3"));
}

TEST(Config, AValueOfTheWrongKindIsRefusedWithItsLine) {
  for (const char* line : {"radius_mm = \"wide\"", "radius_mm = 1e9", "radius_mm = nan", "radius_mm = true", "bus = 5",
                           "bus = \"serial\"", "boards = 7", "boards = { left = 1 }"}) {
    EXPECT_THAT(RefusalOf("[ring]\n" + std::string(line) + "\n"), HasSubstr("line 2")) << line;
  }
  EXPECT_THAT(RefusalOf("ring = 5\n"), HasSubstr("line 1"));
  EXPECT_THAT(RefusalOf("[sim]\nseed = -1\n"), HasSubstr("line 2"));
  EXPECT_THAT(RefusalOf("[profile.body]\nsweeps = 1.5\n"), HasSubstr("line 2"));
}

TEST(Config, WhatIsNoTomlIsRefusedWithItsLine) {
  EXPECT_THAT(RefusalOf("[station]\nid = \"a\"\nid = \"b\"\n"), HasSubstr("line 3"));
  EXPECT_THAT(RefusalOf("[station\n"), HasSubstr("line 1"));
}

}  // namespace
}  // namespace annulus
