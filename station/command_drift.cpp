// drift: what customers' scans say of the ring, scan by scan.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "acquisition/recording.h"
#include "acquisition/swapped_channels.h"
#include "station/commands.h"
#include "station/drift_lock.h"
#include "station/drift_picture.h"
#include "station/files.h"
#include "station/key_file.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct DriftOptions {
  std::vector<std::string> scans;
  std::string history;
  std::string plot;
  std::string key_file;
  std::string json;
  std::optional<double> temperature;
};

/// What came of one scan.
struct Taken {
  std::string path;
  DriftHistory::Added added = DriftHistory::Added::kNew;
  std::vector<ChannelSwap> swaps;
};

Json NumberOrNull(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

Json JsonFrom(const DriftState& state, const std::vector<Taken>& taken) {
  Json alarms = Json::array();
  for (const DriftAlarm& alarm : state.alarms) {
    alarms.push_back({{"sensor", alarm.sensor},
                      {"count", alarm.count},
                      {"since", DriftSinceName(alarm.since)},
                      {"drift_mm", alarm.drift_mm},
                      {"sigma_mm", alarm.sigma_mm},
                      {"speed_mm_s", alarm.speed_mm_s},
                      {"text", alarm.Text()}});
  }
  Json swaps = Json::array();
  std::size_t known = 0;
  for (const Taken& scan : taken) {
    known += scan.added == DriftHistory::Added::kKnown ? 1 : 0;
    for (const ChannelSwap& swap : scan.swaps) {
      swaps.push_back({{"scan", scan.path},
                       {"sensor_a", swap.sensor_a},
                       {"sensor_b", swap.sensor_b},
                       {"count", swap.count},
                       {"evidence", swap.evidence},
                       {"text", swap.text}});
    }
  }
  Json sensors = Json::array();
  for (const SensorState& sensor : state.sensors) {
    sensors.push_back({{"offset_mm", NumberOrNull(sensor.offset_mm)},
                       {"sigma_mm", NumberOrNull(sensor.sigma_mm)},
                       {"baseline_mm", NumberOrNull(sensor.baseline_mm)}});
  }
  return {{"scans_added", taken.size() - known},    {"scans_known", known},        {"scans", state.scans},
          {"baseline_ready", state.baseline_ready}, {"alarms", std::move(alarms)}, {"exchanged", std::move(swaps)},
          {"sensors", std::move(sensors)}};
}

std::string TextFrom(const DriftState& state, const std::vector<Taken>& taken) {
  std::string text;
  for (const Taken& scan : taken) {
    for (const ChannelSwap& swap : scan.swaps) text += "EXCHANGED (" + scan.path + "): " + swap.text + "\n";
  }
  for (const DriftAlarm& alarm : state.alarms) text += "ALARM: " + alarm.Text() + "\n";
  text += std::to_string(state.scans) + " scans since the calibration, " +
          (state.alarms.empty() ? std::string("no drift") : std::to_string(state.alarms.size()) + " alarm(s)") +
          (state.baseline_ready ? "" : "; the baseline is not made yet: smaller drifts are not seen") + "\n";
  const bool exchanged = std::any_of(taken.begin(), taken.end(), [](const Taken& one) { return !one.swaps.empty(); });
  if (exchanged) text += "do: put exchanged channels back in their places; their scans are not in the history\n";
  if (!state.alarms.empty())
    text += "do: clean these sensors' windows, run 'annulus check', and calibrate if it stays\n";
  return text;
}

Status RunDrift(const DriftOptions& options, CommandIo& io) {
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  const auto lock = LockDriftHistory(options.history);
  if (!lock) return Fail(lock);
  auto history = DriftHistory::Load(io.storage(), options.history);
  if (!history) return Fail(history);
  ProgressDisplay display(io.progress_mode());
  std::vector<Taken> taken;
  std::vector<RecordedBoard> boards;
  for (const std::string& path : options.scans) {
    display.Show("look at scans", static_cast<double>(taken.size()), static_cast<double>(options.scans.size()));
    if (io.stop().stop_requested()) return tl::unexpected(InterruptedError("look for drift"));
    const auto scan = ReadRecording(io.storage(), path, keys->get());
    if (!scan) return Fail(scan);
    Taken one{path, DriftHistory::Added::kNew, FindSwappedChannels(*scan)};
    boards = scan->header.machine.boards;
    // Exchanged channels are no drift, and would spoil the baseline.
    if (one.swaps.empty()) {
      const auto added = history->Add(EstimateDrift(*scan), options.temperature);
      if (!added) return Fail(added);
      one.added = *added;
    }
    taken.push_back(std::move(one));
  }
  display.Clear();
  const DriftState state = JudgeDrift(*history, boards);
  RETURN_IF_ERROR(history->Save(io.storage(), options.history));
  if (!options.plot.empty()) {
    const auto picture = DrawDrift(*history, state);
    if (!picture) return Fail(picture);
    RETURN_IF_ERROR(WritePngFile(io.storage(), options.plot, *picture));
  }
  if (!options.json.empty()) RETURN_IF_ERROR(io.WriteJson(options.json, JsonFrom(state, taken)));
  return options.json == "-" ? Status() : io.Print(TextFrom(state, taken));
}

}  // namespace

void AddDriftCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<DriftOptions>();
  CLI::App* command = app.add_subcommand("drift", "sensors that drift, from customers' scans");
  command->add_option("scans", options->scans, "recordings, oldest first; none: the history is judged as it is");
  command->add_option("--history", options->history, "drift history of the ring; made if it is not there")
      ->required()
      ->type_name("F");
  command->add_option("--plot", options->plot, "PNG picture of the trend of every sensor")->type_name("F.png");
  command->add_option("--ring-c", options->temperature, "temperature of the ring, degrees Celsius")->type_name("C");
  AddKeyFileOption(*command, options->key_file);
  AddJsonOption(*command, options->json);
  command->footer(
      "Exit code 0 whether or not a sensor drifts: see 'ALARM' in the text, 'alarms' and 'exchanged' in the JSON.\n"
      "What all sensors have in common is not seen this way: 'annulus check' sees it.\n"
      "Example: annulus drift monday/*.mcap --history ring.drift.json --plot drift.png");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunDrift(*options, io); }; });
}

}  // namespace annulus
