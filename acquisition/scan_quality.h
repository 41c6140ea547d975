#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/scan.h"

namespace annulus {

/// A part of the cylinder that the ring looks at.
struct QualityRegion {
  double theta_from = 0.0;  ///< rad, [0, 2 pi); from here counter-clockwise seen from above …
  double theta_to = 0.0;    ///< … to here, > theta_from, at most a turn further.
  double z_min = 0.0;       ///< mm, station frame.
  double z_max = 0.0;
  std::size_t cells = 0;  ///< Of the coverage map that belong to it.
};

/// A region in words: "front left, 1.20-1.35 m".
[[nodiscard]] std::string RegionText(const QualityRegion& region);

/// What can be amiss with a scan.
enum class NoticeCode : std::uint8_t {
  kLeft,           ///< Nobody is in the ring any more (U4).
  kMoved,          ///< The person stands elsewhere than before (U4).
  kSwayed,         ///< As people sway, but enough to be seen in lengths and depths.
  kPartMoved,      ///< An arm, mostly, is elsewhere than in another sweep, or something is in the way (U4).
  kSpectacles,     ///< Thin rims before the face.
  kHair,           ///< A rough scalp.
  kCap,            ///< A smooth layer with an edge around the head.
  kLooseClothing,  ///< Cloth that does not keep its shape.
  kWeakReturns,    ///< Dark or shiny places.
  kGaps,           ///< Parts of the body that were not seen.
  kSensorsDead,    ///< S5, S6.
  kSensorsStuck,   ///< S1.
  kSpikes,         ///< Cross-talk, stray light (S3).
  kNoise,          ///< More noise than a good ring has.
};
inline constexpr std::size_t kNoticeCodes = 14;
/// As in JSON: "part_moved".
[[nodiscard]] const char* NoticeName(NoticeCode code);

/// What a scan is good for.
enum class QualityVerdict : std::uint8_t {
  kGood,
  kUsable,  ///< With what the notices say.
  kRepeat,  ///< Change what the notices say, and scan again.
};
[[nodiscard]] const char* VerdictName(QualityVerdict verdict);

/// One thing that is amiss.
struct QualityNotice {
  NoticeCode code = NoticeCode::kGaps;
  QualityVerdict verdict = QualityVerdict::kUsable;  ///< What the scan is good for because of it.
  QualityRegion where;
  double size = 0.0;   ///< In `unit`.
  std::string unit;    ///< "mm", "cells", "share" …
  std::string text;    ///< What was seen, in plain words.
  std::string advice;  ///< What to change; ends without a full stop.
};

/// One sensor over the scan.
struct SensorQuality {
  std::uint32_t expected = 0;  ///< Levels on which something of the body lay in its line.
  std::uint32_t missing = 0;   ///< Of these, without a return.
  bool stuck = false;          ///< The same value over 8 levels or more while its neighbours moved.
  bool dead = false;           ///< No return over dozens of levels while its neighbours had some.

  bool operator==(const SensorQuality&) const = default;
};

/// What the dead sensors allow (RELIABILITY rows S5 and S6).
enum class SensorsVerdict : std::uint8_t {
  kGood,      ///< None is dead.
  kDegraded,  ///< At most `most_single` are, none beside another: the scan goes on, flagged.
  kRefuse,    ///< More, or two side by side: no scan starts, a running one stops.
};
/// `dead`: indices below `sensor_count`, each once, ascending. The first and the last sensor are neighbours.
[[nodiscard]] SensorsVerdict JudgeDeadSensors(const std::vector<std::size_t>& dead, std::size_t sensor_count,
                                              std::size_t most_single = 2);

/// How a person moved between the sweeps of a scan.
struct MotionQuality {
  double sigma_x_mm = 0.0;             ///< sd of one level's displacement sideways.
  double sigma_y_mm = 0.0;             ///< Front-back.
  double correlation_length_mm = 0.0;  ///< Along z, as in SwayErrors; > 0.
  double largest_mm = 0.0;             ///< Displacement against the first sweep that one level in twenty exceeds.
  double largest_yaw_rad = 0.0;        ///< The same of the turn; round sections do not show theirs.
  std::size_t levels = 0;              ///< That were compared.
};

/// One cell of the coverage map.
enum class CoverageCell : std::uint8_t {
  kOutside,  ///< Nothing of the body lies in this direction.
  kSeen,
  kDoubtful,  ///< Seen, but weakly, or otherwise than in another sweep.
  kGap,       ///< Something lies there and was not seen.
};

/// Directions × heights, unrolled.
struct CoverageMap {
  std::size_t columns = 0;  ///< One per sensor, in order of theta.
  std::size_t rows = 0;     ///< Row 0 is the lowest.
  double z_min = 0.0;       ///< Lower edge of row 0, mm.
  double row_mm = 1.0;
  std::vector<CoverageCell> cells;  ///< Row by row.

  [[nodiscard]] CoverageCell At(std::size_t row, std::size_t column) const { return cells[row * columns + column]; }
};

/// What is known of a scan's quality.
struct ScanQuality {
  QualityVerdict verdict = QualityVerdict::kRepeat;
  std::vector<QualityNotice> notices;  ///< The gravest first.
  std::size_t levels = 0;
  double coverage = 0.0;  ///< Share of the body's cells that were seen, 0 … 1.
  CoverageMap map;
  std::vector<QualityRegion> gaps;     ///< Those worth a word, largest first.
  double dropout_rate = 0.0;           ///< Share of readings that something lay before and that have no return.
  double return_quality = 0.0;         ///< Median of the return quality, 0 … 1.
  double noise_sigma_mm = 0.0;         ///< sd of one reading at full return quality, mm; 0 if it cannot be told.
  double spike_rate = 0.0;             ///< Share of readings far from all their neighbours.
  std::vector<SensorQuality> sensors;  ///< One per sensor.
  SensorsVerdict sensors_verdict = SensorsVerdict::kGood;
  std::optional<MotionQuality> motion;  ///< Absent if no height was scanned twice.
};

/// What is known while the scan runs.
struct LiveQuality {
  std::size_t levels = 0;
  double dropout_rate = 0.0;
  double seen_share = 0.0;  ///< Of the last level's directions.
  SensorsVerdict sensors_verdict = SensorsVerdict::kGood;
  std::vector<std::size_t> dead;   ///< Sensors, ascending.
  std::vector<std::size_t> stuck;  ///< Sensors, ascending.
  bool left = false;               ///< Nobody is in the ring any more.
};

/// Watches a scan while it is taken. Bounded memory: five bytes per reading of at most kMostLevels levels; what comes
/// after them is counted only. Deterministic: the same levels give the same quality. Thread-bound.
class QualityMonitor {
 public:
  static constexpr std::size_t kMostLevels = 20'000;

  /// `header`: calibration and ring radius of the scan; the plan is read from plan_json where it is known.
  explicit QualityMonitor(const ScanHeader& header);
  QualityMonitor(QualityMonitor&&) noexcept;
  QualityMonitor& operator=(QualityMonitor&&) noexcept;
  ~QualityMonitor();

  /// The next level; at most 0.2 ms for 180 sensors. Readings that are no numbers are no returns.
  void Add(const ScanLevel& level);
  /// Cheap: may be asked after every level.
  [[nodiscard]] LiveQuality live() const;
  /// Everything; takes some tens of ms. A scan of rings with fewer than 24 sensors is not judged: kUsable, no notice.
  [[nodiscard]] ScanQuality Assess() const;
  /// A factor on the weight of every reading, level by level and sensor by sensor; empty if all are 1. Stuck sensors
  /// and what was elsewhere in other sweeps get 0, fluttering cloth and a person who has moved less than 1.
  [[nodiscard]] std::vector<float> Weights() const;
  /// How the person moved between the sweeps, as in ScanQuality; nothing if the person left.
  [[nodiscard]] std::optional<MotionQuality> Motion() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The quality of a whole scan.
[[nodiscard]] ScanQuality AssessScan(const Scan& scan);
/// QualityMonitor::Weights of a whole scan: what BuildSamples multiplies the return quality by.
[[nodiscard]] std::vector<float> QualityWeights(const Scan& scan);
/// QualityMonitor::Motion of a whole scan.
[[nodiscard]] std::optional<MotionQuality> MeasureMotion(const Scan& scan);

/// The quality as a JSON object (docs/formats.md), without the map.
[[nodiscard]] std::string JsonFromQuality(const ScanQuality& quality);
/// Verdict and notices, a line each, for people.
[[nodiscard]] std::string TextFromQuality(const ScanQuality& quality);

}  // namespace annulus
