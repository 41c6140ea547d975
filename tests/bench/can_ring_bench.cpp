// What the host spends on a ring on CAN: from the bytes of a socket to whole levels in a queue.

#include <benchmark/benchmark.h>

#include <vector>

#include "base/ensure.h"
#include "firmware_iface/can_level_codec.h"
#include "firmware_iface/socket_can_codec.h"

namespace annulus {
namespace {

constexpr std::uint32_t kLevels = 500;
constexpr NodeId kBoards = 12;
constexpr std::chrono::nanoseconds kPeriod = std::chrono::milliseconds(20);

/// The reads of a socket while twelve boards send their levels, as they come from the bus: by identifier.
std::vector<std::vector<std::byte>> Reads(bool fd) {
  std::vector<std::vector<std::byte>> reads;
  for (std::uint32_t sequence = 0; sequence < kLevels; ++sequence) {
    std::vector<std::vector<CanFrame>> boards;
    for (NodeId node = 1; node <= kBoards; ++node) {
      LevelFrame level;
      level.board_serial = 1000U + node;
      level.sequence = sequence;
      for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
        level.range_um[i] = 450'000 + 40 * static_cast<std::uint32_t>(i + sequence);
        level.quality[i] = 200;
      }
      const auto parts = EncodeCanLevel(node, level);
      boards.emplace_back(parts.begin(), parts.end());
      if (fd) boards.back() = {EncodeCanFdLevel(node, level)};
    }
    for (std::size_t part = 0; part < boards[0].size(); ++part) {
      for (const auto& board : boards) reads.push_back(EncodeSocketCan(board[part]));
    }
  }
  return reads;
}

void DecodeAndQueue(benchmark::State& state, bool fd) {
  const auto reads = Reads(fd);
  for (auto _ : state) {
    std::vector<CanLevelAssembler> boards;
    for (NodeId node = 1; node <= kBoards; ++node) {
      boards.emplace_back(node, 1000U + node);
      boards.back().Begin(kPeriod);
    }
    std::size_t levels = 0;
    std::chrono::nanoseconds time{0};
    for (const auto& bytes : reads) {
      time += kPeriod / 72;
      const auto what = DecodeSocketCan(bytes);
      const auto& frame = std::get<CanFrame>(*what);
      CanLevelAssembler& board = boards[*LevelNodeOf(frame) - 1U];
      board.Push(frame, time);
      for (; board.has_level(); board.Pop()) ++levels;
    }
    ENSURE(levels == std::size_t{kLevels} * kBoards, "every level came out");
  }
  const double ranges = 1.0 * kLevels * kBoards * kSensorsPerBoard;
  state.counters["ranges_per_s"] = benchmark::Counter(ranges, benchmark::Counter::kIsIterationInvariantRate);
}

void BM_CanRingClassic(benchmark::State& state) { DecodeAndQueue(state, false); }
void BM_CanRingFd(benchmark::State& state) { DecodeAndQueue(state, true); }
BENCHMARK(BM_CanRingClassic);
BENCHMARK(BM_CanRingFd);

}  // namespace
}  // namespace annulus
