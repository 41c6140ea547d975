#include "station/store/byte_search.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "station/store/sealed_text.h"

namespace annulus {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

}  // namespace

ByteSearch::ByteSearch(std::vector<std::string> markers) : markers_(std::move(markers)) {
  std::erase_if(markers_, [](const std::string& marker) { return marker.empty(); });
  for (const std::string& marker : markers_) overlap_ = std::max(overlap_, marker.size() - 1);
}

ByteSearch::~ByteSearch() {
  for (std::string& marker : markers_) Wipe(marker);
}

void ByteSearch::Look(std::span<const std::byte> block) {
  bytes_ += block.size();
  for (const std::string& marker : markers_) {
    if (::memmem(block.data(), block.size(), marker.data(), marker.size()) != nullptr) ++hits_;
  }
}

Status ByteSearch::LookAtFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  if (!file) {
    if (!std::filesystem::exists(path, error)) return {};
    return Fail("search " + path, "it cannot be read", "check its permissions");
  }
  std::vector<std::byte> block(kBlockBytes + overlap_);
  std::size_t kept = 0;
  while (true) {
    file.read(reinterpret_cast<char*>(block.data() + kept), static_cast<std::streamsize>(kBlockBytes));
    const auto got = static_cast<std::size_t>(file.gcount());
    if (file.bad()) return Fail("search " + path, "it cannot be read", "check the disk");
    if (got == 0) return {};
    Look(std::span(block).first(kept + got));
    bytes_ -= kept;
    const std::size_t next = std::min(overlap_, kept + got);
    std::copy_n(block.begin() + static_cast<std::ptrdiff_t>(kept + got - next), next, block.begin());
    kept = next;
  }
}

}  // namespace annulus
