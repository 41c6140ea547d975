/// Sealed files. The input edits a good file (pairs: place, byte; then a cut), as foreign bytes alone never pass a tag.
/// Beyond "no crash": what is opened is some of the frames that were sealed, in their order.
#include <algorithm>
#include <cstdint>
#include <cstring>

#include "acquisition/sealed_file.h"
#include "base/ensure.h"
#include "tests/support/test_keys.h"
#include "tests/support/test_storage.h"

namespace {

using namespace annulus;

constexpr std::size_t kFrames = 6;

std::vector<std::byte> GoodFile(const test::TestKeys& keys) {
  test::TestStorage storage;
  auto file = storage.Create("f");
  ENSURE(file.has_value(), "memory takes a file");
  SealedFile sealed(std::move(*file), Seal{"k1", *keys.Key("k1"), SealedFileId{9}});
  for (std::size_t i = 0; i < kFrames; ++i) {
    const std::vector<std::byte> text(8 + i, static_cast<std::byte>('a' + i));
    ENSURE(sealed.Append(text).has_value(), "memory takes a frame");
  }
  return storage.files["f"];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const test::TestKeys keys;
  static const std::vector<std::byte> good = GoodFile(keys);
  const auto foreign = std::as_bytes(std::span(data, size));
  if (LooksSealed(foreign)) (void)Unseal(foreign, keys, "fuzz");
  std::vector<std::byte> bytes = good;
  constexpr std::size_t kEdit = 3;
  for (; size >= kEdit; data += kEdit, size -= kEdit) {
    std::uint16_t place = 0;
    std::memcpy(&place, data, sizeof place);
    const std::size_t at = place % (bytes.size() + 1);
    if (at == bytes.size()) {
      bytes.insert(bytes.end(), good.begin(), good.begin() + data[2]);
    } else {
      bytes[at] = static_cast<std::byte>(data[2]);
    }
  }
  if (size > 0) bytes.erase(bytes.end() - std::min<std::ptrdiff_t>(data[0], std::ssize(bytes)), bytes.end());
  const auto opened = Unseal(bytes, keys, "fuzz");
  if (!opened) return 0;
  ENSURE(opened->frames == opened->sizes.size() && opened->frames <= kFrames, "every frame is opened once at most");
  std::size_t at = 0;
  std::uint64_t newest = 0;
  for (const std::uint64_t length : opened->sizes) {
    ENSURE(length > newest && length >= 8 && length < 8 + kFrames, "frames come in their order");
    for (std::size_t i = 0; i < length; ++i) {
      ENSURE(opened->bytes[at + i] == static_cast<std::byte>('a' + length - 8), "a frame is as it was sealed");
    }
    at += length;
    newest = length;
  }
  return 0;
}
