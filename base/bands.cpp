#include "base/bands.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace annulus {

int ThreadCount(int requested) {
  const int count = requested > 0 ? requested : static_cast<int>(std::thread::hardware_concurrency());
  return std::clamp(count, 1, 64);
}

void ForEachBand(int count, int threads, const std::stop_token& stop, const std::function<void(int)>& work) {
  std::atomic<int> next{0};
  const auto run = [&] {
    for (int band = next.fetch_add(1); band < count && !stop.stop_requested(); band = next.fetch_add(1)) work(band);
  };
  std::vector<std::jthread> others;
  for (int k = 1; k < std::min(threads, count); ++k) others.emplace_back(run);
  run();
}

}  // namespace annulus
