#include "tests/firmware_iface/modbus_link_contract.h"
#include "tests/firmware_iface/modbus_rigs.h"
#include "tests/firmware_iface/scan_axis_contract.h"

namespace annulus {
namespace {

std::string RigName(const testing::TestParamInfo<NamedModbusRig>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(All, ModbusLinkContract,
                         testing::Values(SimulatedSerialRig(), SimulatedTcpRig(), TerminalRtuRig(), LoopbackTcpRig()),
                         RigName);
INSTANTIATE_TEST_SUITE_P(All, ScanAxisContract,
                         testing::Values(SimulatedSerialRig(), SlowDriveRig(), SimulatedTcpRig(), TerminalRtuRig(),
                                         LoopbackTcpRig()),
                         RigName);

}  // namespace
}  // namespace annulus
