// rebuild: everything that is derived, made again from the recordings by this program's own commands.

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "station/commands.h"
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

/// Opened files of a customer, for the owner only, in memory if the machine can; removed when it goes.
class OpenedFiles {
 public:
  static Result<std::unique_ptr<OpenedFiles>> Make() {
    std::error_code error;
    const std::string base = std::filesystem::is_directory("/dev/shm", error)
                                 ? "/dev/shm"
                                 : std::filesystem::temp_directory_path(error).string();
    std::string name = base + "/annulus-rebuild-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) {
      return Fail("make a folder in " + base, std::generic_category().message(errno), "free space there");
    }
    return std::unique_ptr<OpenedFiles>(new OpenedFiles(std::move(name)));
  }
  ~OpenedFiles() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  OpenedFiles(const OpenedFiles&) = delete;
  OpenedFiles& operator=(const OpenedFiles&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string File(const std::string& name) const { return path_ + "/" + name; }

 private:
  explicit OpenedFiles(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

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
    if (::chdir(folder.c_str()) == 0) ::execv("/proc/self/exe", argv.data());
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

/// What came of one file.
struct Rebuilt {
  std::string scan;
  std::string name;
  std::string what;  ///< "identical", "changed", "new", "kept", or why it failed.
};

/// One scan's files, made again.
class ScanRebuild {
 public:
  ScanRebuild(Store& store, Storage& storage, ScanRow scan, const OpenedFiles& files)
      : store_(store), storage_(storage), scan_(std::move(scan)), files_(files) {}

  Status Run() {
    const auto artefacts = store_.ArtefactsOf(scan_.id);
    if (!artefacts) return Fail(artefacts);
    artefacts_ = *artefacts;
    const auto recording = store_.ReadRecording(scan_.id);
    if (!recording) return Fail(recording);
    RETURN_IF_ERROR(WriteFileAtomically(storage_, files_.File(kRecording), *recording));
    RETURN_IF_ERROR(Fit());
    RETURN_IF_ERROR(FindLandmarks());
    RETURN_IF_ERROR(Measure());
    for (const Artefact& artefact : artefacts_) {
      if (artefact.derived && !Made(artefact)) done_.push_back({scan_.id, artefact.name, "kept"});
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
  [[nodiscard]] bool Made(const Artefact& artefact) const {
    for (const Rebuilt& rebuilt : done_) {
      if (rebuilt.name == artefact.name) return true;
    }
    return false;
  }
  /// The options of what is there already, or none.
  [[nodiscard]] std::string RecipeOf(const std::string& kind, const char* name, const std::string& otherwise) const {
    const Artefact* there = Find(kind, name);
    return there != nullptr && !there->recipe.empty() ? there->recipe : otherwise;
  }

  Status Fit() {
    const std::string recipe = RecipeOf("model", kModel, "fit");
    std::vector<std::string> words = Words(recipe);
    words.insert(words.end(), {kRecording, "--out", kModel, "--report", kReport});
    RETURN_IF_ERROR(RunOurselves(words, files_.path()));
    RETURN_IF_ERROR(Keep("model", kModel, recipe));
    // The report has times in it, which differ from run to run.
    return Find("document", kReport) != nullptr ? Keep("document", kReport, recipe) : Status();
  }

  Status FindLandmarks() {
    const Artefact* there = Find("landmarks", kLandmarks);
    if (there != nullptr && !there->derived) {  // set by hand: they are put on the new model
      const auto bytes = store_.ReadArtefact(there->id);
      if (!bytes) return Fail(bytes);
      return WriteFileAtomically(storage_, files_.File(kLandmarks), *bytes);
    }
    RETURN_IF_ERROR(RunOurselves({"landmarks", kModel, "--out", kLandmarks}, files_.path()));
    return Keep("landmarks", kLandmarks, "landmarks");
  }

  Status Measure() {
    RETURN_IF_ERROR(
        RunOurselves({"measure", kModel, "--landmarks", kLandmarks, "--json", kMeasurements}, files_.path()));
    return Keep("measurements", kMeasurements, "measure");
  }

  Status Keep(const std::string& kind, const char* name, const std::string& recipe) {
    const auto bytes = storage_.ReadAll(files_.File(name), kMaxInputBytes);
    if (!bytes) return Fail(bytes);
    const Artefact* there = Find(kind, name);
    if (there != nullptr) {
      const auto old = store_.ReadArtefact(there->id);
      if (old && *old == *bytes) {
        done_.push_back({scan_.id, name, "identical"});
        return {};
      }
    }
    Artefact artefact;
    artefact.scan_id = scan_.id;
    artefact.kind = kind;
    artefact.name = name;
    artefact.recipe = recipe;
    const auto put = store_.PutArtefact(std::move(artefact), *bytes);
    if (!put) return Fail(put);
    done_.push_back({scan_.id, name, there != nullptr ? "changed" : "new"});
    return {};
  }

  Store& store_;
  Storage& storage_;
  ScanRow scan_;
  const OpenedFiles& files_;
  std::vector<Artefact> artefacts_;
  std::vector<Rebuilt> done_;
};

Result<std::vector<ScanRow>> ScansToRebuild(Store& store, const std::string& id) {
  if (id.empty()) return store.LatestScans(kAll);
  auto scan = store.GetScan(id);
  if (!scan) return Fail(scan);
  return std::vector<ScanRow>{std::move(*scan)};
}

Status RebuildScan(Store& store, const ScanRow& scan, CommandIo& io, std::vector<Rebuilt>& done) {
  const auto files = OpenedFiles::Make();
  if (!files) return Fail(files);
  ScanRebuild rebuild(store, io.storage(), scan, **files);
  const Status status = rebuild.Run();
  done.insert(done.end(), rebuild.done().begin(), rebuild.done().end());
  AuditLine line;
  line.origin = "program";
  line.action = "rebuild";
  line.subject = scan.id;
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
  store_options.station_key_file = options.key_file;
  const auto store = Store::Open(store_options, io.storage(), clock);
  if (!store) return Fail(store);
  const auto scans = ScansToRebuild(**store, options.scan);
  if (!scans) return Fail(scans);
  std::vector<Rebuilt> done;
  std::size_t failed = 0;
  ProgressDisplay display(io.progress_mode());
  for (std::size_t k = 0; k < scans->size(); ++k) {
    const ScanRow& scan = scans->at(k);
    if (io.stop().stop_requested()) return tl::unexpected(InterruptedError("rebuild"));
    display.Show("rebuild", static_cast<double>(k), static_cast<double>(scans->size()));
    if (scan.recording.empty()) continue;
    if (const Status status = RebuildScan(**store, scan, io, done); !status) {
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
  command->add_option("--key-file", options->key_file, "the station's key file")->required()->type_name("FILE");
  command->add_option("--scan", options->scan, "this scan only")->type_name("ID");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus rebuild --store station/store --key-file station/station.key --scan S-000123");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Rebuild(*options, io); }; });
}

}  // namespace annulus
