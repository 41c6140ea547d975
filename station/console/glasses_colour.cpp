#include "station/console/glasses_colour.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/units.h"
#include "render/hvc.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kHueSteps = 100.0;  // Munsell's
constexpr double kMostChroma = 60.0;
constexpr double kSeenChroma = 0.05;  // less is nobody's loss

/// A colour, and whether chroma was lost on the way to it.
struct AskedColour {
  LinearRgb colour = LinearRgb::Zero();
  bool clipped = false;
};

tl::expected<AskedColour, ApiError> FromRgb(const nlohmann::json& rgb) {
  const char* const advice = "give three whole numbers of 0 … 255 (sRGB)";
  if (!rgb.is_array() || rgb.size() != 3) return BadField("rgb", "it is no list of three", advice);
  AskedColour asked;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!rgb[k].is_number_integer()) return BadField("rgb", "a channel is no whole number", advice);
    const auto channel = rgb[k].get<double>();
    if (!(channel >= 0.0 && channel <= 255.0)) return BadField("rgb", "a channel is " + rgb[k].dump(), advice);
    asked.colour[static_cast<Eigen::Index>(k)] = static_cast<float>(LinearFromSrgb(channel / 255.0));
  }
  return asked;
}

tl::expected<AskedColour, ApiError> FromHvc(const nlohmann::json& hvc) {
  if (!hvc.is_object()) return BadField("hvc", "it is no object", "give {hue, value, chroma}");
  if (const auto known = OnlyKeys(hvc, {"hue", "value", "chroma"}); !known) {
    return BadField("hvc." + known.error().field, known.error().error);
  }
  const std::array<std::pair<const char*, double>, 3> members{
      {{"hue", kHueSteps}, {"value", 10.0}, {"chroma", kMostChroma}}};
  std::array<double, 3> numbers{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto number = NumberField(hvc, members[k].first, 0.0, members[k].second);
    if (!number) return BadField("hvc." + number.error().field, number.error().error);
    numbers[k] = *number;
  }
  const double hue = numbers[0] * kTwoPi / kHueSteps;
  const double most = GreatestChroma(hue, numbers[1]);
  return AskedColour{ShownRgb({hue, numbers[1], numbers[2]}), numbers[2] > most + kSeenChroma};
}

tl::expected<AskedColour, ApiError> Changed(AskedColour asked, const nlohmann::json& change) {
  if (!change.is_object()) return BadField("change", "it is no object", "give {value, chroma}, each -1 … 1");
  if (const auto known = OnlyKeys(change, {"value", "chroma"}); !known) {
    return BadField("change." + known.error().field, known.error().error);
  }
  const auto value = NumberOr(change, "value", 0.0, -1.0, 1.0);
  if (!value) return BadField("change.value", value.error().error);
  const auto chroma = NumberOr(change, "chroma", 0.0, -1.0, 1.0);
  if (!chroma) return BadField("change.chroma", chroma.error().error);
  if (*value != 0.0) {
    const double before = HvcFromRgb(asked.colour).chroma;
    asked.colour = Brightened(asked.colour, *value);
    asked.clipped = asked.clipped || HvcFromRgb(asked.colour).chroma < before - kSeenChroma;
  }
  if (*chroma != 0.0) asked.colour = Vivified(asked.colour, *chroma);
  return asked;
}

}  // namespace

ApiResult ColourAnswer(const ApiRequest& request) {
  const nlohmann::json& body = request.body;
  if (const auto known = OnlyKeys(body, {"rgb", "hvc", "change"}); !known) return tl::unexpected(known.error());
  if (body.contains("rgb") == body.contains("hvc")) {
    return BadField("rgb", "a colour is asked for in no way, or in two", "give either rgb or hvc");
  }
  auto asked = body.contains("rgb") ? FromRgb(body.at("rgb")) : FromHvc(body.at("hvc"));
  if (asked && body.contains("change")) asked = Changed(*asked, body.at("change"));
  if (!asked) return tl::unexpected(asked.error());
  const Hvc hvc = HvcFromRgb(asked->colour);
  double hue = hvc.hue * kHueSteps / kTwoPi;
  if (hue >= kHueSteps) hue = 0.0;
  return JsonAnswer({{"rgb",
                      {SrgbByteFromLinear(asked->colour[0]), SrgbByteFromLinear(asked->colour[1]),
                       SrgbByteFromLinear(asked->colour[2])}},
                     {"hvc", {{"hue", hue}, {"value", hvc.value}, {"chroma", hvc.chroma}}},
                     {"munsell", MunsellText(hvc)},
                     {"clipped", asked->clipped}});
}

}  // namespace annulus
