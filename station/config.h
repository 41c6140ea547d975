#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "station/device_config.h"
#include "station/sim_target.h"

namespace annulus {

/// [profile.NAME]: overrides of a built-in profile, or a profile of its own.
struct ProfileConfig {
  std::optional<double> z_top_mm;
  bool find_top = false;  ///< z_top_mm = "auto": 40 mm above the top that a search sweep finds.
  std::optional<double> z_bottom_mm;
  std::optional<double> pitch_mm;
  std::optional<double> speed_mm_s;
  std::optional<std::uint32_t> sweeps;
  std::optional<double> level_rate_hz;
  bool of_target = false;  ///< For calibration targets, as the built-in profile target is.
};

/// [sim]: who stands in the simulated booth, and how well the sensors see.
struct SimConfig {
  std::uint64_t seed = 1;
  std::string subject = "body";  ///< "body", "head", or a mesh file (.obj, .ply, .stl).
  double subject_scale = 1.0;    ///< Of a mesh file, mm per unit.
  bool subject_y_up = false;     ///< A mesh file whose y axis is up.
  double noise_mm = 0.5;
  double dropout_rate = 0.01;
  double outlier_rate = 0.002;
  double sway = 0.0;       ///< 0 none, 1 as people sway.
  double breathing = 0.0;  ///< Relative growth of the chest's radius.
  bool hair = false;
  bool spectacles = false;
  bool dark_patches = false;
  bool reference = false;  ///< The reference board is there; its sensors are those of [ring] reference.
  std::string faults;      ///< Path of a fault plan (docs/formats.md); empty: nothing goes wrong.
  bool real_time = false;  ///< Served by boothd, its time is the host's even where nothing is real (Pace).
  bool cap = false;
  bool loose_clothing = false;
  std::optional<double> step_aside_s;  ///< On the booth's clock, as the times of a recording's levels.
  std::optional<double> leave_s;
  std::optional<double> raise_arm_s;
  std::optional<SimTarget> target;  ///< Stands there instead of a subject.
  SimRing ring;
};

/// [calibration]: which calibration of the ring is in force, and what a scan without a good one is worth.
struct CalibrationConfig {
  /// What becomes of a scan without a calibration file.
  enum class Uncalibrated {
    kByBooth,  ///< Refused on real rings, marked on simulated ones.
    kRefuse,
    kMark,  ///< Taken; every result says that the ring was not calibrated.
  };

  std::string file;               ///< CAL.json; "": the one that was accepted at the console (CalibrationPath).
  std::string reference_check;    ///< File that 'annulus check' keeps; "": not asked for.
  double reference_hours = 24.0;  ///< A reference check older than that is none.
  Uncalibrated uncalibrated = Uncalibrated::kByBooth;
};

/// [store]: where customers, scans and their files are kept.
struct StoreConfig {
  std::string folder;         ///< "": of `annulus serve --folder`.
  std::string key_file;       ///< The station's key; "": station.key in the folder, made at first start.
  std::string backup_folder;  ///< "": backups in the folder.
  std::string recordings;     ///< Where boothd writes (its --recordings); "": recordings in the folder.
  int keep_days = 90;         ///< Retention of new customers.
};

/// [console]: how the operator's console is reached.
struct ConsoleConfig {
  int port = 8437;
  std::vector<std::string> addresses;   ///< In digits, beside 127.0.0.1 and ::1; any makes it reachable from afar.
  std::vector<std::string> host_names;  ///< Under which it is reached, beside localhost; in the certificate.
};

/// A station's configuration (docs/config.md). Unknown keys are errors.
struct Config {
  std::string station_id = "sim";
  std::string language = "en";  ///< Of the console until somebody chooses: "en", "ja".
  std::string units = "mm";     ///< Of lengths on screens and documents: "mm", "cm", "in".
  StoreConfig store;
  ConsoleConfig console;
  RingConfig ring;
  AxisConfig axis;
  InterlockConfig interlock;
  std::map<std::string, ProfileConfig> profiles;
  CalibrationConfig calibration;
  SimConfig sim;
};

/// Where boothd leaves its recordings: [store] recordings, or recordings in the folder; "" if there is no folder either.
[[nodiscard]] std::string RecordingsFolder(const StoreConfig& store);

/// The calibration in force: [calibration] file, or calibration.json beside boothd's recordings, the one folder that
/// boothd reads and the console writes. "" if the configuration knows neither.
[[nodiscard]] std::string CalibrationPath(const Config& config);

/// The built-in configuration `sim`: a simulated booth, nothing else needed.
[[nodiscard]] Config SimulatedConfig();

/// Reads a TOML configuration. `name` is what messages call it. Errors name line and key.
[[nodiscard]] Result<Config> ParseConfig(std::string_view toml, const std::string& name);

/// `path` is a file, or "sim" for the built-in configuration.
[[nodiscard]] Result<Config> ReadConfig(Storage& storage, const std::string& path);

}  // namespace annulus
