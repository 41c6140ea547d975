#include "sim/faulty_modbus_link.h"

#include <gtest/gtest.h>

#include "sim/axis_firmware.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;

class FaultyModbusLinkTest : public testing::Test {
 protected:
  ModbusReply Count(FaultyModbusLink& line, std::uint16_t counter) {
    return line.Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {counter}, 0x0100, 2}, milliseconds(30));
  }
  static ModbusFatePlan Once(ModbusFate fate) {
    return [fate, left = 1]() mutable { return left-- > 0 ? fate : ModbusFate{}; };
  }
  /// What the drive holds, asked beside the line.
  std::uint16_t Counter() {
    return drive_.Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0100, 1}, milliseconds(30))->at(0);
  }

  ManualClock clock_;
  AxisDriveModel drive_{{}, clock_};
};

TEST_F(FaultyModbusLinkTest, TakesTheFirstReplyForTheAnswerWhereNothingNumbersThem) {
  ModbusFate late;
  late.delay = std::chrono::microseconds(28'600);  // after the time-out, before the next reply
  FaultyModbusLink line(drive_, clock_, ModbusNumbering::kNone, Once(late));
  EXPECT_FALSE(Count(line, 1));
  const auto wrong = Count(line, 2);
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->at(0), 1);
  const auto still_wrong = Count(line, 3);
  ASSERT_TRUE(still_wrong);
  EXPECT_EQ(still_wrong->at(0), 2);
  line.DiscardInput();
  const auto right = Count(line, 4);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->at(0), 4);
}

TEST_F(FaultyModbusLinkTest, TellsRepliesApartWhereTheyAreNumbered) {
  ModbusFate twice;
  twice.copies = 2;
  FaultyModbusLink line(drive_, clock_, ModbusNumbering::kTransaction, Once(twice));
  EXPECT_TRUE(Count(line, 1));
  const auto other = Count(line, 2);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().fault, ModbusFault::kBadReply);
}

TEST_F(FaultyModbusLinkTest, CarriesOutARequestWhoseReplyIsLostAndNotOneThatIsLostItself) {
  ModbusFate reply_lost;
  reply_lost.copies = 0;
  FaultyModbusLink line(drive_, clock_, ModbusNumbering::kNone, Once(reply_lost));
  EXPECT_FALSE(Count(line, 11));
  EXPECT_EQ(Counter(), 11);
  ModbusFate request_lost;
  request_lost.request_lost = true;
  line.SetPlan(Once(request_lost));
  EXPECT_FALSE(Count(line, 12));
  EXPECT_EQ(Counter(), 11);
}

TEST_F(FaultyModbusLinkTest, DeliversWhatAFrozenPeerWasSentWhenItThaws) {
  FaultyModbusLink line(drive_, clock_);
  line.Freeze();
  EXPECT_FALSE(Count(line, 21));
  EXPECT_FALSE(Count(line, 22));
  EXPECT_EQ(Counter(), 0);
  EXPECT_EQ(line.Thaw(), 2U);
  EXPECT_EQ(Counter(), 22);
}

TEST_F(FaultyModbusLinkTest, ResetsTakeBackAllButOneOfWhatAFrozenPeerWasSent) {
  FaultyModbusLink line(drive_, clock_, ModbusNumbering::kTransaction);
  line.Freeze();
  EXPECT_FALSE(Count(line, 31));
  EXPECT_FALSE(Count(line, 32));
  line.Close();
  EXPECT_EQ(Count(line, 33).error().fault, ModbusFault::kLinkLost);
  EXPECT_EQ(line.Thaw(), 1U);
  EXPECT_EQ(Counter(), 31);
}

TEST_F(FaultyModbusLinkTest, ThawsByItselfWhileSomebodyWaits) {
  FaultyModbusLink line(drive_, clock_);
  line.FreezeUntil(clock_.Now() + milliseconds(10));
  const auto reply = Count(line, 41);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->at(0), 41);
  EXPECT_GE(clock_.Now(), milliseconds(10));
}

TEST_F(FaultyModbusLinkTest, RepeatsItsFatesForTheSameSeedAndMeetsItsRates) {
  ModbusFaultRates rates;
  rates.request_lost = 0.1;
  rates.exception = 0.2;
  rates.repeated = 0.3;
  const auto draw = [&](std::uint64_t seed) {
    ModbusFatePlan plan = SeededModbusFates(rates, seed);
    std::vector<ModbusFate> fates;
    for (int i = 0; i < 10'000; ++i) fates.push_back(plan());
    return fates;
  };
  const auto first = draw(5);
  const auto again = draw(5);
  int lost = 0;
  int refused = 0;
  int repeated = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].delay, again[i].delay);
    EXPECT_EQ(first[i].copies, again[i].copies);
    EXPECT_EQ(first[i].exception, again[i].exception);
    lost += first[i].request_lost ? 1 : 0;
    refused += first[i].exception ? 1 : 0;
    repeated += first[i].copies > 1 ? 1 : 0;
    if (first[i].exception) {
      EXPECT_GE(*first[i].exception, 1);
      EXPECT_LE(*first[i].exception, 6);
    }
  }
  // Five standard deviations of a binomial count: 5 · sqrt(10,000 · p (1 - p)).
  EXPECT_NEAR(lost, 1'000, 150);
  EXPECT_NEAR(refused, 2'000, 200);
  EXPECT_NEAR(repeated, 3'000, 230);
}

}  // namespace
}  // namespace annulus::sim
