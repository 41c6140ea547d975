#include "tests/sim/safety_fixture.h"

namespace annulus {
namespace {

using sim::ChainInterlockFixture;
using sim::ChainLinesFixture;
using sim::EverydayFaults;

template <class Transport>
std::string NameOf(const testing::TestParamInfo<Transport>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(
    Simulated, GpioLinesContract,
    testing::Values(GpioLinesTransport{"SafetyChain", [] { return std::make_unique<ChainLinesFixture>(); }},
                    GpioLinesTransport{"BouncingLate",
                                       [] { return std::make_unique<ChainLinesFixture>(EverydayFaults(7)); }}),
    NameOf<GpioLinesTransport>);

INSTANTIATE_TEST_SUITE_P(
    Simulated, InterlockContract,
    testing::Values(InterlockTransport{"SafetyChain", [] { return std::make_unique<ChainInterlockFixture>(); }},
                    InterlockTransport{"BouncingLate",
                                       [] { return std::make_unique<ChainInterlockFixture>(EverydayFaults(11)); }}),
    NameOf<InterlockTransport>);

}  // namespace
}  // namespace annulus
