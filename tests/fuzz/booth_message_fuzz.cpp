/// The messages of boothd's socket. The first byte chooses: a request, a message of boothd, or a stream of frames cut
/// into pieces. Beyond "no crash": what is accepted is written and read back to the same text, and what comes out of
/// frames is what went in.
#include <cstdint>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "station/booth_messages.h"

namespace {

using namespace annulus;

void CheckRequest(std::string_view text) {
  const auto request = DecodeRequest(text);
  if (!request) return;
  const std::string written = EncodeRequest(*request);
  const auto again = DecodeRequest(written);
  ENSURE(again.has_value() && EncodeRequest(*again) == written, "a request reads back as it was");
}

void CheckMessage(std::string_view text) {
  const auto message = DecodeMessage(text);
  if (!message) return;
  const std::string written = EncodeMessage(*message);
  const auto again = DecodeMessage(written);
  ENSURE(again.has_value() && EncodeMessage(*again) == written, "a message reads back as it was");
}

void CheckStream(std::string_view stream, std::size_t piece) {
  BoothFrameReader reader(kMaxBoothRequest);
  std::size_t taken = 0;
  for (std::size_t begin = 0; begin < stream.size(); begin += piece) {
    reader.Append(stream.substr(begin, piece));
    while (true) {
      const auto text = reader.Next();
      if (!text) return;
      if (!*text) break;
      const auto frame = BoothFrame(**text);
      ENSURE(frame && stream.substr(taken, frame->size()) == *frame, "a frame is what was sent");
      taken += frame->size();
    }
  }
  ENSURE(taken + reader.waiting() == stream.size(), "no byte is lost");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'q':
      CheckRequest(text);
      break;
    case 'm':
      CheckMessage(text);
      break;
    default:
      CheckStream(text, 1U + data[0] % 64U);
      break;
  }
  return 0;
}
