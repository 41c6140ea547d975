#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "base/result.h"
#include "modeling/glasses/frame_design.h"

namespace annulus {

/// How the value of a field is shown and written.
enum class FieldUnit {
  kMillimetres,
  kDegrees,   ///< Inside: rad.
  kDioptres,  ///< Base curve at n = 1.53.
  kWord,      ///< One of a few words.
};

/// A word for a number: `share` of the field's WordBase.
struct NamedShare {
  std::string_view word;
  double share;
};

/// What a field's words and percentages are shares of.
enum class WordBase {
  kWidth,    ///< l1.
  kShorter,  ///< min(l1, l2).
  kHeight,   ///< l2.
};

/// A member of FrameParameters or FrameDetails.
using FieldMember =
    std::variant<double FrameParameters::*, double FrameDetails::*, std::optional<double> FrameDetails::*,
                 RimForm FrameDetails::*, BridgeForm FrameDetails::*, PadForm FrameDetails::*,
                 TempleForm FrameDetails::*, HingeForm FrameDetails::*>;

/// One thing that can be chosen of a frame: shared by the command line, the files, the documentation and the web page.
struct FrameField {
  std::string_view option;  ///< "groove-depth": the command line's --groove-depth.
  std::string_view key;     ///< "groove_depth_mm" in files; carries the unit.
  FieldUnit unit;
  FieldMember member;
  double low;   ///< What a slider offers, in `unit`: the usual range, not the permitted one (Validate). 0 for words.
  double high;  ///< As `low`.
  std::string_view description;       ///< One line.
  std::span<const NamedShare> words;  ///< Words that stand for numbers; empty if there are none.
  WordBase word_base = WordBase::kWidth;
};

/// Every field: width and height first (others may be given as shares of them), then the rest of the paper's
/// parameters, then the details.
[[nodiscard]] std::span<const FrameField> FrameFields();
/// The field of a command-line option; null if there is none.
[[nodiscard]] const FrameField* FindFrameField(std::string_view option);

/// Whether the field is one of the paper's parameters (always present) or a detail.
[[nodiscard]] bool IsParameter(const FrameField& field);
/// The words that a kWord field takes; empty for numbers.
[[nodiscard]] std::span<const std::string_view> FormWords(const FrameField& field);

/// The number in a field as it is kept (mm, rad, dioptres); empty for words and for a detail that is left to the paper.
[[nodiscard]] std::optional<double> StoredNumber(const FrameField& field, const FrameDesign& design);
/// StoredNumber in the field's unit (degrees for angles).
[[nodiscard]] std::optional<double> ShownNumber(const FrameField& field, const FrameDesign& design);
/// The word in a kWord field. Requires one.
[[nodiscard]] std::string_view FormWord(const FrameField& field, const FrameDesign& design);
/// `design` with the stored number of a field. Requires a number field.
[[nodiscard]] FrameDesign WithStoredNumber(const FrameField& field, FrameDesign design, double value);
/// `design` with a word of FormWords; empty if the field does not take it.
[[nodiscard]] std::optional<FrameDesign> WithFormWord(const FrameField& field, FrameDesign design,
                                                      std::string_view word);

/// `design` with the field called `option` set from `text` as people write it: a number in the field's unit, for
/// lengths also "16%" of l1, a word ("slightly round" or "slightly-round"), or "paper" for a detail that is to be as
/// the paper has it. Setting "width" scales the frame. The result is not yet validated; the error names option and
/// text.
[[nodiscard]] Result<FrameDesign> WithField(const FrameDesign& design, std::string_view option, std::string_view text);

/// The word that is nearest to a field's number ("slightly round"); empty if the field has no words.
[[nodiscard]] std::string_view NearestWord(const FrameField& field, const FrameDesign& design);

/// What may be written for a field on the command line: "MM|PERCENT|WORD", "straight|saddle|keyhole".
[[nodiscard]] std::string FieldSyntax(const FrameField& field);

}  // namespace annulus
