#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "firmware_iface/usb_frame_codec.h"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

// The first byte says how the rest is cut into chunks; the frames must be those of the uncut stream, every byte must be
// accounted for, and every frame must be one that its own bytes make again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::byte> stream = std::as_bytes(std::span(data + 1, std::min<std::size_t>(size - 1, 512)));
  annulus::UsbFrameAssembler whole;
  const std::vector<annulus::LevelFrame> expected = whole.Push(stream);

  annulus::UsbFrameAssembler pieces;
  std::vector<annulus::LevelFrame> frames;
  std::uint32_t step = data[0];
  for (std::size_t at = 0; at < stream.size();) {
    step = step * 1664525U + 1013904223U;
    const std::size_t length = std::min<std::size_t>(1 + (step >> 24) % 128, stream.size() - at);
    for (const annulus::LevelFrame& frame : pieces.Push(stream.subspan(at, length))) frames.push_back(frame);
    Require(pieces.pending_bytes() < annulus::kLevelFrameBytes);
    at += length;
  }
  Require(frames == expected);
  Require(pieces.rejected_bytes() == whole.rejected_bytes());
  Require(frames.size() * annulus::kLevelFrameBytes + pieces.rejected_bytes() + pieces.pending_bytes() ==
          stream.size());
  for (const annulus::LevelFrame& frame : frames) {
    const auto again = annulus::UsbFrameAssembler().Push(annulus::EncodeLevelFrame(frame));
    Require(again.size() == 1 && again[0] == frame);
  }
  if (const auto identity = annulus::DecodeBoardIdentity(stream)) {
    Require(annulus::DecodeBoardIdentity(annulus::EncodeBoardIdentity(*identity)) == *identity);
  }
  return 0;
}
