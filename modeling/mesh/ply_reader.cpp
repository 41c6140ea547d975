#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "modeling/mesh/mesh_readers.h"

namespace annulus::mesh_readers {
namespace {

enum class Encoding { kAscii, kLittle, kBig };
enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::optional<Type> TypeNamed(std::string_view name) {
  struct Entry {
    std::string_view name;
    Type type;
  };
  static constexpr std::array<Entry, 16> kNames{{{"char", Type::kInt8},
                                                 {"int8", Type::kInt8},
                                                 {"uchar", Type::kUint8},
                                                 {"uint8", Type::kUint8},
                                                 {"short", Type::kInt16},
                                                 {"int16", Type::kInt16},
                                                 {"ushort", Type::kUint16},
                                                 {"uint16", Type::kUint16},
                                                 {"int", Type::kInt32},
                                                 {"int32", Type::kInt32},
                                                 {"uint", Type::kUint32},
                                                 {"uint32", Type::kUint32},
                                                 {"float", Type::kFloat32},
                                                 {"float32", Type::kFloat32},
                                                 {"double", Type::kFloat64},
                                                 {"float64", Type::kFloat64}}};
  for (const Entry& entry : kNames) {
    if (entry.name == name) return entry.type;
  }
  return std::nullopt;
}

std::size_t SizeOf(Type type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string name;
  Type type = Type::kFloat32;
  std::optional<Type> list_count;  // of a list: the type of its length
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
};

// One line of the header after "ply", put into `header`; what is wrong with it, or "".
std::string TakeHeaderLine(const std::vector<std::string_view>& words, Header& header) {
  if (words[0] == "format") {
    if (words.size() != 3 || words[2] != "1.0") return "an unknown format";
    if (words[1] == "ascii")
      header.encoding = Encoding::kAscii;
    else if (words[1] == "binary_little_endian")
      header.encoding = Encoding::kLittle;
    else if (words[1] == "binary_big_endian")
      header.encoding = Encoding::kBig;
    else
      return "an unknown format";
    return "";
  }
  if (words[0] == "element") {
    const auto count = words.size() == 3 ? ParseInteger(words[2]) : std::nullopt;
    if (!count || *count < 0) return "not an element and its count";
    header.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(*count), {}});
    return "";
  }
  if (words[0] == "property") {
    if (header.elements.empty()) return "a property before any element";
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) return "not a property";
    const auto type = TypeNamed(words[words.size() - 2]);
    const auto count_type = list ? TypeNamed(words[2]) : std::nullopt;
    if (!type || (list && !count_type)) return "a type that PLY does not have";
    header.elements.back().properties.push_back({std::string(words.back()), *type, count_type});
    return "";
  }
  return words[0] == "comment" || words[0] == "obj_info" ? "" : "an unknown word";
}

// Numbers one after the other, text or binary.
class ValueReader {
 public:
  ValueReader(std::string_view bytes, Encoding encoding, std::size_t line_number)
      : bytes_(bytes), encoding_(encoding), line_number_(line_number) {}

  [[nodiscard]] std::size_t remaining() const { return bytes_.size(); }
  // Bytes that one value takes at least.
  [[nodiscard]] std::size_t SmallestSize(Type type) const { return encoding_ == Encoding::kAscii ? 1 : SizeOf(type); }

  std::optional<double> Next(Type type) { return encoding_ == Encoding::kAscii ? NextWord() : NextBinary(type); }

  [[nodiscard]] std::string Place() const {
    return encoding_ == Encoding::kAscii ? fmt::format("line {}", line_number_)
                                         : fmt::format("{} bytes before the end", bytes_.size());
  }

 private:
  std::optional<double> NextWord() {
    while (!bytes_.empty() && std::string_view(" \t\r\n").find(bytes_.front()) != std::string_view::npos) {
      if (bytes_.front() == '\n') ++line_number_;
      bytes_.remove_prefix(1);
    }
    const std::string_view word = bytes_.substr(0, bytes_.find_first_of(" \t\r\n"));
    bytes_.remove_prefix(word.size());
    return ParseCoordinate(word);
  }

  template <class T>
  T Take() {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data(), raw.size());
    if (encoding_ == Encoding::kBig) std::reverse(raw.begin(), raw.end());
    bytes_.remove_prefix(raw.size());
    T value;
    std::memcpy(&value, raw.data(), raw.size());
    return value;
  }

  std::optional<double> NextBinary(Type type) {
    if (bytes_.size() < SizeOf(type)) return std::nullopt;
    switch (type) {
      case Type::kInt8:
        return Take<std::int8_t>();
      case Type::kUint8:
        return Take<std::uint8_t>();
      case Type::kInt16:
        return Take<std::int16_t>();
      case Type::kUint16:
        return Take<std::uint16_t>();
      case Type::kInt32:
        return Take<std::int32_t>();
      case Type::kUint32:
        return Take<std::uint32_t>();
      case Type::kFloat32:
        return Take<float>();
      case Type::kFloat64:
        return Take<double>();
    }
    return std::nullopt;
  }

  std::string_view bytes_;
  Encoding encoding_;
  std::size_t line_number_;
};

// Reads the elements in their order; vertices and faces are kept, the rest is skipped.
class BodyReader {
 public:
  BodyReader(ValueReader values, const std::string& what) : values_(values), what_(what) {}

  Result<TriangleMesh> Read(const Header& header) {
    for (const Element& element : header.elements) {
      RETURN_IF_ERROR(CheckCount(element));
      for (std::uint64_t i = 0; i < element.count; ++i) RETURN_IF_ERROR(ReadRecord(element));
    }
    for (const auto& face : mesh_.faces) {
      for (const std::uint32_t vertex : face) {
        if (vertex >= mesh_.vertices.size()) {
          return FailRead(what_, fmt::format("a face names vertex {} of {}", vertex, mesh_.vertices.size()));
        }
      }
    }
    return std::move(mesh_);
  }

 private:
  Status CheckCount(const Element& element) const {
    std::size_t smallest = 0;
    for (const Property& property : element.properties) {
      smallest += values_.SmallestSize(property.list_count.value_or(property.type));
    }
    if (element.count == 0) return {};
    if (smallest == 0 || element.count > values_.remaining() / smallest) {
      return FailRead(what_, fmt::format("{} records '{}' announced, but {} bytes left", element.count,
                                         Shown(element.name), values_.remaining()));
    }
    return {};
  }

  Status ReadRecord(const Element& element) {
    const bool is_vertex = element.name == "vertex";
    Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
    for (const Property& property : element.properties) {
      if (property.list_count) {
        RETURN_IF_ERROR(ReadList(element, property));
        continue;
      }
      const auto value = values_.Next(property.type);
      if (!value) return FailRead(what_, values_.Place() + ": a number of '" + Shown(property.name) + "' is missing");
      if (!is_vertex) continue;
      const std::size_t axis = std::string_view("xyz").find(property.name);
      if (property.name.size() == 1 && axis != std::string_view::npos) vertex[static_cast<Eigen::Index>(axis)] = *value;
    }
    if (!is_vertex) return {};
    // allFinite first: maxCoeff passes over a NaN.
    if (!vertex.allFinite() || vertex.cwiseAbs().maxCoeff() > kLargestCoordinate) {
      return FailRead(what_, fmt::format("vertex {} has a coordinate that is not a number or too large",
                                         mesh_.vertices.size() + 1));
    }
    mesh_.vertices.push_back(vertex);
    return {};
  }

  Status ReadList(const Element& element, const Property& property) {
    const auto count = values_.Next(*property.list_count);
    const std::size_t most = values_.remaining() / values_.SmallestSize(property.type) + 1;
    if (!count || !(*count >= 0.0 && *count <= static_cast<double>(most))) {
      return FailRead(what_, values_.Place() + ": the length of a list does not fit the file");
    }
    const bool is_face =
        element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < static_cast<std::size_t>(*count); ++i) {
      const auto value = values_.Next(property.type);
      if (!value) return FailRead(what_, values_.Place() + ": a list is cut short or holds what is no number");
      if (!is_face) continue;
      if (!(*value >= 0.0 && *value < 4294967295.0 && *value == std::floor(*value))) {
        return FailRead(what_, values_.Place() + fmt::format(": {} is no vertex number", *value));
      }
      corners.push_back(static_cast<std::uint32_t>(*value));
    }
    if (is_face && corners.size() < 3) {
      return FailRead(what_, values_.Place() + fmt::format(": a face of {} corners", corners.size()));
    }
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      mesh_.faces.push_back({corners[0], corners[i], corners[i + 1]});
    }
    return {};
  }

  ValueReader values_;
  const std::string& what_;
  TriangleMesh mesh_;
};

bool HasCoordinates(const Header& header) {
  for (const Element& element : header.elements) {
    if (element.name != "vertex") continue;
    const auto has = [&element](std::string_view name) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [name](const Property& p) { return p.name == name && !p.list_count; });
    };
    return has("x") && has("y") && has("z");
  }
  return false;
}

}  // namespace

Result<TriangleMesh> ParsePly(std::string_view bytes, const std::string& what) {
  LineReader lines(bytes);
  if (lines.Next() != "ply") return FailRead(what, "line 1: not 'ply'");
  Header header;
  while (true) {
    const auto line = lines.Next();
    if (!line) return FailRead(what, fmt::format("line {}: the header has no end", lines.line_number()));
    const std::vector<std::string_view> words = SplitWords(*line);
    if (words.empty()) continue;
    if (words[0] == "end_header") break;
    const std::string wrong = TakeHeaderLine(words, header);
    if (!wrong.empty()) {
      return FailRead(what, fmt::format("line {}: '{}': {}", lines.line_number(), Shown(*line), wrong));
    }
  }
  if (!HasCoordinates(header)) return FailRead(what, "no element 'vertex' with x, y and z");
  return BodyReader(ValueReader(lines.rest(), header.encoding, lines.line_number() + 1), what).Read(header);
}

}  // namespace annulus::mesh_readers
