#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "station/sheet_words.h"

namespace annulus {

/// What somebody agrees to, one by one.
struct ConsentPurpose {
  std::string id;    ///< "measure", "glasses", "reshape", "research".
  std::string text;  ///< In the first person.
};

/// The wording that a customer is shown before a scan. A change of what it says is a new version; older consents stay
/// bound to the version that was shown.
struct ConsentText {
  std::string version;
  std::string language;  ///< "en", "ja".
  std::string title;
  std::vector<std::string> paragraphs;
  std::vector<ConsentPurpose> purposes;
};

/// `keep_days`: how long data is kept unless the customer wants otherwise.
[[nodiscard]] ConsentText ConsentTextIn(SheetLanguage language, int keep_days);
/// The version of the present wording.
[[nodiscard]] std::string_view ConsentTextVersion();
[[nodiscard]] bool IsConsentPurpose(std::string_view id);

}  // namespace annulus
