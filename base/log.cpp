#include "base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>

namespace annulus {
namespace {

spdlog::level::level_enum SpdLevel(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

// The one process-wide log; spdlog's sinks lock themselves.
spdlog::logger& Logger() {
  static const auto logger = [] {
    auto made = std::make_shared<spdlog::logger>("annulus", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    made->set_pattern("annulus [%o ms] %l: %v");
    made->set_level(spdlog::level::warn);
    return made;
  }();
  return *logger;
}

}  // namespace

void Log(LogLevel level, const std::string& text) { Logger().log(SpdLevel(level), "{}", text); }

void SetLogLevel(LogLevel level) { Logger().set_level(SpdLevel(level)); }

}  // namespace annulus
