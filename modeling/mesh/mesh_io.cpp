#include "modeling/mesh/mesh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "modeling/mesh/mesh_readers.h"

namespace annulus {
namespace mesh_readers {

std::vector<std::string_view> SplitWords(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\v\f\r";
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(kBlanks);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

std::optional<double> ParseCoordinate(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  if (!(std::abs(value) <= kLargestCoordinate)) return std::nullopt;
  return value;
}

std::optional<long long> ParseInteger(std::string_view word) {
  long long value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::string Shown(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  return word.size() <= kLongest ? std::string(word) : std::string(word.substr(0, kLongest)) + "…";
}

std::optional<std::string_view> LineReader::Next() {
  if (text_.empty()) return std::nullopt;
  const std::size_t end = std::min(text_.find('\n'), text_.size());
  std::string_view line = text_.substr(0, end);
  text_.remove_prefix(std::min(end + 1, text_.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  ++line_number_;
  return line;
}

tl::unexpected<Error> FailRead(const std::string& what, std::string seen) {
  return Fail("read mesh " + what, std::move(seen), "export the mesh again as OBJ, PLY or STL");
}

}  // namespace mesh_readers

Result<TriangleMesh> ParseMesh(std::span<const std::byte> bytes, MeshFormat format, const std::string& what) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Result<TriangleMesh> mesh = format == MeshFormat::kObj   ? mesh_readers::ParseObj(text, what)
                              : format == MeshFormat::kPly ? mesh_readers::ParsePly(text, what)
                                                           : mesh_readers::ParseStl(text, what);
  if (mesh && mesh->faces.empty()) return mesh_readers::FailRead(what, "no triangle in it");
  return mesh;
}

Result<TriangleMesh> ReadMesh(Storage& storage, const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  std::string extension = dot == std::string::npos ? "" : path.substr(dot);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto format = extension == ".obj"   ? std::optional(MeshFormat::kObj)
                      : extension == ".ply" ? std::optional(MeshFormat::kPly)
                      : extension == ".stl" ? std::optional(MeshFormat::kStl)
                                            : std::nullopt;
  if (!format) return mesh_readers::FailRead(path, fmt::format("the extension is '{}'", extension));
  const auto bytes = storage.ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  return ParseMesh(*bytes, *format, path);
}

}  // namespace annulus
