#pragma once

#include <functional>
#include <stop_token>

namespace annulus {

/// Threads that `requested` stands for: itself, or the machine's count for 0; 1 … 64.
[[nodiscard]] int ThreadCount(int requested);

/// Calls work(0) … work(count - 1), each once, on `threads` threads in unspecified order; returns when all are done.
/// The calls must not touch each other's results and must not throw. No call starts after `stop` is requested.
void ForEachBand(int count, int threads, const std::stop_token& stop, const std::function<void(int)>& work);

}  // namespace annulus
