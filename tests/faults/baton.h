#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace annulus::faults {

/// A second thread that runs only while the first one waits for it, and the other way round: two flows of control and
/// never two things at once, so that every run is the same. Each side is ordered after the other's last hand-over.
class Baton {
 public:
  /// The second flow. It waits until it is given the baton first, and has it back when `body` ends.
  explicit Baton(std::function<void()> body)
      : thread_([this, run = std::move(body)] {
          Await(kSecond);
          run();
          ended_ = true;
          Hand(kFirst);
        }) {}
  Baton(const Baton&) = delete;
  Baton& operator=(const Baton&) = delete;
  /// The second flow must have ended.
  ~Baton() { thread_.join(); }

  /// First flow: lets the second one run until it yields or ends. Nothing happens when it has ended.
  void Resume() {
    if (ended_) return;
    Hand(kSecond);
    Await(kFirst);
  }
  /// Second flow: lets the first one go on, until it resumes this one.
  void Yield() {
    Hand(kFirst);
    Await(kSecond);
  }
  /// First flow.
  [[nodiscard]] bool ended() const { return ended_; }
  /// Whether the caller is the second flow.
  [[nodiscard]] bool IsSecond() const { return std::this_thread::get_id() == thread_.get_id(); }

 private:
  enum Side { kFirst, kSecond };
  void Hand(Side to) {
    const std::scoped_lock lock(mutex_);
    holder_ = to;
    changed_.notify_all();
  }
  void Await(Side side) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return holder_ == side; });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  Side holder_ = kFirst;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace annulus::faults
