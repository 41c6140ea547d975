#include "station/console/glasses_catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "modeling/glasses/boxing.h"
#include "modeling/glasses/frame_fields.h"
#include "modeling/glasses/frame_parameters.h"
#include "render/colour_choice.h"
#include "render/environment.h"
#include "station/look_words.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kStep = 0.1;  // mm, degrees: finer than anybody sees

const char* UnitName(FieldUnit unit) {
  switch (unit) {
    case FieldUnit::kMillimetres:
      return "mm";
    case FieldUnit::kDegrees:
      return "deg";
    case FieldUnit::kDioptres:
      return "D";
    case FieldUnit::kWord:
      break;
  }
  return "";
}

Json FieldJson(const FrameField& field) {
  Json json{{"id", field.option}, {"label", field.description}, {"unit", UnitName(field.unit)}};
  if (field.unit == FieldUnit::kWord) {
    json["words"] = Json::array();
    for (const std::string_view word : FormWords(field)) json["words"].push_back(word);
    return json;
  }
  json["low"] = field.low;
  json["high"] = field.high;
  json["step"] = kStep;
  if (!field.words.empty()) json["low_word"] = field.words.front().word;
  if (!field.words.empty()) json["high_word"] = field.words.back().word;
  return json;
}

Json SizeJson(const SoldSize& size) {
  FrameBoxing boxing;
  boxing.a = size.a;
  boxing.dbl = size.dbl;
  return {{"id", size.name},    {"marking", SizeText(boxing, size.temple)},
          {"a_mm", size.a},     {"b_mm", size.b ? Json(*size.b) : Json()},
          {"dbl_mm", size.dbl}, {"temple_mm", size.temple}};
}

Json StyleJson(const LibraryStyle& style) {
  Json sizes = Json::array();
  for (const SoldSize& size : style.sizes) sizes.push_back(SizeJson(size));
  return {{"id", style.name},
          {"name", style.description},
          {"material", DesignMaterialWord(style.material)},
          {"sizes", sizes},
          {"design", {{"style", style.name}, {"size", ""}, {"fields", Json::object()}}},
          {"values", FieldValues(style.design)}};
}

template <class Value, std::size_t kCount>
Json WordsOf(const std::array<Word<Value>, kCount>& words) {
  Json list = Json::array();
  for (const Word<Value>& word : words) list.push_back(word.word);
  return list;
}

bool IsSlider(const FrameField& field) { return IsParameter(field) && field.option != "width"; }

Json Sliders() {
  Json sliders = Json::array();
  for (const FrameParameterField& paper : FrameParameterFields()) {
    const FrameField* const field = FindFrameField(paper.option);
    if (field != nullptr && IsSlider(*field)) sliders.push_back(FieldJson(*field));
  }
  return sliders;
}

}  // namespace

Json FieldValues(const FrameDesign& design) {
  Json values = Json::object();
  for (const FrameField& field : FrameFields()) {
    const auto number = ShownNumber(field, design);
    values[std::string(field.option)] = field.unit == FieldUnit::kWord ? Json(FormWord(field, design))
                                        : number                       ? Json(*number)
                                                                       : Json();
  }
  return values;
}

Json GlassesCatalogue(const FrameLibrary& library) {
  Json styles = Json::array();
  for (const LibraryStyle& style : library.styles) styles.push_back(StyleJson(style));
  Json details = Json::array();
  for (const FrameField& field : FrameFields()) {
    if (!IsSlider(field)) details.push_back(FieldJson(field));
  }
  Json colours = Json::array();
  for (const SampleColour& sample : SampleColours()) {
    colours.push_back({sample.rrggbb >> 16U & 0xffU, sample.rrggbb >> 8U & 0xffU, sample.rrggbb & 0xffU});
  }
  Json lights = Json::array();
  for (const std::string_view name : LightPresetNames()) lights.push_back(name);
  return {{"styles", styles},
          {"sliders", Sliders()},
          {"details", details},
          {"textures", WordsOf(kPatternWords)},
          {"finishes", WordsOf(kMaterialWords)},
          {"coatings", WordsOf(kCoatingWords)},
          {"colours", colours},
          {"lights", lights}};
}

}  // namespace annulus
