// The boards' ports on a real USB host controller: who is there, transfers in flight at an unplug, hotplug.

#include <grp.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <iostream>
#include <map>
#include <memory>
#include <set>

#include "firmware_iface/usb_frame_codec.h"
#include "firmware_iface/usb_host.h"
#include "tests/hil/guest/machine.h"
#include "tests/hil/guest/usb_ring.h"

namespace annulus::hil {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr int kTransfers = 64;

class UsbHostKernel : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(WaitForBoards(clock_));
    auto host = OpenLibusbHost(clock_);
    ASSERT_TRUE(host) << host.error().Text();
    host_ = std::move(*host);
  }
  [[nodiscard]] nanoseconds In(nanoseconds time) const { return clock_.Now() + time; }

  /// Lets the first board send 100 frames a second.
  static void Stream(UsbPort& port) {
    const auto request = [](BoardRequest what) { return UsbRequest{static_cast<std::uint8_t>(what), 0, 0}; };
    const auto armed = port.ControlOut(request(BoardRequest::kArm), EncodeLevelRate(100'000), seconds(1));
    ASSERT_TRUE(armed) << armed.error().detail;
    const auto started = port.ControlOut(request(BoardRequest::kStartSync), {}, seconds(1));
    ASSERT_TRUE(started) << started.error().detail;
  }

  SystemClock clock_;
  std::unique_ptr<UsbHost> host_;
};

TEST_F(UsbHostKernel, ListsTwelveBoardsEachAtItsPlace) {
  const auto list = host_->List();
  ASSERT_TRUE(list) << list.error().detail;
  std::set<std::string> serials;
  std::set<std::string> places;
  for (const UsbIdentity& identity : *list) {
    EXPECT_EQ(identity.vendor_id, 0x1209);
    EXPECT_EQ(identity.product_id, 0xA180);
    serials.insert(identity.serial);
    places.insert(identity.port_path);
  }
  EXPECT_EQ(serials.size(), kBoards);
  EXPECT_EQ(places.size(), kBoards);
  EXPECT_EQ(serials.count(""), 0U);
  EXPECT_GT(host_->transfer_memory(), 0U) << "usbfs_memory_mb of the real kernel";
}

TEST_F(UsbHostKernel, B7_EveryTransferOfAPortThatIsUnpluggedWhileItStreamsEndsOnce) {
  std::map<UsbStatus, int> ends;
  for (int round = 0; round < (IsLongRun() ? 24 : 12); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const auto port = OpenPort(*host_, {0x1209, 0xA180, SerialOf(0), ""}, clock_, In(seconds(30)));
    ASSERT_TRUE(port) << port.error().detail;
    std::set<std::uint64_t> pending;
    for (int i = 0; i < kTransfers; ++i) {
      const auto token = (*port)->SubmitBulkIn(kLevelEndpoint, 512);
      ASSERT_TRUE(token) << token.error().detail;
      pending.insert(token->value);
    }
    Stream(**port);
    const auto first = (*port)->WaitCompletion(In(seconds(10)));
    ASSERT_TRUE(first) << "no frame in 10 s";
    EXPECT_EQ(first->status, UsbStatus::kCompleted);
    pending.erase(first->token.value);
    Unplug(0);
    const nanoseconds deadline = In(seconds(10));
    while ((*port)->in_flight() > 0 && clock_.Now() < deadline) {
      if (const auto completion = (*port)->WaitCompletion(In(milliseconds(500)))) {
        EXPECT_EQ(pending.erase(completion->token.value), 1U) << "ended twice, or never submitted";
        ++ends[completion->status];
      }
    }
    EXPECT_TRUE(pending.empty()) << pending.size() << " transfers never ended";
    EXPECT_FALSE((*port)->SubmitBulkIn(kLevelEndpoint, 512));
    EXPECT_FALSE((*port)->ControlIn({static_cast<std::uint8_t>(BoardRequest::kReadClock), 0, 0}, 8, milliseconds(500)));
    Plug(0);
  }
  for (const auto& [status, count] : ends) std::cout << count << " transfers ended: " << UsbStatusText(status) << "\n";
}

/// Opens the first board as another user of this group: 0 opened, 1 refused for want of rights, 2 anything else.
int OpenAs(gid_t group) {
  const pid_t child = ::fork();
  if (child == 0) {
    constexpr uid_t kSomebody = 1000;
    if (::setgroups(0, nullptr) != 0 || ::setgid(group) != 0 || ::setuid(kSomebody) != 0) ::_exit(2);
    SystemClock clock;
    const auto host = OpenLibusbHost(clock);
    if (!host) ::_exit(2);
    const auto port = (*host)->Open({0x1209, 0xA180, SerialOf(0), ""});
    if (port) ::_exit(0);
    ::_exit(port.error().status == UsbStatus::kNoAccess ? 1 : 2);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 2;
}

TEST_F(UsbHostKernel, B9_OpensByTheRightsOfTheBoothsGroupAndSaysWhenTheyAreMissing) {
  const group* ours = ::getgrnam("annulus");
  ASSERT_NE(ours, nullptr);
  EXPECT_EQ(OpenAs(ours->gr_gid), 0);
  EXPECT_EQ(OpenAs(1000), 1);
}

TEST_F(UsbHostKernel, B2_TellsWhoLeftAndWhoCame) {
  while (host_->WaitHotplug(In(milliseconds(300)))) {
  }
  Unplug(3);
  const auto left = host_->WaitHotplug(In(seconds(20)));
  ASSERT_TRUE(left) << "no event in 20 s";
  EXPECT_EQ(left->kind, UsbHotplug::Kind::kLeft);
  EXPECT_FALSE(left->identity.port_path.empty());
  const auto list = host_->List();
  ASSERT_TRUE(list);
  EXPECT_EQ(list->size(), kBoards - 1);
  Plug(3);
  const auto came = host_->WaitHotplug(In(seconds(20)));
  ASSERT_TRUE(came) << "no event in 20 s";
  EXPECT_EQ(came->kind, UsbHotplug::Kind::kArrived);
  EXPECT_EQ(came->identity.port_path, left->identity.port_path);
  const auto port = OpenPort(*host_, came->identity, clock_, In(seconds(30)));
  ASSERT_TRUE(port) << port.error().detail;
  EXPECT_EQ((*port)->identity().serial, SerialOf(3));
}

}  // namespace
}  // namespace annulus::hil
