#include "sim/fault_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;

std::string Plan(const std::string& faults) {
  return R"({"format": "annulus fault plan", "version": 1, "seed": 7, "faults": [)" + faults + "]}";
}

std::string Refusal(const std::string& text) {
  const auto plan = ParseFaultPlan(text, "p.json");
  return plan ? "accepted" : plan.error().Text();
}

TEST(FaultPlan, ReadsWhenWhereAndWhat) {
  const auto plan = ParseFaultPlan(
      Plan(R"({"at": {"state": "SCANNING", "after_s": 1.5}, "for_s": 0.3, "target": "usb", "kind": "unplug",
               "args": {"board": 3, "ending": "error"}},
              {"at": {"call": 12}, "target": "storage", "kind": "no_space"},
              {"at": {"level": 40}, "until": {"state": "FAULT"}, "target": "axis", "kind": "slip",
               "args": {"speed_mm_s": 0.5}})"),
      "p.json");
  ASSERT_TRUE(plan) << plan.error().Text();
  EXPECT_EQ(plan->seed, 7U);
  ASSERT_EQ(plan->faults.size(), 3U);
  const Fault& unplug = plan->faults[0];
  EXPECT_EQ(unplug.kind, FaultKind::kUsbUnplug);
  EXPECT_EQ(unplug.at.state, "SCANNING");
  EXPECT_EQ(unplug.at.delay, milliseconds(1500));
  EXPECT_EQ(unplug.lasting, milliseconds(300));
  EXPECT_EQ(unplug.Choice(FaultArg::kBoard), 3U);
  EXPECT_EQ(unplug.Whole(FaultArg::kEnding), 1U);
  EXPECT_EQ(unplug.Value(FaultArg::kSpreadMs), 0.0);
  EXPECT_EQ(plan->faults[1].at.number, 12U);
  EXPECT_FALSE(plan->faults[1].Choice(FaultArg::kCount));
  EXPECT_EQ(plan->faults[2].until->state, "FAULT");
  EXPECT_EQ(plan->faults[2].Value(FaultArg::kSpeedMmS), 0.5);
  EXPECT_EQ(FaultText(unplug), "usb unplug board=3 ending=error at SCANNING + 1.5 s for 0.3 s");
}

TEST(FaultPlan, RefusesWhatItDoesNotKnowAndSaysWhatIsAllowed) {
  EXPECT_THAT(Refusal("{"), HasSubstr("it is not JSON"));
  EXPECT_THAT(Refusal(std::string(100'000, '[')), HasSubstr("it is not JSON"));
  EXPECT_THAT(Refusal("[]"), HasSubstr("not an object"));
  EXPECT_THAT(Refusal(R"({"faults": []})"), HasSubstr("annulus fault plan"));
  EXPECT_THAT(Refusal(R"({"format": "annulus fault plan", "version": 2, "faults": []})"), HasSubstr("2 is not known"));
  const auto fault = [](const std::string& text) { return Refusal(Plan("{" + text + "}")); };
  const std::string at = R"("at": {"time_s": 1}, )";
  EXPECT_THAT(fault(at + R"("target": "usb", "kind": "zero", "wen": 1)"),
              AllOf(HasSubstr(R"(faults[0]: unknown key "wen")"), HasSubstr("until")));
  EXPECT_THAT(fault(at + R"("target": "bus", "kind": "zero")"), AllOf(HasSubstr("\"bus\""), HasSubstr("axis_link")));
  EXPECT_THAT(fault(at + R"("target": "usb", "kind": "slip")"), AllOf(HasSubstr("\"slip\""), HasSubstr("unplug")));
  EXPECT_THAT(fault(at + R"("target": "usb", "kind": "zero", "args": {"bord": 1})"),
              AllOf(HasSubstr("faults[0].args: unknown key \"bord\""), HasSubstr("board, share")));
  EXPECT_THAT(fault(at + R"("target": "usb", "kind": "zero", "args": {"board": 13})"), HasSubstr("0 to 12"));
  EXPECT_THAT(fault(at + R"("target": "usb", "kind": "zero", "args": {"board": 1.5})"), HasSubstr("not whole"));
  EXPECT_THAT(fault(at + R"("target": "axis", "kind": "slip")"), HasSubstr("speed_mm_s is missing"));
  EXPECT_THAT(fault(at + R"("target": "axis", "kind": "limit", "args": {"end": "left"})"),
              HasSubstr("upper, lower, both"));
  EXPECT_THAT(fault(R"("target": "host", "kind": "kill")"), HasSubstr("at is missing"));
}

TEST(FaultPlan, RefusesTimesThatMakeNoSense) {
  const auto fault = [](const std::string& at, const std::string& rest) {
    return Refusal(Plan(R"({"at": )" + at + ", " + rest + "}"));
  };
  const std::string kill = R"("target": "host", "kind": "kill")";
  EXPECT_THAT(fault(R"({"state": "DANCING"})", kill), HasSubstr("SCANNING"));
  EXPECT_THAT(fault(R"({"state": "IDLE", "level": 3})", kill), HasSubstr("unknown key \"level\""));
  EXPECT_THAT(fault(R"({"time_s": 1, "level": 3})", kill), HasSubstr("it has 2 keys"));
  EXPECT_THAT(fault(R"({})", kill), HasSubstr("it has 0 keys"));
  EXPECT_THAT(fault(R"({"time_s": -1})", kill), HasSubstr("out of range"));
  EXPECT_THAT(fault(R"({"call": 0})", kill), HasSubstr("1 to 1000000000"));
  EXPECT_THAT(fault(R"({"time_s": 1})", kill + R"(, "for_s": 1)"), HasSubstr("happens once"));
  EXPECT_THAT(fault(R"({"time_s": 1})", R"("target": "host", "kind": "hang")"), HasSubstr("must end"));
  EXPECT_THAT(fault(R"({"time_s": 1})", R"("target": "host", "kind": "hang", "for_s": 0)"), HasSubstr("no time"));
  EXPECT_THAT(fault(R"({"time_s": 1})", R"("target": "host", "kind": "hang", "for_s": 1, "until": {"time_s": 3})"),
              HasSubstr("one of them"));
  EXPECT_THAT(fault(R"({"time_s": 1})", R"("target": "usb", "kind": "zero", "until": {"call": 3})"),
              HasSubstr("ends nothing"));
  EXPECT_THAT(fault(R"({"call": 1})", R"("target": "axis", "kind": "slip", "args": {"speed_mm_s": 1})"),
              HasSubstr("no calls"));
}

/// A plan with every kind once, each argument at one end of its range.
FaultPlan EveryKind(bool low) {
  FaultPlan plan;
  plan.seed = 0xFFFF'FFFF'FFFF'FFFF;
  for (const FaultKindTraits& traits : AllFaultKinds()) {
    Fault fault;
    fault.kind = traits.kind;
    fault.at.delay = std::chrono::nanoseconds(1'234'567'891);
    if (traits.span == FaultSpan::kLimited) fault.lasting = milliseconds(1);
    for (const FaultArgRule& rule : traits.args) fault.args.Set(rule.arg, low ? rule.low : rule.high);
    plan.faults.push_back(fault);
  }
  return plan;
}

TEST(FaultPlan, EveryKindIsWrittenAndReadBackTheSame) {
  for (const bool low : {true, false}) {
    const FaultPlan plan = EveryKind(low);
    const auto again = ParseFaultPlan(WriteFaultPlan(plan), "again");
    ASSERT_TRUE(again) << again.error().Text();
    EXPECT_TRUE(*again == plan);
    EXPECT_EQ(WriteFaultPlan(*again), WriteFaultPlan(plan));
  }
}

TEST(FaultPlan, NamesOfATargetsKindsAreAllDifferent) {
  std::set<std::string> names;
  for (const FaultKindTraits& traits : AllFaultKinds()) {
    EXPECT_TRUE(names.insert(std::string(FaultTargetName(traits.target)) + "/" + traits.name).second) << traits.name;
  }
  EXPECT_EQ(names.size(), kFaultKinds);
}

TEST(RandomFaultPlan, IsTheSameForTheSameNumberAndCanBeWritten) {
  std::set<std::string> texts;
  std::set<std::size_t> sizes;
  for (std::uint64_t number = 0; number < 500; ++number) {
    const FaultPlan plan = RandomFaultPlan(11, number);
    const std::string text = WriteFaultPlan(plan);
    EXPECT_EQ(text, WriteFaultPlan(RandomFaultPlan(11, number)));
    const auto again = ParseFaultPlan(text, "random");
    ASSERT_TRUE(again) << again.error().Text() << text;
    EXPECT_TRUE(*again == plan) << text;
    texts.insert(text);
    sizes.insert(plan.faults.size());
  }
  EXPECT_GE(texts.size(), 495U);
  EXPECT_EQ(sizes, (std::set<std::size_t>{1, 2, 3, 4}));
}

}  // namespace
}  // namespace annulus::sim
