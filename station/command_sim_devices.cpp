// sim-devices: the simulated booth's devices on real buses, for any program that speaks their protocols.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "station/commands.h"
#include "station/config.h"
#include "station/sim_devices.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct SimDevicesCommand {
  std::string config = "sim";
  SimDevicesOptions buses;
  std::string json;
};

Json EndpointsToJson(const std::vector<SimEndpoint>& endpoints) {
  Json list = Json::array();
  for (const SimEndpoint& one : endpoints) {
    list.push_back({{"device", one.device}, {"transport", one.transport}, {"address", one.address}});
  }
  return {{"endpoints", std::move(list)}};
}

std::string EndpointsToText(const std::vector<SimEndpoint>& endpoints) {
  std::string text;
  for (const SimEndpoint& one : endpoints)
    text += fmt::format("{:<11} {:<11} {}\n", one.device, one.transport, one.address);
  return text + "serving until Ctrl-C\n";
}

Status RunSimDevicesCommand(const SimDevicesCommand& options, CommandIo& io) {
  const auto config = ReadConfig(io.storage(), options.config);
  if (!config) return Fail(config);
  const auto devices = MakeSimDevices(*config, options.buses, io.storage());
  if (!devices) return Fail(devices);
  const std::vector<SimEndpoint>& endpoints = (*devices)->endpoints();
  RETURN_IF_ERROR(options.json.empty() ? io.Print(EndpointsToText(endpoints))
                                       : io.WriteJson(options.json, EndpointsToJson(endpoints)));
  (*devices)->Serve(io.stop());
  return {};
}

}  // namespace

void AddSimDevicesCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<SimDevicesCommand>();
  CLI::App* command = app.add_subcommand("sim-devices", "put the simulated devices on real buses, until Ctrl-C");
  command->add_option("--config", options->config, "who stands in the booth ([sim] of a configuration)")
      ->type_name("F")
      ->capture_default_str();
  command
      ->add_option("--tcp", options->buses.tcp_port, "the axis drive on Modbus TCP, loopback only; 0 is any free port")
      ->type_name("PORT")
      ->check(CLI::Range(0, 65'535));
  command->add_option("--pty", options->buses.pty, "the axis drive on Modbus RTU, a pseudo-terminal linked as LINK")
      ->type_name("LINK");
  command->add_option("--can", options->buses.can_interfaces, "the ring's boards as CANopen nodes on CAN interfaces")
      ->type_name("NAME");
  command
      ->add_option("--usbredir", options->buses.usbredir_folder,
                   "the ring's boards on an emulated machine's USB: DIR/SERIAL.sock are its usb-redir sockets")
      ->type_name("DIR");
  command
      ->add_option("--json", options->json,
                   "write where the devices are as JSON to FILE, once they are served; - is standard output")
      ->type_name("FILE");
  command->footer(
      "Without an option: the axis on TCP and on a pseudo-terminal.\n"
      "Example: annulus sim-devices --tcp 5020, then: mbpoll -0 -t 4:hex -r 256 -c 8 -1 -p 5020 127.0.0.1");
  command->callback(
      [&chosen, options] { chosen = [options](CommandIo& io) { return RunSimDevicesCommand(*options, io); }; });
}

}  // namespace annulus
