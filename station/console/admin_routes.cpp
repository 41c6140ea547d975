// Users, retention, backups, the audit (docs/console_api.md §13).

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/console/accounts.h"
#include "station/console/console_audit.h"
#include "station/console/console_context.h"
#include "station/console/console_frame.h"
#include "station/console/job_runner.h"
#include "station/console/live_hub.h"
#include "station/console/model_cache.h"
#include "station/console/passwords.h"
#include "station/console/request_keys.h"
#include "station/console/retention.h"
#include "station/console/sessions.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestName = 64;
constexpr std::size_t kLongestSecret = 256;
constexpr int kTenYears = 3653;  // days
constexpr std::size_t kAuditPage = 200;
constexpr std::size_t kMostAuditLines = 1000;

struct Desk {
  ConsoleContext& context;
  ConsoleFrame& frame;
};

Json UserToJson(const User& user) {
  return {{"name", user.name},
          {"role", StationRoleName(user.role)},
          {"enabled", user.enabled},
          {"has_pin", user.has_pin},
          {"has_totp", user.has_totp},
          {"created_ms", user.created.count()},
          {"last_login_ms", user.last_login ? Json(user.last_login->count()) : Json(nullptr)}};
}

tl::expected<User, ApiError> FindUser(const Desk& desk, const std::string& name) {
  auto found = IsUserName(name) ? desk.context.store.GetUser(name) : std::optional<User>();
  if (!found) return Refuse(503, found.error());
  if (!*found) return Refuse(404, {"find user", "there is none of this name", "look at the list again"});
  return std::move(**found);
}

tl::expected<StationRole, ApiError> RoleField(const nlohmann::json& body) {
  const auto name = TextField(body, "role", 16);
  if (!name) return tl::unexpected(name.error());
  const auto role = ParseStationRole(*name);
  if (!role || *role == StationRole::kNone) {
    return BadField("role", "there is no such role", "give operator, technician or admin");
  }
  return *role;
}

/// Whatever the user's browsers hold open ends: what they may do has changed.
void EndSessionsOf(const Desk& desk, const std::string& user, const std::string& except, const std::string& reason) {
  for (const std::string& ended : desk.frame.sessions.CloseOf(user, except))
    EndSession(desk.context.live, ended, reason);
}

ApiResult ListUsers(const Desk& desk) {
  const auto users = desk.context.store.Users();
  if (!users) return Refuse(503, users.error());
  Json list = Json::array();
  for (const User& user : *users) list.push_back(UserToJson(user));
  return JsonAnswer({{"users", std::move(list)}});
}

ApiResult AddUser(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {"name", "role", "password"}); !known) return tl::unexpected(known.error());
  const auto name = TextField(request.body, "name", kLongestName);
  if (!name) return tl::unexpected(name.error());
  if (!IsUserName(*name)) {
    return BadField("name", "it is not made of letters, digits, '-', '_' and '.'", "take another name");
  }
  const auto role = RoleField(request.body);
  if (!role) return tl::unexpected(role.error());
  const auto password = TextField(request.body, "password", kLongestSecret);
  if (!password) return tl::unexpected(password.error());
  if (FindUser(desk, *name)) {
    return tl::unexpected(ApiError{409, {"add user", "there is one of this name", "take another name"}, "name"});
  }
  if (const Status good = CheckNewPassword(*password, *name); !good) {
    return tl::unexpected(ApiError{400, good.error(), "password"});
  }
  if (const Status added = desk.frame.accounts.Add(*name, *role, *password); !added) return Refuse(503, added.error());
  const auto user = FindUser(desk, *name);
  if (!user) return tl::unexpected(user.error());
  return JsonAnswer(UserToJson(*user));
}

/// What a change of a user asks for. Read as a whole before any of it is done.
struct UserChange {
  User user;
  std::optional<std::string> password;
  std::optional<std::string> pin;
  std::optional<std::string> totp;
};

tl::expected<UserChange, ApiError> ReadChange(const nlohmann::json& body, User user) {
  if (auto known = OnlyKeys(body, {"role", "enabled", "password", "pin", "totp"}); !known) {
    return tl::unexpected(known.error());
  }
  UserChange change;
  change.user = std::move(user);
  if (body.contains("role")) {
    const auto role = RoleField(body);
    if (!role) return tl::unexpected(role.error());
    change.user.role = *role;
  }
  const auto enabled = FlagOr(body, "enabled", change.user.enabled);
  if (!enabled) return tl::unexpected(enabled.error());
  change.user.enabled = *enabled;
  for (const auto& [name, target] :
       {std::pair{"password", &change.password}, std::pair{"pin", &change.pin}, std::pair{"totp", &change.totp}}) {
    auto text = OptionalText(body, name, kLongestSecret);
    if (!text) return tl::unexpected(text.error());
    *target = std::move(*text);
  }
  if (change.totp && *change.totp != "new" && *change.totp != "off") {
    return BadField("totp", "it is neither new nor off", "give one of them");
  }
  return change;
}

/// Carries it out; the text for an authenticator if there is a new second factor.
tl::expected<std::string, ApiError> ChangeAll(const Desk& desk, const UserChange& change) {
  const std::string& name = change.user.name;
  const auto bad = [](const Status& status, const char* field) {
    return tl::unexpected<ApiError>(ApiError{400, status.error(), field});
  };
  // The role first: a PIN asks what it is.
  if (const Status done = desk.frame.accounts.Change(change.user); !done) return Refuse(409, done.error());
  if (change.password) {
    if (const Status done = desk.frame.accounts.SetPassword(name, *change.password); !done)
      return bad(done, "password");
  }
  if (change.pin) {
    if (const Status done = desk.frame.accounts.SetPin(name, *change.pin); !done) return bad(done, "pin");
  }
  if (change.totp == "off") {
    if (const Status done = desk.frame.accounts.DropTotp(name); !done) return Refuse(503, done.error());
  }
  if (change.totp != "new") return std::string();
  auto uri = desk.frame.accounts.NewTotp(name);
  if (!uri) return Refuse(503, uri.error());
  return std::move(*uri);
}

ApiResult ChangeUser(const Desk& desk, const ApiRequest& request) {
  auto before = FindUser(desk, request.path.at("user"));
  if (!before) return tl::unexpected(before.error());
  const std::string name = before->name;
  const auto change = ReadChange(request.body, std::move(*before));
  if (!change) return tl::unexpected(change.error());
  const auto uri = ChangeAll(desk, *change);
  // Refused as a whole (the last admin): nothing has changed, and nobody has to go.
  if (!uri && uri.error().status == 409) return tl::unexpected(uri.error());
  // Also if only half of it could be done. The admin's own session stays if it may still do this.
  const bool own = name == request.caller.user && change->user.enabled && change->user.role == StationRole::kAdmin;
  EndSessionsOf(desk, name, own ? request.caller.session_id : "", "an admin has changed the account");
  if (!uri) return tl::unexpected(uri.error());
  const auto after = FindUser(desk, name);
  if (!after) return tl::unexpected(after.error());
  Json json = UserToJson(*after);
  if (!uri->empty()) json["totp_uri"] = *uri;
  return JsonAnswer(json);
}

ApiResult RemoveUser(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const auto user = FindUser(desk, request.path.at("user"));
  if (!user) return tl::unexpected(user.error());
  const Status removed = desk.frame.accounts.Remove(user->name);
  if (!removed) return Refuse(409, removed.error());
  EndSessionsOf(desk, user->name, "", "the account was removed");
  return JsonAnswer(Json::object());
}

Retention RetentionOf(const Desk& desk) { return {desk.context.store, desk.context.models, desk.context.clock}; }

ApiResult GetRetention(const Desk& desk) {
  const auto expired = desk.context.store.Expired();
  if (!expired) return Refuse(503, expired.error());
  Retention retention = RetentionOf(desk);
  const auto applied = retention.LastApplied();
  if (!applied) return Refuse(503, applied.error());
  const auto held = retention.IsHeld();
  if (!held) return Refuse(503, held.error());
  Json list = Json::array();
  for (const Customer& one : *expired) list.push_back({{"id", one.id}, {"keep_until_ms", one.keep_until.count()}});
  return JsonAnswer({{"days", RetentionDays(desk.context.store, desk.context.config.store)},
                     {"expired", std::move(list)},
                     {"applied_ms", *applied ? Json((*applied)->count()) : Json(nullptr)},
                     {"held", *held}});
}

ApiResult SetRetention(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {"days"}); !known) return tl::unexpected(known.error());
  const auto days = NumberField(request.body, "days", 1, kTenYears);
  if (!days) return tl::unexpected(days.error());
  if (*days != static_cast<int>(*days)) return BadField("days", "it is no whole number", "give whole days");
  const Status set = desk.context.store.SetSetting(kRetentionSetting, std::to_string(static_cast<int>(*days)));
  if (!set) return Refuse(503, set.error());
  return GetRetention(desk);
}

Json ProofToJson(const ErasureProof& proof) {
  return {{"customer_id", proof.customer_id},
          {"files", proof.files},
          {"rows", proof.rows},
          {"key_destroyed", proof.key_destroyed},
          {"bytes_searched", proof.bytes_searched},
          {"marker_hits", proof.marker_hits}};
}

ApiResult ApplyRetention(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const auto proofs = RetentionOf(desk).Apply([&](const std::string& id, const std::string& result) {
    desk.frame.audit.Done(request.caller, "erase", id, result);
  });
  if (!proofs) return Refuse(503, proofs.error());
  Json erased = Json::array();
  for (const ErasureProof& proof : *proofs) erased.push_back(ProofToJson(proof));
  return JsonAnswer({{"erased", std::move(erased)}});
}

ApiResult KeepCustomer(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {"until_ms"}); !known) return tl::unexpected(known.error());
  const auto now = std::chrono::duration_cast<StoreTime>(desk.context.clock.WallNow());
  const auto latest = now + std::chrono::hours(24 * kTenYears);
  const auto until =
      NumberField(request.body, "until_ms", static_cast<double>(now.count()), static_cast<double>(latest.count()));
  if (!until) return tl::unexpected(until.error());
  const std::string& id = request.path.at("customer");
  if (const auto customer = desk.context.store.GetCustomer(id); !customer) return Refuse(404, customer.error());
  const Status kept = desk.context.store.KeepUntil(id, StoreTime(static_cast<std::int64_t>(*until)));
  if (!kept) return Refuse(503, kept.error());
  return JsonAnswer(Json::object());
}

std::uint64_t BytesBelow(const std::string& path) {
  namespace fs = std::filesystem;
  std::uint64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(path, error); !error && entry != fs::recursive_directory_iterator();
       entry.increment(error)) {
    std::error_code unknown;
    if (entry->is_regular_file(unknown)) bytes += entry->file_size(unknown);
  }
  return bytes;
}

/// A job without steps: the store does it, in the runner's thread.
ApiResult StartBackup(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  JobRequest job;
  job.kind = "backup";
  job.owner = request.caller.user;
  job.subject = "store";
  job.finish = [&store = desk.context.store, folder = desk.context.config.store.backup_folder]() -> Result<Json> {
    const auto backup = store.Backup(folder);
    if (!backup) return Fail(backup);
    return Json{{"backup", *backup}, {"keys", *backup + "-keys"}, {"bytes", BytesBelow(*backup)}};
  };
  const std::string id = desk.context.jobs.Start(std::move(job));
  return JsonAnswer({{"id", id},
                     {"kind", "backup"},
                     {"subject", "store"},
                     {"state", "waiting"},
                     {"stage", ""},
                     {"share", 0.0},
                     {"eta_s", nullptr},
                     {"error", nullptr},
                     {"result", nullptr}});
}

tl::expected<std::uint64_t, ApiError> CountQuery(const HttpRequest& http, const char* name, std::uint64_t otherwise,
                                                 std::uint64_t most) {
  const auto text = http.Query(name);
  if (!text) return otherwise;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc() || end != text->data() + text->size() || number > most) {
    return BadField(name, "it is no whole number up to " + std::to_string(most), "give one");
  }
  return number;
}

Json LineToJson(const AuditLine& line) {
  return {{"number", line.number}, {"time_ms", line.time.count()}, {"user", line.user},     {"origin", line.origin},
          {"action", line.action}, {"subject", line.subject},      {"result", line.result}, {"hash", line.hash}};
}

/// The number in a message of the store that says where the chain breaks: the last digits in it.
Json FirstNumberIn(const std::string& text) {
  const std::size_t begin = text.find_first_of("0123456789");
  if (begin == std::string::npos) return nullptr;
  std::uint64_t number = 0;
  std::from_chars(text.data() + begin, text.data() + text.size(), number);
  return number;
}

ApiResult GetAudit(const Desk& desk, const ApiRequest& request) {
  constexpr std::uint64_t kNewest = 0;
  const auto from = CountQuery(request.http, "from", kNewest, std::uint64_t{1} << 52U);
  if (!from) return tl::unexpected(from.error());
  const auto limit = CountQuery(request.http, "limit", kAuditPage, kMostAuditLines);
  if (!limit) return tl::unexpected(limit.error());
  const auto lines = desk.context.store.AuditLines(*from, *limit);
  if (!lines) return Refuse(503, lines.error());
  Json list = Json::array();
  for (const AuditLine& line : *lines) list.push_back(LineToJson(line));
  const auto verified = desk.context.store.VerifyAudit();
  return JsonAnswer({{"lines", std::move(list)},
                     {"verified", verified.has_value()},
                     {"first_bad", verified ? Json(nullptr) : FirstNumberIn(verified.error().seen)}});
}

/// The last line's hash, to print and file: whoever rewrites the chain later cannot rewrite the paper.
ApiResult GetAnchor(const Desk& desk) {
  const auto hash = desk.context.store.VerifyAudit();
  if (!hash) return Refuse(409, hash.error());
  const auto last = desk.context.store.AuditLines(0, 1);
  if (!last) return Refuse(503, last.error());
  const bool empty = last->empty();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(desk.context.clock.WallNow()).count();
  const auto time = static_cast<std::time_t>(seconds);
  std::tm utc{};
  ::gmtime_r(&time, &utc);
  std::array<char, 32> date{};
  std::strftime(date.data(), date.size(), "%Y-%m-%d", &utc);
  return JsonAnswer({{"date", date.data()},
                     {"number", empty ? 0 : last->back().number},
                     {"hash", empty ? *hash : last->back().hash}});
}

ApiResult GetStore(const Desk& desk) {
  constexpr std::size_t kAll = 1'000'000;
  const auto customers = desk.context.store.FindCustomers("", kAll);
  const auto scans = desk.context.store.LatestScans(kAll);
  const auto schema = desk.context.store.Schema();
  const bool ready = desk.context.store.state() == StoreState::kReady;
  return JsonAnswer({{"state", ready ? "ready" : "read_only"},
                     {"problem", desk.context.store.problem()},
                     {"customers", customers ? Json(customers->size()) : Json(nullptr)},
                     {"scans", scans ? Json(scans->size()) : Json(nullptr)},
                     {"bytes", BytesBelow(desk.context.config.store.folder)},
                     {"schema", schema ? Json(*schema) : Json(nullptr)}});
}

}  // namespace

void AddAdminRoutes(RouteTable& table, ConsoleContext& context, ConsoleFrame& frame) {
  const Desk desk{context, frame};
  using Answer = ApiResult (*)(const Desk&, const ApiRequest&);
  using Look = ApiResult (*)(const Desk&);
  const auto get = [&](const char* pattern, RouteRoles roles, Look look) {
    table.Add({"GET", pattern, roles, false, "", "", [desk, look](const ApiRequest&) { return look(desk); }});
  };
  const auto post = [&](const char* pattern, const char* action, const char* subject, Answer answer) {
    table.Add({"POST", pattern, kAdmins, false, action, subject,
               [desk, answer](const ApiRequest& request) { return answer(desk, request); }});
  };
  get("/api/users", kAdmins, ListUsers);
  post("/api/users", "add user", "name", AddUser);
  post("/api/users/{user}", "change user", "user", ChangeUser);
  post("/api/users/{user}/remove", "remove user", "user", RemoveUser);
  get("/api/retention", kAdmins, GetRetention);
  post("/api/retention", "retention", "", SetRetention);
  post("/api/retention/apply", "apply retention", "", ApplyRetention);
  post("/api/customers/{customer}/keep", "keep customer", "customer", KeepCustomer);
  post("/api/backup", "backup", "", StartBackup);
  table.Add({"GET", "/api/audit", kTechniciansAdmins, false, "", "",
             [desk](const ApiRequest& request) { return GetAudit(desk, request); }});
  get("/api/audit/anchor", kAdmins, GetAnchor);
  get("/api/store", kTechniciansAdmins, GetStore);
}

}  // namespace annulus
