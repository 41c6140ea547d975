#include <gtest/gtest.h>

#include "acquisition/mcap_reader.h"
#include "acquisition/mcap_writer.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using test::TestStorage;

/// Remembers what it was told.
class Listener final : public McapListener {
 public:
  void OnMetadata(const McapMetadata& metadata) override { metadata_names.push_back(metadata.name); }
  void OnMessage(const McapChannel& channel, const McapMessage& message) override {
    messages.push_back(channel.topic + "#" + std::to_string(message.sequence) + "=" + std::string(message.data));
  }
  std::vector<std::string> metadata_names;
  std::vector<std::string> messages;
};

std::span<const std::byte> Bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

/// `text` with a little-endian length of `width` bytes before it.
std::string Sized(const std::string& text, std::size_t width = 4) {
  std::string out;
  for (std::size_t i = 0; i < width; ++i) out += static_cast<char>(i < 8 ? (text.size() >> (8 * i)) & 0xffU : 0U);
  return out + text;
}

std::string Record(char opcode, const std::string& content) { return opcode + Sized(content, 8); }

/// A file put together by hand from the specification: one uncompressed chunk with one message on topic "t".
std::string HandMadeFile(const std::string& chunk_crc, const std::string& after_chunk = "") {
  using namespace std::string_literals;
  const std::string magic = "\x89MCAP0\r\n"s;
  const std::string channel = Record('\x04', "\x07\0\0\0"s + Sized("t") + Sized("json") + Sized(""));
  const std::string message =
      Record('\x05', "\x07\0"s + "\x05\0\0\0"s + "\x09\0\0\0\0\0\0\0"s + std::string(8, '\0') + "{}");
  const std::string records = channel + message;
  const std::string chunk =
      std::string(16, '\0') + Sized(records, 8).substr(0, 8) + chunk_crc + Sized("") + Sized(records, 8);
  const std::string data = magic + Record('\x01', Sized("") + Sized("hand")) + Record('\x06', chunk) + after_chunk;
  return data + Record('\x0f', std::string(4, '\0')) + Record('\x02', std::string(20, '\0')) + magic;
}

// Python: ch = struct.pack('<HHI1sI4sI', 7, 0, 1, b't', 4, b'json', 0); m = struct.pack('<HIQQ', 7, 5, 9, 0) + b'{}'
//         r = b'\4' + struct.pack('<Q', len(ch)) + ch + b'\5' + struct.pack('<Q', len(m)) + m
//         struct.pack('<I', zlib.crc32(r)).hex()  ->  f4ec1bb3
const std::string kRightCrc = "\xf4\xec\x1b\xb3";

TEST(McapCrc, IsTheUsualCrc32) {
  EXPECT_EQ(McapCrc(0, Bytes("123456789")), 0xCBF43926U);  // the check value of CRC-32/ISO-HDLC
  EXPECT_EQ(McapCrc(McapCrc(0, Bytes("1234")), Bytes("56789")), 0xCBF43926U);
}

TEST(ReadMcap, UnderstandsAFileMadeByHandFromTheSpecification) {
  Listener listener;
  const auto report = ReadMcap(Bytes(HandMadeFile(kRightCrc)), "hand", listener);
  ASSERT_TRUE(report) << report.error().Text();
  for (const McapDamage& damage : report->damages) ADD_FAILURE() << damage.offset << " " << damage.what;
  EXPECT_TRUE(report->clean());
  EXPECT_EQ(listener.messages, std::vector<std::string>{"t#5={}"});
}

TEST(ReadMcap, TellsNothingOfAChunkWhoseCrcIsWrong) {
  Listener listener;
  const auto report = ReadMcap(Bytes(HandMadeFile("\x01\x02\x03\x04")), "hand", listener);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->chunks_lost, 1U);
  EXPECT_TRUE(listener.messages.empty());
}

TEST(ReadMcap, CountsMessagesThatNothingProtects) {
  Listener listener;
  const auto report = ReadMcap(Bytes(HandMadeFile(std::string(4, '\0'))), "hand", listener);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->unprotected, 1U);
  EXPECT_TRUE(listener.messages.empty());
}

TEST(ReadMcap, SkipsPrivateRecordsAndAttachments) {
  Listener listener;
  const std::string private_record = Record('\x80', "anything");
  const std::string attachment = Record('\x09', std::string(40, 'x'));
  const auto report = ReadMcap(Bytes(HandMadeFile(kRightCrc, private_record + attachment)), "hand", listener);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->clean());
  EXPECT_EQ(listener.messages.size(), 1U);
}

TEST(ReadMcap, RefusesAnotherMajorVersion) {
  Listener listener;
  std::string file = HandMadeFile(kRightCrc);
  file[5] = '1';
  const auto report = ReadMcap(Bytes(file), "new.mcap", listener);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().seen, "it is an MCAP file of another version");
}

TEST(ReadMcap, DoesNotUnpackMoreThanItIsAllowed) {
  TestStorage storage;
  auto file = storage.Create("f");
  McapWriter writer(std::move(*file), McapCompression::kZstd);
  ASSERT_TRUE(writer.WritePreamble({"", "", {}, {}, {{1, 0, "t", "json", {}}}}));
  const std::string large(1'000'000, ' ');  // packs to some 50 bytes
  const McapMessage message{1, 0, 0, 0, large};
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer.WriteChunk(std::span(&message, 1)));
  ASSERT_TRUE(writer.Finish());
  Listener small_chunks;
  const auto too_large = ReadMcap(storage.files["f"], "f", small_chunks, {.chunk_bytes = 999'999});
  ASSERT_TRUE(too_large);
  EXPECT_EQ(too_large->chunks_lost, 5U);
  Listener small_total;
  const auto too_much = ReadMcap(storage.files["f"], "f", small_total, {.total_bytes = 2'500'000});
  ASSERT_TRUE(too_much);
  EXPECT_EQ(small_total.messages.size(), 2U);
  EXPECT_FALSE(too_much->finished);
}

TEST(McapWriter, GivesBackWhatItTook) {
  for (const McapCompression compression : {McapCompression::kNone, McapCompression::kZstd}) {
    TestStorage storage;
    auto file = storage.Create("f");
    McapWriter writer(std::move(*file), compression);
    ASSERT_TRUE(writer.WritePreamble({"p",
                                      "l",
                                      {{"m", {{"a", "1"}, {"b", ""}}}},
                                      {{1, "s", "jsonschema", "{}"}},
                                      {{1, 1, "x", "json", {{"k", "v"}}}, {2, 1, "y", "json", {}}}}));
    const McapMessage messages[] = {{2, 10, 5, 5, "second"}, {1, 11, 4, 4, "first"}};
    ASSERT_TRUE(writer.WriteChunk(messages));
    ASSERT_TRUE(writer.WriteMetadata({"n", {}}));
    ASSERT_TRUE(writer.Finish());
    Listener listener;
    const auto report = ReadMcap(storage.files["f"], "f", listener);
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->clean());
    EXPECT_EQ(listener.messages, (std::vector<std::string>{"y#10=second", "x#11=first"}));
    EXPECT_EQ(listener.metadata_names, (std::vector<std::string>{"m", "n"}));
  }
}

TEST(McapWriter, ThrowsWhenItIsUsedAfterItsEnd) {
  TestStorage storage;
  auto file = storage.Create("f");
  McapWriter writer(std::move(*file), McapCompression::kNone);
  ASSERT_TRUE(writer.WritePreamble({}));
  ASSERT_TRUE(writer.Finish());
  EXPECT_THROW((void)writer.Sync(), std::logic_error);
}

}  // namespace
}  // namespace annulus
