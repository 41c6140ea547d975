#include "station/console/scan_intake.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stop_token>
#include <thread>
#include <utility>

#include "base/log.h"
#include "station/console/live_hub.h"
#include "station/console/route_errors.h"
#include "station/console/scan_fit_job.h"
#include "station/console/scan_json.h"
#include "station/console/scan_judgement.h"
#include "station/console/scan_tickets.h"
#include "station/console/technician_drift.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::chrono::seconds kTryAgain{10};
constexpr std::chrono::hours kStillWanted{24};  ///< A model that was not finished, after a restart.
constexpr std::size_t kLookedThrough = 50;
constexpr const char* kEnding = ".mcap";

class Intake final : public ScanIntake {
 public:
  Intake(ConsoleContext& context, ScanIntakeOptions options)
      : context_(context), options_(std::move(options)), tickets_(context.store) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }

  void ScanEnded(const ScanResult* result) override {
    const std::lock_guard lock(mutex_);
    if (result != nullptr) ended_.push_back(*result);
    look_ = true;
    wake_.notify_all();
  }

 private:
  void Run(const std::stop_token& stop) {
    Guarded([&] { FitWhatWasLeft(); });
    while (!stop.stop_requested()) {
      bool all_taken = true;
      Guarded([&] {
        all_taken = TakeAll(stop);
        TellWhatWasNotRecorded();
      });
      std::unique_lock lock(mutex_);
      const auto called = [this] { return look_; };
      if (all_taken) {
        wake_.wait(lock, stop, called);
      } else {
        wake_.wait_for(lock, stop, kTryAgain, called);
      }
      look_ = false;
    }
  }

  /// Our own mistakes must not end the intake.
  template <class Work>
  static void Guarded(Work work) {
    try {
      work();
    } catch (const std::exception& mistake) {
      Log(LogLevel::kError, std::string("scan intake: ") + mistake.what());
    }
  }

  /// False if one is to be tried again.
  bool TakeAll(const std::stop_token& stop) {
    const auto names = context_.storage.List(options_.recordings);
    if (!names) return true;  // there is no folder yet
    bool all = true;
    for (const std::string& name : *names) {
      if (stop.stop_requested()) return true;
      if (!name.starts_with("T-") || !name.ends_with(kEnding) || given_up_.contains(name)) continue;
      const std::string file = options_.recordings + "/" + name;
      if (context_.storage.InUse(file)) continue;
      const Status taken = Take(name.substr(0, name.size() - std::string_view(kEnding).size()), file);
      if (taken) continue;
      all = false;
      if (told_.insert(name).second) Tell("", "", taken.error());
    }
    return all;
  }

  Status Take(const std::string& id, const std::string& file) {
    const auto known = tickets_.Find(id);
    if (!known) return Fail(known);
    const auto bytes = context_.storage.ReadAll(file, kMaxInputBytes);
    if (!bytes) return Fail(bytes);
    auto judged = JudgeRecording(*bytes, file, options_.keys, id);
    if (!judged) {
      given_up_.insert(id + kEnding);  // it will not get better; it stays for the technician
      return Fail(judged);
    }
    ScanTicket ticket = known->value_or(ScanTicket{});
    // The recording itself says for whom it was taken.
    if (!judged->header.subject_id.empty()) ticket.customer_id = judged->header.subject_id;
    if (!judged->header.consent_reference.empty()) ticket.consent_id = judged->header.consent_reference;
    if (const auto there = AlreadyThere(ticket.customer_id, id)) return context_.storage.Remove(file);
    if (*known) {
      if (const std::string why = WhyNotWanted(ticket); !why.empty()) return Discard(ticket, file, why);
    }
    return Add(ticket, id, file, *judged);
  }

  Status Add(const ScanTicket& ticket, const std::string& id, const std::string& file, const ScanJudgement& judged) {
    ScanRow row;
    row.customer_id = ticket.customer_id;
    row.consent_id = ticket.consent_id;
    row.profile = judged.header.profile;
    row.verdict = judged.verdict;
    row.summary_json = judged.summary_json;
    row.taken = std::chrono::duration_cast<StoreTime>(std::chrono::nanoseconds(judged.header.wall_start_ns));
    const auto added = context_.store.AddScan(std::move(row), file, options_.keys);
    if (!added) return Fail(added);
    Audit("scan", added->id, "ok");
    Log(LogLevel::kInfo, "scan " + added->id + " taken in from " + id);
    Tell(added->customer_id, added->id, std::nullopt);
    // The scan is safe; a fit that cannot be started now is asked for again, drift is looked for after the next scan.
    if (!judged.parked) {
      const auto job = StartFitJob(context_, added->id, ticket.user);
      if (!job) Log(LogLevel::kError, "fit of " + added->id + ": " + job.error().Text());
    }
    const auto drift = StartDriftUpdate(context_, "");
    if (!drift) Log(LogLevel::kError, "drift after " + added->id + ": " + drift.error().Text());
    return {};
  }

  /// The scan that the store has of this ticket.
  std::optional<std::string> AlreadyThere(const std::string& customer_id, const std::string& ticket) {
    const auto scans = context_.store.ScansOf(customer_id);
    if (!scans) return std::nullopt;
    for (const ScanRow& scan : *scans) {
      if (SummaryOf(scan).value("ticket", "") == ticket) return scan.id;
    }
    return std::nullopt;
  }

  /// Why the store must not have it any more; "" if it may, or if that cannot be told now.
  std::string WhyNotWanted(const ScanTicket& ticket) {
    const auto consents = context_.store.Consents(ticket.customer_id);
    const auto withdrawn = [&](const Consent& one) { return one.id == ticket.consent_id && one.withdrawn; };
    if (consents && std::any_of(consents->begin(), consents->end(), withdrawn)) return "the consent was withdrawn";
    // A store that does not answer is no reason.
    const bool answers = context_.store.state() == StoreState::kReady && context_.store.LatestScans(1).has_value();
    const bool gone = !context_.store.GetCustomer(ticket.customer_id) && (!consents || consents->empty());
    return answers && gone ? "the customer was erased" : "";
  }

  Status Discard(const ScanTicket& ticket, const std::string& file, const std::string& why) {
    RETURN_IF_ERROR(context_.storage.Remove(file));
    Audit("recording_deleted", ticket.customer_id, why);
    Tell(ticket.customer_id, "",
         Error{"take the scan into the store", why, "the recording was deleted; scan again with a consent"});
    return {};
  }

  /// Scans that ended without a recording, of which the folder says nothing.
  void TellWhatWasNotRecorded() {
    std::deque<ScanResult> ended;
    {
      const std::lock_guard lock(mutex_);
      ended.swap(ended_);
    }
    for (const ScanResult& result : ended) {
      if (result.recorded || result.top) continue;
      Tell(
          "", "",
          result.status ? Error{"scan", "it was stopped before its first level", "scan again"} : result.status.error());
    }
  }

  /// What technicians are told names nobody.
  void Tell(const std::string& customer_id, const std::string& scan_id, const std::optional<Error>& error) {
    Json message{{"type", "scan_result"},
                 {"customer_id", customer_id.empty() ? Json(nullptr) : Json(customer_id)},
                 {"scan", nullptr},
                 {"error", nullptr}};
    if (error) message["error"] = ErrorJson(*error);
    const auto scan = scan_id.empty() ? Result<ScanRow>(Fail("", "", "")) : context_.store.GetScan(scan_id);
    if (scan) message["scan"] = ScanToJson(context_.store, *scan, StationRole::kOperator);
    context_.live.Send(message, kOperators);
    message["customer_id"] = nullptr;
    if (scan) message["scan"] = ScanToJson(context_.store, *scan, StationRole::kTechnician);
    context_.live.Send(message, kTechnicians);
  }

  void Audit(const std::string& action, const std::string& subject, const std::string& result) {
    AuditLine line;
    line.origin = "program";
    line.action = action;
    line.subject = subject;
    line.result = result;
    if (const Status kept = context_.store.Audit(std::move(line)); !kept) {
      Log(LogLevel::kError, "the audit does not take a line: " + kept.error().Text());
    }
  }

  /// Scans whose fit was under way when the console died.
  void FitWhatWasLeft() {
    const auto scans = context_.store.LatestScans(kLookedThrough);
    if (!scans) return;
    const auto now = std::chrono::duration_cast<StoreTime>(context_.clock.WallNow());
    for (const ScanRow& scan : *scans) {
      if (scan.recording_missing || scan.recording.empty() || now - scan.taken > kStillWanted) continue;
      const Json json = ScanToJson(context_.store, scan, StationRole::kOperator);
      if (json.at("model").get<bool>() || scan.profile == "breath") continue;
      const auto ticket = tickets_.Find(SummaryOf(scan).value("ticket", ""));
      const std::string owner = ticket && *ticket ? (*ticket)->user : "";
      const auto job = StartFitJob(context_, scan.id, owner);
      if (!job) Log(LogLevel::kWarning, "fit of " + scan.id + ": " + job.error().Text());
    }
  }

  ConsoleContext& context_;
  const ScanIntakeOptions options_;
  ScanTickets tickets_;
  std::set<std::string> given_up_;  ///< Of the thread alone: recordings that cannot be read.
  std::set<std::string> told_;      ///< Likewise: failures that were told.
  std::mutex mutex_;                ///< Of what follows.
  std::condition_variable_any wake_;
  std::deque<ScanResult> ended_;
  bool look_ = false;
  std::jthread thread_;  ///< Last: it ends first.
};

}  // namespace

std::unique_ptr<ScanIntake> ScanIntake::Make(ConsoleContext& context, ScanIntakeOptions options) {
  return std::make_unique<Intake>(context, std::move(options));
}

}  // namespace annulus
