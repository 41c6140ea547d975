#include "station/console/calibration_records.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "acquisition/calibration_file.h"
#include "modeling/exchange/base64.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kReportEnding = ".report";
constexpr double kNsPerMs = 1e6;
constexpr std::array kReportFiles{"report.html", "report.pdf"};

bool IsReport(const Artefact& row) { return row.name.ends_with(kReportEnding); }

/// sd of the mean effective radial error of all sensors, mm; nothing where the calibration does not say.
std::optional<double> CommonSigma(const RingCalibration& calibration) {
  const std::optional<CalibrationUncertainty>& unknown = calibration.uncertainty;
  if (!unknown || unknown->own_mm.empty()) return std::nullopt;
  const auto count = static_cast<double>(unknown->own_mm.size());
  double variance = 0.0;
  for (const double own : unknown->own_mm) variance += own * own / (count * count);
  if (unknown->together_mm.rows() > 0) variance += unknown->together_mm.colwise().mean().squaredNorm();
  return std::sqrt(variance);
}

Json CalibrationJson(const std::string& name, const CalibrationFile& file) {
  const auto sigma = CommonSigma(file.calibration);
  return {{"name", name},
          {"made_ms", static_cast<double>(file.wall_ns) / kNsPerMs},
          {"verdict", file.passed ? "pass" : "fail"},
          {"sigma_common_mm", sigma ? Json(*sigma) : Json()},
          {"valid_until_ms", static_cast<double>(file.valid_until_ns) / kNsPerMs},
          {"traceable", file.traceable},
          {"technician", file.technician},
          {"hash", file.calibration.certificate}};
}

/// "20261129-225801": sorts by time, stands in an address and a file name.
std::string NameNow(const Clock& clock) {
  std::string text = UtcText(clock.WallNow().count());  // 2026-11-29T22:58:01Z
  std::erase_if(text, [](char c) { return c == '-' || c == ':' || c == 'Z'; });
  std::replace(text.begin(), text.end(), 'T', '-');
  return text;
}

Result<std::optional<Artefact>> FindRow(Store& store, const std::string& name) {
  const auto rows = store.Calibrations();
  if (!rows) return Fail(rows);
  for (const Artefact& row : *rows) {
    if (row.name == name) return std::optional(row);
  }
  return std::optional<Artefact>();
}

/// The name in the store of a calibration by its hash; "" if it is not there.
std::string NameOf(Store& store, const std::string& hash) {
  const auto rows = store.Calibrations();
  if (!rows) return "";
  for (const Artefact& row : *rows) {
    if (IsReport(row)) continue;
    const auto text = store.ReadCalibration(row.id);
    if (!text) continue;
    const auto file = ParseCalibrationFile(*text, row.name);
    if (file && file->calibration.certificate == hash) return row.name;
  }
  return "";
}

Result<std::string> Bundle(ConsoleContext& context, const std::string& folder, const Json& result) {
  Json bundle{{"data", result}};
  for (const char* file : kReportFiles) {
    const auto bytes = context.storage.ReadAll(folder + "/report/" + file, kMaxInputBytes);
    if (!bytes) return Fail(bytes);
    bundle[file] = EncodeBase64(std::span<const std::byte>(*bytes));
  }
  return bundle.dump();
}

/// Replaces the file that boothd reads when it arms, in one step.
Status PutInForce(ConsoleContext& context, const std::string& text) {
  const std::filesystem::path path = CalibrationPath(context.config);
  const std::string attempted = "put the calibration in force";
  if (path.empty()) return Fail(attempted, "the station has no folder for it", "name one in [calibration] file");
  if (path.has_parent_path()) RETURN_IF_ERROR(context.storage.CreateFolder(path.parent_path().string()));
  RETURN_IF_ERROR(WriteFileAtomically(context.storage, path.string(), text));
  // boothd may be another user: what we write is otherwise for ourselves only.
  using std::filesystem::perms;
  std::error_code failed;
  std::filesystem::permissions(path, perms::owner_read | perms::owner_write | perms::group_read | perms::others_read,
                               failed);
  if (failed) return Fail(attempted, path.string() + ": " + failed.message(), "let boothd's user read it (chmod 0644)");
  return {};
}

}  // namespace

Json CalibrationResultJson(const Json& printed) {
  const bool passed = printed.value("passed", false);
  Json limits = Json::array();
  for (const Json& line : printed.value("limits", Json::array())) {
    limits.push_back({{"name", line.value("name", "")},
                      {"unit", line.value("unit", "")},
                      {"as_found", line.value("found", Json())},
                      {"as_left", line.value("left", Json())},
                      {"limit", line.value("limit", 0.0)},
                      {"passed", line.value("pass", false)}});
  }
  return {{"passed", passed},
          {"verdict", passed ? "pass" : "fail"},
          {"limits", std::move(limits)},
          {"findings", printed.value("findings", Json::array())},
          {"unobservable", printed.value("unobservable", Json::array())},
          {"budget", printed.value("budget_900_mm", Json::array())},
          {"certificate",
           {{"traceable", printed.value("traceable", false)},
            {"statement", printed.value("traceability", "")},
            {"hash", printed.value("hash", "")},
            {"verification", printed.value("verification", Json())}}},
          {"placements", printed.value("placements", Json::array())},
          {"observability", printed.value("observability", Json::array())},
          {"plots", printed.value("plots", Json::object())},
          {"noise_mm", printed.value("noise_mm", Json())},
          {"time_s", printed.value("time_s", Json())}};
}

Result<std::string> KeepCalibration(ConsoleContext& context, const std::string& folder, const Json& result) {
  const auto text = ReadTextFile(context.storage, folder + "/CAL.json");
  if (!text) return Fail(text);
  const auto bundle = Bundle(context, folder, result);
  if (!bundle) return Fail(bundle);
  const std::string name = NameNow(context.clock);
  const auto kept = context.store.AddCalibration(name, *text);
  if (!kept) return Fail(kept);
  const auto report = context.store.AddCalibration(name + kReportEnding, *bundle);
  if (!report) return Fail(report);
  RETURN_IF_ERROR(PutInForce(context, *text));
  return name;
}

Json CalibrationInForceJson(ConsoleContext& context) {
  const std::string path = CalibrationPath(context.config);
  if (path.empty() || !context.storage.Exists(path)) return nullptr;
  const auto file = ReadCalibrationFile(context.storage, path);
  if (!file) {
    return {{"name", path},
            {"made_ms", 0},
            {"verdict", "fail"},
            {"sigma_common_mm", nullptr},
            {"problem", file.error().Text()}};
  }
  const std::string name = NameOf(context.store, file->calibration.certificate);
  return CalibrationJson(name.empty() ? UtcText(file->wall_ns) : name, *file);
}

Result<Json> CalibrationHistoryJson(Store& store) {
  const auto rows = store.Calibrations();
  if (!rows) return Fail(rows);
  Json history = Json::array();
  for (const Artefact& row : *rows) {
    if (IsReport(row)) continue;
    const auto text = store.ReadCalibration(row.id);
    if (!text) return Fail(text);
    const auto file = ParseCalibrationFile(*text, row.name);
    if (file) history.push_back(CalibrationJson(row.name, *file));
  }
  std::sort(history.begin(), history.end(), [](const Json& a, const Json& b) {
    return a.at("name").get_ref<const std::string&>() > b.at("name").get_ref<const std::string&>();
  });
  return history;
}

Result<std::vector<std::byte>> StoredCalibrationFile(Store& store, const std::string& name, const std::string& file) {
  const auto row = FindRow(store, file == "CAL.json" ? name : name + kReportEnding);
  if (!row) return Fail(row);
  if (!*row) return Fail("show the report of calibration " + name, "there is none", "look at the list");
  const auto text = store.ReadCalibration((*row)->id);
  if (!text) return Fail(text);
  const auto bytes_of = [](const std::string& t) {
    const auto bytes = std::as_bytes(std::span(t));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  };
  if (file == "CAL.json") return bytes_of(*text);
  const Json bundle = Json::parse(*text, nullptr, false);
  if (bundle.is_object() && file == "data.json") return bytes_of(bundle.value("data", Json()).dump());
  const auto member = bundle.is_object() ? bundle.find(file) : bundle.end();
  if (bundle.is_object() && member != bundle.end() && member->is_string()) {
    auto bytes = DecodeBase64(member->get_ref<const std::string&>());
    if (bytes) return std::move(*bytes);
  }
  return Fail("show " + file + " of calibration " + name, "it is not in the store",
              "ask for report.pdf or report.html");
}

}  // namespace annulus
