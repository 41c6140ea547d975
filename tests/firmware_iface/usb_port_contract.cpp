#include "tests/firmware_iface/usb_port_contract.h"

#include <cmath>

#include "firmware_iface/usb_frame_codec.h"

namespace annulus::contract {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

namespace {

constexpr std::size_t kTransferBytes = 2048;
constexpr std::uint32_t kRateMhz = 50'000;

UsbRequest Request(BoardRequest request) { return {static_cast<std::uint8_t>(request), 0, 0}; }

}  // namespace

nanoseconds UsbPortContract::Patient(nanoseconds time) const {
  return nanoseconds(std::llround(static_cast<double>(time.count()) * fixture_->patience()));
}

nanoseconds UsbPortContract::In(nanoseconds time) const { return fixture_->clock().Now() + Patient(time); }

void UsbPortContract::SetUp() {
  fixture_ = GetParam().make();
  ASSERT_NE(fixture_, nullptr);
}

void UsbPortContract::TearDown() {
  if (fixture_ == nullptr) return;
  StopLevels();
  CollectAll();
}

void UsbPortContract::StartLevels() {
  const auto armed = port().ControlOut(Request(BoardRequest::kArm), EncodeLevelRate(kRateMhz), Patient(seconds(1)));
  ASSERT_TRUE(armed) << armed.error().detail;
  const auto started = port().ControlOut(Request(BoardRequest::kStartSync), {}, Patient(seconds(1)));
  ASSERT_TRUE(started) << started.error().detail;
}

void UsbPortContract::StopLevels() {
  static_cast<void>(port().ControlOut(Request(BoardRequest::kStop), {}, Patient(seconds(1))));
}

void UsbPortContract::Submit(int count) {
  for (int i = 0; i < count; ++i) {
    const auto token = port().SubmitBulkIn(kLevelEndpoint, kTransferBytes);
    ASSERT_TRUE(token) << token.error().detail;
    EXPECT_TRUE(used_.insert(token->value).second) << "a token is never used twice";
    submitted_.insert(token->value);
  }
  EXPECT_EQ(port().in_flight(), submitted_.size());
}

void UsbPortContract::Account(const UsbCompletion& completion) {
  EXPECT_EQ(submitted_.erase(completion.token.value), 1U) << "each transfer ends once";
  EXPECT_LE(completion.host_time, fixture_->clock().Now());
  EXPECT_LE(completion.data.size(), kTransferBytes);
  EXPECT_EQ(port().in_flight(), submitted_.size());
}

void UsbPortContract::CollectAll() {
  for (const std::uint64_t token : submitted_) port().Cancel({token});
  const nanoseconds deadline = In(seconds(1));
  while (!submitted_.empty()) {
    const auto completion = port().WaitCompletion(deadline);
    ASSERT_TRUE(completion) << submitted_.size() << " transfers never ended";
    Account(*completion);
  }
  EXPECT_EQ(port().in_flight(), 0U);
}

TEST_P(UsbPortContract, SaysWhoItIs) {
  EXPECT_EQ(port().identity().vendor_id, 0x1209);
  EXPECT_EQ(port().identity().product_id, 0xA180);
  EXPECT_EQ(port().identity().serial, "RB" + std::to_string(fixture_->serial()));
  EXPECT_FALSE(port().identity().port_path.empty());
}

TEST_P(UsbPortContract, AnswersARequestWithinItsLength) {
  const auto whole = port().ControlIn(Request(BoardRequest::kIdentify), kBoardIdentityBytes, Patient(seconds(1)));
  ASSERT_TRUE(whole) << whole.error().detail;
  const auto identity = DecodeBoardIdentity(*whole);
  ASSERT_TRUE(identity) << identity.error().Text();
  EXPECT_EQ(identity->serial, fixture_->serial());
  const auto roomy = port().ControlIn(Request(BoardRequest::kIdentify), 200, Patient(seconds(1)));
  ASSERT_TRUE(roomy);
  EXPECT_EQ(roomy->size(), kBoardIdentityBytes) << "what the board has, not what was asked for";
  const auto begin = port().ControlIn(Request(BoardRequest::kIdentify), 4, Patient(seconds(1)));
  ASSERT_TRUE(begin);
  EXPECT_EQ(begin->size(), 4U);
}

TEST_P(UsbPortContract, TellsAStallFromOtherFailuresAndGoesOn) {
  for (int i = 0; i < 3; ++i) {
    const auto in = port().ControlIn({0x77, 0, 0}, 8, Patient(seconds(1)));
    ASSERT_FALSE(in);
    EXPECT_EQ(in.error().status, UsbStatus::kStall);
    const auto out = port().ControlOut({0x77, 0, 0}, {}, Patient(seconds(1)));
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().status, UsbStatus::kStall);
  }
  EXPECT_TRUE(port().ControlIn(Request(BoardRequest::kReadClock), 8, Patient(seconds(1))));
}

TEST_P(UsbPortContract, DeliversTheStreamInOrder) {
  StartLevels();
  Submit(4);
  UsbFrameAssembler assembler;
  std::uint32_t sequence = 0;
  nanoseconds last{0};
  while (sequence < 30) {
    const auto completion = port().WaitCompletion(In(seconds(1)));
    ASSERT_TRUE(completion);
    ASSERT_EQ(completion->status, UsbStatus::kCompleted);
    EXPECT_GE(completion->host_time, last);
    last = completion->host_time;
    Account(*completion);
    for (const LevelFrame& frame : assembler.Push(completion->data)) EXPECT_EQ(frame.sequence, sequence++);
    Submit(1);
  }
  EXPECT_EQ(assembler.rejected_bytes(), 0U);
}

TEST_P(UsbPortContract, AnswersRequestsWhileItStreams) {
  StartLevels();
  Submit(4);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(port().ControlIn(Request(BoardRequest::kReadClock), 8, Patient(seconds(1))));
    const auto completion = port().WaitCompletion(In(seconds(1)));
    ASSERT_TRUE(completion);
    Account(*completion);
    Submit(1);
  }
}

TEST_P(UsbPortContract, WaitsUntilTheDeadlineAndNoLonger) {
  Submit(2);
  const nanoseconds begin = fixture_->clock().Now();
  const nanoseconds deadline = begin + milliseconds(30);
  EXPECT_FALSE(port().WaitCompletion(deadline)) << "an idle board sends nothing";
  EXPECT_GE(fixture_->clock().Now(), deadline);
  EXPECT_LT(fixture_->clock().Now(), deadline + Patient(milliseconds(100)));
  const nanoseconds again = fixture_->clock().Now();
  EXPECT_FALSE(port().WaitCompletion(begin)) << "a deadline in the past only collects";
  EXPECT_LT(fixture_->clock().Now(), again + Patient(milliseconds(100)));
}

TEST_P(UsbPortContract, EndsEveryCancelledTransfer) {
  for (int round = 0; round < 20; ++round) {
    Submit(1 + round % 8);
    CollectAll();
  }
  port().Cancel({0});
  port().Cancel({1'000'000});
  EXPECT_EQ(port().in_flight(), 0U) << "a token that is not in flight is ignored";
}

TEST_P(UsbPortContract, EndsTransfersThatAreCancelledInTheMidstOfTheStream) {
  for (int round = 0; round < 10; ++round) {
    StartLevels();
    Submit(6);
    const auto completion = port().WaitCompletion(In(seconds(1)));
    ASSERT_TRUE(completion);
    Account(*completion);
    CollectAll();
    StopLevels();
  }
}

TEST_P(UsbPortContract, ClearsAHaltThatIsNone) {
  EXPECT_TRUE(port().ClearHalt(kLevelEndpoint));
  StartLevels();
  Submit(1);
  const auto completion = port().WaitCompletion(In(seconds(1)));
  ASSERT_TRUE(completion);
  Account(*completion);
  EXPECT_EQ(completion->status, UsbStatus::kCompleted);
}

TEST_P(UsbPortContract, EndsEverythingAtAnUnplugAndTakesNothingMore) {
  if (!fixture_->CanUnplug()) GTEST_SKIP() << "nothing can be unplugged here";
  StartLevels();
  Submit(8);
  for (int i = 0; i < 5; ++i) {
    const auto completion = port().WaitCompletion(In(seconds(1)));
    ASSERT_TRUE(completion);
    Account(*completion);
    Submit(1);
  }
  fixture_->Unplug();
  // The kernel may take a moment to notice; each transfer ends, as NO_DEVICE, as an error, or even well.
  const nanoseconds deadline = In(seconds(2));
  while (!submitted_.empty()) {
    const auto completion = port().WaitCompletion(deadline);
    ASSERT_TRUE(completion) << submitted_.size() << " transfers never ended";
    Account(*completion);
  }
  const auto token = port().SubmitBulkIn(kLevelEndpoint, kTransferBytes);
  ASSERT_FALSE(token);
  EXPECT_EQ(token.error().status, UsbStatus::kNoDevice);
  const nanoseconds asking = fixture_->clock().Now();
  EXPECT_FALSE(port().ControlIn(Request(BoardRequest::kReadClock), 8, Patient(seconds(1))));
  EXPECT_FALSE(port().ClearHalt(kLevelEndpoint));
  EXPECT_LT(fixture_->clock().Now(), asking + Patient(seconds(2)));
}

}  // namespace annulus::contract
