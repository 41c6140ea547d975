#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace annulus {

/// Makes a zip archive in memory (PKWARE APPNOTE 6.3: local headers, entries stored or deflated, central directory,
/// names in UTF-8), without ZIP64: at most 65,535 entries and 4 GiB. Files and folders that only their owner may read.
class ZipWriter {
 public:
  /// `time`: of all entries, UTC; shown as local time by what reads zips, which knows no zones.
  explicit ZipWriter(std::chrono::system_clock::time_point time);

  /// Adds a file; deflated if that makes it smaller. Fails for a name that is empty, absolute, has a ".." part or a
  /// backslash, or was there before; and beyond what a zip can hold.
  Status Add(const std::string& name, std::string_view bytes);
  /// The whole archive; nothing may be added afterwards.
  [[nodiscard]] std::string Finish();

 private:
  struct Entry {
    std::string name;
    std::uint32_t crc = 0;
    std::uint32_t packed = 0;
    std::uint32_t size = 0;
    std::uint32_t offset = 0;
    bool deflated = false;
  };
  [[nodiscard]] std::string CommonFields(const Entry& entry) const;

  std::uint16_t dos_time_ = 0;
  std::uint16_t dos_date_ = 0;
  std::string archive_;
  std::vector<Entry> entries_;
};

}  // namespace annulus
