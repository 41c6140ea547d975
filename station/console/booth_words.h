#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acquisition/scan_cause.h"
#include "station/booth_messages.h"
#include "station/sheet_words.h"

namespace annulus {

/// What happened and what to do about it, in words of somebody in a shop.
struct PlainWords {
  std::string text;
  std::string advice;  ///< "" if there is nothing to do.
};

/// One thing that has to be so before a scan, in the order in which an operator sees to them.
struct PlainStep {
  std::string id;  ///< "chain", "reset", "fault", "home", "sensors", "disk", "calibration", "stand", "key".
  bool ok = false;
  PlainWords words;
};

/// A latched cause.
struct PlainCause {
  std::string code;      ///< CauseTraits::name.
  bool service = false;  ///< Only a technician can acknowledge it.
  PlainWords words;
  std::string seen;  ///< boothd's own text, in English: for the technician.
};

/// The booth as an operator understands it.
struct PlainBooth {
  bool ready = false;  ///< A customer may be prepared: chain closed, reset, no fault, home found.
  std::vector<PlainStep> steps;
  std::vector<PlainCause> causes;
  std::string state_text;
  std::string lost_text;  ///< What to do while boothd is away; "" while it is there.
};

/// What is known of the booth.
struct BoothView {
  const StatusMessage* status = nullptr;  ///< Null while boothd is away. Borrowed.
  std::string why;                        ///< Then: why.
  bool start_agreed = false;              ///< BoothLink::start_agreed.
};

[[nodiscard]] PlainBooth DescribeBooth(const BoothView& view, SheetLanguage language);
/// Of one cause, without what boothd saw of it. All codes have words in both languages.
[[nodiscard]] PlainWords WordsOfCause(CauseCode code, SheetLanguage language);
[[nodiscard]] std::string WordsOfState(ScanState state, SheetLanguage language);

/// `plain` of docs/console_api.md §4.
[[nodiscard]] nlohmann::ordered_json PlainToJson(const PlainBooth& plain);
/// "ja", else English.
[[nodiscard]] SheetLanguage LanguageOf(std::string_view name);

}  // namespace annulus
