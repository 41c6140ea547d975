#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "modeling/table/table.h"

namespace annulus {

/// The language of what a customer reads.
enum class SheetLanguage { kEnglish, kJapanese };

/// "en" or "ja"; nothing for other names.
[[nodiscard]] std::optional<SheetLanguage> SheetLanguageFromName(std::string_view name);

/// Groups of measurements, in the order of the sheet.
enum class SheetGroup { kGirths, kLengths, kBreadths, kHeights, kHead, kAngles, kVolumes };
inline constexpr int kSheetGroups = 7;

/// Where a measurement is listed, by its id and unit.
[[nodiscard]] SheetGroup GroupOf(const Measurement& measurement);
[[nodiscard]] std::string_view GroupTitle(SheetGroup group, SheetLanguage language);

/// The measurement's term in the language. Japanese terms are those of body measuring for clothes (JIS L 0111) and of
/// physical anthropometry; a measurement without one keeps its English term.
[[nodiscard]] std::string TermIn(const Measurement& measurement, SheetLanguage language);

/// The fixed texts of the sheet.
struct SheetWords {
  std::string_view title;
  std::string_view subject;
  std::string_view scan;
  std::string_view units;
  std::string_view front;
  std::string_view side;
  std::string_view back;
  std::string_view measurement;
  std::string_view value;
  std::string_view half95;
  std::string_view measured;
  std::string_view within_limit;
  std::string_view levels_note;  ///< Under the pictures.
  std::string_view interval_note;
  std::string_view share_note;
  std::string_view limit_note;
  std::string_view page;
};
[[nodiscard]] const SheetWords& WordsIn(SheetLanguage language);

}  // namespace annulus
