#include "station/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "station/command_io.h"

namespace annulus {
namespace {

using testing::HasSubstr;

struct Outcome {
  int code = 0;
  std::string out;
  std::string err;
};

Outcome RunAnnulus(std::vector<const char*> arguments, const std::stop_token& stop = {}) {
  arguments.insert(arguments.begin(), "annulus");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.code = RunCommandLine(static_cast<int>(arguments.size()), arguments.data(), stop);
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

/// A folder of this test's own, empty.
std::string EmptyFolder() {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder.string();
}

TEST(CommandLine, HelpAndVersionSucceed) {
  EXPECT_EQ(RunAnnulus({"--help"}).code, 0);
  const Outcome version = RunAnnulus({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_THAT(version.out, HasSubstr(ProgramVersion()));
}

TEST(CommandLine, AFailedTaskIsOneLineAndExitCode1) {
  const Outcome outcome = RunAnnulus({"inspect", "/nonexistent/scan.mcap"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
  EXPECT_EQ(outcome.err.rfind("annulus: ", 0), 0U);
  EXPECT_THAT(outcome.err, HasSubstr("/nonexistent/scan.mcap"));
}

TEST(CommandLine, WrongUsageAndLaterCommandsAreExitCode2) {
  EXPECT_EQ(RunAnnulus({}).code, 2);
  EXPECT_EQ(RunAnnulus({"frobnicate"}).code, 2);
  EXPECT_EQ(RunAnnulus({"section", "model.json", "--z", "high"}).code, 2);
  const Outcome later = RunAnnulus({"convert"});
  EXPECT_EQ(later.code, 2);
  EXPECT_THAT(later.err, HasSubstr("not yet"));
}

TEST(CommandLine, ScanningARealPersonNeedsToSayWhoAndWithWhatConsent) {
  const std::string folder = EmptyFolder();
  const std::string config = folder + "/booth.toml";
  PosixStorage storage;
  ASSERT_TRUE(WriteFileAtomically(storage, config, std::string("[ring]\nbus = \"usb\"\n")));
  const std::string out = folder + "/scan.mcap";
  const Outcome nobody = RunAnnulus({"scan", "--config", config.c_str(), "--profile", "body", "--out", out.c_str()});
  EXPECT_EQ(nobody.code, 2);
  EXPECT_THAT(nobody.err, HasSubstr("--subject-id"));
  const Outcome unasked = RunAnnulus(
      {"scan", "--config", config.c_str(), "--profile", "body", "--out", out.c_str(), "--subject-id", "p-1"});
  EXPECT_EQ(unasked.code, 2);
  EXPECT_THAT(unasked.err, HasSubstr("--consent"));
  EXPECT_FALSE(storage.Exists(out));
}

TEST(CommandLine, AStopRequestIsExitCode130AndLeavesNoHalfFile) {
  const std::string folder = EmptyFolder();
  std::stop_source stop;
  stop.request_stop();
  const std::string out = folder + "/scan.mcap";
  const Outcome outcome = RunAnnulus({"scan", "--profile", "body", "--out", out.c_str()}, stop.get_token());
  EXPECT_EQ(outcome.code, 130);
  EXPECT_THAT(outcome.err, HasSubstr("Ctrl-C"));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace annulus
