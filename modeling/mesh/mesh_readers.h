#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus::mesh_readers {

/// The readers behind ParseMesh, one per format; `what` names the input in messages.
Result<TriangleMesh> ParseObj(std::string_view text, const std::string& what);
Result<TriangleMesh> ParsePly(std::string_view bytes, const std::string& what);
Result<TriangleMesh> ParseStl(std::string_view bytes, const std::string& what);

/// Largest coordinate that is taken for a place, in the file's unit.
inline constexpr double kLargestCoordinate = 1e9;

/// Words of one line between blanks.
[[nodiscard]] std::vector<std::string_view> SplitWords(std::string_view line);
/// A whole word as a number; empty if it is anything else, not finite, or over kLargestCoordinate.
[[nodiscard]] std::optional<double> ParseCoordinate(std::string_view word);
/// A whole word as an integer.
[[nodiscard]] std::optional<long long> ParseInteger(std::string_view word);
/// A word as it may be shown in a message: cut to 40 characters.
[[nodiscard]] std::string Shown(std::string_view word);

/// Walks the lines of a text; CR LF or LF.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : text_(text) {}
  /// The next line without its end; empty at the end of the text.
  std::optional<std::string_view> Next();
  /// Number of the line that Next() gave last, from 1.
  [[nodiscard]] std::size_t line_number() const { return line_number_; }
  /// What Next() has not given yet.
  [[nodiscard]] std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
  std::size_t line_number_ = 0;
};

/// The failure "read mesh WHAT: seen: advice".
[[nodiscard]] tl::unexpected<Error> FailRead(const std::string& what, std::string seen);

}  // namespace annulus::mesh_readers
