// doctor: what is connected, what is not as it should be, and what to do.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "station/commands.h"
#include "station/config.h"
#include "station/doctor.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct DoctorOptions {
  std::string config = "sim";
  WatchdogTest watchdog = WatchdogTest::kSkip;
  std::string json;
};

Json ReportToJson(const DoctorReport& report) {
  Json items = Json::array();
  for (const DoctorItem& item : report.items) {
    items.push_back({{"group", item.group},
                     {"name", item.name},
                     {"verdict", DoctorVerdictText(item.verdict)},
                     {"seen", item.seen},
                     {"advice", item.advice}});
  }
  return {{"config", report.config}, {"healthy", report.healthy()}, {"items", std::move(items)}};
}

std::string ReportToText(const DoctorReport& report) {
  std::size_t width = 0;
  for (const DoctorItem& item : report.items) width = std::max(width, item.name.size());
  std::string text;
  std::string group;
  for (const DoctorItem& item : report.items) {
    if (item.group != group) text += (text.empty() ? "" : "\n") + item.group + "\n";
    group = item.group;
    text += fmt::format("  {:<7}  {:<{}}  {}\n", DoctorVerdictText(item.verdict), item.name, width, item.seen);
    if (!item.advice.empty()) text += fmt::format("  {:<7}  {:<{}}  -> {}\n", "", "", width, item.advice);
  }
  const auto problems = std::count_if(report.items.begin(), report.items.end(),
                                      [](const DoctorItem& item) { return item.verdict == DoctorVerdict::kProblem; });
  std::string simulated;
  for (const DoctorItem& item : report.items) {
    if (item.name == "simulated") simulated.append(simulated.empty() ? " (simulated: " : ", ").append(item.group);
  }
  if (!simulated.empty()) simulated += ")";
  return text + (problems == 0 ? "\nno problem found" + simulated + "\n"
                               : fmt::format("\n{} problem{} found\n", problems, problems == 1 ? "" : "s"));
}

Status RunDoctorCommand(const DoctorOptions& options, CommandIo& io) {
  const auto config = ReadConfig(io.storage(), options.config);
  if (!config) return Fail(config);
  const DoctorReport report = Diagnose(*config, options.config, io.storage(), options.watchdog);
  RETURN_IF_ERROR(options.json.empty() ? io.Print(ReportToText(report))
                                       : io.WriteJson(options.json, ReportToJson(report)));
  if (report.healthy()) return {};
  const auto first = std::find_if(report.items.begin(), report.items.end(),
                                  [](const DoctorItem& item) { return item.verdict == DoctorVerdict::kProblem; });
  return Fail("check the devices of " + options.config, first->group + " " + first->name + ": " + first->seen,
              first->advice.empty() ? "see the report" : first->advice);
}

}  // namespace

void AddDoctorCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command = app.add_subcommand("doctor", "check host, buses and devices, and say what to do");
  command->add_option("--config", options->config, "the station's configuration; 'sim' is the built-in simulated booth")
      ->type_name("F")
      ->capture_default_str();
  command->add_flag_callback(
      "--test-watchdog", [options] { options->watchdog = WatchdogTest::kRun; },
      "make the watchdog relay pull in and drop, and measure how long that takes (enable stays off)");
  AddJsonOption(*command, options->json);
  command->footer(
      "Nothing moves and no emitter is switched on. Exit code 1 if there is a problem.\n"
      "Example: annulus doctor --config booth.toml");
  command->callback(
      [&chosen, options] { chosen = [options](CommandIo& io) { return RunDoctorCommand(*options, io); }; });
}

}  // namespace annulus
