// The file of a drift history (docs/formats.md).

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "acquisition/drift_history.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus drift history";
constexpr int kVersion = 1;
constexpr int kDeepest = 6;
constexpr std::size_t kMostBytes = std::size_t{64} << 20;
constexpr std::size_t kLongestText = 200;
constexpr double kLargest = 1e4;

/// A list of numbers of a record, its key, and the smallest that it may hold.
struct ListKey {
  const char* key;
  std::vector<double> DriftRecord::*member;
  double smallest;
};
constexpr std::array kLists{
    ListKey{"offset_mm", &DriftRecord::offset_mm, -kLargest},
    ListKey{"sigma_mm", &DriftRecord::sigma_mm, 1e-4},
    ListKey{"trend_mm_s", &DriftRecord::trend_mm_s, -kLargest},
    ListKey{"trend_sigma_mm_s", &DriftRecord::trend_sigma_mm_s, 1e-4},
};

Json ListJson(const std::vector<double>& numbers) {
  Json list = Json::array();
  for (const double number : numbers) list.push_back(std::isfinite(number) ? Json(number) : Json(nullptr));
  return list;
}

/// Reads one file; where something is wrong, `wrong_` says what.
class HistoryReader {
 public:
  explicit HistoryReader(const Json& json) : json_(json) {}

  [[nodiscard]] const std::string& wrong() const { return wrong_; }

  std::string Text(const Json& object, const char* key) {
    const Json* const found = Member(object, key);
    if (found != nullptr && found->is_string() && found->get_ref<const std::string&>().size() <= kLongestText) {
      return found->get<std::string>();
    }
    return Wrong<std::string>(key);
  }
  double Number(const Json& object, const char* key, double low, double high) {
    const Json* const found = Member(object, key);
    const double number = found != nullptr && found->is_number() ? found->get<double>() : kNone;
    return number >= low && number <= high ? number : Wrong<double>(key);
  }
  std::int64_t Whole(const Json& object, const char* key, std::int64_t low, std::int64_t high) {
    const Json* const found = Member(object, key);
    if (found == nullptr || !found->is_number_integer()) return Wrong<std::int64_t>(key);
    const bool fits = !found->is_number_unsigned() || found->get<std::uint64_t>() <= static_cast<std::uint64_t>(high);
    const std::int64_t number = fits ? found->get<std::int64_t>() : low - 1;
    return number >= low && number <= high ? number : Wrong<std::int64_t>(key);
  }
  /// Numbers or null.
  std::vector<double> List(const Json& list, const std::string& name, std::size_t size, double low) {
    if (!list.is_array() || list.size() != size) return Wrong<std::vector<double>>(name);
    std::vector<double> numbers;
    for (const Json& entry : list) {
      const double number = entry.is_number() ? entry.get<double>() : kNone;
      const bool good = entry.is_null() || (number >= low && number <= kLargest);
      if (!good) return Wrong<std::vector<double>>(name);
      numbers.push_back(number);
    }
    return numbers;
  }
  const Json& Array(const char* key, std::size_t most) {
    static const Json kEmpty = Json::array();
    const Json* const found = Member(json_, key);
    if (found != nullptr && found->is_array() && found->size() <= most) return *found;
    Wrong<int>(key);
    return kEmpty;
  }
  DriftRecord Record(const Json& json, std::size_t sensors) {
    DriftRecord record;
    if (!json.is_object()) return Wrong<DriftRecord>("records");
    record.scan_hash = Text(json, "scan_hash");
    record.calibration = Text(json, "calibration");
    record.wall_start_ns = Whole(json, "wall_start_ns", 0, std::numeric_limits<std::int64_t>::max());
    record.duration_s = Number(json, "duration_s", 0.0, kLargest);
    const Json* const temperature = Member(json, "temperature_c");
    if (temperature != nullptr && !temperature->is_null()) {
      record.temperature = Number(json, "temperature_c", -100.0, 200.0);
    }
    for (const ListKey& list : kLists) {
      const Json* const found = Member(json, list.key);
      record.*list.member = List(found == nullptr ? Json() : *found, list.key, sensors, list.smallest);
    }
    return record;
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  static const Json* Member(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
  }
  template <class T>
  T Wrong(const std::string& key) {
    if (wrong_.empty()) wrong_ = "'" + key + "' is missing or wrong";
    return T();
  }

  const Json& json_;
  std::string wrong_;
};

}  // namespace

std::string DriftHistory::ToJson() const {
  Json stencils = Json::array();
  for (const auto& weights : stencils_) stencils.push_back(weights);
  Json records = Json::array();
  for (const DriftRecord& record : records_) {
    Json json{{"scan_hash", record.scan_hash},
              {"calibration", record.calibration},
              {"wall_start_ns", record.wall_start_ns},
              {"temperature_c", record.temperature ? Json(*record.temperature) : Json(nullptr)},
              {"duration_s", record.duration_s}};
    for (const ListKey& list : kLists) json[list.key] = ListJson(record.*list.member);
    records.push_back(std::move(json));
  }
  Json checks = Json::array();
  for (const ReferenceRecord& check : checks_) checks.push_back(JsonFromCheck(check));
  const Json json{{"format", kFormat},
                  {"version", kVersion},
                  {"ring_serial", ring_serial_},
                  {"sensors", stencils_.size()},
                  {"stencil_scans", stencil_scans_},
                  {"stencils", std::move(stencils)},
                  {"records", std::move(records)},
                  {"checks", std::move(checks)}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<DriftHistory> DriftHistory::FromJson(std::string_view text, const std::string& name) {
  const std::string attempted = "read the drift history " + name;
  const std::string advice = "give a file that 'annulus drift --history' wrote, or a new name to begin a history";
  if (text.size() > kMostBytes) return Fail(attempted, "it is larger than 64 MiB", advice);
  bool deep = false;
  const auto shallow = [&deep](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > kDeepest;
    return !deep;
  };
  const Json json = Json::parse(text.begin(), text.end(), shallow, false);
  if (deep || !json.is_object()) return Fail(attempted, "it is not a JSON object of that kind", advice);
  HistoryReader reader(json);
  if (reader.Text(json, "format") != kFormat) return Fail(attempted, "it is no drift history", advice);
  const std::int64_t version = reader.Whole(json, "version", 1, 1'000'000);
  if (version > kVersion) {
    return Fail(attempted, "it is of version " + std::to_string(version),
                "use the program that wrote it, or a newer one");
  }
  DriftHistory history;
  history.ring_serial_ = reader.Text(json, "ring_serial");
  const auto sensors = static_cast<std::size_t>(reader.Whole(json, "sensors", 0, kMostSensors));
  history.stencil_scans_ = static_cast<std::size_t>(reader.Whole(json, "stencil_scans", 0, 1'000'000'000));
  for (const Json& weights : reader.Array("stencils", kMostSensors)) {
    const std::vector<double> read = reader.List(weights, "stencils", kNeighbours, -kLargest);
    std::array<double, kNeighbours> stencil{};
    for (std::size_t k = 0; k < read.size(); ++k) stencil[k] = std::isfinite(read[k]) ? read[k] : 0.0;
    history.stencils_.push_back(stencil);
  }
  for (const Json& record : reader.Array("records", kMostRecords)) {
    if (!reader.wrong().empty()) break;
    history.records_.push_back(reader.Record(record, sensors));
  }
  for (const Json& check : reader.Array("checks", kMostChecks)) {
    auto read = CheckFromJson(check);
    if (!read) return Fail(attempted, "a check: " + read.error().seen, advice);
    history.checks_.push_back(std::move(*read));
  }
  if (!reader.wrong().empty()) return Fail(attempted, reader.wrong(), advice);
  if (history.stencils_.size() != sensors) return Fail(attempted, "'stencils' has another length than sensors", advice);
  return history;
}

}  // namespace annulus
