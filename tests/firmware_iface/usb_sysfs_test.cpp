#include "firmware_iface/usb_sysfs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "firmware_iface/usb_host.h"

namespace annulus {
namespace {

using testing::HasSubstr;

/// A folder that looks like sysfs.
class UsbSysfsTest : public testing::Test {
 protected:
  UsbSysfsTest() : root_(std::filesystem::temp_directory_path() / ("annulus_sysfs_" + std::to_string(::getpid()))) {}
  ~UsbSysfsTest() override { std::filesystem::remove_all(root_); }
  void Write(const std::string& file, const std::string& text) {
    std::filesystem::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  std::string Read(const std::string& file) {
    std::string line;
    std::ifstream(root_ / file) >> line;
    return line;
  }

  std::filesystem::path root_;
  UsbSysfs sysfs_{root_.string()};
};

TEST_F(UsbSysfsTest, ReadsTheSerialNumberOfAPort) {
  Write("bus/usb/devices/1-4.2/serial", "RB1001\n");
  EXPECT_EQ(sysfs_.ReadSerial("1-4.2"), "RB1001");
  EXPECT_EQ(sysfs_.ReadSerial("1-4.3"), std::nullopt);
}

TEST_F(UsbSysfsTest, ReadsTheMemoryForTransfersInBytes) {
  EXPECT_EQ(sysfs_.ReadTransferMemory(), 0U) << "not known";
  Write("module/usbcore/parameters/usbfs_memory_mb", "16\n");
  EXPECT_EQ(sysfs_.ReadTransferMemory(), 16U * 1024 * 1024);
  for (const char* text : {"0\n", "\n", "many\n", "-1\n", "99999999999999999999\n"}) {
    Write("module/usbcore/parameters/usbfs_memory_mb", text);
    EXPECT_EQ(sysfs_.ReadTransferMemory(), 0U) << text;
  }
}

TEST_F(UsbSysfsTest, KeepsADeviceAwakeAndSaysWhereItMayNot) {
  Write("bus/usb/devices/1-1/power/control", "auto\n");
  EXPECT_TRUE(sysfs_.KeepAwake("1-1"));
  EXPECT_EQ(Read("bus/usb/devices/1-1/power/control"), "on");
  const Status absent = sysfs_.KeepAwake("1-2");
  ASSERT_FALSE(absent);
  EXPECT_THAT(absent.error().Text(), HasSubstr("port 1-2"));
  EXPECT_THAT(absent.error().Text(), HasSubstr("udev rule"));
}

// This machine may have no USB at all: the adapter must then say so, or list nothing, and in no case wait or crash.
TEST(LibusbHost, ListsWhatThereIsOrSaysWhyNot) {
  SystemClock clock;
  const auto host = OpenLibusbHost(clock);
  if (!host) {
    EXPECT_FALSE(host.error().advice.empty());
    return;
  }
  const auto known = (*host)->List();
  ASSERT_TRUE(known);
  for (const UsbIdentity& identity : *known) EXPECT_EQ(identity.vendor_id, kRingBoardVendor);
  const auto port = (*host)->Open({kRingBoardVendor, kRingBoardProduct, "no such board", {}});
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().status, UsbStatus::kNoDevice);
  EXPECT_THAT(port.error().detail, HasSubstr("no such board"));
  const auto begin = clock.Now();
  EXPECT_FALSE((*host)->WaitHotplug(begin + std::chrono::milliseconds(20)));
  EXPECT_GE(clock.Now(), begin + std::chrono::milliseconds(20));
}

}  // namespace
}  // namespace annulus
