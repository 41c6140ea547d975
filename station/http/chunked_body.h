#pragma once

#include <cstddef>
#include <string>

namespace annulus {

/// Decodes a body in chunks (RFC 9112 §7.1). Extensions are passed over; trailers are refused, since nothing that the
/// console serves has a use for them.
class ChunkedBody {
 public:
  enum class State { kMore, kDone, kMalformed, kTooLarge };

  /// `limit`: largest body in bytes.
  explicit ChunkedBody(std::size_t limit) : limit_(limit) {}

  /// Takes all that can be decoded from the front of `received` and appends it to `body`. After kDone, what is left in
  /// `received` belongs to the next request; after kMalformed and kTooLarge nothing may be called.
  [[nodiscard]] State Take(std::string& received, std::string& body);

 private:
  enum class Part { kSize, kData, kDataEnd, kTrailer };
  enum class Step { kNext, kMore, kDone, kMalformed, kTooLarge };
  Step TakeSize(std::string& received, std::size_t& at, std::size_t body_bytes);
  Step TakeData(std::string& received, std::size_t& at, std::string& body);
  Step TakeLineEnd(std::string& received, std::size_t& at, Part next);

  std::size_t limit_;
  Part part_ = Part::kSize;
  std::size_t left_ = 0;  ///< Of the chunk.
};

}  // namespace annulus
