#include "station/measurement_files.h"

#include <array>
#include <nlohmann/json.hpp>

#include "modeling/exchange/freesewing.h"
#include "modeling/exchange/smis.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

struct Ending {
  std::string_view text;
  MeasurementFormat format;
};
/// The longer ending before the one that it ends with.
constexpr std::array<Ending, 6> kEndings{{{".freesewing.json", MeasurementFormat::kFreeSewing},
                                          {".json", MeasurementFormat::kJson},
                                          {".csv", MeasurementFormat::kCsv},
                                          {".smis", MeasurementFormat::kSeamly},
                                          {".vit", MeasurementFormat::kValentina},
                                          {".pdf", MeasurementFormat::kSheet}}};

PatternFile TextOf(MeasurementFormat format, const MeasurementTable& table) {
  switch (format) {
    case MeasurementFormat::kCsv:
      return {MeasurementsToCsv(table), {}};
    case MeasurementFormat::kSeamly:
      return MeasurementsToSmis(table, SewingDialect::kSeamly);
    case MeasurementFormat::kValentina:
      return MeasurementsToSmis(table, SewingDialect::kValentina);
    case MeasurementFormat::kFreeSewing:
      return MeasurementsToFreeSewing(table);
    case MeasurementFormat::kJson:
    case MeasurementFormat::kSheet:
      break;
  }
  return {MeasurementsToJson(table).dump(1) + "\n", {}};
}

}  // namespace

Result<MeasurementFormat> MeasurementFormatOf(std::string_view path) {
  std::string known;
  for (const Ending& ending : kEndings) {
    if (path.ends_with(ending.text)) return ending.format;
    known += (known.empty() ? "" : ", ") + std::string(ending.text);
  }
  return Fail("write measurements to " + std::string(path), "its ending is no format of ours",
              "end the name with one of " + known);
}

Result<std::vector<std::string>> WriteMeasurements(Storage& storage, const std::string& path,
                                                   const MeasuredModel& measured, const SheetOptions& options) {
  const auto format = MeasurementFormatOf(path);
  if (!format) return Fail(format);
  if (*format == MeasurementFormat::kSheet) {
    RETURN_IF_ERROR(WriteMeasurementSheet(storage, path, measured.table, measured.model, options));
    return std::vector<std::string>{};
  }
  PatternFile file = TextOf(*format, measured.table);
  RETURN_IF_ERROR(WriteFileAtomically(storage, path, file.text));
  return std::move(file.left_out);
}

}  // namespace annulus
