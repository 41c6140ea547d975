#pragma once

#include <stop_token>

namespace annulus {

/// The version that --version prints and files carry.
[[nodiscard]] const char* ProgramVersion();

/// Runs one command of the `annulus` program. Returns its exit code: 0 success, 1 the task failed, 2 wrong usage,
/// 130 stopped by `stop`. Errors go to stderr as one line.
int RunCommandLine(int argc, const char* const* argv, const std::stop_token& stop);

}  // namespace annulus
