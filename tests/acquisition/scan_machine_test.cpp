#include "acquisition/scan_machine.h"

#include <gtest/gtest.h>

namespace annulus {
namespace {

TEST(ScanMachine, StartsSafe) {
  const ScanMachine machine;
  EXPECT_EQ(machine.state(), ScanState::kSafe);
  EXPECT_EQ(machine.Lines(), (LineOrders{.lamp_fault = false}));
  EXPECT_FALSE(machine.may_move());
}

}  // namespace
}  // namespace annulus
