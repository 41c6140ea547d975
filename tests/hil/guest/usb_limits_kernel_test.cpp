// What the ring takes of a real kernel: processor time, and memory for transfers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <iostream>
#include <memory>

#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_frame_codec.h"
#include "firmware_iface/usb_host.h"
#include "tests/hil/guest/usb_ring.h"

namespace annulus::hil {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;

constexpr const char* kMemoryFile = "/sys/module/usbcore/parameters/usbfs_memory_mb";

/// Processor time of this process, its own and the kernel's for it, s.
double ProcessorTime() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds_of = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
}

/// Changes the kernel's limit for as long as it lives.
class MemoryLimit {
 public:
  explicit MemoryLimit(int megabytes) {
    std::ifstream(kMemoryFile) >> before_;
    std::ofstream(kMemoryFile) << megabytes;
  }
  ~MemoryLimit() { std::ofstream(kMemoryFile) << before_; }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  int before_ = 16;
};

class UsbLimitsKernel : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(WaitForBoards(clock_));
    auto host = OpenLibusbHost(clock_);
    ASSERT_TRUE(host) << host.error().Text();
    host_ = std::move(*host);
  }

  SystemClock clock_;
  std::unique_ptr<UsbHost> host_;
};

TEST_F(UsbLimitsKernel, TakesLittleProcessorTimeAtFiftyLevelsPerSecond) {
  const auto ring = OpenUsbRangeRing(*host_, PatientRingOptions(), clock_);
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(50.0)));
  ASSERT_TRUE((*ring)->NextLevel(clock_.Now() + seconds(10)));
  const double begin_cpu = ProcessorTime();
  const auto begin = clock_.Now();
  for (int i = 0; i < 250; ++i) ASSERT_TRUE((*ring)->NextLevel(clock_.Now() + seconds(10)));
  const double taken = std::chrono::duration<double>(clock_.Now() - begin).count();
  const double share = (ProcessorTime() - begin_cpu) / taken;
  std::cout << "driver, libusb and kernel take " << 100.0 * share << " % of an emulated core at 50 levels/s\n";
  // The promise is 15 % of a real core; software emulation is some five to ten times slower than one.
  EXPECT_LT(share, 0.75);
}

TEST_F(UsbLimitsKernel, B8_TellsThatTheKernelHasNoMemoryForTransfersAndClosesAllTheSame) {
  const MemoryLimit limit(1);
  EXPECT_EQ(host_->transfer_memory(), std::uint64_t{1} << 20);
  auto port =
      OpenPort(*host_, {kRingBoardVendor, kRingBoardProduct, SerialOf(0), ""}, clock_, clock_.Now() + seconds(30));
  ASSERT_TRUE(port) << port.error().detail;
  UsbResult<UsbToken> token = UsbToken{};
  std::size_t submitted = 0;
  for (; submitted < 100 && token; ++submitted) token = (*port)->SubmitBulkIn(kLevelEndpoint, 65'536);
  ASSERT_FALSE(token) << "16 transfers of 64 KiB fill a megabyte";
  EXPECT_LE(submitted, 17U);
  EXPECT_EQ(token.error().status, UsbStatus::kNoMemory);
  EXPECT_THAT(token.error().detail, HasSubstr("1 MB together (usbfs_memory_mb)"));
  const auto begin = clock_.Now();
  port->reset();
  EXPECT_LT(clock_.Now() - begin, seconds(5));
}

TEST_F(UsbLimitsKernel, B8_ARingWhoseTransfersCanNotFitIsNotArmed) {
  const MemoryLimit limit(1);
  UsbRangeRingOptions options = PatientRingOptions();
  options.transfers_per_board = 50;
  const auto ring = OpenUsbRangeRing(*host_, options, clock_);
  ASSERT_TRUE(ring) << ring.error().Text();
  const Status started = (*ring)->Start(Hertz(50.0));
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("usbfs_memory_mb"));
  EXPECT_EQ((*ring)->state(), RangeRing::State::kIdle);
}

}  // namespace
}  // namespace annulus::hil
