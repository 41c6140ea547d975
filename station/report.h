#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "station/demo.h"

namespace annulus {

/// The demo's result as one self-contained HTML page: tables of measured against true values, pictures inside as data
/// URIs. Same result, same bytes: no path, no time.
[[nodiscard]] std::string RenderReport(const DemoResult& result);

/// For a terminal: measured against true values, and how the worst of them fares.
[[nodiscard]] std::string DemoText(const DemoResult& result);

/// For scripts: comparisons {group, term, unit, measured, half95, true, difference}, scan, fit, shares and files of
/// each subject.
[[nodiscard]] nlohmann::ordered_json DemoJson(const DemoResult& result);

}  // namespace annulus
