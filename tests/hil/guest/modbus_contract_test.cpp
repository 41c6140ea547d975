// The contracts of ModbusLink and ScanAxis over the kernel's serial drivers, its terminals and its TCP.

#include "tests/firmware_iface/modbus_link_contract.h"
#include "tests/firmware_iface/modbus_rigs.h"
#include "tests/firmware_iface/scan_axis_contract.h"
#include "tests/hil/guest/served_drive.h"

namespace annulus {
namespace {

NamedModbusRig Adapter() {
  return {"Ftdi", [] { return std::make_unique<hil::HostDriveRig>(hil::kDriveOnAdapter); }};
}
NamedModbusRig BoardPort() {
  return {"Uart", [] { return std::make_unique<hil::HostDriveRig>(hil::kDriveOnBoardPort); }};
}
std::string RigName(const testing::TestParamInfo<NamedModbusRig>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(ModbusKernel, ModbusLinkContract,
                         testing::Values(TerminalRtuRig(), LoopbackTcpRig(), Adapter()), RigName);
INSTANTIATE_TEST_SUITE_P(ModbusKernel, ScanAxisContract, testing::Values(TerminalRtuRig(), LoopbackTcpRig(), Adapter()),
                         RigName);

// The board's port has no plug: the suite's pattern (tests/hil/hil.py) leaves out the tests that pull one.
INSTANTIATE_TEST_SUITE_P(ModbusBoardPort, ModbusLinkContract, testing::Values(BoardPort()), RigName);
INSTANTIATE_TEST_SUITE_P(ModbusBoardPort, ScanAxisContract, testing::Values(BoardPort()), RigName);

}  // namespace
}  // namespace annulus
