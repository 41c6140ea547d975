#include "station/look_file.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "base/ensure.h"
#include "modeling/glasses/json_reader.h"
#include "render/colour_choice.h"
#include "station/look_words.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus-look";
constexpr int kVersion = 1;
constexpr const char* kAdvice = "see LOOK.json in docs/formats.md";

struct Range {
  double low;
  double high;
};

/// Members of one object that may be left out: each leaves its target alone then. Keeps the first failure.
class Optional {
 public:
  Optional(const JsonReader& reader, const Json& object) : reader_(reader), object_(object) {}

  [[nodiscard]] const Status& status() const { return status_; }

  /// The number of a key, or `otherwise`.
  double Number(std::string_view key, Range range, double otherwise) {
    if (!IsToRead(key)) return otherwise;
    const Result<double> number = reader_.Number(object_, key);
    if (!number) {
      status_ = Fail(number);
      return otherwise;
    }
    if (*number >= range.low && *number <= range.high) return *number;
    Refuse(fmt::format("{} is {}, not {} … {}", reader_.Named(key), *number, range.low, range.high));
    return otherwise;
  }

  LinearRgb Colour(std::string_view key, const LinearRgb& otherwise) {
    if (!IsToRead(key)) return otherwise;
    const Result<std::string> text = reader_.Text(object_, key);
    if (!text) {
      status_ = Fail(text);
      return otherwise;
    }
    const Result<LinearRgb> colour = ParseColourChoice(*text);
    if (colour) return *colour;
    Refuse(fmt::format("{}: {}: {}", reader_.Named(key), colour.error().seen, colour.error().advice));
    return otherwise;
  }

  template <class Value, std::size_t kCount>
  Value OneOf(std::string_view key, const std::array<Word<Value>, kCount>& words, Value otherwise) {
    if (!IsToRead(key)) return otherwise;
    const Result<std::string> text = reader_.Text(object_, key);
    if (!text) {
      status_ = Fail(text);
      return otherwise;
    }
    std::string allowed;
    for (const auto& [word, value] : words) {
      if (word == *text) return value;
      allowed += (allowed.empty() ? "" : ", ") + std::string(word);
    }
    Refuse(fmt::format("{} is '{}', not one of {}", reader_.Named(key), *text, allowed));
    return otherwise;
  }

  /// Whether there is an object of that key.
  const Json* Object(std::string_view key) {
    if (!IsToRead(key)) return nullptr;
    const Result<const Json*> object = reader_.Object(object_, key);
    if (object) return *object;
    status_ = Fail(object);
    return nullptr;
  }

 private:
  [[nodiscard]] bool IsToRead(std::string_view key) const { return status_.has_value() && object_.contains(key); }
  void Refuse(std::string seen) { status_ = reader_.Refuse(std::move(seen)); }

  const JsonReader& reader_;
  const Json& object_;
  Status status_;
};

constexpr Range kShare{0.0, 1.0};
constexpr Range kScales{0.1, 10.0};
constexpr Range kPowers{-30.0, 30.0};
constexpr Range kSeeds{0.0, static_cast<double>(std::numeric_limits<std::uint32_t>::max())};

Result<Texture> ReadTexture(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"pattern", "scale", "seed", "second"}));
  Texture texture;
  Optional read(reader, object);
  texture.pattern = read.OneOf("pattern", kPatternWords, texture.pattern);
  texture.scale = static_cast<float>(read.Number("scale", kScales, static_cast<double>(texture.scale)));
  const double seed = read.Number("seed", kSeeds, texture.seed);
  texture.second = read.Colour("second", texture.second);
  RETURN_IF_ERROR(read.status());
  if (seed != std::floor(seed))
    return reader.Refuse(fmt::format("{} is {}, no whole number", reader.Named("seed"), seed));
  texture.seed = static_cast<std::uint32_t>(seed);
  return texture;
}

Result<PartLook> ReadPart(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"colour", "material", "texture"}));
  PartLook part;
  Optional read(reader, object);
  part.colour = read.Colour("colour", part.colour);
  part.finish = read.OneOf("material", kMaterialWords, part.finish);
  const Json* const texture_object = read.Object("texture");
  RETURN_IF_ERROR(read.status());
  if (texture_object != nullptr) {
    const Result<Texture> texture = ReadTexture(reader.Within("texture"), *texture_object);
    if (!texture) return Fail(texture);
    part.texture = *texture;
  }
  return part;
}

Result<LensLook> ReadLens(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(
      reader.OnlyKeys(object, {"tint", "transmittance", "lower_transmittance", "coating", "mirror_colour", "power_d"}));
  LensLook lens;
  Optional read(reader, object);
  lens.tint = read.Colour("tint", lens.tint);
  lens.transmittance = read.Number("transmittance", kShare, lens.transmittance);
  lens.lower_transmittance = read.Number("lower_transmittance", kShare, lens.transmittance);
  lens.coating = read.OneOf("coating", kCoatingWords, lens.coating);
  lens.mirror = read.Colour("mirror_colour", lens.mirror);
  lens.power = read.Number("power_d", kPowers, lens.power);
  RETURN_IF_ERROR(read.status());
  return lens;
}

Result<MakeUpLayer> ReadLayer(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"colour", "strength"}));
  MakeUpLayer layer;
  Optional read(reader, object);
  layer.colour = read.Colour("colour", layer.colour);
  layer.strength = read.Number("strength", kShare, layer.strength);
  RETURN_IF_ERROR(read.status());
  return layer;
}

struct NamedLayer {
  const char* key;
  MakeUpLayer MakeUp::*layer;
};
constexpr std::array<NamedLayer, 3> kLayers = {
    {{"lips", &MakeUp::lips}, {"cheeks", &MakeUp::cheeks}, {"brows", &MakeUp::brows}}};

Result<MakeUp> ReadMakeUp(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"lips", "cheeks", "brows"}));
  MakeUp make_up;
  for (const auto& [key, member] : kLayers) {
    if (!object.contains(key)) continue;
    const Result<const Json*> layer_object = reader.Object(object, key);
    if (!layer_object) return Fail(layer_object);
    const Result<MakeUpLayer> layer = ReadLayer(reader.Within(key), **layer_object);
    if (!layer) return Fail(layer);
    make_up.*member = *layer;
  }
  return make_up;
}

/// The shortest decimal of a float, so that 0.7 is not written as 0.699999988079071.
double ShortestDecimal(float value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  double decimal = 0.0;
  std::from_chars(text.data(), end, decimal);
  ENSURE(error == std::errc() && static_cast<float>(decimal) == value, "the decimal reads back to the same float");
  return decimal;
}

Json PartToJson(const PartLook& part) {
  const Texture& texture = part.texture;
  return {{"colour", ColourText(part.colour)},
          {"material", WordOf(kMaterialWords, part.finish)},
          {"texture",
           {{"pattern", WordOf(kPatternWords, texture.pattern)},
            {"scale", ShortestDecimal(texture.scale)},
            {"seed", texture.seed},
            {"second", ColourText(texture.second)}}}};
}

}  // namespace

std::string LookToJson(const Look& look) {
  Json root{{"format", kFormat}, {"version", kVersion}};
  root["upper"] = PartToJson(look.upper);
  root["lower"] = PartToJson(look.lower);
  root["lens"] = {{"tint", ColourText(look.lens.tint)},
                  {"transmittance", look.lens.transmittance},
                  {"lower_transmittance", look.lens.lower_transmittance},
                  {"coating", WordOf(kCoatingWords, look.lens.coating)},
                  {"mirror_colour", ColourText(look.lens.mirror)},
                  {"power_d", look.lens.power}};
  root["skin"] = ColourText(look.skin);
  for (const auto& [key, member] : kLayers) {
    const MakeUpLayer& layer = look.make_up.*member;
    root["make_up"][key] = {{"colour", ColourText(layer.colour)}, {"strength", layer.strength}};
  }
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Look> LookFromJson(std::string_view json, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const Result<Json> root = reader.Root(json);
  if (!root) return Fail(root);
  const Result<int> version = reader.Version(*root, kFormat, kVersion);
  if (!version) return Fail(version);
  RETURN_IF_ERROR(reader.OnlyKeys(*root, {"format", "version", "upper", "lower", "lens", "skin", "make_up"}));
  Look look;
  Optional read(reader, *root);
  look.skin = read.Colour("skin", look.skin);
  const Json* const upper = read.Object("upper");
  const Json* const lower = read.Object("lower");
  const Json* const lens = read.Object("lens");
  const Json* const make_up = read.Object("make_up");
  RETURN_IF_ERROR(read.status());
  if (upper != nullptr) {
    const auto part = ReadPart(reader.Within("upper"), *upper);
    if (!part) return Fail(part);
    look.upper = *part;
  }
  look.lower = look.upper;
  if (lower != nullptr) {
    const auto part = ReadPart(reader.Within("lower"), *lower);
    if (!part) return Fail(part);
    look.lower = *part;
  }
  if (lens != nullptr) {
    const auto read_lens = ReadLens(reader.Within("lens"), *lens);
    if (!read_lens) return Fail(read_lens);
    look.lens = *read_lens;
  }
  if (make_up != nullptr) {
    const auto layers = ReadMakeUp(reader.Within("make_up"), *make_up);
    if (!layers) return Fail(layers);
    look.make_up = *layers;
  }
  return look;
}

}  // namespace annulus
