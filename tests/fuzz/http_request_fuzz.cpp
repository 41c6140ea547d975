/// Bytes of a connection. The first byte is the size of the pieces that they come in. Beyond "no crash": whatever the
/// pieces, the same requests come out as when all comes at once, or both are refused; and what comes out is within the
/// limits.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/ensure.h"
#include "station/http/http_target.h"
#include "station/http/request_reader.h"

namespace {

using namespace annulus;

struct Outcome {
  std::vector<std::string> requests;
  bool refused = false;
};

HttpLimits SmallLimits() {
  HttpLimits limits;
  limits.header_bytes = 2048;
  limits.target_bytes = 256;
  limits.body_bytes = 512;
  return limits;
}

/// False once the stream is refused.
bool TakeAll(RequestReader& reader, const HttpLimits& limits, Outcome& outcome) {
  while (true) {
    switch (reader.Next()) {
      case RequestReader::Event::kMore:
        return true;
      case RequestReader::Event::kRefused:
        ENSURE(reader.problem().status >= 400 && IsPlainUtf8(reader.problem().reason), "a refusal says why");
        outcome.refused = true;
        return false;
      case RequestReader::Event::kHead:
        ENSURE(reader.head().request.HeaderCount("host") == 1, "a request has one Host");
        break;
      case RequestReader::Event::kDone: {
        const HttpRequest& request = reader.head().request;
        ENSURE(request.body.size() <= limits.body_bytes, "a body is within its limit");
        std::string text = request.method + ' ' + request.path + '\n' + request.body;
        for (const auto& [name, value] : request.headers) text += '\n' + name + ':' + value;
        outcome.requests.push_back(std::move(text));
        reader.Begin();
        if (reader.empty()) return true;
        break;
      }
    }
  }
}

Outcome Read(std::string_view stream, std::size_t piece, const HttpLimits& limits) {
  RequestReader reader(limits);
  Outcome outcome;
  for (std::size_t at = 0; at < stream.size(); at += piece) {
    reader.Append(stream.substr(at, piece));
    if (!TakeAll(reader, limits, outcome)) break;
  }
  return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const HttpLimits limits = SmallLimits();
  const std::string_view stream(reinterpret_cast<const char*>(data) + 1, size - 1);
  const Outcome whole = Read(stream, stream.size() + 1, limits);
  const Outcome pieces = Read(stream, 1U + data[0] % 64U, limits);
  ENSURE(whole.requests == pieces.requests, "the same requests come out");
  ENSURE(!whole.refused || pieces.refused, "what is refused at once is refused in pieces");
  return 0;
}
