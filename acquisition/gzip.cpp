#include "acquisition/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr int kGzipWindow = 15 + 16;  // zlib: largest window, gzip frame
constexpr std::size_t kBlockBytes = std::size_t{1} << 18;

/// A zlib stream that unpacks, freed with its scope.
class Inflater {
 public:
  Inflater() { ENSURE(inflateInit2(&stream_, kGzipWindow) == Z_OK, "zlib has memory to unpack"); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&stream_); }
  [[nodiscard]] z_stream& stream() { return stream_; }

 private:
  z_stream stream_{};
};

/// zlib counts 32 bits: the next part of a long text.
std::string_view NextPart(std::string_view rest) {
  return rest.substr(0, std::min<std::size_t>(rest.size(), std::numeric_limits<uInt>::max() / 2));
}

void Feed(z_stream& stream, std::string_view part) {
  // zlib never writes through next_in; its C interface lacks the const.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(part.data()));
  stream.avail_in = static_cast<uInt>(part.size());
}

}  // namespace

bool LooksLikeGzip(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

Result<std::string> GunzipText(std::span<const std::byte> bytes, const std::string& name, std::uint64_t max_bytes) {
  const std::string attempted = "unpack " + name;
  std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Inflater inflater;
  z_stream& stream = inflater.stream();
  std::string text;
  auto block = std::make_unique_for_overwrite<char[]>(kBlockBytes);
  while (!rest.empty()) {
    const std::string_view part = NextPart(rest);
    Feed(stream, part);
    stream.next_out = reinterpret_cast<Bytef*>(block.get());
    stream.avail_out = static_cast<uInt>(kBlockBytes);
    const int code = inflate(&stream, Z_NO_FLUSH);
    rest.remove_prefix(part.size() - stream.avail_in);
    text.append(block.get(), kBlockBytes - stream.avail_out);
    if (text.size() > max_bytes) {
      return Fail(attempted, "it unpacks to more than " + std::to_string(max_bytes) + " bytes", "give a smaller file");
    }
    if (code == Z_STREAM_END) {
      if (rest.find_first_not_of('\0') == std::string_view::npos) return text;  // padding of tapes and disks
      if (!LooksLikeGzip(std::as_bytes(std::span(rest)))) {
        return Fail(attempted, "something else follows the gzip data", "copy or pack the file again");
      }
      inflateReset(&stream);
    } else if (code != Z_OK && !(code == Z_BUF_ERROR && stream.avail_out == 0)) {
      return code == Z_BUF_ERROR ? Fail(attempted, "the gzip data is truncated", "copy the file again")
                                 : Fail(attempted, "the gzip data is damaged", "copy the file again");
    }
  }
  return Fail(attempted, "the gzip data is truncated", "copy the file again");
}

struct GzipPacker::State {
  State() {
    constexpr int kLevel = 6;
    constexpr int kMemory = 8;
    ENSURE(deflateInit2(&stream, kLevel, Z_DEFLATED, kGzipWindow, kMemory, Z_DEFAULT_STRATEGY) == Z_OK,
           "zlib has memory to pack");
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() { deflateEnd(&stream); }

  std::string Run(std::string_view part, int flush) {
    Feed(stream, part);
    std::string packed;
    std::array<char, 1U << 16U> block;
    do {
      stream.next_out = reinterpret_cast<Bytef*>(block.data());
      stream.avail_out = static_cast<uInt>(block.size());
      ENSURE(deflate(&stream, flush) != Z_STREAM_ERROR, "zlib's state is sound");
      packed.append(block.data(), block.size() - stream.avail_out);
    } while (stream.avail_out == 0);
    return packed;
  }

  z_stream stream{};
};

GzipPacker::GzipPacker() : state_(std::make_unique<State>()) {}
GzipPacker::GzipPacker(GzipPacker&&) noexcept = default;
GzipPacker& GzipPacker::operator=(GzipPacker&&) noexcept = default;
GzipPacker::~GzipPacker() = default;

std::string GzipPacker::Pack(std::string_view text) {
  std::string packed;
  while (!text.empty()) {
    const std::string_view part = NextPart(text);
    packed += state_->Run(part, Z_NO_FLUSH);
    text.remove_prefix(part.size());
  }
  return packed;
}

std::string GzipPacker::Finish() { return state_->Run({}, Z_FINISH); }

}  // namespace annulus
