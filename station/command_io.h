#pragma once

#include <chrono>
#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <stop_token>
#include <string>

#include "base/progress.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// How progress of long work is shown on stderr.
enum class ProgressMode {
  kAuto,  ///< A line that is rewritten, on a terminal only.
  kJson,  ///< One JSON object per line: {"stage", "done", "total", "eta_s"}.
  kNone,
};

/// Shows progress with the time left. Quiet for the first second of a stage on a terminal. A stage that goes on where
/// the last one ended is timed together with it. Thread-bound.
class ProgressDisplay {
 public:
  explicit ProgressDisplay(ProgressMode mode);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void Show(std::string_view stage, double done, double total);
  /// Removes the progress line, so that something else can be printed.
  void Clear();

 private:
  void ShowLine(std::string_view stage, double share, double eta_s);
  void ShowJson(std::string_view stage, double done, double total, double eta_s);

  ProgressMode mode_;
  bool terminal_;
  bool line_shown_ = false;
  std::string stage_;
  double last_share_ = 0.0;
  std::chrono::steady_clock::time_point stage_start_;
  std::chrono::steady_clock::time_point last_shown_;
};

/// What a command works with: files, progress, stop requests, and where results go. Thread-bound.
class CommandIo {
 public:
  /// Borrows `storage`. `stop` is requested by Ctrl-C.
  CommandIo(Storage& storage, std::stop_token stop) : storage_(storage), stop_(std::move(stop)) {}

  [[nodiscard]] Storage& storage() { return storage_; }
  [[nodiscard]] const std::stop_token& stop() const { return stop_; }
  /// Set from --progress before a command runs.
  void set_progress_mode(ProgressMode mode) { progress_mode_ = mode; }
  [[nodiscard]] ProgressMode progress_mode() const { return progress_mode_; }

  /// Exit code of a failed command: 1 unless set.
  void set_failure_code(int code) { failure_code_ = code; }
  [[nodiscard]] int failure_code() const { return failure_code_; }

  /// Writes text to stdout; a failing stdout is an error.
  Status Print(const std::string& text);
  /// Writes a JSON document with a final newline to `target`: "-" is stdout, else a file, written atomically.
  Status WriteJson(const std::string& target, const nlohmann::ordered_json& json);
  /// Writes `text` to a file atomically.
  Status WriteText(const std::string& path, const std::string& text);

 private:
  Storage& storage_;
  std::stop_token stop_;
  ProgressMode progress_mode_ = ProgressMode::kAuto;
  int failure_code_ = 1;
};

/// The error of work that Ctrl-C stopped; the command line turns it into exit code 130.
[[nodiscard]] Error InterruptedError(const std::string& attempted);

}  // namespace annulus
