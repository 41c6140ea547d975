#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "station/booth_messages.h"

namespace annulus {

/// Shared by the two halves of the booth's codec; everybody else includes station/booth_messages.h.
using BoothJson = nlohmann::ordered_json;

/// `text`, cut at a character's boundary to at most `max_bytes`.
[[nodiscard]] std::string Clipped(std::string_view text, std::size_t max_bytes = 1024);
/// The number, null if it is not finite.
[[nodiscard]] BoothJson FiniteOrNull(double number);

/// Reads the members of one JSON object; the first that is not as it must be is remembered by name, and what is read
/// from then on means nothing. Borrows both.
class FieldReader {
 public:
  FieldReader(const BoothJson& object, std::string& wrong) : object_(object), wrong_(wrong) {}

  /// Text of at most `max_bytes` without control characters.
  std::string Text(const char* key, std::size_t max_bytes = 8192);
  /// The same; empty if it is missing.
  std::string OptionalText(const char* key, std::size_t max_bytes);
  /// Text of any length with any characters.
  std::string Words(const char* key);
  bool Flag(const char* key);
  std::uint64_t Count(const char* key, std::uint64_t max = std::numeric_limits<std::uint64_t>::max());
  std::int64_t Integer(const char* key);
  /// A number within the bounds.
  double Number(const char* key, double low, double high);
  /// A number; null is NaN.
  double NumberOrNan(const char* key);
  /// Whether it is there and not null.
  [[nodiscard]] bool Has(const char* key) const;
  /// Calls `read(FieldReader&)` for the object at `key`.
  template <class Read>
  void Object(const char* key, Read read) {
    const BoothJson* found = Find(key);
    if (found == nullptr) return;
    if (!found->is_object()) return Wrong(key, *found, "an object");
    FieldReader inner(*found, wrong_);
    read(inner);
  }
  /// Calls `read(const BoothJson&)` for the elements of the array at `key`, which has at most `max` of them.
  template <class Read>
  void Array(const char* key, std::size_t max, Read read) {
    const BoothJson* found = Find(key);
    if (found == nullptr) return;
    if (!found->is_array() || found->size() > max) return Wrong(key, *found, "a list, or too long a one");
    for (const BoothJson& element : *found) read(element);
  }
  /// The same for a list of objects: `read(FieldReader&)`.
  template <class Read>
  void Objects(const char* key, std::size_t max, Read read) {
    Array(key, max, [&](const BoothJson& element) {
      if (!element.is_object()) return Wrong(key, element, "a list of objects");
      FieldReader inner(element, wrong_);
      read(inner);
    });
  }
  /// The same for a list of texts.
  std::vector<std::string> Texts(const char* key, std::size_t max);
  /// Remembers that `key` is wrong, unless something was before.
  void Wrong(const char* key, const BoothJson& value, const std::string& wanted);
  void Wrong(const char* key, const std::string& what);

 private:
  const BoothJson* Find(const char* key);

  const BoothJson& object_;
  std::string& wrong_;
};

/// Adds the members of a status, or of a result, to `json`, and reads them.
void PutStatus(const StatusMessage& message, BoothJson& json);
[[nodiscard]] StatusMessage ReadStatus(FieldReader& fields);
[[nodiscard]] BoothJson JsonFromResult(const ScanResult& result);
[[nodiscard]] ScanResult ReadResult(FieldReader& fields);
[[nodiscard]] BoothJson JsonFromError(const Error& error);
[[nodiscard]] Error ReadError(FieldReader& fields);

}  // namespace annulus
