#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/firmware_iface/modbus_rig.h"

namespace annulus {

/// What every ModbusLink promises, whatever lies below: INSTANTIATE_TEST_SUITE_P with NamedModbusRigs.
class ModbusLinkContract : public testing::TestWithParam<NamedModbusRig> {
 protected:
  ModbusLinkContract() : rig_(GetParam().make()) {}

  ModbusReply Read(std::uint16_t address, std::uint16_t count) {
    return rig_->link().Transact({ModbusFunction::kReadRegisters, 0, {}, address, count}, Patient());
  }
  ModbusReply Count(std::uint16_t counter) {
    return rig_->link().Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {counter}, 0x0100, 2}, Patient());
  }
  [[nodiscard]] std::chrono::nanoseconds Patient() const { return rig_->Longer(std::chrono::milliseconds(250)); }
  /// Lets pass what is still on its way, then throws it away.
  void Settle() {
    rig_->clock().SleepUntil(rig_->clock().Now() + rig_->Longer(std::chrono::milliseconds(100)));
    rig_->link().DiscardInput();
  }

  std::unique_ptr<ModbusRig> rig_;
};

// docs/wire_protocol.md: protocol version 1, firmware 1.3, serial 4711.
TEST_P(ModbusLinkContract, ReadsRegisters) {
  const ModbusReply reply = Read(0x0108, 4);
  ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
  EXPECT_EQ(*reply, (std::vector<std::uint16_t>{1, 0x0103, 0, 4711}));
}

TEST_P(ModbusLinkContract, WritesOneRegisterAndManyAndReadsThemBack) {
  const ModbusReply one = rig_->link().Transact({ModbusFunction::kWriteRegister, 0x0000, {0xBEEF}, 0, 0}, Patient());
  ASSERT_TRUE(one) << ModbusFailureText(one.error());
  EXPECT_TRUE(one->empty());
  const ModbusReply many =
      rig_->link().Transact({ModbusFunction::kWriteRegisters, 0x0003, {1, 0xFFFF, 0x8000, 4}, 0, 0}, Patient());
  ASSERT_TRUE(many) << ModbusFailureText(many.error());
  EXPECT_TRUE(many->empty());
  const ModbusReply back = Read(0x0000, 7);
  ASSERT_TRUE(back) << ModbusFailureText(back.error());
  EXPECT_EQ(*back, (std::vector<std::uint16_t>{0xBEEF, 0, 0, 1, 0xFFFF, 0x8000, 4}));
}

TEST_P(ModbusLinkContract, WritesBeforeItReadsInOneTransaction) {
  for (std::uint16_t counter = 0xFFF0; counter != 0x0010; ++counter) {
    const ModbusReply reply = Count(counter);
    ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
    ASSERT_EQ(reply->size(), 2U);
    EXPECT_EQ((*reply)[0], counter);
  }
}

TEST_P(ModbusLinkContract, TellsExceptionsApartAndGoesOnAfterThem) {
  const ModbusReply nowhere = Read(0x4000, 2);
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().fault, ModbusFault::kException);
  EXPECT_EQ(nowhere.error().exception_code, 2);
  const ModbusReply refused = rig_->link().Transact({ModbusFunction::kWriteRegister, 0x0002, {7}, 0, 0}, Patient());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, ModbusFault::kException);
  EXPECT_EQ(refused.error().exception_code, 3);
  const ModbusReply reply = Count(77);
  ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
  EXPECT_EQ((*reply)[0], 77);
}

TEST_P(ModbusLinkContract, GivesUpInTimeAndAnswersAgainLater) {
  ASSERT_TRUE(Count(1));
  rig_->Silence();
  const auto timeout = rig_->Longer(std::chrono::milliseconds(20));
  const auto asked = rig_->clock().Now();
  const ModbusReply silent =
      rig_->link().Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {2}, 0x0100, 2}, timeout);
  const auto waited = rig_->clock().Now() - asked;
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().fault, ModbusFault::kTimeout);
  // A kernel may round down what is left of a time-out, and come back late.
  EXPECT_GE(waited, timeout - std::chrono::milliseconds(2));
  EXPECT_LE(waited, timeout + rig_->Longer(std::chrono::milliseconds(rig_->real_time ? 500 : 1)));
  rig_->Speak();
  Settle();
  const ModbusReply reply = Count(3);
  ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
  EXPECT_EQ((*reply)[0], 3);
}

TEST_P(ModbusLinkContract, IsLostWhenUnpluggedAndComesBackUnderItsName) {
  ASSERT_TRUE(Count(1));
  rig_->Unplug();
  const ModbusReply gone = Count(2);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().fault, ModbusFault::kLinkLost) << ModbusFailureText(gone.error());
  EXPECT_FALSE(rig_->link().Reopen());
  const ModbusReply still_gone = Count(3);
  ASSERT_FALSE(still_gone);
  EXPECT_EQ(still_gone.error().fault, ModbusFault::kLinkLost);
  rig_->Plug();
  const auto deadline = rig_->clock().Now() + rig_->Longer(std::chrono::seconds(3));
  auto opened = rig_->link().Reopen();
  while (!opened && rig_->clock().Now() < deadline) {
    rig_->clock().SleepUntil(rig_->clock().Now() + std::chrono::milliseconds(50));
    opened = rig_->link().Reopen();
  }
  ASSERT_TRUE(opened) << ModbusFailureText(opened.error());
  const ModbusReply reply = Count(4);
  ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
  EXPECT_EQ((*reply)[0], 4);
}

TEST_P(ModbusLinkContract, AnswersNothingOnceClosedUntilReopened) {
  ASSERT_TRUE(Count(1));
  rig_->link().Close();
  rig_->link().Close();
  rig_->link().DiscardInput();
  const ModbusReply closed = Count(2);
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().fault, ModbusFault::kLinkLost);
  const auto opened = rig_->link().Reopen();
  ASSERT_TRUE(opened) << ModbusFailureText(opened.error());
  const ModbusReply reply = Count(3);
  ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
  EXPECT_EQ((*reply)[0], 3);
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ModbusLinkContract);

}  // namespace annulus
