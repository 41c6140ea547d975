#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "acquisition/recording.h"
#include "base/clock.h"
#include "base/result.h"
#include "fitting/surface_model.h"

namespace annulus {

/// A recording that a developer looks at: in memory, with the models that were fitted to it. Thread-safe.
class ReplaySession {
 public:
  /// Reads the bytes of a recording. `name` is for messages. Fails as ParseRecording does.
  static Result<std::shared_ptr<ReplaySession>> Open(std::vector<std::byte> bytes, const std::string& name);

  /// {levels, sweeps, from_ns, to_ns, sensors, radius_mm, profile, events, safety} (docs/console_api.md §12).
  [[nodiscard]] nlohmann::ordered_json Summary() const;
  /// Levels × sensors in the binary form of §12: ranges as they were recorded.
  [[nodiscard]] std::string MapBytes() const;
  /// Level `n` of the recording, 0 first, with what passed the buses from its SYNC to the next one's. Fails if there
  /// is no such level.
  [[nodiscard]] Result<nlohmann::ordered_json> Level(std::size_t n) const;

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  /// Keeps a model (MODEL.json); its id in this session. At most eight, the oldest goes.
  std::string AddModel(std::string json);
  /// Statistics of b's surface less a's where both know it: {cells, shared_share, mean_mm, sd_mm, rms_mm, p95_mm,
  /// largest_mm, largest_theta_deg, largest_z_mm, noise_a_mm, noise_b_mm, coefficients}. Fails on an unknown id.
  [[nodiscard]] Result<nlohmann::ordered_json> CompareModels(const std::string& a, const std::string& b) const;

 private:
  ReplaySession(std::vector<std::byte> bytes, Recording recording)
      : bytes_(std::move(bytes)), recording_(std::move(recording)) {}
  [[nodiscard]] Result<SurfaceModel> Model(const std::string& id) const;

  std::vector<std::byte> bytes_;
  Recording recording_;
  mutable std::mutex mutex_;  ///< Of what follows.
  std::map<std::string, std::string> models_;
  std::size_t last_model_ = 0;
};

/// The sessions that are open: at most three, dropped after fifteen minutes without use. Of one technician each.
/// Thread-safe. The clock is borrowed.
class ReplaySessions {
 public:
  explicit ReplaySessions(const Clock& clock) : clock_(clock) {}

  /// Its id.
  std::string Add(const std::string& owner, std::shared_ptr<ReplaySession> session);
  /// Null if there is none of this owner.
  [[nodiscard]] std::shared_ptr<ReplaySession> Find(const std::string& owner, const std::string& id);
  void Close(const std::string& owner, const std::string& id);

 private:
  struct Open {
    std::string owner;
    std::shared_ptr<ReplaySession> session;  ///< Shared with requests and jobs that are under way.
    std::chrono::nanoseconds used{0};
  };
  void DropOld();

  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Open> open_;
  std::size_t last_ = 0;
};

}  // namespace annulus
