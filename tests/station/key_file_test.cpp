#include "station/key_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "acquisition/recording.h"
#include "tests/acquisition/scan_fixture.h"

namespace annulus {
namespace {

class KeyFile : public testing::Test {
 protected:
  std::string Write(const std::string& text, mode_t mode = 0600) {
    const std::string path = testing::TempDir() + "annulus_keys";
    std::ofstream(path) << text;
    EXPECT_EQ(::chmod(path.c_str(), mode), 0);
    return path;
  }
  std::string SeenIn(const std::string& text, mode_t mode = 0600) {
    const auto keys = ReadKeyFile(Write(text, mode));
    return keys ? "" : keys.error().seen;
  }
  const std::string hex_ = "000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F";
};

TEST_F(KeyFile, GivesItsKeysAndTheLastOneForNewRecordings) {
  const auto keys = ReadKeyFile(Write("# of booth 3\n\nold = " + std::string(64, 'f') + "\r\n new.1=" + hex_));
  ASSERT_TRUE(keys) << keys.error().Text();
  EXPECT_EQ(*(*keys)->NewRecordingKeyId(), "new.1");
  const auto key = (*keys)->Key("new.1");
  ASSERT_TRUE(key);
  for (std::size_t i = 0; i < SealKey::kBytes; ++i) EXPECT_EQ(key->bytes[i], i);
  EXPECT_EQ((*keys)->Key("old")->bytes[7], 255);
  EXPECT_FALSE((*keys)->Key("gone"));
}

TEST_F(KeyFile, IsRefusedIfOthersMayUseIt) {
  for (const mode_t mode : {0640U, 0604U, 0620U, 0601U}) {
    EXPECT_EQ(SeenIn("k = " + hex_, mode), "others than its owner may use it");
  }
  EXPECT_EQ(SeenIn("k = " + hex_, 0400), "");
}

TEST_F(KeyFile, NamesTheLineThatIsWrongButNotTheKey) {
  EXPECT_EQ(SeenIn("k = " + hex_ + "\nl = " + hex_.substr(1)), "line 2 is not ID = 64 hex digits");
  EXPECT_EQ(SeenIn(hex_), "line 1 is not ID = 64 hex digits");
  EXPECT_EQ(SeenIn("a b = " + hex_), "line 1 is not ID = 64 hex digits");
  EXPECT_EQ(SeenIn("k = " + hex_ + "\nk = " + hex_), "line 2 repeats an id");
  EXPECT_EQ(SeenIn("# nothing\n"), "it has no keys");
  EXPECT_EQ(SeenIn(std::string(70'000, '#')), "it is no text file of at most 64 KiB");
  EXPECT_FALSE(ReadKeyFile("/dev/null"));
  EXPECT_FALSE(ReadKeyFile("/nowhere"));
}

TEST_F(KeyFile, SealsAndOpensARecording) {
  const auto keys = OpenKeys(Write("k = " + hex_));
  ASSERT_TRUE(keys);
  PosixStorage storage;
  const std::string path = testing::TempDir() + "annulus_sealed.mcap.enc";
  const Scan scan = test::MakeScan(3, 4);
  RecordingOptions options;
  options.keys = keys->get();
  auto writer = RecordingWriter::Create(storage, path, scan.header, options);
  ASSERT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) ASSERT_TRUE(writer->AppendLevel(level));
  ASSERT_TRUE(writer->Finish());
  EXPECT_FALSE(ReadWholeRecording(storage, path));
  const auto read = ReadWholeRecording(storage, path, keys->get());
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(test::SameScan(read->scan, scan));
}

}  // namespace
}  // namespace annulus
