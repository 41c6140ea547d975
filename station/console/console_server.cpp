#include "station/console/console_server.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "base/log.h"
#include "station/console/accounts.h"
#include "station/console/booth_link.h"
#include "station/console/booth_live.h"
#include "station/console/console_audit.h"
#include "station/console/console_context.h"
#include "station/console/console_frame.h"
#include "station/console/console_handler.h"
#include "station/console/job_folder.h"
#include "station/console/job_runner.h"
#include "station/console/live_hub.h"
#include "station/console/login_guard.h"
#include "station/console/model_cache.h"
#include "station/console/request_gate.h"
#include "station/console/retention.h"
#include "station/console/scan_intake.h"
#include "station/console/scratch_folder.h"
#include "station/console/sessions.h"
#include "station/console/static_files.h"
#include "station/http/http_server.h"
#include "station/http/tls_identity.h"
#include "station/key_file.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::chrono::minutes kLookAtCertificate{60};
constexpr std::size_t kImportBytes = std::size_t{64} << 20;

std::chrono::sys_seconds WallSeconds(const Clock& clock) {
  return std::chrono::sys_seconds(std::chrono::duration_cast<std::chrono::seconds>(clock.WallNow()));
}

/// An address as it stands behind "Host:": IPv6 in brackets.
std::string HostOfAddress(const std::string& address) {
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

/// Names and addresses beside localhost under which browsers may reach us.
std::vector<std::string> ReachedAs(const ConsoleServerOptions& options) {
  std::vector<std::string> names = options.config.console.host_names;
  for (const std::string& address : options.remote) names.push_back(HostOfAddress(address));
  return names;
}

/// The same for the certificate, in which addresses have no brackets.
std::vector<std::string> CertifiedNames(const ConsoleServerOptions& options) {
  std::vector<std::string> names = options.config.console.host_names;
  names.insert(names.end(), options.remote.begin(), options.remote.end());
  return names;
}

StoreOptions StoreOptionsOf(const ConsoleServerOptions& options) {
  StoreOptions store;
  store.folder = options.folder;
  store.station_key_file = StationKeyFile(options);
  store.make_key = true;
  store.keep = std::chrono::hours(24 * options.config.store.keep_days);
  return store;
}

class Server final : public ConsoleServer {
 public:
  Server(ConsoleServerOptions options, Storage& storage, const Clock& clock)
      : options_(std::move(options)), storage_(storage), clock_(clock), guard_(clock), sessions_(clock) {}

  ~Server() override {
    server_.reset();
    if (booth_live_ != nullptr) booth_live_->OnScanEnded({});  // the link may still hear of one
    intake_.reset();
    jobs_.reset();  // what they do last works with the context
  }

  Status Prepare() {
    auto files = StaticFiles::Read(options_.web_folder);
    if (!files) return Fail(files);
    files_ = std::move(*files);
    auto store = Store::Open(StoreOptionsOf(options_), storage_, clock_);
    if (!store) return Fail(store);
    store_ = std::move(*store);
    auto keys = ReadKeyFile(StationKeyFile(options_));
    if (!keys) return Fail(keys);
    keys_ = std::move(*keys);
    auto identity = OpenTlsIdentity(storage_, options_.folder + "/tls", CertifiedNames(options_), clock_);
    if (!identity) return Fail(identity);
    identity_ = std::move(*identity);
    auto scratch = ScratchFolder::Make("");
    if (!scratch) return Fail(scratch);
    scratch_ = std::move(*scratch);
    accounts_ = std::make_unique<Accounts>(*store_, guard_, clock_);
    audit_ = std::make_unique<ConsoleAudit>(*store_, clock_);
    live_ = LiveHub::Make();
    models_ = ModelCache::Make([this](const std::string& scan_id) { return OpenStoredModel(*store_, scan_id); });
    retention_ = std::make_unique<Retention>(*store_, *models_, clock_);
    return {};
  }

  Status Listen() override {
    jobs_ = JobRunner::Make(options_.job_program, [this](const JobStatus& job) { TellOf(job); });
    booth_live_ = std::make_unique<BoothLive>(*live_, clock_);
    link_ = BoothLink::Make(options_.booth_socket, booth_live_->events());
    booth_live_->Attach(*link_);
    AddRoutes();
    intake_ = ScanIntake::Make(*context_, {options_.config.store.recordings, keys_.get()});
    booth_live_->OnScanEnded([this](const ScanResult* result) { intake_->ScanEnded(result); });
    gate_ = std::make_unique<RequestGate>(
        GateOptions{ReachedAs(options_), true, [this] { return ProblemOfCertificate(); }}, sessions_);
    handler_ = std::make_unique<ConsoleHandler>(
        ConsoleParts{table_, *gate_, sessions_, files_, *live_, *audit_,
                     [this](Scanner::JogDirection direction) { return link_->AskAsTechnician(JogOrder{direction}); }});
    HttpServerOptions http;
    http.addresses.insert(http.addresses.end(), options_.remote.begin(), options_.remote.end());
    http.port = options_.port;
    http.certificate_pem = identity_.certificate_pem;
    http.private_key_pem = identity_.private_key_pem;
    http.urgent_paths = {std::string(kStopPath)};
    http.limits.large_bodies = {{"/api/scans/import", kImportBytes}};
    auto server = HttpServer::Make(std::move(http), *handler_);
    if (!server) return Fail(server);
    server_ = std::move(*server);
    gate_->set_port(server_->port());
    return {};
  }

  void Tick() override {
    for (const std::string& ended : sessions_.CloseExpired()) EndSession(*live_, ended, "not used for too long");
    const std::string problem = store_->problem();
    if (problem != last_problem_) {
      last_problem_ = problem;
      const bool ready = store_->state() == StoreState::kReady;
      live_->Send({{"type", "store"}, {"state", ready ? "ready" : "read_only"}, {"problem", problem}}, kEverybody);
    }
    if (clock_.Now() - looked_at_certificate_ >= kLookAtCertificate) RenewCertificate();
    if (retention_->IsDue()) StartRetention();
  }

  [[nodiscard]] Accounts& accounts() override { return *accounts_; }
  [[nodiscard]] Store& store() override { return *store_; }
  [[nodiscard]] std::uint16_t port() const override { return server_->port(); }
  [[nodiscard]] std::string fingerprint() const override { return identity_.fingerprint; }
  [[nodiscard]] std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (!store_->problem().empty()) notes.push_back(store_->problem());
    if (!scratch_->problem().empty()) notes.push_back(scratch_->problem());
    if (!files_.has_page()) notes.push_back("the page is not built; the console shows how");
    const std::string certificate = ProblemOfCertificate();
    if (!certificate.empty()) notes.push_back(certificate);
    return notes;
  }

 private:
  void AddRoutes() {
    context_ =
        std::make_unique<ConsoleContext>(ConsoleContext{options_.config, options_.config_path, *store_, *link_, *live_,
                                                        *jobs_, *models_, *scratch_, storage_, clock_, keys_.get()});
    frame_ = std::make_unique<ConsoleFrame>(
        ConsoleFrame{*accounts_, sessions_, *audit_, [this] { return ProblemOfCertificate(); }});
    AddAllRoutes(table_, *context_, *frame_);
  }

  std::string ProblemOfCertificate() const {
    const std::lock_guard lock(identity_mutex_);
    return CertificateProblem(identity_, WallSeconds(clock_));
  }

  void TellOf(const JobStatus& job) {
    Json json{{"type", "job"}};
    json.update(JobJson(job));
    live_->SendTo(job.owner, json);
  }

  /// Erasing searches all of the store: a job's work, though without a process.
  void StartRetention() {
    JobRequest job;
    job.kind = "retention";
    job.subject = "store";
    job.finish = [this]() -> Result<Json> {
      const auto proofs = retention_->ApplyByItself();
      if (!proofs) return Fail(proofs);
      return Json{{"erased", proofs->size()}};
    };
    jobs_->Start(std::move(job));
  }

  /// A certificate that is near its end is replaced while we run; connections that are open keep theirs.
  void RenewCertificate() {
    looked_at_certificate_ = clock_.Now();
    auto identity = OpenTlsIdentity(storage_, options_.folder + "/tls", CertifiedNames(options_), clock_);
    if (!identity) return Log(LogLevel::kWarning, identity.error().Text());
    const std::lock_guard lock(identity_mutex_);
    if (identity->certificate_pem == identity_.certificate_pem) return;
    const Status taken = server_->SetIdentity(identity->certificate_pem, identity->private_key_pem);
    if (!taken) return Log(LogLevel::kWarning, taken.error().Text());
    identity_ = std::move(*identity);
  }

  // In the order in which they depend on each other: the server, which calls all others, is the first to go.
  ConsoleServerOptions options_;
  Storage& storage_;
  const Clock& clock_;
  StaticFiles files_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<KeySource> keys_;  ///< The station's; boothd seals with it.
  mutable std::mutex identity_mutex_;
  TlsIdentity identity_;
  std::unique_ptr<ScratchFolder> scratch_;
  LoginGuard guard_;
  Sessions sessions_;
  std::unique_ptr<Accounts> accounts_;
  std::unique_ptr<ConsoleAudit> audit_;
  std::unique_ptr<LiveHub> live_;
  std::unique_ptr<ModelCache> models_;
  std::unique_ptr<Retention> retention_;
  std::unique_ptr<JobRunner> jobs_;
  std::unique_ptr<BoothLive> booth_live_;
  std::unique_ptr<BoothLink> link_;
  std::unique_ptr<ConsoleContext> context_;
  std::unique_ptr<ScanIntake> intake_;
  std::unique_ptr<ConsoleFrame> frame_;
  RouteTable table_;
  std::unique_ptr<RequestGate> gate_;
  std::unique_ptr<ConsoleHandler> handler_;
  std::unique_ptr<HttpServer> server_;
  std::chrono::nanoseconds looked_at_certificate_{0};
  std::string last_problem_;
};

}  // namespace

std::string StationKeyFile(const ConsoleServerOptions& options) {
  return options.config.store.key_file.empty() ? options.folder + "/station.key" : options.config.store.key_file;
}

Result<std::unique_ptr<ConsoleServer>> ConsoleServer::Open(ConsoleServerOptions options, Storage& storage,
                                                           const Clock& clock) {
  RETURN_IF_ERROR(storage.CreateFolder(options.folder));
  auto server = std::make_unique<Server>(std::move(options), storage, clock);
  RETURN_IF_ERROR(server->Prepare());
  return std::unique_ptr<ConsoleServer>(std::move(server));
}

}  // namespace annulus
