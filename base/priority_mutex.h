#pragma once

#include <pthread.h>

namespace annulus {

/// A mutex that a real-time thread may share with ordinary ones: whoever holds it while a thread of higher priority
/// waits for it runs at that priority until it lets go. With std::mutex the control tick would wait until the scheduler
/// gives a preempted holder its next turn, on a busy machine some tens of milliseconds. For std::scoped_lock and the
/// like. Thread-safe.
class PriorityMutex {
 public:
  PriorityMutex() {
    pthread_mutexattr_t attributes;
    pthread_mutexattr_init(&attributes);
    // Where the system has no such thing it is an ordinary mutex.
    pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
    if (pthread_mutex_init(&mutex_, &attributes) != 0) pthread_mutex_init(&mutex_, nullptr);
    pthread_mutexattr_destroy(&attributes);
  }
  ~PriorityMutex() { pthread_mutex_destroy(&mutex_); }
  PriorityMutex(const PriorityMutex&) = delete;
  PriorityMutex& operator=(const PriorityMutex&) = delete;

  void lock() { pthread_mutex_lock(&mutex_); }
  bool try_lock() { return pthread_mutex_trylock(&mutex_) == 0; }
  void unlock() { pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_;
};

}  // namespace annulus
