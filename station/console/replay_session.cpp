#include "station/console/replay_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "acquisition/level_stamper.h"
#include "base/units.h"
#include "firmware_iface/interlock.h"
#include "modeling/exchange/model_json.h"
#include "station/console/replay_frames.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostModels = 8;
constexpr std::size_t kMostOpen = 3;
constexpr std::chrono::minutes kUnused{15};

template <class Word>
void PutWord(std::string& bytes, Word word) {
  for (unsigned shift = 0; shift < 8 * sizeof(Word); shift += 8) {
    bytes.push_back(static_cast<char>((word >> shift) & 0xffU));
  }
}
void Put(std::string& bytes, float value) { PutWord(bytes, std::bit_cast<std::uint32_t>(value)); }
void Put(std::string& bytes, double value) { PutWord(bytes, std::bit_cast<std::uint64_t>(value)); }

Json FiniteOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

/// What changed of the safety chain's lines, one row per line.
Json SafetyJson(const std::vector<SafetyLines>& safety) {
  Json rows = Json::array();
  const SafetyLines* before = nullptr;
  for (const SafetyLines& now : safety) {
    const auto add = [&](const char* name, bool level) {
      rows.push_back({{"time_ns", now.time.count()}, {"line", name}, {"level", level}});
    };
    for (std::size_t k = 0; k < kInterlockInputs; ++k) {
      if (before == nullptr || before->input.at(k) != now.input.at(k)) {
        add(InterlockName(static_cast<InterlockInput>(k)), now.input.at(k));
      }
    }
    for (std::size_t k = 0; k < kInterlockOutputs; ++k) {
      if (before == nullptr || before->output.at(k) != now.output.at(k)) {
        add(InterlockName(static_cast<InterlockOutput>(k)), now.output.at(k));
      }
    }
    before = &now;
  }
  return rows;
}

/// Differences of two surfaces on a grid of 2° by 4 mm, where both are known.
class SurfaceDifference {
 public:
  SurfaceDifference(const SurfaceModel& a, const SurfaceModel& b) {
    const SplineSurface& first = a.main().surface;
    const SplineSurface& second = b.main().surface;
    constexpr int kColumns = 180;
    constexpr double kStep = 4.0;  // mm
    for (double z = std::max(first.z_min(), second.z_min()); z <= std::min(first.z_max(), second.z_max()); z += kStep) {
      for (int column = 0; column < kColumns; ++column) {
        const double theta = kTwoPi * column / kColumns;
        ++cells_;
        if (!IsKnown(a, theta, z) || !IsKnown(b, theta, z)) continue;
        Take(second.Radius(theta, z) - first.Radius(theta, z), theta, z);
      }
    }
  }

  [[nodiscard]] Json Report() const {
    std::vector<double> sizes;
    double sum = 0.0;
    double squares = 0.0;
    for (const double difference : differences_) {
      sizes.push_back(std::abs(difference));
      sum += difference;
      squares += difference * difference;
    }
    const auto count = static_cast<double>(std::max<std::size_t>(1, sizes.size()));
    double p95 = 0.0;
    if (!sizes.empty()) {
      const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(sizes.size() - 1));
      std::nth_element(sizes.begin(), place, sizes.end());
      p95 = *place;
    }
    const double mean = sum / count;
    return {
        {"cells", differences_.size()},
        {"shared_share", cells_ == 0 ? 0.0 : static_cast<double>(differences_.size()) / static_cast<double>(cells_)},
        {"mean_mm", mean},
        {"sd_mm", std::sqrt(std::max(0.0, squares / count - mean * mean))},
        {"rms_mm", std::sqrt(squares / count)},
        {"p95_mm", p95},
        {"largest_mm", largest_},
        {"largest_theta_deg", DegreesFromRadians(largest_theta_)},
        {"largest_z_mm", largest_z_}};
  }

 private:
  static bool IsKnown(const SurfaceModel& model, double theta, double z) {
    const KnowledgeMap& known = model.main().knowledge;
    return known.rows() == 0 || known.At(theta, z) != Knowledge::kUnknown;
  }
  void Take(double difference, double theta, double z) {
    differences_.push_back(difference);
    if (std::abs(difference) <= std::abs(largest_)) return;
    largest_ = difference;
    largest_theta_ = theta;
    largest_z_ = z;
  }

  std::size_t cells_ = 0;
  std::vector<double> differences_;
  double largest_ = 0.0;
  double largest_theta_ = 0.0;
  double largest_z_ = 0.0;
};

}  // namespace

Result<std::shared_ptr<ReplaySession>> ReplaySession::Open(std::vector<std::byte> bytes, const std::string& name) {
  auto recording = ParseRecording(bytes, name);
  if (!recording) return Fail(recording);
  return std::shared_ptr<ReplaySession>(new ReplaySession(std::move(bytes), std::move(*recording)));
}

Json ReplaySession::Summary() const {
  const Scan& scan = recording_.scan;
  Json events = Json::array();
  for (const RecordedEvent& event : recording_.events) {
    events.push_back({{"time_ns", event.time.count()}, {"kind", "event"}, {"text", event.text}});
  }
  for (const std::string& note : recording_.report.notes) {
    events.push_back({{"time_ns", 0}, {"kind", "damage"}, {"text", note}});
  }
  std::uint16_t sweeps = 0;
  for (const ScanLevel& level : scan.levels) sweeps = std::max<std::uint16_t>(sweeps, level.sweep);
  return {{"levels", scan.levels.size()},
          {"sweeps", scan.levels.empty() ? 0 : sweeps + 1},
          {"from_ns", scan.levels.empty() ? 0 : scan.levels.front().time.count()},
          {"to_ns", scan.levels.empty() ? 0 : scan.levels.back().time.count()},
          {"sensors", scan.header.calibration.sensors.size()},
          {"radius_mm", scan.header.ring_radius_mm},
          {"profile", scan.header.profile},
          {"has_raw_bytes", !recording_.raw.empty()},
          {"events", std::move(events)},
          {"safety", SafetyJson(recording_.safety)}};
}

std::string ReplaySession::MapBytes() const {
  const std::vector<ScanLevel>& levels = recording_.scan.levels;
  const std::size_t sensors = recording_.scan.header.calibration.sensors.size();
  std::string bytes;
  bytes.reserve(8 + levels.size() * (4 * sensors + 12));
  PutWord(bytes, static_cast<std::uint32_t>(levels.size()));
  PutWord(bytes, static_cast<std::uint32_t>(sensors));
  for (const ScanLevel& level : levels) {
    for (std::size_t k = 0; k < sensors; ++k) {
      const bool is_there = k < level.readings.size();
      Put(bytes, is_there ? static_cast<float>(level.readings[k].range_mm) : std::numeric_limits<float>::quiet_NaN());
    }
  }
  for (const ScanLevel& level : levels) Put(bytes, static_cast<float>(MeanHeight(level)));
  for (const ScanLevel& level : levels) {
    Put(bytes, std::chrono::duration<double>(level.time - levels.front().time).count());
  }
  return bytes;
}

Result<Json> ReplaySession::Level(std::size_t n) const {
  const std::vector<ScanLevel>& levels = recording_.scan.levels;
  if (n >= levels.size()) {
    return Fail(fmt::format("show level {}", n), fmt::format("there are {}", levels.size()), "count from 0");
  }
  const ScanLevel& level = levels[n];
  Json ranges = Json::array();
  Json quality = Json::array();
  Json heights = Json::array();
  for (const RangeReading& reading : level.readings) {
    ranges.push_back(FiniteOrNull(reading.range_mm));
    quality.push_back(reading.quality);
    heights.push_back(FiniteOrNull(reading.z_mm));
  }
  const auto next = n + 1 < levels.size() ? levels[n + 1].time : std::chrono::nanoseconds::max();
  return Json{{"n", n},
              {"sweep", level.sweep},
              {"level", level.index},
              {"time_ns", level.time.count()},
              {"z_mm", FiniteOrNull(MeanHeight(level))},
              {"range_mm", std::move(ranges)},
              {"stamps", {{"quality", std::move(quality)}, {"z_mm", std::move(heights)}}},
              {"frames", FramesJson(recording_.raw, level.time, next)}};
}

std::string ReplaySession::AddModel(std::string json) {
  const std::lock_guard lock(mutex_);
  const std::string id = fmt::format("M-{:04}", ++last_model_);
  models_[id] = std::move(json);
  if (models_.size() > kMostModels) models_.erase(models_.begin());
  return id;
}

Result<SurfaceModel> ReplaySession::Model(const std::string& id) const {
  std::string text;
  {
    const std::lock_guard lock(mutex_);
    const auto found = models_.find(id);
    if (found == models_.end()) return Fail("find model " + id, "it is not of this replay", "fit it again");
    text = found->second;
  }
  return ModelFromJson(text, id);
}

Result<Json> ReplaySession::CompareModels(const std::string& a, const std::string& b) const {
  const auto first = Model(a);
  if (!first) return Fail(first);
  const auto second = Model(b);
  if (!second) return Fail(second);
  Json report{{"a", a}, {"b", b}};
  report.update(SurfaceDifference(*first, *second).Report());
  report["noise_a_mm"] = first->noise_sigma_mm;
  report["noise_b_mm"] = second->noise_sigma_mm;
  return report;
}

std::string ReplaySessions::Add(const std::string& owner, std::shared_ptr<ReplaySession> session) {
  const std::lock_guard lock(mutex_);
  DropOld();
  const std::string id = fmt::format("R-{}", ++last_);
  open_[id] = {owner, std::move(session), clock_.Now()};
  return id;
}

std::shared_ptr<ReplaySession> ReplaySessions::Find(const std::string& owner, const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(id);
  if (found == open_.end() || found->second.owner != owner) return nullptr;
  found->second.used = clock_.Now();
  return found->second.session;
}

void ReplaySessions::Close(const std::string& owner, const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(id);
  if (found != open_.end() && found->second.owner == owner) open_.erase(found);
}

/// Those that were not used for long, and the oldest if there are too many. With the lock held.
void ReplaySessions::DropOld() {
  const auto now = clock_.Now();
  std::erase_if(open_, [&](const auto& one) { return now - one.second.used > kUnused; });
  while (open_.size() >= kMostOpen) {
    open_.erase(std::min_element(open_.begin(), open_.end(),
                                 [](const auto& x, const auto& y) { return x.second.used < y.second.used; }));
  }
}

}  // namespace annulus
