#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "sim/fault_actors.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Kind = FaultKind;

constexpr std::uint64_t kForCan = 0x63616e00;
constexpr std::uint32_t kIntruderSerial = 9001;

}  // namespace

/// A station that talks all the time.
class CanFaultActor::Babbler final : public CanStation {
 public:
  void BabbleBetween(nanoseconds from, nanoseconds to, nanoseconds period, std::uint32_t id) {
    next_ = from;
    to_ = to;
    period_ = period;
    id_ = id;
  }
  void EndBy(nanoseconds time) { to_ = std::min(to_, time); }
  void OnFrame(const CanFrame&, nanoseconds) override {}
  void OnSent(const CanFrame&, nanoseconds) override { --waiting_; }
  void OnState(CanState, nanoseconds) override {}
  [[nodiscard]] std::optional<nanoseconds> NextTime() const override {
    if (next_ >= to_) return std::nullopt;
    return next_;
  }
  void Act(nanoseconds time) override {
    if (next_ >= to_ || next_ > time) return;
    next_ = std::max(next_ + period_, time + nanoseconds(1));
    // One frame follows the other; what the bus does not take beyond that is not piled up.
    due_ = waiting_ < 2;
  }
  std::vector<CanFrame> TakeFrames() override {
    if (!std::exchange(due_, false)) return {};
    ++waiting_;
    CanFrame frame;
    frame.id = id_;
    frame.size = 8;
    return {frame};
  }

 private:
  nanoseconds next_{0};
  nanoseconds to_{0};
  nanoseconds period_{1};
  std::uint32_t id_ = 0;
  bool due_ = false;
  int waiting_ = 0;
};

CanFaultActor::CanFaultActor(FaultGround ground, const FaultPlan& plan) : ground_(std::move(ground)) {
  const bool babbles = std::any_of(plan.faults.begin(), plan.faults.end(),
                                   [](const Fault& fault) { return fault.kind == Kind::kCanFlood; });
  for (std::size_t bus = 0; bus < ground_.booth.can_buses().size(); ++bus) {
    faulty_.push_back(std::make_unique<FaultyCanBus>(*ground_.booth.can_buses()[bus], ground_.clock));
    faulty_.back()->OnCall([this, bus] { ground_.on_call({FaultTarget::kCan, bus, false}); });
    buses_.push_back(faulty_.back().get());
    if (!babbles) continue;
    babblers_.push_back(std::make_unique<Babbler>());
    ground_.booth.can_wire(bus).Attach(*babblers_.back());
  }
}

CanFaultActor::~CanFaultActor() = default;

std::vector<std::size_t> CanFaultActor::BusesOf(const Fault& fault) const {
  std::vector<std::size_t> buses;
  for (std::size_t bus = 0; bus < faulty_.size(); ++bus) {
    if (fault.Choice(FaultArg::kBus).value_or(bus) == bus) buses.push_back(bus);
  }
  return buses;
}

std::size_t CanFaultActor::BusOfBoard(std::size_t board) const {
  return std::min(board, BoothDevices::kBoards - 1) * faulty_.size() / BoothDevices::kBoards;
}

bool CanFaultActor::HasBoard(const Fault& fault) const {
  return !faulty_.empty() && fault.Whole(FaultArg::kBoard) < ground_.booth.board_count();
}

void CanFaultActor::Begin(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  switch (fault.kind) {
    case Kind::kCanLose:
    case Kind::kCanRepeat:
    case Kind::kCanDisplace:
      holding_.Add(number, fault, from, to);
      return Rebuild();
    case Kind::kCanBoardOff:
    case Kind::kCanBoardHangs:
    case Kind::kCanEmergency:
    case Kind::kCanSameNode:
      if (HasBoard(fault)) BeginOnBoard(fault, from, to);
      return;
    default:
      for (const std::size_t bus : BusesOf(fault)) BeginOnBus(bus, fault, from, to);
      return;
  }
}

bool BeginOnInterface(FaultyCanBus& bus, const Fault& fault, nanoseconds from, nanoseconds to) {
  switch (fault.kind) {
    case Kind::kCanOverflow:
      bus.OverflowBy(fault.Whole(FaultArg::kFrames));
      return true;
    case Kind::kCanQueueFull:
      bus.RefuseSendsBetween(from, to, CanFault::kQueueFull);
      return true;
    case Kind::kCanDown:
      bus.BreakBetween(from, to, CanFault::kDown);
      return true;
    case Kind::kCanGone:
      bus.BreakBetween(from, to, CanFault::kGone);
      return true;
    case Kind::kCanErrorStates: {
      CanReport report;
      const bool passive = fault.Whole(FaultArg::kErrorState) == 1;
      report.state = passive ? CanState::kErrorPassive : CanState::kErrorWarning;
      report.receive_errors = passive ? 130 : 100;
      bus.ReportBetween(from, to, fault.Period(), report);
      return true;
    }
    default:
      return false;
  }
}

void CanFaultActor::BeginOnBus(std::size_t bus, const Fault& fault, nanoseconds from, nanoseconds to) {
  if (BeginOnInterface(*faulty_[bus], fault, from, to)) return;
  switch (fault.kind) {
    case Kind::kCanBusOff:
      return ground_.booth.can_wire(bus).DisturbBetween(from, to);
    case Kind::kCanFlood:
      return babblers_.at(bus)->BabbleBetween(from, to, fault.Period(),
                                              static_cast<std::uint32_t>(fault.Whole(FaultArg::kId)));
    default:
      return;
  }
}

void CanFaultActor::BeginOnBoard(const Fault& fault, nanoseconds from, nanoseconds to) {
  const std::size_t number = fault.Whole(FaultArg::kBoard);
  CanBoardModel& board = ground_.booth.can_board(number);
  switch (fault.kind) {
    case Kind::kCanBoardOff:
      board.PowerOffAt(from);
      if (to != nanoseconds::max()) board.PowerOnAt(to);
      return;
    case Kind::kCanBoardHangs:
      return board.HangAt(from);
    case Kind::kCanEmergency:
      return board.EmergencyAt(from, static_cast<std::uint16_t>(fault.Whole(FaultArg::kCode)));
    case Kind::kCanSameNode: {
      CanBoardOptions options;
      options.board.serial = kIntruderSerial + static_cast<std::uint32_t>(number);
      options.board.first_sensor = static_cast<std::uint16_t>(number * kSensorsPerBoard);
      options.board.seed = MixSeed(ground_.seed, kForCan);
      options.node = static_cast<NodeId>(number + 1);
      intruders_.push_back(std::make_unique<CanBoardModel>(options, ground_.booth.world(), ground_.booth.can_sync(),
                                                           ground_.clock.Now()));
      return ground_.booth.can_wire(BusOfBoard(number)).Attach(*intruders_.back());
    }
    default:
      return;
  }
}

void CanFaultActor::End(std::size_t number, const Fault& fault, nanoseconds time) {
  if (fault.kind == Kind::kCanLose || fault.kind == Kind::kCanRepeat || fault.kind == Kind::kCanDisplace) {
    holding_.Remove(number);
    return Rebuild();
  }
  if (fault.kind == Kind::kCanErrorStates) {
    // A controller says so when it is well again.
    CanReport well;
    well.state = CanState::kErrorActive;
    for (const std::size_t bus : BusesOf(fault)) faulty_[bus]->ReportAt(time, well);
  }
  // Buses and boards were told at the beginning, if the end was known then.
  if (EndsInTime(fault)) return;
  switch (fault.kind) {
    case Kind::kCanBoardOff:
      if (HasBoard(fault)) ground_.booth.can_board(fault.Whole(FaultArg::kBoard)).PowerOnAt(time);
      return;
    case Kind::kCanBusOff:
      for (const std::size_t bus : BusesOf(fault)) ground_.booth.can_wire(bus).DisturbBetween(time, time);
      return;
    case Kind::kCanFlood:
      for (const std::size_t bus : BusesOf(fault)) babblers_.at(bus)->EndBy(time);
      return;
    default:
      for (const std::size_t bus : BusesOf(fault)) faulty_[bus]->EndBy(time);
      return;
  }
}

void CanFaultActor::Rebuild() {
  ++changes_;
  for (std::size_t bus = 0; bus < faulty_.size(); ++bus) {
    CanFrameFaults faults;
    faults.seed = MixSeed(MixSeed(MixSeed(ground_.seed, kForCan), bus), changes_);
    for (const HoldingFaults::Holding& holding : holding_.all()) {
      const Fault& fault = holding.fault;
      if (fault.Choice(FaultArg::kBus).value_or(bus) != bus) continue;
      const double share = fault.Value(FaultArg::kShare);
      if (fault.kind == Kind::kCanLose) faults.lose = share;
      if (fault.kind == Kind::kCanRepeat) faults.repeat = share;
      if (fault.kind != Kind::kCanDisplace) continue;
      faults.displace = share;
      faults.displace_by = fault.Whole(FaultArg::kFrames);
    }
    faulty_[bus]->SetFrameFaults(faults);
  }
}

}  // namespace annulus::sim
