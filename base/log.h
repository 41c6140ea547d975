#pragma once

#include <string>

namespace annulus {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// Writes one line to stderr: time since start, level, text. Thread-safe. No customer's name or measurement goes here.
void Log(LogLevel level, const std::string& text);

/// Lines below `level` are dropped; kWarning at start.
void SetLogLevel(LogLevel level);

}  // namespace annulus
