#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "firmware_iface/usb_frame_codec.h"

namespace {

using Bytes = std::span<const std::byte>;

void Require(bool condition) {
  if (!condition) std::abort();
}

/// Pushes the stream in pieces of the lengths that `length(position)` says.
template <class Length>
void ExpectSame(Bytes stream, const std::vector<annulus::LevelFrame>& expected, const annulus::UsbFrameAssembler& whole,
                Length length) {
  annulus::UsbFrameAssembler pieces;
  std::vector<annulus::LevelFrame> frames;
  for (std::size_t at = 0; at < stream.size();) {
    const std::size_t size = std::min(length(at), stream.size() - at);
    for (const annulus::LevelFrame& frame : pieces.Push(stream.subspan(at, size))) frames.push_back(frame);
    Require(pieces.pending_bytes() < annulus::kLevelFrameBytes);
    at += size;
  }
  Require(frames == expected);
  Require(pieces.rejected_bytes() == whole.rejected_bytes());
  Require(pieces.rejected_frames() == whole.rejected_frames());
}

}  // namespace

// The first byte says how the rest is cut into chunks; whatever the cuts (these, in two where the second byte
// says, or single bytes), the frames must be those of the uncut stream, every byte must be accounted for, and every
// frame must be one that its own bytes make again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const Bytes stream = std::as_bytes(std::span(data + 2, std::min<std::size_t>(size - 2, 512)));
  annulus::UsbFrameAssembler whole;
  const std::vector<annulus::LevelFrame> expected = whole.Push(stream);
  Require(expected.size() * annulus::kLevelFrameBytes + whole.rejected_bytes() + whole.pending_bytes() ==
          stream.size());

  std::uint32_t step = data[0];
  ExpectSame(stream, expected, whole, [&step](std::size_t) {
    step = step * 1664525U + 1013904223U;
    return std::size_t{1} + (step >> 24) % 128;
  });
  if (data[1] % 4 == 0) ExpectSame(stream, expected, whole, [](std::size_t) { return std::size_t{1}; });
  const std::size_t cut = 1 + data[1] * std::size_t{2};
  ExpectSame(stream, expected, whole, [&](std::size_t at) { return at == 0 ? cut : stream.size(); });

  for (const annulus::LevelFrame& frame : expected) {
    const auto again = annulus::UsbFrameAssembler().Push(annulus::EncodeLevelFrame(frame));
    Require(again.size() == 1 && again[0] == frame);
  }
  if (const auto identity = annulus::DecodeBoardIdentity(stream)) {
    Require(annulus::DecodeBoardIdentity(annulus::EncodeBoardIdentity(*identity)) == *identity);
  }
  if (const auto time = annulus::DecodeDeviceTime(stream)) Require(time->count() >= 0);
  return 0;
}
