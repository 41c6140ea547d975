#include "acquisition/sealed_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "acquisition/recording.h"
#include "scan_fixture.h"
#include "tests/support/test_keys.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using test::MakeScan;
using test::SameScan;
using test::TestKeys;
using test::TestStorage;

constexpr char kPath[] = "scan.mcap.enc";

std::vector<std::byte> Bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

std::string Text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Seal SealOf(const TestKeys& keys, SealedFileId file_id) {
  const std::string id = *keys.NewRecordingKeyId();
  return {id, *keys.Key(id), file_id};
}

std::vector<std::byte> SealTexts(const TestKeys& keys, SealedFileId file_id, const std::vector<std::string>& texts) {
  TestStorage storage;
  SealedFile file(std::move(*storage.Create("f")), SealOf(keys, file_id));
  for (const std::string& text : texts) EXPECT_TRUE(file.Append(Bytes(text)));
  return storage.files["f"];
}

constexpr std::size_t kHeaders = 128;
constexpr std::size_t kFrameOverhead = 32;

TEST(SealedFile, GivesBackWhatWasAppendedWithOneWriteEach) {
  const TestKeys keys;
  TestStorage storage;
  SealedFile file(std::move(*storage.Create("f")), SealOf(keys, {1}));
  const std::uint64_t before = storage.calls();
  ASSERT_TRUE(file.Append(Bytes("first")));
  ASSERT_TRUE(file.Append({}));
  ASSERT_TRUE(file.Append(Bytes("third")));
  EXPECT_EQ(storage.calls(), before + 3);
  EXPECT_EQ(storage.files["f"].size(), kHeaders + 3 * kFrameOverhead + 10);
  const auto unsealed = Unseal(storage.files["f"], keys, "f");
  ASSERT_TRUE(unsealed) << unsealed.error().Text();
  EXPECT_EQ(Text(unsealed->bytes), "firstthird");
  EXPECT_EQ(unsealed->sizes, (std::vector<std::uint64_t>{5, 0, 5}));
  EXPECT_EQ(unsealed->key_id, "k1");
  EXPECT_TRUE(unsealed->first_frame);
  EXPECT_TRUE(unsealed->notes.empty());
}

TEST(SealedFile, WithAnyBitFlippedLosesAtMostOneFrameAndChangesNone) {
  const TestKeys keys;
  const std::vector<std::string> texts{"alpha", "beta", "gamma", "delta"};
  std::vector<std::byte> bytes = SealTexts(keys, {2}, texts);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    bytes[bit / 8] ^= mask;
    const auto unsealed = Unseal(bytes, keys, "f");
    bytes[bit / 8] ^= mask;
    ASSERT_TRUE(unsealed) << "bit " << bit << ": " << unsealed.error().Text();
    ASSERT_FALSE(unsealed->notes.empty()) << "bit " << bit;
    const std::string text = Text(unsealed->bytes);
    bool whole = text == "alphabetagammadelta";
    for (std::size_t lost = 0; lost < texts.size(); ++lost) {
      std::string rest;
      for (std::size_t i = 0; i < texts.size(); ++i) rest += i == lost ? "" : texts[i];
      whole = whole || text == rest;
    }
    ASSERT_TRUE(whole) << "bit " << bit << ": " << text;
    if (bit / 8 < kHeaders) {
      ASSERT_EQ(unsealed->frames, 4U) << "bit " << bit;
    }
  }
}

TEST(SealedFile, CutAtAnyByteGivesTheFramesThatAreWhole) {
  const TestKeys keys;
  const std::vector<std::byte> bytes = SealTexts(keys, {3}, {"alpha", "beta", "gamma"});
  const std::vector<std::size_t> ends{kHeaders + kFrameOverhead + 5, kHeaders + 2 * kFrameOverhead + 9,
                                      kHeaders + 3 * kFrameOverhead + 14};
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    const auto unsealed = Unseal(std::span(bytes).first(cut), keys, "f");
    const auto frames = std::count_if(ends.begin(), ends.end(), [&](std::size_t end) { return end <= cut; });
    ASSERT_EQ(unsealed ? static_cast<std::ptrdiff_t>(unsealed->frames) : 0, frames) << "cut at " << cut;
  }
}

TEST(SealedFile, TakesNoFrameFromAnotherPlaceOrFile) {
  const TestKeys keys;
  const std::size_t frame = kFrameOverhead + 4;
  const std::vector<std::byte> one = SealTexts(keys, {4}, {"aaaa", "bbbb", "cccc"});
  const std::vector<std::byte> other = SealTexts(keys, {5}, {"dddd", "eeee", "ffff"});
  const auto at = [&](std::size_t i) { return static_cast<std::ptrdiff_t>(kHeaders + i * frame); };
  std::vector<std::byte> spliced = one;  // the second frame of the other file
  std::copy(other.begin() + at(1), other.begin() + at(2), spliced.begin() + at(1));
  EXPECT_EQ(Text(Unseal(spliced, keys, "f")->bytes), "aaaacccc");
  std::vector<std::byte> repeated = one;  // the first frame again, in the place of the second
  std::copy(one.begin(), one.begin() + at(1), repeated.begin());
  std::copy(one.begin() + at(0), one.begin() + at(1), repeated.begin() + at(1));
  EXPECT_EQ(Text(Unseal(repeated, keys, "f")->bytes), "aaaacccc");
  std::vector<std::byte> swapped = one;  // the third before the second
  std::copy(one.begin() + at(2), one.end(), swapped.begin() + at(1));
  std::copy(one.begin() + at(1), one.begin() + at(2), swapped.begin() + at(2));
  EXPECT_EQ(Text(Unseal(swapped, keys, "f")->bytes), "aaaacccc");
  EXPECT_EQ(Unseal(swapped, keys, "f")->frames_lost, 1U);
}

TEST(SealedFile, HidesWhatItHolds) {
  const TestKeys keys;
  const std::string secret = "a text that nobody may read";
  const std::string sealed = Text(SealTexts(keys, {6}, {secret, secret}));
  EXPECT_EQ(sealed.find("nobody"), std::string::npos);
  EXPECT_NE(sealed.substr(kHeaders + 16, secret.size()), sealed.substr(kHeaders + 48 + secret.size(), secret.size()));
}

TEST(SealedFile, SaysWhichKeyIsMissingOrWrong) {
  const TestKeys keys;
  const std::vector<std::byte> bytes = SealTexts(keys, {7}, {"alpha"});
  TestKeys none;
  none.keys.clear();
  EXPECT_EQ(Unseal(bytes, none, "f").error().Text(), "find the key 'k1': it is not there: add it");
  TestKeys wrong;
  wrong.keys["k1"].bytes[5] ^= 1U;
  EXPECT_EQ(Unseal(bytes, wrong, "f").error().seen, "the key 'k1' opens nothing of it");
  EXPECT_EQ(ParseRecording(bytes, "f").error().Text(),
            "open f: it is sealed with the key 'k1': give its key with --key-file");
}

TEST(SealedFile, SurvivesManyFalseStartsOfFrames) {
  const TestKeys keys;
  std::vector<std::byte> bytes = SealTexts(keys, {8}, {"alpha"});
  std::string trap(std::size_t{1} << 20, '\0');  // each claims all the rest
  for (std::size_t i = 0; i + 16 < trap.size(); i += 16)
    trap.replace(i, 7, std::string("\xF7\x5E\xA1\x3D\x00\x00\x08", 7));
  const auto more = Bytes(trap);
  bytes.insert(bytes.end(), more.begin(), more.end());
  const auto unsealed = Unseal(bytes, keys, "f");
  ASSERT_TRUE(unsealed);
  EXPECT_EQ(Text(unsealed->bytes), "alpha");
}

TEST(SealedRecording, IsReadWithItsKeyAndSaysThatItIsSealed) {
  const TestKeys keys;
  const Scan scan = MakeScan(6, 5);
  TestStorage storage;
  RecordingOptions options;
  options.keys = &keys;
  auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
  ASSERT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) ASSERT_TRUE(writer->AppendLevel(level));
  ASSERT_TRUE(writer->Finish());
  EXPECT_TRUE(LooksLikeRecording(storage.files[kPath]));
  EXPECT_EQ(Text(storage.files[kPath]).find("subject_id"), std::string::npos);
  const auto read = ReadWholeRecording(storage, kPath, &keys);
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(read->report.clean());
  EXPECT_TRUE(read->report.sealed);
  EXPECT_TRUE(SameScan(read->scan, scan));
}

TEST(SealedRecording, WithAnyByteDamagedLosesAtMostOneLevel) {
  const TestKeys keys;
  const Scan scan = MakeScan(4, 3);
  TestStorage storage;
  RecordingOptions options;
  options.keys = &keys;
  auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
  ASSERT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) ASSERT_TRUE(writer->AppendLevel(level));
  ASSERT_TRUE(writer->Finish());
  std::vector<std::byte> bytes = storage.files[kPath];
  const std::size_t step = std::getenv("ANNULUS_LONG") != nullptr ? 1 : 5;
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    bytes[at] ^= std::byte{0x40};
    const auto read = ParseRecording(bytes, "damaged", &keys);
    bytes[at] ^= std::byte{0x40};
    ASSERT_TRUE(read) << "byte " << at << ": " << read.error().Text();
    ASSERT_FALSE(read->report.clean()) << "byte " << at;
    ASSERT_TRUE(test::SameHeader(read->scan.header, scan.header));
    ASSERT_GE(read->scan.levels.size(), 3U) << "byte " << at;
    ASSERT_EQ(read->scan.levels.size() + read->report.levels_lost, 4U) << "byte " << at;
  }
}

}  // namespace
}  // namespace annulus
