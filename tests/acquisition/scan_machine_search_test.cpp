// The scan machine against the checker of tests/support: every state that it can be in, and a random walk
// of five million events.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <unordered_set>
#include <utility>
#include <vector>

#include "tests/acquisition/scan_machine_walk.h"
#include "tests/support/scan_machine_session.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using test::LookAt;
using test::MachineSession;
using test::MachineView;
using test::ScanMachineChecker;
using test::VisitCounts;
using Kind = ScanEventKind;
using State = ScanState;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSlow = true;
#else
constexpr bool kSlow = false;
#endif

bool IsLong() { return std::getenv("ANNULUS_LONG") != nullptr && !kSlow; }

void PrintVisits(const VisitCounts& visits) {
  std::printf("%-14s", "");
  for (std::size_t s = 0; s < kScanStates; ++s) std::printf("%10s", ScanStateText(static_cast<State>(s)));
  for (std::size_t k = 0; k < kScanEventKinds; ++k) {
    std::printf("\n%-14s", ScanEventText(static_cast<Kind>(k)));
    for (std::size_t s = 0; s < kScanStates; ++s) std::printf("%10llu", static_cast<unsigned long long>(visits[s][k]));
  }
  std::printf("\n");
}

std::size_t PairsVisited(const VisitCounts& visits) {
  std::size_t pairs = 0;
  for (const auto& of_state : visits)
    pairs += static_cast<std::size_t>(std::count_if(of_state.begin(), of_state.end(), [](auto n) { return n > 0; }));
  return pairs;
}

/// From a state, by an event, to the next one.
using Edge = std::tuple<State, Kind, State>;

/// A machine somewhere, with all that was checked of it on the way there.
struct Node {
  ScanMachine machine;
  ScanMachineChecker checker;
  nanoseconds now{0};
};

/// What tells two nodes apart as far as anything that follows: versions and times only count relative to now.
std::string KeyOf(const Node& node) {
  const MachineView& view = node.checker.view();
  std::string key;
  key += static_cast<char>(view.state);
  key += static_cast<char>((view.homed ? 1 : 0) + (view.quick_stop ? 2 : 0) + (node.checker.chain_open() ? 4 : 0));
  // Due is due, however long; else it counts in ticks.
  const auto left = node.checker.deadline() ? *node.checker.deadline() - node.now : nanoseconds(0);
  key += std::to_string(std::max(left, nanoseconds(0)) / scan_time::kTick) + "/";
  for (std::size_t i = 0; i < view.causes.count; ++i) key += static_cast<char>(view.causes.marks.at(i).code);
  return key;
}

ScanEvent Event(Kind kind, CauseCode code = CauseCode::kInternal) {
  ScanEvent event;
  event.kind = kind;
  event.cause = {code, "seen", "do", {}};
  return event;
}

/// All events, with causes of every sort: the chain's own, one for service only, one that stops at once and loses home,
/// one that ramps; roles; good and stale versions; scans that may last 0.3 s or no time.
std::vector<ScanEvent> Alphabet() {
  std::vector<ScanEvent> events;
  for (const CauseCode code : {CauseCode::kChainOpen, CauseCode::kChannelsDiffer})
    events.push_back(Event(Kind::kChainOpened, code));
  for (const CauseCode code :
       {CauseCode::kSensorLost, CauseCode::kAxisLink, CauseCode::kChannelsDiffer, CauseCode::kChainOpen})
    events.push_back(Event(Kind::kFaulted, code));
  for (const CauseCode code : {CauseCode::kHoming, CauseCode::kChainOpen})
    events.push_back(Event(Kind::kHomingFailed, code));
  for (const CauseCode code : {CauseCode::kInternal, CauseCode::kChannelsDiffer})
    events.push_back(Event(Kind::kAwoke, code));
  events.push_back(Event(Kind::kStopOverdue, CauseCode::kStopOverdue));
  for (const CauseRole role : {CauseRole::kOperator, CauseRole::kService}) {
    events.push_back(Event(Kind::kAcknowledged));
    events.back().role = role;
  }
  // The version is set when the event is handed over: 0 becomes the present one, 1 the one before, -1 the one after.
  for (const int longest : {0, 300}) {
    for (const std::uint64_t age : {std::uint64_t{0}, std::uint64_t{1}, ~std::uint64_t{0}}) {
      events.push_back(Event(Kind::kStarted));
      events.back().version = age;
      events.back().longest = milliseconds(longest);
    }
  }
  for (const Kind kind :
       {Kind::kResetTaken, Kind::kHomeOrdered, Kind::kHomed, Kind::kArmed, Kind::kLastLevel, Kind::kCancelled,
        Kind::kArmExpired, Kind::kStopped, Kind::kStopLate, Kind::kJogOrdered, Kind::kJogReleased})
    events.push_back(Event(kind));
  return events;
}

/// Breadth first over everything that can happen, until nothing new is found.
class Search {
 public:
  Search() : alphabet_(Alphabet()) {
    Node first{ScanMachine{}, ScanMachineChecker(LookAt(ScanMachine{})), {}};
    seen_.insert(KeyOf(first));
    open_.push_back(std::move(first));
  }

  /// False: a rule was broken, and the test has failed.
  bool Run() {
    while (!open_.empty()) {
      const Node node = std::move(open_.front());
      open_.pop_front();
      for (ScanEvent event : alphabet_) {
        if (!Visit(node, [&](Node& next) { return Hand(next, event); })) return false;
      }
      for (const nanoseconds time : {nanoseconds(scan_time::kTick), nanoseconds(milliseconds(400))}) {
        if (!Visit(node, [&](Node& next) { return Pass(next, time); })) return false;
      }
      if (node.machine.state() == State::kJog && !Visit(node, [](Node& next) { return Beat(next); })) return false;
    }
    return true;
  }

  [[nodiscard]] std::size_t states() const { return seen_.size(); }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  [[nodiscard]] const VisitCounts& visits() const { return visits_; }
  [[nodiscard]] const auto& edges() const { return edges_; }

 private:
  template <class Action>
  bool Visit(const Node& node, Action action) {
    Node next = node;
    if (const char* broken = action(next)) {
      ADD_FAILURE() << "from " << ScanStateText(node.machine.state()) << ": " << broken;
      return false;
    }
    ++steps_;
    if (seen_.insert(KeyOf(next)).second) open_.push_back(std::move(next));
    return true;
  }

  const char* Hand(Node& node, ScanEvent event) {
    event.time = node.now;
    event.cause.time = node.now;
    event.version = node.machine.version() - event.version;
    const State from = node.machine.state();
    ++visits_.at(static_cast<std::size_t>(from)).at(static_cast<std::size_t>(event.kind));
    const bool refused = !node.machine.Handle(event);
    edges_.insert({from, event.kind, node.machine.state()});
    return node.checker.AfterEvent(event, refused, LookAt(node.machine));
  }

  /// The tick deals with what is due, then time passes to the next one: 10 ms, or 0.4 s if the program hangs.
  const char* Pass(Node& node, nanoseconds time) {
    for (int asked = 0; asked < 4; ++asked) {
      const std::optional<ScanEvent> due = node.machine.Due(node.now);
      if (const char* broken = node.checker.AfterDue(due, node.now)) return broken;
      if (!due) {
        node.now += time;
        return nullptr;
      }
      ScanEvent event = *due;
      event.version = 0;
      if (const char* broken = Hand(node, event)) return broken;
    }
    return "I7: what is due stays due";
  }

  static const char* Beat(Node& node) {
    node.machine.JogBeat(node.now);
    node.checker.Beat(node.now);
    return node.checker.AfterDue(node.machine.Due(node.now), node.now);
  }

  std::vector<ScanEvent> alphabet_;
  std::unordered_set<std::string> seen_;
  std::deque<Node> open_;
  std::uint64_t steps_ = 0;
  VisitCounts visits_{};
  std::set<Edge> edges_;
};

TEST(ScanMachineSearch, EveryReachableStateKeepsEveryRule) {
  Search search;
  ASSERT_TRUE(search.Run());
  std::printf("%zu reachable abstract states, %llu steps, %zu of %zu (state, event) pairs, %zu (state, event, next)\n",
              search.states(), static_cast<unsigned long long>(search.steps()), PairsVisited(search.visits()),
              kScanStates * kScanEventKinds, search.edges().size());
  // Every event can be told in every state, so that all pairs are reachable.
  EXPECT_EQ(PairsVisited(search.visits()), kScanStates * kScanEventKinds);

  const auto moves = [](State s) { return s == State::kHoming || s == State::kScanning || s == State::kJog; };
  std::set<Edge> begins;
  for (const Edge& edge : search.edges()) {
    if (!moves(std::get<0>(edge)) && moves(std::get<2>(edge))) begins.insert(edge);
  }
  EXPECT_EQ(begins, (std::set<Edge>{{State::kIdle, Kind::kHomeOrdered, State::kHoming},
                                    {State::kArmed, Kind::kStarted, State::kScanning},
                                    {State::kIdle, Kind::kJogOrdered, State::kJog}}))
      << "I1: motion begins otherwise than by an order";
}

TEST(ScanMachineWalk, FiveMillionEventsBreakNoRule) {
  const std::uint64_t events = IsLong() ? 50'000'000 : kSlow ? 300'000 : 5'000'000;
  MachineSession<ScanMachine> session;
  const char* broken = test::Walk(session, events, 20261129);
  ASSERT_EQ(broken, nullptr) << "after " << session.events() << " events";
  PrintVisits(session.visits());
  std::printf("%llu events, %llu scans, %zu of %zu pairs\n", static_cast<unsigned long long>(session.events()),
              static_cast<unsigned long long>(session.view().scans), PairsVisited(session.visits()),
              kScanStates * kScanEventKinds);
  EXPECT_EQ(PairsVisited(session.visits()), kScanStates * kScanEventKinds);
  EXPECT_GT(session.view().scans, events / 100) << "the walk hardly comes to the deep states";
}

}  // namespace
}  // namespace annulus
