#include "station/calibration_report.h"

#include <span>
#include <variant>

#include "station/calibration_document.h"
#include "station/files.h"

namespace annulus {

std::string CalibrationReportHtml(const CalibrationReport& report) { return DocumentHtml(CalibrationDocument(report)); }

Result<std::vector<std::byte>> CalibrationReportPdf(const CalibrationReport& report) {
  return DocumentPdf(CalibrationDocument(report));
}

Status WriteCalibrationReport(Storage& storage, const std::string& directory, const CalibrationReport& report) {
  constexpr double kPixelsPerMm = 8.0;  // 200 dots per inch
  const Document document = CalibrationDocument(report);
  const auto pdf = DocumentPdf(document);
  if (!pdf) return Fail(pdf);
  const std::string plots = directory + "/plots";
  RETURN_IF_ERROR(storage.CreateFolder(plots));
  for (const auto& block : document.blocks) {
    const auto* figure = std::get_if<DocumentFigure>(&block);
    if (figure == nullptr) continue;
    const auto image = figure->figure.ToImage(kPixelsPerMm);
    if (!image) return Fail(image);
    RETURN_IF_ERROR(WritePngFile(storage, plots + "/" + figure->file + ".png", *image));
  }
  RETURN_IF_ERROR(WriteFileAtomically(storage, directory + "/report.html", DocumentHtml(document)));
  return WriteFileAtomically(storage, directory + "/report.pdf", std::span<const std::byte>(*pdf));
}

}  // namespace annulus
