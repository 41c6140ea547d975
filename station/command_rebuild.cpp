// rebuild: everything that is derived, made again from the recordings by this program's own commands.

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "modeling/exchange/landmarks_json.h"
#include "modeling/table/table.h"
#include "station/commands.h"
#include "station/console/model_cache.h"
#include "station/console/scan_json.h"
#include "station/console/scan_judgement.h"
#include "station/console/scan_measurements.h"
#include "station/console/scratch_folder.h"
#include "station/store/sealed_text.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kAll = 1'000'000'000;

struct RebuildOptions {
  std::string folder;
  std::string key_file;
  std::string scan;
  std::string json;
};

/// What the files of a scan are called while it is rebuilt.
constexpr const char* kRecording = "scan.mcap";
constexpr const char* kModel = "model.json";
constexpr const char* kReport = "fit-report.json";
constexpr const char* kLandmarks = "landmarks.json";
constexpr const char* kMeasurements = "measurements.json";

/// Runs this program with `arguments` in `folder`; its errors go where ours do, its results to files.
Status RunOurselves(const std::vector<std::string>& arguments, const std::string& folder) {
  std::vector<std::string> words{"annulus", "--progress", "none"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string attempted = "run annulus " + arguments.front();
  const pid_t child = ::fork();
  if (child < 0) return Fail(attempted, std::generic_category().message(errno), "close other programs");
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);                 // its opened files are to go with us
    const int nowhere = ::open("/dev/null", O_WRONLY);  // what it prints is not our result
    const bool ready = nowhere >= 0 && ::dup2(nowhere, STDOUT_FILENO) >= 0 && ::chdir(folder.c_str()) == 0;
    if (ready) ::execv("/proc/self/exe", argv.data());
    ::_exit(127);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return Fail(attempted, "it failed", "see its message above");
}

/// The words of a recipe: a command and its options, without the names of files ("fit --method adaptive").
std::vector<std::string> Words(const std::string& recipe) {
  std::istringstream in(recipe);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// What came of one file, or of the verdict and summary in the scan's row ("summary").
struct Rebuilt {
  std::string scan;
  std::string name;
  std::string what;  ///< "identical", "changed", "new", "kept", or why it failed.
};

/// One scan's files, made again: the model by a process of its own in `folder`, what follows from it here.
class ScanRebuild {
 public:
  ScanRebuild(Store& store, Storage& storage, std::string scan_id, std::string folder)
      : store_(store), storage_(storage), scan_id_(std::move(scan_id)), folder_(std::move(folder)) {}

  Status Run() {
    auto artefacts = store_.ArtefactsOf(scan_id_);
    if (!artefacts) return Fail(artefacts);
    artefacts_ = std::move(*artefacts);
    const auto recording = store_.ReadRecording(scan_id_);
    if (!recording) return Fail(recording);
    const auto parked = Judge(*recording);
    if (!parked) return Fail(parked);
    if (!*parked) {
      RETURN_IF_ERROR(Fit(*recording));
      RETURN_IF_ERROR(Measure());
    }
    for (const Artefact& artefact : artefacts_) {
      const auto made = [&](const Rebuilt& rebuilt) { return rebuilt.name == artefact.name; };
      if (std::none_of(done_.begin(), done_.end(), made)) done_.push_back({scan_id_, artefact.name, "kept"});
    }
    return {};
  }
  [[nodiscard]] const std::vector<Rebuilt>& done() const { return done_; }

 private:
  [[nodiscard]] const Artefact* Find(const std::string& kind, const std::string& name) const {
    for (const Artefact& artefact : artefacts_) {
      if (artefact.kind == kind && artefact.name == name) return &artefact;
    }
    return nullptr;
  }

  /// Verdict and summary; what was decided since the scan (that the body may be shown) stays. Whether the ring stood
  /// still: then there is no body to fit.
  Result<bool> Judge(std::span<const std::byte> recording) {
    const auto scan = store_.GetScan(scan_id_);
    if (!scan) return Fail(scan);
    const Json before = SummaryOf(*scan);
    const auto judged = JudgeRecording(recording, "the recording of " + scan_id_, nullptr, before.value("ticket", ""));
    if (!judged) return Fail(judged);
    Json summary = Json::parse(judged->summary_json);
    summary["released"] = before.value("released", false);
    const bool same = summary.dump() == scan->summary_json && judged->verdict == scan->verdict;
    if (!same) RETURN_IF_ERROR(store_.JudgeScan(scan_id_, judged->verdict, summary.dump()));
    done_.push_back({scan_id_, "summary", same ? "identical" : "changed"});
    return judged->parked;
  }

  Status Fit(std::span<const std::byte> recording) {
    RETURN_IF_ERROR(WriteFileAtomically(storage_, folder_ + "/" + kRecording, recording));
    const Artefact* before = Find("model", kModel);
    const std::string recipe = before != nullptr && !before->recipe.empty() ? before->recipe : "fit";
    std::vector<std::string> words = Words(recipe);
    words.insert(words.end(), {kRecording, "--out", kModel, "--report", kReport});
    RETURN_IF_ERROR(RunOurselves(words, folder_));
    const auto model = storage_.ReadAll(folder_ + "/" + kModel, kMaxInputBytes);
    if (!model) return Fail(model);
    const auto report = storage_.ReadAll(folder_ + "/" + kReport, kMaxInputBytes);
    if (!report) return Fail(report);
    RETURN_IF_ERROR(Keep("model", kModel, recipe, *model));
    return Keep("document", kReport, recipe, *report);  // differs from run to run: there are times in it
  }

  Status Measure() {
    const auto open = OpenStoredModel(store_, scan_id_);  // with the landmarks that were set by hand
    if (!open) return Fail(open);
    const OpenModel& model = **open;
    const Artefact* landmarks = Find("landmarks", kLandmarks);
    if (landmarks == nullptr || landmarks->derived) {
      const std::string text = LandmarksToJson(model.loaded.body, model.landmarks);
      RETURN_IF_ERROR(Keep("landmarks", kLandmarks, "landmarks", BytesOf(text)));
    }
    const auto table = MeasureTable(model.loaded.body, model.landmarks);
    // A part of a body on which there is nothing to measure is still a model.
    if (!table) return model.landmarks.found.empty() ? Status{} : Status(Fail(table));
    return Keep("measurements", kMeasurements, "measure", BytesOf(KeptMeasurements(*table).dump()));
  }

  Status Keep(const std::string& kind, const char* name, const std::string& recipe, std::span<const std::byte> bytes) {
    const Artefact* before = Find(kind, name);
    if (before != nullptr) {
      const auto old = store_.ReadArtefact(before->id);
      if (old && std::ranges::equal(*old, bytes)) {
        done_.push_back({scan_id_, name, "identical"});
        return {};
      }
    }
    Artefact artefact;
    artefact.scan_id = scan_id_;
    artefact.kind = kind;
    artefact.name = name;
    artefact.recipe = recipe;
    const auto put = store_.PutArtefact(std::move(artefact), bytes);
    if (!put) return Fail(put);
    done_.push_back({scan_id_, name, before != nullptr ? "changed" : "new"});
    return {};
  }

  Store& store_;
  Storage& storage_;
  std::string scan_id_;
  std::string folder_;
  std::vector<Artefact> artefacts_;  ///< As they were.
  std::vector<Rebuilt> done_;
};

Result<std::vector<ScanRow>> ScansToRebuild(Store& store, const std::string& id) {
  if (id.empty()) return store.LatestScans(kAll);
  auto scan = store.GetScan(id);
  if (!scan) return Fail(scan);
  return std::vector<ScanRow>{std::move(*scan)};
}

Status RebuildScan(Store& store, ScratchFolder& scratch, const std::string& scan_id, CommandIo& io,
                   std::vector<Rebuilt>& done) {
  const auto folder = scratch.NewFolder();
  if (!folder) return Fail(folder);
  ScanRebuild rebuild(store, io.storage(), scan_id, *folder);
  const Status status = rebuild.Run();
  scratch.Remove(*folder);
  done.insert(done.end(), rebuild.done().begin(), rebuild.done().end());
  AuditLine line;
  line.origin = "program";
  line.action = "rebuild";
  line.subject = scan_id;
  line.result = status ? "ok" : "failed";
  RETURN_IF_ERROR(store.Audit(std::move(line)));
  return status;
}

Status Report(const RebuildOptions& options, const std::vector<Rebuilt>& done, CommandIo& io) {
  if (options.json.empty()) {
    std::string text;
    for (const Rebuilt& rebuilt : done)
      text += fmt::format("{}  {:20}  {}\n", rebuilt.scan, rebuilt.name, rebuilt.what);
    return io.Print(text.empty() ? "no recordings\n" : text);
  }
  Json json{{"files", Json::array()}};
  for (const Rebuilt& rebuilt : done) {
    json["files"].push_back({{"scan", rebuilt.scan}, {"name", rebuilt.name}, {"what", rebuilt.what}});
  }
  return io.WriteJson(options.json, json);
}

Status Rebuild(const RebuildOptions& options, CommandIo& io) {
  if (!io.storage().Exists(options.folder + "/annulus.db")) {
    return Fail("open the store " + options.folder, "there is none", "give the folder of a store with --store");
  }
  const SystemClock clock;
  StoreOptions store_options;
  store_options.folder = options.folder;
  store_options.station_key_file = options.key_file.empty() ? options.folder + "/station.key" : options.key_file;
  const auto store = Store::Open(store_options, io.storage(), clock);
  if (!store) return Fail(store);
  const auto scans = ScansToRebuild(**store, options.scan);
  if (!scans) return Fail(scans);
  const auto scratch = ScratchFolder::Make("");
  if (!scratch) return Fail(scratch);
  std::vector<Rebuilt> done;
  std::size_t failed = 0;
  ProgressDisplay display(io.progress_mode());
  for (std::size_t k = 0; k < scans->size(); ++k) {
    const ScanRow& scan = scans->at(k);
    if (io.stop().stop_requested()) return tl::unexpected(InterruptedError("rebuild"));
    display.Show("rebuild", static_cast<double>(k), static_cast<double>(scans->size()));
    if (scan.recording.empty()) continue;
    if (const Status status = RebuildScan(**store, **scratch, scan.id, io, done); !status) {
      ++failed;
      done.push_back({scan.id, "", status.error().Text()});
    }
  }
  display.Clear();
  RETURN_IF_ERROR(Report(options, done, io));
  if (failed == 0) return {};
  return Fail("rebuild", fmt::format("{} of {} scans could not be rebuilt", failed, scans->size()),
              "see the list; what there was of them is as it was");
}

}  // namespace

void AddRebuildCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<RebuildOptions>();
  CLI::App* command = app.add_subcommand("rebuild", "derive everything again from recordings");
  command->add_option("--store", options->folder, "folder of the store")->required()->type_name("DIR");
  command->add_option("--key-file", options->key_file, "the station's key file (DIR/station.key)")->type_name("FILE");
  command->add_option("--scan", options->scan, "this scan only")->type_name("ID");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus rebuild --store /var/lib/annulus/store --scan S-000123");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Rebuild(*options, io); }; });
}

}  // namespace annulus
