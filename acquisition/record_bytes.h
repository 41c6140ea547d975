#pragma once

#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace annulus {

/// Writes the fields of a bus record: numbers in as few bytes as they need (LEB128, signed ones zigzag), times as
/// differences to the record's own. RecordReader has the same calls, so that one description serves both.
class RecordWriter {
 public:
  explicit RecordWriter(std::chrono::nanoseconds time) : time_(time) {}

  template <class Unsigned>
  void Number(const Unsigned& value) {
    static_assert(std::is_unsigned_v<Unsigned>);
    Put(value);
  }
  void Flag(const bool& value) { Put(value ? 1U : 0U); }
  void Real(const double& value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (unsigned shift = 0; shift < 64; shift += 8) bytes_.push_back(static_cast<std::byte>(bits >> shift & 0xFFU));
  }
  template <class Enum>
  void Choice(const Enum& value, Enum /*last*/) {
    Put(static_cast<std::uint64_t>(value));
  }
  void Span(const std::chrono::nanoseconds& value) { PutSigned(value.count()); }
  void Time(const std::chrono::nanoseconds& value) {
    PutSigned(static_cast<std::int64_t>(static_cast<std::uint64_t>(value.count()) -
                                        static_cast<std::uint64_t>(time_.count())));
  }
  void Bytes(const std::vector<std::byte>& value) {
    Put(value.size());
    bytes_.insert(bytes_.end(), value.begin(), value.end());
  }
  /// The bytes as they are; how many there are is known otherwise.
  void Raw(std::span<std::byte> value) { bytes_.insert(bytes_.end(), value.begin(), value.end()); }
  void Text(const std::string& value) {
    Put(value.size());
    const auto text = std::as_bytes(std::span(value));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  /// How many elements follow; the reader makes room for them.
  template <class Vector>
  void Count(const Vector& values) {
    Put(values.size());
  }

  [[nodiscard]] std::vector<std::byte> Take() { return std::move(bytes_); }

 private:
  void Put(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<std::byte>((value & 0x7FU) | 0x80U));
    bytes_.push_back(static_cast<std::byte>(value));
  }
  void PutSigned(std::int64_t value) {
    Put(static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63));
  }

  std::chrono::nanoseconds time_;
  std::vector<std::byte> bytes_;
};

/// Reads what RecordWriter wrote. Whatever the bytes are, it ends; ok() tells whether they held all that was asked for.
class RecordReader {
 public:
  RecordReader(std::span<const std::byte> bytes, std::chrono::nanoseconds time) : bytes_(bytes), time_(time) {}

  [[nodiscard]] bool ok() const { return ok_; }

  template <class Unsigned>
  void Number(Unsigned& value) {
    static_assert(std::is_unsigned_v<Unsigned>);
    const std::uint64_t got = Get();
    ok_ = ok_ && got <= std::numeric_limits<Unsigned>::max();
    value = ok_ ? static_cast<Unsigned>(got) : Unsigned{0};
  }
  void Flag(bool& value) { value = Get() != 0; }
  void Real(double& value) {
    std::uint64_t bits = 0;
    for (unsigned shift = 0; shift < 64; shift += 8) bits |= std::uint64_t{Byte()} << shift;
    value = std::bit_cast<double>(bits);
  }
  template <class Enum>
  void Choice(Enum& value, Enum last) {
    const std::uint64_t got = Get();
    ok_ = ok_ && got <= static_cast<std::uint64_t>(last);
    value = ok_ ? static_cast<Enum>(got) : Enum{};
  }
  void Span(std::chrono::nanoseconds& value) { value = std::chrono::nanoseconds(GetSigned()); }
  void Time(std::chrono::nanoseconds& value) {
    value = std::chrono::nanoseconds(
        static_cast<std::int64_t>(static_cast<std::uint64_t>(GetSigned()) + static_cast<std::uint64_t>(time_.count())));
  }
  void Bytes(std::vector<std::byte>& value) {
    const auto got = Piece(Get());
    value.assign(got.begin(), got.end());
  }
  void Raw(std::span<std::byte> value) {
    const auto got = Piece(value.size());
    for (std::size_t i = 0; i < got.size(); ++i) value[i] = got[i];
  }
  void Text(std::string& value) {
    value.clear();
    for (const std::byte one : Piece(Get())) value.push_back(static_cast<char>(std::to_integer<unsigned char>(one)));
  }
  template <class Vector>
  void Count(Vector& values) {
    const std::uint64_t count = Get();
    // Every element has at least one byte.
    ok_ = ok_ && count <= bytes_.size();
    values.resize(ok_ ? static_cast<std::size_t>(count) : 0);
  }

 private:
  std::uint8_t Byte() {
    ok_ = ok_ && !bytes_.empty();
    if (!ok_) return 0;
    const auto value = std::to_integer<std::uint8_t>(bytes_.front());
    bytes_ = bytes_.subspan(1);
    return value;
  }
  std::uint64_t Get() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const std::uint8_t byte = Byte();
      value |= std::uint64_t{byte & 0x7FU} << shift;
      if ((byte & 0x80U) == 0) return ok_ ? value : 0;
    }
    ok_ = false;
    return 0;
  }
  std::int64_t GetSigned() {
    const std::uint64_t value = Get();
    return static_cast<std::int64_t>(value >> 1 ^ (~(value & 1U) + 1U));
  }
  std::span<const std::byte> Piece(std::uint64_t size) {
    ok_ = ok_ && size <= bytes_.size();
    if (!ok_) return {};
    const auto piece = bytes_.first(static_cast<std::size_t>(size));
    bytes_ = bytes_.subspan(piece.size());
    return piece;
  }

  std::span<const std::byte> bytes_;
  std::chrono::nanoseconds time_;
  bool ok_ = true;
};

}  // namespace annulus
