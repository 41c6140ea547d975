#include "firmware_iface/usb_frame_codec.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace annulus {
namespace {

std::vector<std::byte> FromHex(const std::string& hex) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

// docs/wire_protocol.md, "Golden vectors". Made with Python, not with this code:
//   body = b'ANRL' + struct.pack('<BBHIIQhBB', 1, 0, 108, 1008, 513, 1234567890123, 2315, 15, 0)
//          + struct.pack('<15I', *ranges) + bytes(qualities) + b'\0'
//   frame = body + struct.pack('<I', crc32c(body))     crc32c bit by bit, polynomial 0x82F63B78
// ranges 450000 + 1000 i with none at 3, qualities 255 - i with 0 at 3.
const char* const kGoldenFrame =
    "414e524c01006c00f003000001020000cb04fb711f0100000b090f00d0dd0600b8e10600a0e50600ffffffff70ed060058f1060040f50600"
    "28f9060010fd0600f8000700e0040700c8080700b00c07009810070080140700fffefd00fbfaf9f8f7f6f5f4f3f2f100a5a1c43a";
//   b'ANRI' + bytes([1, 1, 2, 0]) + struct.pack('<IHBBII', 1008, 105, 15, 0, 100000, 15000)
const char* const kGoldenIdentity = "414e524901010200f003000069000f00a0860100983a0000";

LevelFrame GoldenFrame() {
  LevelFrame frame;
  frame.board_serial = 1008;
  frame.sequence = 513;
  frame.device_time = std::chrono::nanoseconds(1'234'567'890'123);
  frame.temperature_centi_c = 2315;
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    frame.range_um[i] = static_cast<std::uint32_t>(450'000 + 1000 * i);
    frame.quality[i] = static_cast<std::uint8_t>(255 - i);
  }
  frame.range_um[3] = kNoReturn;
  frame.quality[3] = 0;
  return frame;
}

LevelFrame RandomFrame(std::mt19937_64& random) {
  LevelFrame frame;
  frame.board_serial = static_cast<std::uint32_t>(random());
  frame.sequence = static_cast<std::uint32_t>(random());
  frame.device_time = std::chrono::nanoseconds(static_cast<std::int64_t>(random() >> 1));
  frame.status = static_cast<std::uint8_t>(random());
  frame.temperature_centi_c = static_cast<std::int16_t>(random());
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    frame.range_um[i] = static_cast<std::uint32_t>(random());
    frame.quality[i] = static_cast<std::uint8_t>(random());
  }
  return frame;
}

void Append(std::vector<std::byte>& stream, std::span<const std::byte> bytes) {
  stream.insert(stream.end(), bytes.begin(), bytes.end());
}

/// Frames, garbage, damaged and cut frames.
std::vector<std::byte> RandomStream(std::mt19937_64& random) {
  std::vector<std::byte> stream;
  for (int piece = 0; piece < 12; ++piece) {
    auto bytes = EncodeLevelFrame(RandomFrame(random));
    switch (random() % 4) {
      case 0:
        for (std::size_t i = 0; i < random() % 200; ++i) stream.push_back(static_cast<std::byte>(random() % 4 + 'J'));
        break;
      case 1:
        bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
        Append(stream, bytes);
        break;
      case 2:
        Append(stream, std::span(bytes).first(random() % bytes.size()));
        break;
      default:
        Append(stream, bytes);
    }
  }
  return stream;
}

TEST(UsbFrameCodec, WritesTheGoldenFrame) {
  const auto bytes = EncodeLevelFrame(GoldenFrame());
  EXPECT_EQ(std::vector<std::byte>(bytes.begin(), bytes.end()), FromHex(kGoldenFrame));
}

TEST(UsbFrameCodec, ReadsTheGoldenFrame) {
  UsbFrameAssembler assembler;
  const auto frames = assembler.Push(FromHex(kGoldenFrame));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0], GoldenFrame());
  EXPECT_EQ(assembler.pending_bytes(), 0U);
}

TEST(UsbFrameCodec, ReadsAndWritesTheGoldenIdentity) {
  BoardIdentity identity;
  identity.firmware_version = {1, 2, 0};
  identity.serial = 1008;
  identity.first_sensor = 105;
  identity.max_level_rate_mhz = 100'000;
  identity.min_level_rate_mhz = 15'000;
  const auto bytes = EncodeBoardIdentity(identity);
  EXPECT_EQ(std::vector<std::byte>(bytes.begin(), bytes.end()), FromHex(kGoldenIdentity));
  const auto read = DecodeBoardIdentity(FromHex(kGoldenIdentity));
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, identity);
}

TEST(UsbFrameCodec, RefusesIdentitiesRatesAndTimesOfTheWrongLength) {
  const auto golden = FromHex(kGoldenIdentity);
  EXPECT_FALSE(DecodeBoardIdentity(std::span(golden).first(golden.size() - 1)));
  EXPECT_FALSE(DecodeBoardIdentity({}));
  EXPECT_FALSE(DecodeLevelRate({}));
  EXPECT_FALSE(DecodeDeviceTime(std::span(golden).first(7)));
  EXPECT_FALSE(DecodeDeviceTime(std::vector<std::byte>(8, std::byte{0xFF})));  // below zero
}

TEST(UsbFrameAssembler, GivesTheSameFramesForAnySplit) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 200; ++run) {
    const auto stream = RandomStream(random);
    UsbFrameAssembler whole;
    const auto expected = whole.Push(stream);
    UsbFrameAssembler pieces;
    std::vector<LevelFrame> frames;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t size = std::min<std::size_t>(random() % 90, stream.size() - at);
      for (const LevelFrame& frame : pieces.Push(std::span(stream).subspan(at, size))) frames.push_back(frame);
      at += size;
      EXPECT_LT(pieces.pending_bytes(), kLevelFrameBytes);
    }
    ASSERT_EQ(frames, expected);
    EXPECT_EQ(pieces.rejected_bytes(), whole.rejected_bytes());
    EXPECT_EQ(pieces.rejected_frames(), whole.rejected_frames());
    EXPECT_EQ(frames.size() * kLevelFrameBytes + pieces.rejected_bytes() + pieces.pending_bytes(), stream.size());
  }
}

TEST(UsbFrameAssembler, FindsEveryGoodFrameBetweenGarbage) {
  std::mt19937_64 random(2);
  for (int run = 0; run < 100; ++run) {
    std::vector<std::byte> stream;
    std::vector<LevelFrame> sent;
    for (int i = 0; i < 10; ++i) {
      // Garbage that never holds the magic's first letter, so that it can not swallow what follows.
      for (std::size_t n = random() % 50; n > 0; --n) stream.push_back(static_cast<std::byte>(random() % 64));
      sent.push_back(RandomFrame(random));
      Append(stream, EncodeLevelFrame(sent.back()));
    }
    UsbFrameAssembler assembler;
    EXPECT_EQ(assembler.Push(stream), sent);
  }
}

TEST(UsbFrameAssembler, LosesOnlyTheFrameThatAFlippedBitTouches) {
  std::mt19937_64 random(3);
  const LevelFrame first = RandomFrame(random);
  const LevelFrame last = RandomFrame(random);
  for (std::size_t bit = 0; bit < 8 * kLevelFrameBytes; ++bit) {
    auto middle = EncodeLevelFrame(GoldenFrame());
    middle[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    std::vector<std::byte> stream;
    Append(stream, EncodeLevelFrame(first));
    Append(stream, middle);
    Append(stream, EncodeLevelFrame(last));
    UsbFrameAssembler assembler;
    EXPECT_EQ(assembler.Push(stream), (std::vector<LevelFrame>{first, last})) << "bit " << bit;
    EXPECT_EQ(assembler.rejected_bytes(), kLevelFrameBytes);
  }
}

TEST(UsbFrameAssembler, GoesOnAfterAFrameCutAtAnyByte) {
  const auto golden = EncodeLevelFrame(GoldenFrame());
  std::mt19937_64 random(4);
  const LevelFrame next = RandomFrame(random);
  for (std::size_t cut = 0; cut < golden.size(); ++cut) {
    std::vector<std::byte> stream(golden.begin(), golden.begin() + static_cast<std::ptrdiff_t>(cut));
    Append(stream, EncodeLevelFrame(next));
    UsbFrameAssembler assembler;
    EXPECT_EQ(assembler.Push(stream), std::vector<LevelFrame>{next}) << "cut at " << cut;
    EXPECT_EQ(assembler.rejected_bytes(), cut);
  }
}

}  // namespace
}  // namespace annulus
