#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "firmware_iface/modbus_link.h"
#include "sim/axis_firmware.h"
#include "sim/modbus_server.h"

namespace {

using annulus::ModbusFunction;
using annulus::ModbusLink;
using annulus::ModbusReply;
using annulus::ModbusRequest;

int Complain(const std::string& text) {
  std::fprintf(stderr, "modbus_peer: %s\n", text.c_str());
  return 1;
}

/// Serves the simulated drive until standard input ends.
int Serve(const std::string& transport) {
  annulus::SystemClock clock;
  annulus::sim::AxisDriveModel drive({}, clock);
  annulus::sim::ModbusServerOptions options;
  if (transport == "tcp") options.tcp_port = 0;
  const auto server = annulus::sim::ModbusServer::Start(drive, options);
  if (!server) return Complain(server.error().Text());
  std::printf("%s\n",
              transport == "tcp" ? std::to_string((*server)->port()).c_str() : (*server)->device_name().c_str());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  return 0;
}

void Print(const char* name, const ModbusReply& reply) {
  std::printf("%s", name);
  if (!reply) std::printf(" %s", annulus::ModbusFailureText(reply.error()).c_str());
  if (reply) {
    for (const std::uint16_t value : *reply) std::printf(" %u", value);
  }
  std::printf("\n");
}

/// Asks a server of others one question of each kind and prints the answers.
int Ask(ModbusLink& link) {
  const auto ask = [&](const ModbusRequest& request) { return link.Transact(request, std::chrono::seconds(3)); };
  Print("fc03", ask({ModbusFunction::kReadRegisters, 0, {}, 10, 5}));
  Print("fc06", ask({ModbusFunction::kWriteRegister, 20, {0xABCD}, 0, 0}));
  Print("fc16", ask({ModbusFunction::kWriteRegisters, 30, {1, 2, 0xFFFF}, 0, 0}));
  Print("fc23", ask({ModbusFunction::kWriteReadRegisters, 40, {7, 8}, 39, 4}));
  Print("beyond", ask({ModbusFunction::kReadRegisters, 0, {}, 5000, 2}));
  Print("after", ask({ModbusFunction::kReadRegisters, 0, {}, 30, 3}));
  return 0;
}

int AskAt(const std::string& transport, const std::string& where) {
  annulus::SystemClock clock;
  auto link = transport == "tcp" ? annulus::OpenModbusTcp({"127.0.0.1", std::atoi(where.c_str())}, clock)
                                 : annulus::OpenModbusRtu({where, 115'200, 'N'}, clock);
  if (!link) return Complain(link.error().Text());
  return Ask(**link);
}

}  // namespace

/// Our side of the tests against Modbus programs of others: `serve tcp|rtu`, which prints the port or terminal, or
/// `ask tcp PORT`, `ask rtu DEVICE`.
int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 2 && arguments[0] == "serve") return Serve(arguments[1]);
  if (arguments.size() == 3 && arguments[0] == "ask") return AskAt(arguments[1], arguments[2]);
  return Complain("serve tcp|rtu, or ask tcp PORT, or ask rtu DEVICE");
}
