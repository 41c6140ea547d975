#include "render/colour_choice.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <vector>

#include "base/ensure.h"
#include "base/units.h"
#include "render/hvc.h"

namespace annulus {
namespace {

constexpr std::string_view kAttempt = "read a colour";

std::string Quoted(std::string_view text) { return "'" + std::string(text) + "'"; }

/// All of it as one finite number.
std::optional<double> NumberOf(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string_view> SplitAtCommas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

/// "key:rest"; the key is empty if there is no colon.
struct Named {
  std::string_view key;
  std::string_view rest;
};
Named NamedPart(std::string_view part) {
  const std::size_t colon = part.find(':');
  if (colon == std::string_view::npos) return {{}, part};
  return {part.substr(0, colon), part.substr(colon + 1)};
}

std::string SampleNames() {
  std::string names;
  for (const SampleColour& sample : SampleColours()) names += (names.empty() ? "" : ", ") + std::string(sample.name);
  return names;
}

Result<LinearRgb> SampleOf(std::string_view name) {
  const auto& samples = SampleColours();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (name == samples[k].name || name == std::to_string(k + 1)) return LinearFromHex(samples[k].rrggbb);
  }
  return Fail(std::string(kAttempt), Quoted(name) + " is no sample colour",
              "the samples are " + SampleNames() + ", or 1 to " + std::to_string(samples.size()));
}

/// Three numbers of these ranges from the first part's rest and the two parts after it.
struct Triple {
  std::string_view kind;
  std::array<double, 3> highest;
  const char* allowed;
};

Result<std::array<double, 3>> NumbersOf(const Triple& triple, const std::array<std::string_view, 3>& texts) {
  std::array<double, 3> numbers{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<double> number = NumberOf(texts[k]);
    if (!number || !(*number >= 0.0 && *number <= triple.highest[k])) {
      return Fail(std::string(kAttempt), Quoted(texts[k]) + " in '" + std::string(triple.kind) + ":…' is out of place",
                  triple.allowed);
    }
    numbers[k] = *number;
  }
  return numbers;
}

constexpr std::array<Triple, 3> kTriples = {
    {{"rgb", {255.0, 255.0, 255.0}, "write rgb:R,G,B with three numbers of 0 to 255"},
     {"hvc", {100.0, 10.0, 60.0}, "write hvc:HUE,VALUE,CHROMA with 0 to 100 (5 is 5R), 0 to 10 and 0 to 60"},
     {"linear", {1.0, 1.0, 1.0}, "write linear:R,G,B with three numbers of 0 to 1"}}};

LinearRgb ColourOf(const Triple& triple, const std::array<double, 3>& n) {
  if (triple.kind == "hvc") return ShownRgb({n[0] * kPi / 50.0, n[1], n[2]});
  if (triple.kind == "linear") return Eigen::Vector3d(n[0], n[1], n[2]).cast<float>();
  return Eigen::Vector3d(LinearFromSrgb(n[0] / 255.0), LinearFromSrgb(n[1] / 255.0), LinearFromSrgb(n[2] / 255.0))
      .cast<float>();
}

/// A colour and how many of the parts said it.
struct Base {
  LinearRgb colour;
  std::size_t parts = 1;
};

Result<Base> BaseOf(const std::vector<std::string_view>& parts) {
  const Named named = NamedPart(parts.front());
  if (named.key.empty() && named.rest.starts_with('#')) {
    const Result<LinearRgb> colour = ParseHexColour(named.rest);
    if (!colour) return Fail(colour);
    return Base{*colour};
  }
  if (named.key == "sample") {
    const Result<LinearRgb> colour = SampleOf(named.rest);
    if (!colour) return Fail(colour);
    return Base{*colour};
  }
  if (named.key == "bar") {
    const std::optional<double> position = NumberOf(named.rest);
    if (!position || !(*position >= 0.0 && *position <= 1.0)) {
      return Fail(std::string(kAttempt), Quoted(named.rest) + " is no place on the colour bar",
                  "write bar:P with P of 0 to 1");
    }
    return Base{ColourBar(*position)};
  }
  for (const Triple& triple : kTriples) {
    if (named.key != triple.kind) continue;
    if (parts.size() < 3) {
      return Fail(std::string(kAttempt), Quoted(parts.front()) + " has less than three numbers", triple.allowed);
    }
    const auto numbers = NumbersOf(triple, {named.rest, parts[1], parts[2]});
    if (!numbers) return Fail(numbers);
    return Base{ColourOf(triple, *numbers), 3};
  }
  return Fail(std::string(kAttempt), Quoted(parts.front()) + " is no colour",
              "write #rrggbb, sample:NAME, bar:P, rgb:R,G,B, hvc:H,V,C or linear:R,G,B");
}

Result<LinearRgb> Changed(const LinearRgb& colour, std::string_view change) {
  const Named named = NamedPart(change);
  const bool is_known = named.key == "brighter" || named.key == "vivid";
  const std::optional<double> share = NumberOf(named.rest);
  if (!is_known || !share || !(*share >= -1.0 && *share <= 1.0)) {
    return Fail(std::string(kAttempt), Quoted(change) + " is no change of a colour",
                "write ,brighter:SHARE or ,vivid:SHARE with a share of -1 to 1");
  }
  return named.key == "brighter" ? Brightened(colour, *share) : Vivified(colour, *share);
}

/// The fewest digits that read back to the same float.
std::string FloatText(float value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  ENSURE(error == std::errc(), "a float has at most 32 characters");
  return {text.data(), end};
}

}  // namespace

const std::array<SampleColour, 8>& SampleColours() {
  static constexpr std::array<SampleColour, 8> kSamples = {{{"black", 0x161616},
                                                            {"brown", 0x4a2c1a},
                                                            {"amber", 0xb8722a},
                                                            {"red", 0x8c1c2c},
                                                            {"green", 0x1f6040},
                                                            {"blue", 0x20427e},
                                                            {"silver", 0xd4d4d2},
                                                            {"gold", 0xd9b56c}}};
  return kSamples;
}

LinearRgb ColourBar(double position) {
  ENSURE(position >= 0.0 && position <= 1.0, "a position of 0 … 1");
  const double red = HvcFromRgb(LinearRgb(1.0F, 0.0F, 0.0F)).hue;
  if (position == 0.0 || position == 1.0) return {1.0F, 0.0F, 0.0F};
  return PureColour(red + 2.0 * kPi * position);
}

Result<LinearRgb> ParseColourChoice(std::string_view text) {
  const std::vector<std::string_view> parts = SplitAtCommas(text);
  const Result<Base> base = BaseOf(parts);
  if (!base) return Fail(base);
  LinearRgb colour = base->colour;
  for (std::size_t k = base->parts; k < parts.size(); ++k) {
    const Result<LinearRgb> changed = Changed(colour, parts[k]);
    if (!changed) return Fail(changed);
    colour = *changed;
  }
  return colour;
}

std::string ColourText(const LinearRgb& colour) {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  std::uint32_t rrggbb = 0;
  std::string hex = "#";
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t byte = SrgbByteFromLinear(colour[k]);
    rrggbb = (rrggbb << 8U) | byte;
    hex += kDigits[byte >> 4U];
    hex += kDigits[byte & 15U];
  }
  if (LinearFromHex(rrggbb) == colour) return hex;
  return "linear:" + FloatText(colour[0]) + "," + FloatText(colour[1]) + "," + FloatText(colour[2]);
}

}  // namespace annulus
