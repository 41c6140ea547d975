#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace annulus {

/// Writes a JSON text piece by piece. Unlike a tree of values, which needs memory to be destroyed, it survives any
/// allocation that fails while the booth arms. Objects and arrays are closed by whoever opened them.
class JsonText {
 public:
  JsonText& Open(char bracket);   ///< '{' or '['
  JsonText& Close(char bracket);  ///< '}' or ']'
  JsonText& Key(std::string_view key);
  /// The shortest decimal that reads back as the number; null if it is not finite.
  JsonText& Number(double number);
  JsonText& Integer(std::int64_t number);
  JsonText& Unsigned(std::uint64_t number);
  /// Escaped; bytes that are no UTF-8 are replaced.
  JsonText& Text(const std::string& text);
  JsonText& Numbers(const std::vector<double>& numbers);
  /// A value that is JSON already.
  JsonText& Raw(std::string_view json);

  [[nodiscard]] std::string Take() { return std::move(out_); }

 private:
  void Separate();
  std::string out_;
};

/// Appends a number as JsonText::Number writes it.
void PutNumber(std::string& out, double number);

}  // namespace annulus
