#pragma once

#include <functional>
#include <stop_token>
#include <string_view>

namespace annulus {

/// Told how far a long task is: a stage name in plain words, and `done` of `total` units (0 <= done <= total).
/// Called from the thread that does the work, often; must return quickly.
using ProgressSink = std::function<void(std::string_view stage, double done, double total)>;

/// What long work is given from outside: where to report, and whether to stop early.
struct TaskContext {
  ProgressSink progress;  ///< May be empty.
  std::stop_token stop;   ///< Never requested by default.

  /// Reports if somebody listens.
  void Report(std::string_view stage, double done, double total) const {
    if (progress) progress(stage, done, total);
  }
};

}  // namespace annulus
