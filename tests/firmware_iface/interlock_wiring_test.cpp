#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware_iface/interlock.h"

namespace annulus {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using In = InterlockInput;
using Out = InterlockOutput;

TEST(InterlockWiring, DefaultIsValidAndInOrder) {
  const InterlockWiring wiring = InterlockWiring::Default();
  EXPECT_TRUE(wiring.Validate());
  const auto lines = wiring.Lines();
  ASSERT_EQ(lines.size(), 19U);
  EXPECT_EQ(lines.front().name, "estop_a");
  EXPECT_EQ(lines[11].name, "lamp_feedback");
  EXPECT_EQ(lines[12].name, "enable");
  EXPECT_EQ(lines.back().name, "lamp_fault");
}

TEST(InterlockWiring, NamesAllThatIsWrongWithIt) {
  InterlockWiring wiring = InterlockWiring::Default();
  wiring.inputs.erase(In::kDoor);
  wiring.inputs[In::kEstopB].name = "estop_a";
  wiring.inputs[In::kCall].edges = false;
  wiring.inputs[In::kReset].name.clear();
  wiring.outputs[Out::kEnable].initial = true;
  wiring.outputs[Out::kQuickStop].name = "estop_a";
  wiring.outputs[Out::kEmitters].direction = GpioDirection::kInput;
  const Status status = wiring.Validate();
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().Text(),
              AllOf(HasSubstr("door is missing"), HasSubstr("line 'estop_a' is both estop_a and estop_b"),
                    HasSubstr("call must report edges"), HasSubstr("reset has no line name"),
                    HasSubstr("enable must be off at first"), HasSubstr("both estop_a and quick_stop"),
                    HasSubstr("emitters must be an output")));
}

}  // namespace
}  // namespace annulus
