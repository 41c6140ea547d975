#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace annulus {

/// Some threads that take work from one queue, in its order. With one thread: one after the other. Work must not throw.
/// Thread-safe.
class WorkerLane {
 public:
  /// `name` of the threads, at most 12 letters; they are numbered.
  WorkerLane(const std::string& name, std::size_t threads);
  /// As Stop(Leftover::kDrop).
  ~WorkerLane();
  WorkerLane(const WorkerLane&) = delete;
  WorkerLane& operator=(const WorkerLane&) = delete;

  /// False after Stop: then it will not be done.
  bool Run(std::function<void()> work);

  enum class Leftover { kDrop, kFinish };
  /// Takes nothing more; returns when all threads have ended. What is under way is finished in any case.
  void Stop(Leftover leftover);

 private:
  void Loop();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> queue_;
  bool stopped_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace annulus
