#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace annulus {

/// Looks for byte strings in whatever is handed to it. Wipes them when it goes. Thread-bound.
class ByteSearch {
 public:
  /// Empty ones are left out.
  explicit ByteSearch(std::vector<std::string> markers);
  ~ByteSearch();
  ByteSearch(const ByteSearch&) = delete;
  ByteSearch& operator=(const ByteSearch&) = delete;

  /// How far blocks must overlap so that no marker falls between two.
  [[nodiscard]] std::size_t overlap() const { return overlap_; }
  /// One block of something; `overlap` of its bytes were in the block before it.
  void Look(std::span<const std::byte> block);
  /// A whole file; one that is not there (any more) has no bytes.
  Status LookAtFile(const std::string& path);

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  /// Blocks times markers in which one was found.
  [[nodiscard]] std::uint64_t hits() const { return hits_; }

 private:
  std::vector<std::string> markers_;
  std::size_t overlap_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t hits_ = 0;
};

}  // namespace annulus
