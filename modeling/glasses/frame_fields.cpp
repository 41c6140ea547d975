#include "modeling/glasses/frame_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

using Words = std::span<const std::string_view>;

// In the order of their enums.
constexpr std::array<std::string_view, 3> kRimWords{"full", "half", "rimless"};
constexpr std::array<std::string_view, 3> kBridgeWords{"straight", "saddle", "keyhole"};
constexpr std::array<std::string_view, 3> kPadWords{"none", "fixed", "adjustable"};
constexpr std::array<std::string_view, 3> kTempleWords{"paper", "skull", "straight"};
constexpr std::array<std::string_view, 2> kHingeWords{"none", "barrel"};

// The paper's sliders "thick ⇔ thin", "large ⇔ small", "high ⇔ low". Its examples 1–3 are middle, example 4 is slightly
// thick above and quite thin below.
constexpr std::array<NamedShare, 5> kThicknessWords{{{"quite thin", 0.025},
                                                     {"slightly thin", 0.04},
                                                     {"middle", 0.05},
                                                     {"slightly thick", 0.075},
                                                     {"quite thick", 0.1}}};
constexpr std::array<NamedShare, 5> kHeightWords{
    {{"quite small", 0.6}, {"slightly small", 0.7}, {"middle", 0.8}, {"slightly large", 0.9}, {"quite large", 1.0}}};
constexpr std::array<NamedShare, 5> kBridgeHeightWords{
    {{"quite low", 0.4}, {"slightly low", 0.5}, {"middle", 0.6}, {"slightly high", 0.68}, {"quite high", 0.75}}};

std::span<const NamedShare> CornerWords() {
  static const std::vector<NamedShare> words = [] {
    std::vector<NamedShare> all;
    all.reserve(kRoundnessWords.size());
    for (const Roundness word : kRoundnessWords) all.push_back({RoundnessWord(word), RoundnessShare(word)});
    return all;
  }();
  return words;
}

FrameField ParameterField(const FrameParameterField& paper) {
  FrameField field{paper.option, paper.key, FieldUnit::kMillimetres, paper.member, 0.5, 20.0, paper.description, {}};
  if (paper.member == &FrameParameters::width) {
    field.low = 30.0;
    field.high = 70.0;
  } else if (paper.member == &FrameParameters::height) {
    field.low = 20.0;
    field.high = 60.0;
    field.words = kHeightWords;
  } else if (paper.member == &FrameParameters::bridge_height) {
    field.low = 10.0;
    field.high = 45.0;
    field.words = kBridgeHeightWords;
    field.word_base = WordBase::kHeight;
  } else if (paper.member == &FrameParameters::upper_thickness || paper.member == &FrameParameters::lower_thickness) {
    field.low = 1.0;
    field.high = 8.0;
    field.words = kThicknessWords;
  } else {
    field.words = CornerWords();
    field.word_base = WordBase::kShorter;
  }
  return field;
}

template <class Member>
FrameField Form(std::string_view name, Member member, std::string_view description) {
  return {name, name, FieldUnit::kWord, member, 0.0, 0.0, description, {}};
}

template <class Member>
FrameField Length(std::string_view option, std::string_view key, Member member, std::array<double, 2> slider,
                  std::string_view description) {
  return {option, key, FieldUnit::kMillimetres, member, slider[0], slider[1], description, {}};
}

std::vector<FrameField> MakeFields() {
  using D = FrameDetails;
  std::vector<FrameField> fields;
  for (const FrameParameterField& paper : FrameParameterFields()) fields.push_back(ParameterField(paper));
  // Size first: the other fields' shares are taken of it.
  std::stable_partition(fields.begin(), fields.end(),
                        [](const FrameField& f) { return f.option == "width" || f.option == "height"; });
  const std::vector<FrameField> details{
      Form("rim", &D::rim,
           "how the rim holds its lens: all round, its upper half, or bridge and temples on the lenses"),
      Form("bridge", &D::bridge, "form of the bridge: the paper's tube, a smooth saddle, or a keyhole"),
      Form("pads", &D::pads, "nose pads: none, part of the rims, or on wire arms"),
      Form("temple", &D::temple, "form behind the ear: the paper's, bent down along the skull, or straight"),
      Form("hinge", &D::hinge, "none (temples in one piece with the rim) or three barrels"),
      Length("bridge-gap", "bridge_gap_mm", &D::bridge_gap, {8, 30},
             "l0, distance between the centre lines' rectangles (paper: l1/5)"),
      Length("depth", "depth_mm", &D::depth, {1.5, 8},
             "s, front to back of the control polygon; the solid has 0.75 of it (paper: l1/20)"),
      Length("arm-height", "arm_height_mm", &D::arm_height, {10, 45},
             "height of the temples over the lower edge (paper: the bridge's)"),
      Length("arm-width", "arm_width_mm", &D::arm_width, {1, 12}, "height of a temple at the rim (paper: d1)"),
      Length("groove-depth", "groove_depth_mm", &D::groove_depth, {0, 1.2},
             "depth of the groove for the lens; 0: none"),
      Length("groove-width", "groove_width_mm", &D::groove_width, {0, 2.5}, "opening of the groove for the lens"),
      Length("bridge-forward", "bridge_forward_mm", &D::bridge_forward, {-3, 12},
             "how far a saddle's or keyhole's middle stands before its ends"),
      Length("bridge-rise", "bridge_rise_mm", &D::bridge_rise, {-3, 12},
             "how far a saddle's or keyhole's middle is over its ends"),
      Length("lens-edge", "lens_edge_mm", &D::lens_edge, {1, 12},
             "edge of the lens that a rimless mount's screw goes through"),
      {"frame-curve",
       "frame_curve_dpt",
       FieldUnit::kDioptres,
       &D::frame_curve,
       0.0,
       8.0,
       "base curve that the front follows, dioptres at n = 1.53; 0: flat",
       {}},
      {"face-form",
       "face_form_deg",
       FieldUnit::kDegrees,
       &D::face_form,
       0.0,
       25.0,
       "wrap: angle between a rim's plane and the front's, degrees",
       {}},
      Length("end-piece", "end_piece_mm", &D::end_piece, {0, 10}, "length from the rim to the hinge; needs a hinge"),
      Length("temple-outset", "temple_outset_mm", &D::temple_outset, {0, 8},
             "how much further out the temples' corners stand than beside the rim, for a wide head"),
      Length("tip-length", "tip_length_mm", &D::tip_length, {25, 55}, "length of a skull or straight temple's tip"),
      {"tip-drop",
       "tip_drop_deg",
       FieldUnit::kDegrees,
       &D::tip_drop,
       0.0,
       60.0,
       "angle by which the tip bends down, degrees; 0: what is usual for the temple's form",
       {}},
      Length("pad-length", "pad_length_mm", &D::pad_length, {8, 18}, "length of a nose pad"),
      Length("pad-width", "pad_width_mm", &D::pad_width, {4, 10}, "width of a nose pad")};
  fields.insert(fields.end(), details.begin(), details.end());
  return fields;
}

Words WordsOf(RimForm /*form*/) { return kRimWords; }
Words WordsOf(BridgeForm /*form*/) { return kBridgeWords; }
Words WordsOf(PadForm /*form*/) { return kPadWords; }
Words WordsOf(TempleForm /*form*/) { return kTempleWords; }
Words WordsOf(HingeForm /*form*/) { return kHingeWords; }

template <class Design, class Value>
auto& At(Design& design, Value FrameParameters::*member) {
  return design.parameters.*member;
}
template <class Design, class Value>
auto& At(Design& design, Value FrameDetails::*member) {
  return design.details.*member;
}

/// Calls `use` with the field's value in `design`.
template <class Design, class Use>
auto Visit(const FrameField& field, Design& design, Use use) {
  return std::visit([&](auto member) { return use(At(design, member)); }, field.member);
}

double BaseOf(WordBase base, const FrameParameters& p) {
  switch (base) {
    case WordBase::kWidth:
      return p.width;
    case WordBase::kShorter:
      return std::min(p.width, p.height);
    case WordBase::kHeight:
      return p.height;
  }
  ENSURE(false, "every base is known");
}

std::string Spaced(std::string_view text) {
  std::string spaced(text);
  std::replace(spaced.begin(), spaced.end(), '-', ' ');
  return spaced;
}

/// A word or "12.5", for lengths also "25%" of l1; in the field's unit. Empty if it is none of these.
std::optional<double> ParseNumber(const FrameField& field, const FrameParameters& p, std::string_view text) {
  for (const NamedShare& named : field.words) {
    if (Spaced(text) == named.word) return named.share * BaseOf(field.word_base, p);
  }
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  if (stop == end) return value;
  if (stop + 1 == end && *stop == '%' && field.unit == FieldUnit::kMillimetres) return value / 100.0 * p.width;
  return std::nullopt;
}

FrameDesign AsInThePaper(const FrameField& field, FrameDesign design) {
  const FrameDesign paper;
  std::visit([&](auto member) { At(design, member) = At(paper, member); }, field.member);
  return design;
}

std::string AdviceFor(const FrameField& field) {
  if (field.unit == FieldUnit::kWord) return fmt::format("choose one of {}", fmt::join(FormWords(field), ", "));
  const char* paper = IsParameter(field) ? "" : ", or 'paper' for what the paper has";
  if (field.unit == FieldUnit::kDegrees) return fmt::format("give degrees{}", paper);
  if (field.unit == FieldUnit::kDioptres) return fmt::format("give dioptres{}", paper);
  if (field.words.empty()) return fmt::format("give mm or a percentage of the width such as 80%{}", paper);
  return fmt::format("give mm, a percentage of the width such as 16%, or a word from '{}' to '{}'{}",
                     field.words.front().word, field.words.back().word, paper);
}

}  // namespace

std::span<const FrameField> FrameFields() {
  static const std::vector<FrameField> fields = MakeFields();
  return fields;
}

const FrameField* FindFrameField(std::string_view option) {
  for (const FrameField& field : FrameFields()) {
    if (field.option == option) return &field;
  }
  return nullptr;
}

bool IsParameter(const FrameField& field) { return std::holds_alternative<double FrameParameters::*>(field.member); }

Words FormWords(const FrameField& field) {
  const FrameDesign any;
  return Visit(field, any, [](const auto& value) -> Words {
    if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(value)>>) {
      return WordsOf(value);
    } else {
      return {};
    }
  });
}

std::optional<double> StoredNumber(const FrameField& field, const FrameDesign& design) {
  return Visit(field, design, [](const auto& value) -> std::optional<double> {
    if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(value)>>) {
      return std::nullopt;
    } else {
      return value;
    }
  });
}

std::optional<double> ShownNumber(const FrameField& field, const FrameDesign& design) {
  const std::optional<double> stored = StoredNumber(field, design);
  return stored && field.unit == FieldUnit::kDegrees ? DegreesFromRadians(*stored) : stored;
}

std::string_view FormWord(const FrameField& field, const FrameDesign& design) {
  return Visit(field, design, [](const auto& value) -> std::string_view {
    if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(value)>>) {
      return WordsOf(value)[static_cast<std::size_t>(value)];
    } else {
      ENSURE(false, "a field of words");
    }
  });
}

FrameDesign WithStoredNumber(const FrameField& field, FrameDesign design, double number) {
  Visit(field, design, [number](auto& value) {
    if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(value)>>) {
      ENSURE(false, "a field of numbers");
    } else {
      value = number + 0.0;  // no negative zero: it would not survive a file that leaves zeros out
    }
  });
  return design;
}

std::optional<FrameDesign> WithFormWord(const FrameField& field, FrameDesign design, std::string_view word) {
  const bool known = Visit(field, design, [word](auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_enum_v<Value>) {
      const Words words = WordsOf(value);
      const auto found = std::find(words.begin(), words.end(), word);
      if (found == words.end()) return false;
      value = static_cast<Value>(found - words.begin());
      return true;
    }
    return false;
  });
  return known ? std::optional(std::move(design)) : std::nullopt;
}

Result<FrameDesign> WithField(const FrameDesign& design, std::string_view option, std::string_view text) {
  const std::string attempt = fmt::format("set the frame's {}", option);
  const FrameField* const field = FindFrameField(option);
  if (field == nullptr) return Fail(attempt, "there is no such field", "see annulus glasses design --help");
  if (text == "paper" && !IsParameter(*field) && field->unit != FieldUnit::kWord) {
    return AsInThePaper(*field, design);
  }
  if (field->unit == FieldUnit::kWord) {
    if (auto changed = WithFormWord(*field, design, text)) return *std::move(changed);
    return Fail(attempt, fmt::format("there is no form '{}'", text), AdviceFor(*field));
  }
  const std::optional<double> value = ParseNumber(*field, design.parameters, text);
  if (!value || (*value < 0.0 && field->low >= 0.0) || (*value == 0.0 && IsParameter(*field))) {
    return Fail(attempt, fmt::format("'{}' is not a {}", text, IsParameter(*field) ? "positive length" : "size"),
                AdviceFor(*field));
  }
  if (field->option == "width") return ScaledToWidth(design, *value);
  return WithStoredNumber(*field, design, field->unit == FieldUnit::kDegrees ? RadiansFromDegrees(*value) : *value);
}

std::string_view NearestWord(const FrameField& field, const FrameDesign& design) {
  const std::optional<double> number = StoredNumber(field, design);
  if (!number || field.words.empty()) return {};
  const double share = *number / BaseOf(field.word_base, design.parameters);
  const auto nearer = [share](const NamedShare& a, const NamedShare& b) {
    return std::abs(a.share - share) < std::abs(b.share - share);
  };
  return std::min_element(field.words.begin(), field.words.end(), nearer)->word;
}

std::string FieldSyntax(const FrameField& field) {
  switch (field.unit) {
    case FieldUnit::kWord:
      return fmt::format("{}", fmt::join(FormWords(field), "|"));
    case FieldUnit::kDegrees:
      return "DEGREES";
    case FieldUnit::kDioptres:
      return "DIOPTRES";
    case FieldUnit::kMillimetres:
      return field.words.empty() ? "MM|PERCENT" : "MM|PERCENT|WORD";
  }
  ENSURE(false, "every unit is known");
}

}  // namespace annulus
