#include "station/console/zip_writer.h"

#include <zlib.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <optional>

namespace annulus {
namespace {

constexpr std::uint32_t kLocalHeader = 0x04034b50;
constexpr std::uint32_t kCentralHeader = 0x02014b50;
constexpr std::uint32_t kEndOfDirectory = 0x06054b50;
constexpr std::uint16_t kVersion = 20;  ///< Needed to extract: deflate.
constexpr std::uint16_t kMadeByUnix = 3 << 8 | kVersion;
constexpr std::uint16_t kUtf8Names = 1 << 11;
constexpr std::uint16_t kDeflated = 8;
constexpr std::uint32_t kOwnersFile = 0100600U << 16U;
constexpr std::size_t kMostBytes = std::numeric_limits<std::uint32_t>::max() - (std::size_t{1} << 20);
constexpr std::size_t kMostEntries = std::numeric_limits<std::uint16_t>::max();

void Put16(std::string& into, std::uint32_t value) {
  into.push_back(static_cast<char>(value & 0xFFU));
  into.push_back(static_cast<char>(value >> 8U & 0xFFU));
}
void Put32(std::string& into, std::uint32_t value) {
  Put16(into, value & 0xFFFFU);
  Put16(into, value >> 16U);
}

/// Raw deflate (RFC 1951); nothing if it does not get smaller.
std::optional<std::string> Deflate(std::string_view bytes) {
  z_stream stream{};
  constexpr int kRaw = -15;
  constexpr int kMemory = 8;
  if (::deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kRaw, kMemory, Z_DEFAULT_STRATEGY) != Z_OK) return std::nullopt;
  std::string packed(bytes.size(), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const bool fits = ::deflate(&stream, Z_FINISH) == Z_STREAM_END;
  packed.resize(stream.total_out);
  ::deflateEnd(&stream);
  if (!fits) return std::nullopt;
  return packed;
}

bool IsGoodName(const std::string& name) {
  if (name.empty() || name.size() > 1000 || name.front() == '/' || name.find('\\') != std::string::npos) return false;
  const std::string framed = "/" + name + "/";
  return framed.find("/../") == std::string::npos && framed.find("//") == std::string::npos;
}

}  // namespace

ZipWriter::ZipWriter(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  const int years = std::clamp(utc.tm_year - 80, 0, 127);  // since 1980
  dos_time_ = static_cast<std::uint16_t>(utc.tm_hour << 11 | utc.tm_min << 5 | utc.tm_sec / 2);
  dos_date_ = static_cast<std::uint16_t>(years << 9 | (utc.tm_mon + 1) << 5 | utc.tm_mday);
}

std::string ZipWriter::CommonFields(const Entry& entry) const {
  std::string fields;
  Put16(fields, kVersion);
  Put16(fields, kUtf8Names);
  Put16(fields, entry.deflated ? kDeflated : 0);
  Put16(fields, dos_time_);
  Put16(fields, dos_date_);
  Put32(fields, entry.crc);
  Put32(fields, entry.packed);
  Put32(fields, entry.size);
  Put16(fields, static_cast<std::uint32_t>(entry.name.size()));
  Put16(fields, 0);  // extra field
  return fields;
}

Status ZipWriter::Add(const std::string& name, std::string_view bytes) {
  const std::string attempted = "put '" + name + "' into a zip";
  const bool there = std::any_of(entries_.begin(), entries_.end(), [&](const Entry& one) { return one.name == name; });
  if (!IsGoodName(name) || there) return Fail(attempted, "its name is no good, or was there before", "report it");
  if (bytes.size() > kMostBytes || archive_.size() + bytes.size() > kMostBytes || entries_.size() >= kMostEntries) {
    return Fail(attempted, "it would get larger than a zip can be", "export fewer things");
  }
  Entry entry;
  entry.name = name;
  entry.size = static_cast<std::uint32_t>(bytes.size());
  entry.offset = static_cast<std::uint32_t>(archive_.size());
  entry.crc = static_cast<std::uint32_t>(
      ::crc32(0L, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
  const std::optional<std::string> deflated = Deflate(bytes);
  entry.deflated = deflated.has_value();
  const std::string_view body = deflated ? std::string_view(*deflated) : bytes;
  entry.packed = static_cast<std::uint32_t>(body.size());
  Put32(archive_, kLocalHeader);
  archive_ += CommonFields(entry) + name;
  archive_ += body;
  entries_.push_back(std::move(entry));
  return {};
}

std::string ZipWriter::Finish() {
  const auto begin = static_cast<std::uint32_t>(archive_.size());
  for (const Entry& entry : entries_) {
    Put32(archive_, kCentralHeader);
    Put16(archive_, kMadeByUnix);
    archive_ += CommonFields(entry);
    Put16(archive_, 0);  // comment
    Put16(archive_, 0);  // disk
    Put16(archive_, 0);  // internal attributes
    Put32(archive_, kOwnersFile);
    Put32(archive_, entry.offset);
    archive_ += entry.name;
  }
  const auto size = static_cast<std::uint32_t>(archive_.size()) - begin;
  const auto count = static_cast<std::uint32_t>(entries_.size());
  Put32(archive_, kEndOfDirectory);
  Put32(archive_, 0);  // this disk, disk of the directory
  Put16(archive_, count);
  Put16(archive_, count);
  Put32(archive_, size);
  Put32(archive_, begin);
  Put16(archive_, 0);  // comment
  return std::move(archive_);
}

}  // namespace annulus
