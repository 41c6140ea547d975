#pragma once

#include <cmath>
#include <string>

#include "station/calibration_report.h"
#include "station/calibration_verdict.h"
#include "station/document.h"

namespace annulus {

/// Certificate and report in English, from which both files are made.
[[nodiscard]] Document CalibrationDocument(const CalibrationReport& report);

/// Its parts, in their order: the certificate's page; what was found of sensors and placements; what is known, and how
/// well.
void AddCertificate(const CalibrationReport& report, Document& document);
void AddSensorSections(const CalibrationReport& report, Document& document);
void AddKnowledgeSections(const CalibrationReport& report, Document& document);

/// A number with `decimals` places, "–" where it is not finite, never "-0.00".
[[nodiscard]] std::string NumberWith(double value, int decimals);
/// The same with its sign.
[[nodiscard]] std::string SignedWith(double value, int decimals);
/// The text, or `otherwise` if it is empty.
[[nodiscard]] std::string OrElse(const std::string& text, const std::string& otherwise);
/// With a capital at its beginning.
[[nodiscard]] std::string Capital(std::string text);
/// Enough of a hash to tell calibrations apart.
[[nodiscard]] std::string ShortHash(const std::string& hash);
/// "column of radius 150.000 mm ± 0.020 mm (k = 2) at 20 °C"
[[nodiscard]] std::string RadiusText(double radius_mm, double expanded_u_mm);
/// A placement's name; of a recording's path its name without folder and ending.
[[nodiscard]] std::string PlacementName(const std::string& name);
/// "column", "sphere", "flat board", "step column"
[[nodiscard]] std::string KindName(CalibrationTarget::Kind kind);

}  // namespace annulus
