// The ring's contract in real time, boards in another thread; the sockets are the kernel's, the bus timing is
// simulated.

#include "tests/firmware_iface/served_can_ring.h"
#include "tests/firmware_iface/socket_pair_can.h"

namespace annulus::contract {
namespace {

RangeRingCase Served(const char* name, std::size_t buses, bool fd) {
  return {name, [buses, fd]() -> std::unique_ptr<RangeRingFixture> {
            static SystemClock clock;
            ServedCanRing::Set set;
            set.fd = fd;
            set.unplug = false;
            for (std::size_t i = 0; i < buses; ++i) {
              auto [host, boards] = SocketPairCanBus::Make(clock);
              set.hosts.push_back(std::move(host));
              set.boards.push_back(std::move(boards));
            }
            return std::make_unique<ServedCanRing>(std::move(set));
          }};
}

INSTANTIATE_TEST_SUITE_P(ServedCan, RangeRingContract, testing::Values(Served("TwoBuses", 2, false)), NameOfCase);

}  // namespace
}  // namespace annulus::contract
