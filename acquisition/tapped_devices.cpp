#include "acquisition/tapped_devices.h"

#include <utility>

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Tells what became of a call.
class CallTap {
 public:
  explicit CallTap(TapContext context) : context_(context), begin_(context.clock.Now()) {}

  [[nodiscard]] nanoseconds begin() const { return begin_; }
  /// `record.end` is filled in here.
  template <class Record, class T>
  void Tell(Record record, const Result<T>& outcome) {
    const nanoseconds now = context_.clock.Now();
    record.end.took = now - begin_;
    if (!outcome) record.end.error = outcome.error().Text();
    context_.tap.Record(EncodeBusRecord(std::move(record), now));
  }

 private:
  TapContext context_;
  nanoseconds begin_;
};

class TappedRing final : public RangeRing {
 public:
  TappedRing(std::unique_ptr<RangeRing> ring, TapContext context) : ring_(std::move(ring)), context_(context) {}

  [[nodiscard]] State state() const override { return ring_->state(); }
  [[nodiscard]] const std::vector<RingBoard>& boards() const override { return ring_->boards(); }
  [[nodiscard]] const RingLimits& limits() const override { return ring_->limits(); }
  [[nodiscard]] const RingCounters& counters() const override { return ring_->counters(); }
  [[nodiscard]] RingTrouble trouble() const override { return ring_->trouble(); }
  [[nodiscard]] const ReferenceBoard* reference() const override { return ring_->reference(); }

  Status Start(Hertz level_rate) override {
    CallTap call(context_);
    Status done = ring_->Start(level_rate);
    call.Tell(bus_record::StartCalled{{}, level_rate.value()}, done);
    return done;
  }
  Status Stop() override {
    CallTap call(context_);
    const RingCounters counters = ring_->counters();
    Status done = ring_->Stop();
    call.Tell(bus_record::StopCalled{{}, counters}, done);
    return done;
  }
  Result<RingLevel> NextLevel(nanoseconds deadline) override {
    CallTap call(context_);
    auto level = ring_->NextLevel(deadline);
    call.Tell(bus_record::NextLevelCalled{{}, deadline}, level);
    return level;
  }
  Status Reopen(nanoseconds deadline) override {
    CallTap call(context_);
    Status done = ring_->Reopen(deadline);
    call.Tell(bus_record::ReopenCalled{{}, deadline}, done);
    return done;
  }
  Result<ClockExchange> ReadClock(std::size_t board) override {
    CallTap call(context_);
    auto exchange = ring_->ReadClock(board);
    call.Tell(bus_record::ReadClockCalled{{}, static_cast<std::uint8_t>(board), exchange.value_or(ClockExchange())},
              exchange);
    return exchange;
  }

 private:
  std::unique_ptr<RangeRing> ring_;
  TapContext context_;
};

class TappedAxis final : public ScanAxis {
 public:
  TappedAxis(std::unique_ptr<ScanAxis> axis, TapContext context) : axis_(std::move(axis)), context_(context) {}

  [[nodiscard]] State state() const override { return axis_->state(); }
  [[nodiscard]] const AxisIdentity& identity() const override { return axis_->identity(); }
  Status Enable() override { return axis_->Enable(); }
  Status StartHoming() override { return axis_->StartHoming(); }
  Status MoveTo(Millimetres z, MillimetresPerSecond speed) override { return axis_->MoveTo(z, speed); }
  Result<AxisPosition> Position() override {
    CallTap call(context_);
    auto position = axis_->Position();
    bus_record::PositionCalled record;
    if (position && position->fresh) {
      record = {{}, true, position->time.host_before, position->time.host_after};
    }
    call.Tell(std::move(record), position);
    return position;
  }
  Status Halt() override { return axis_->Halt(); }
  Status QuickStop() override { return axis_->QuickStop(); }
  Status Disable() override { return axis_->Disable(); }
  Status Verify() override { return axis_->Verify(); }
  [[nodiscard]] AxisTrouble trouble() const override { return axis_->trouble(); }
  Status Reopen(nanoseconds deadline) override { return axis_->Reopen(deadline); }

 private:
  std::unique_ptr<ScanAxis> axis_;
  TapContext context_;
};

}  // namespace

Result<std::unique_ptr<RangeRing>> OpenTappedRing(TapContext context, bus_record::RingOpening opening,
                                                  const std::function<Result<std::unique_ptr<RangeRing>>()>& open) {
  const bool reference = std::visit([](const auto& options) { return options.reference.has_value(); }, opening.options);
  opening.format = reference ? bus_record::kFormat : bus_record::kFormatWithoutReference;
  context.tap.Record(EncodeBusRecord(std::move(opening), context.clock.Now()));
  auto ring = open();
  if (!ring) return ring;
  context.tap.Record(EncodeBusRecord(bus_record::RingOpened{}, context.clock.Now()));
  return std::make_unique<TappedRing>(std::move(*ring), context);
}

Result<std::unique_ptr<ScanAxis>> OpenTappedAxis(TapContext context, const AxisRegisterMap& map,
                                                 const std::function<Result<std::unique_ptr<ScanAxis>>()>& open) {
  auto axis = open();
  if (!axis) return axis;
  context.tap.Record(EncodeBusRecord(bus_record::AxisOpened{ReadingLayout(map)}, context.clock.Now()));
  return std::make_unique<TappedAxis>(std::move(*axis), context);
}

}  // namespace annulus
