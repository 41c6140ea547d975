#include "modeling/glasses/frame_library.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/ensure.h"
#include "modeling/glasses/design_json.h"
#include "modeling/glasses/frame_library_data.h"
#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus-frame-library";
constexpr const char* kAdvice = "correct the file; 'annulus glasses design --list --json -' shows one that is right";

/// What sizes of spectacles are possible, mm.
struct SizeNumber {
  const char* key;
  double SoldSize::*member;
  double low;
  double high;
};
constexpr std::array<SizeNumber, 3> kSizeNumbers{{{"a_mm", &SoldSize::a, 20.0, 90.0},
                                                  {"dbl_mm", &SoldSize::dbl, 8.0, 40.0},
                                                  {"temple_mm", &SoldSize::temple, 80.0, 180.0}}};
constexpr double kLowestLens = 12.0;

Result<SoldSize> ReadSize(const JsonReader& reader, const Json& object) {
  if (!object.is_object()) return reader.Refuse(reader.Named("") + " is no object");
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"name", "a_mm", "b_mm", "dbl_mm", "temple_mm"}));
  SoldSize size;
  const Result<std::string> name = reader.Text(object, "name");
  if (!name) return Fail(name);
  size.name = *name;
  for (const SizeNumber& number : kSizeNumbers) {
    const Result<double> value = reader.Number(object, number.key);
    if (!value) return Fail(value);
    size.*number.member = *value;
  }
  if (object.contains("b_mm")) {
    const Result<double> value = reader.Number(object, "b_mm");
    if (!value) return Fail(value);
    size.b = *value;
  }
  if (const Status valid = Validate(size); !valid) return reader.Refuse(reader.Named("") + ": " + valid.error().seen);
  return size;
}

Result<std::vector<SoldSize>> ReadSizes(const JsonReader& reader, const Json& object) {
  std::vector<SoldSize> sizes;
  if (!object.contains("sizes")) return sizes;
  const Result<const Json*> array = reader.Array(object, "sizes");
  if (!array) return Fail(array);
  for (std::size_t k = 0; k < (*array)->size(); ++k) {
    const JsonReader inside = reader.Within(fmt::format("sizes[{}]", k));
    Result<SoldSize> size = ReadSize(inside, (**array)[k]);
    if (!size) return Fail(size);
    const auto same = [&size](const SoldSize& other) { return other.name == size->name; };
    if (size->name.empty() || std::any_of(sizes.begin(), sizes.end(), same)) {
      return reader.Refuse(fmt::format("{} is empty or there twice", inside.Named("name")));
    }
    sizes.push_back(*std::move(size));
  }
  return sizes;
}

Result<LibraryStyle> ReadLibraryStyle(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"name", "description", "material", "parameters", "details", "sizes"}));
  LibraryStyle style;
  const Result<std::string> description = reader.Text(object, "description");
  if (!description) return Fail(description);
  style.description = *description;
  const auto material = ReadMaterial(reader, object);
  if (!material) return Fail(material);
  style.material = material->value_or(DesignMaterial::kAcetate);
  const Result<FrameDesign> design = ReadDesign(reader, object);
  if (!design) return Fail(design);
  style.design = *design;
  Result<std::vector<SoldSize>> sizes = ReadSizes(reader, object);
  if (!sizes) return Fail(sizes);
  style.sizes = *std::move(sizes);
  return style;
}

Json SizeToJson(const SoldSize& size) {
  Json json{{"name", size.name}, {"a_mm", size.a}};
  if (size.b) json["b_mm"] = *size.b;
  json["dbl_mm"] = size.dbl;
  json["temple_mm"] = size.temple;
  return json;
}

Json StyleToJson(const LibraryStyle& style) {
  Json json{{"name", style.name}, {"description", style.description}};
  FrameDesign shape = style.design;
  shape.style.clear();  // the entry's name says it
  PutDesign(json, shape, style.material);
  for (const SoldSize& size : style.sizes) json["sizes"].push_back(SizeToJson(size));
  return json;
}

}  // namespace

Status Validate(const SoldSize& size) {
  const auto check = [](const char* key, double value, double low, double high) -> Status {
    if (value >= low && value <= high) return {};
    return Fail("check the size", fmt::format("{} is {} mm", key, value),
                fmt::format("choose {} from {} to {} mm", key, low, high));
  };
  for (const SizeNumber& number : kSizeNumbers) {
    RETURN_IF_ERROR(check(number.key, size.*number.member, number.low, number.high));
  }
  return check("b_mm", size.b.value_or(size.a), kLowestLens, kSizeNumbers[0].high);
}

const SoldSize* LibraryStyle::Size(std::string_view size_name) const {
  for (const SoldSize& size : sizes) {
    if (size.name == size_name) return &size;
  }
  return nullptr;
}

Result<const LibraryStyle*> FrameLibrary::Find(std::string_view name) const {
  std::string known;
  for (const LibraryStyle& style : styles) {
    if (style.name == name) return &style;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", style.name);
  }
  return Fail("choose a frame style", fmt::format("there is no style '{}'", name), "choose one of " + known);
}

const FrameLibrary& BuiltInFrameLibrary() {
  static const FrameLibrary library = [] {
    Result<FrameLibrary> read = FrameLibraryFromJson(BuiltInFrameLibraryJson(), "the built-in library");
    ENSURE(read.has_value(), read ? "" : read.error().Text());
    return *std::move(read);
  }();
  return library;
}

Result<FrameLibrary> FrameLibraryFromJson(std::string_view json, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const Result<Json> root = reader.Root(json);
  if (!root) return Fail(root);
  RETURN_IF_ERROR(reader.Version(*root, kFormat, 1));
  RETURN_IF_ERROR(reader.OnlyKeys(*root, {"format", "version", "styles"}));
  const Result<const Json*> array = reader.Array(*root, "styles");
  if (!array) return Fail(array);
  FrameLibrary library;
  for (std::size_t k = 0; k < (*array)->size(); ++k) {
    const Json& object = (**array)[k];
    const std::string place = fmt::format("styles[{}]", k);
    if (!object.is_object()) return reader.Refuse(reader.Named(place) + " is no object");
    const Result<std::string> style_name = reader.Within(place).Text(object, "name");
    if (!style_name) return Fail(style_name);
    if (style_name->empty() || library.Find(*style_name)) {
      return reader.Refuse(
          fmt::format("{} '{}' is empty or there twice", reader.Within(place).Named("name"), *style_name));
    }
    Result<LibraryStyle> style = ReadLibraryStyle(reader.Within(fmt::format("{} ({})", place, *style_name)), object);
    if (!style) return Fail(style);
    style->name = *style_name;
    style->design.style = *style_name;
    library.styles.push_back(*std::move(style));
  }
  if (library.styles.empty()) return reader.Refuse("'styles' is empty");
  return library;
}

std::string FrameLibraryToJson(const FrameLibrary& library) {
  Json root{{"format", kFormat}, {"version", 1}, {"styles", Json::array()}};
  for (const LibraryStyle& style : library.styles) root["styles"].push_back(StyleToJson(style));
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

FrameLibrary Merged(FrameLibrary first, const FrameLibrary& second) {
  for (const LibraryStyle& style : second.styles) {
    if (!first.Find(style.name)) first.styles.push_back(style);
  }
  return first;
}

}  // namespace annulus
