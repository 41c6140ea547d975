#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "firmware_iface/crc32c.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_frame_codec.h"
#include "sim/usb_host_model.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::bench {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::size_t kBoards = 12;
constexpr std::uint32_t kLevels = 2000;
constexpr std::int64_t kRangesPerLevel = kBoards * kSensorsPerBoard;

std::vector<std::byte> StreamOf(std::uint32_t serial, std::uint32_t levels) {
  std::vector<std::byte> stream;
  LevelFrame frame;
  frame.board_serial = serial;
  for (frame.sequence = 0; frame.sequence < levels; ++frame.sequence) {
    frame.device_time = milliseconds(20) * frame.sequence;
    for (std::uint32_t i = 0; i < kSensorsPerBoard; ++i) frame.range_um[i] = 450'000 + 1000 * i + frame.sequence;
    frame.quality.fill(200);
    const auto bytes = EncodeLevelFrame(frame);
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  return stream;
}

/// A board whose bytes are all made beforehand, so that only the driver's time is measured: each transfer ends at once
/// with the next `frames_per_transfer` frames.
class PreparedPort final : public UsbPort {
 public:
  PreparedPort(std::uint32_t number, std::size_t frames_per_transfer)
      : identity_{0x1209, 0xA180, "RB" + std::to_string(number), "1-" + std::to_string(number)},
        number_(number),
        step_(frames_per_transfer * kLevelFrameBytes),
        stream_(StreamOf(number, kLevels)) {}

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t, nanoseconds) override {
    if (static_cast<BoardRequest>(request.request) == BoardRequest::kReadClock) return std::vector<std::byte>(8);
    BoardIdentity identity;
    identity.serial = number_;
    identity.first_sensor = static_cast<std::uint16_t>(number_ * kSensorsPerBoard);
    identity.min_level_rate_mhz = 15'000;
    identity.max_level_rate_mhz = 100'000;
    const auto bytes = EncodeBoardIdentity(identity);
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte>, nanoseconds) override {
    if (static_cast<BoardRequest>(request.request) == BoardRequest::kArm) at_ = 0;
    return {};
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t, std::size_t) override {
    pending_.push_back({next_token_++});
    return pending_.back();
  }
  void Cancel(UsbToken) override {}
  UsbResult<void> ClearHalt(std::uint8_t) override { return {}; }
  std::optional<UsbCompletion> WaitCompletion(nanoseconds) override {
    if (pending_.empty()) return std::nullopt;
    const std::size_t size = std::min(step_, stream_.size() - at_);
    UsbCompletion completion{pending_.front(), UsbStatus::kCompleted, {}, nanoseconds(0)};
    completion.data.assign(stream_.begin() + static_cast<std::ptrdiff_t>(at_),
                           stream_.begin() + static_cast<std::ptrdiff_t>(at_ + size));
    at_ += size;
    pending_.pop_front();
    return completion;
  }
  [[nodiscard]] std::size_t in_flight() const override { return pending_.size(); }

 private:
  UsbIdentity identity_;
  std::uint32_t number_;
  std::size_t step_;
  std::vector<std::byte> stream_;
  std::size_t at_ = 0;
  std::uint64_t next_token_ = 1;
  std::deque<UsbToken> pending_;
};

void Checksum(benchmark::State& state) {
  const std::vector<std::byte> bytes(static_cast<std::size_t>(state.range(0)), std::byte{0x5A});
  for (auto unused : state) benchmark::DoNotOptimize(Crc32c(bytes));
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) * state.range(0));
}
BENCHMARK(Checksum)->Arg(104)->Arg(65536);

/// Bytes to frames, in transfers of the driver's size. Items are ranges.
void DecodeFrames(benchmark::State& state) {
  const std::vector<std::byte> stream = StreamOf(1001, kLevels);
  constexpr std::size_t kTransfer = 2048;
  for (auto unused : state) {
    UsbFrameAssembler assembler;
    for (std::size_t at = 0; at < stream.size(); at += kTransfer) {
      const auto chunk = std::span(stream).subspan(at, std::min(kTransfer, stream.size() - at));
      benchmark::DoNotOptimize(assembler.Push(chunk));
    }
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kLevels *
                          static_cast<std::int64_t>(kSensorsPerBoard));
}
BENCHMARK(DecodeFrames)->Unit(benchmark::kMillisecond);

/// The whole driver of twelve boards, from ended transfers to levels. Items are ranges.
void ReadLevels(benchmark::State& state) {
  std::vector<std::unique_ptr<PreparedPort>> ports;
  std::vector<UsbPort*> borrowed;
  for (std::uint32_t i = 0; i < kBoards; ++i) {
    ports.push_back(std::make_unique<PreparedPort>(i, static_cast<std::size_t>(state.range(0))));
    borrowed.push_back(ports.back().get());
  }
  ManualClock clock;
  const auto ring = MakeUsbRangeRing(borrowed, {}, clock);
  for (auto unused : state) {
    if (!ring || !(*ring)->Start(Hertz(50.0))) return state.SkipWithError("the ring does not start");
    for (std::uint32_t i = 0; i < kLevels; ++i) {
      const auto level = (*ring)->NextLevel(clock.Now() + milliseconds(40));
      if (!level || level->sequence != i) return state.SkipWithError("a level is missing");
      benchmark::DoNotOptimize(level->range_mm.data());
    }
    state.PauseTiming();
    static_cast<void>((*ring)->Stop());
    state.ResumeTiming();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kLevels * kRangesPerLevel);
  state.counters["cpu_percent_at_50"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kLevels / (50.0 * 100.0),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(ReadLevels)->Arg(1)->Arg(18)->Unit(benchmark::kMillisecond);

/// 1,000 levels per second for a minute of virtual time through the simulated bus; most of the time is the
/// simulation's.
void SustainThousandLevels(benchmark::State& state) {
  constexpr std::uint32_t kMinute = 60'000;
  for (auto unused : state) {
    sim::BoothOptions options = sim::CylinderBooth();
    options.axis.start_z_mm = 500.0;
    options.board.max_level_rate_mhz = 1'000'000;
    sim::Booth booth(std::move(options));
    sim::UsbHostModel host(booth.clock());
    for (std::size_t i = 0; i < kBoards; ++i) host.Add(booth.board(i));
    const auto ring = OpenUsbRangeRing(host, {}, booth.clock());
    if (!ring || !(*ring)->Start(Hertz(1000.0))) return state.SkipWithError("the ring does not start");
    for (std::uint32_t i = 0; i < kMinute; ++i) {
      const auto level = (*ring)->NextLevel(booth.clock().Now() + milliseconds(20));
      if (!level || level->sequence != i) return state.SkipWithError("a level is missing");
    }
    state.counters["levels"] = static_cast<double>((*ring)->counters().levels);
    state.counters["lost_frames"] = static_cast<double>((*ring)->counters().lost_frames);
    static_cast<void>((*ring)->Stop());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kMinute * kRangesPerLevel);
}
BENCHMARK(SustainThousandLevels)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus::bench
