// store: customers, scans and their files, from the command line.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/commands.h"
#include "station/console/accounts.h"
#include "station/console/login_guard.h"
#include "station/store/store.h"
#include "station/store/store_check.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// What all actions are told.
struct StoreCommand {
  std::string folder;
  std::string key_file;
  std::string json;
  std::string search;
  std::size_t limit = 50;
  bool names = false;
  std::string out;
  std::string backup;
  std::string keys;
  std::string customer;
  bool yes = false;
  std::uint64_t from = 0;
  std::string user_action = "list";
  std::string user;
};

/// What an action found, for people and for programs.
struct Outcome {
  std::string text;
  Json json;
  bool failed = false;  ///< Exit code 1, though there is a result.
};

std::string DayText(StoreTime time) {
  const auto seconds = static_cast<std::time_t>(std::chrono::floor<std::chrono::seconds>(time).count());
  std::tm day{};
  gmtime_r(&seconds, &day);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d", &day)};
}

/// A folder as it was typed, without the slashes that a shell's completion leaves at its end.
std::string WithoutSlash(std::string folder) {
  while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
  return folder;
}

StoreOptions OptionsOf(const StoreCommand& command) {
  StoreOptions options;
  options.folder = WithoutSlash(command.folder);
  options.station_key_file = command.key_file.empty() ? options.folder + "/station.key" : command.key_file;
  return options;
}

/// An existing store: this command makes none by mistyping.
Result<std::unique_ptr<Store>> OpenStore(const StoreCommand& command, CommandIo& io, const Clock& clock) {
  if (!io.storage().Exists(command.folder + "/annulus.db")) {
    return Fail("open the store " + command.folder, "there is none", "give the folder of a store with --store");
  }
  return Store::Open(OptionsOf(command), io.storage(), clock);
}

Status Note(Store& store, const std::string& action, const std::string& subject, const std::string& result) {
  AuditLine line;
  line.origin = "program";
  line.action = action;
  line.subject = subject;
  line.result = result;
  return store.Audit(std::move(line));
}

Result<Outcome> List(Store& store, const StoreCommand& command) {
  const auto customers = store.FindCustomers(command.search, command.limit);
  if (!customers) return Fail(customers);
  Outcome outcome;
  outcome.json = {{"customers", Json::array()}};
  for (const Customer& customer : *customers) {
    const auto scans = store.ScansOf(customer.id);
    const std::string count = scans ? std::to_string(scans->size()) : "unreadable";
    outcome.text += fmt::format("{}  made {}  kept until {}  scans {}{}\n", customer.id, DayText(customer.created),
                                DayText(customer.keep_until), count, command.names ? "  " + customer.name : "");
    Json line{{"id", customer.id},
              {"created_ms", customer.created.count()},
              {"keep_until_ms", customer.keep_until.count()},
              {"scans", scans ? Json(scans->size()) : Json()}};
    if (command.names) line["name"] = customer.name;
    outcome.json["customers"].push_back(std::move(line));
  }
  if (outcome.text.empty()) outcome.text = "no customers\n";
  return outcome;
}

Result<Outcome> Verify(Store& store, const StoreCommand&) {
  const StoreCheck check = CheckStore(store);
  Outcome outcome;
  outcome.failed = !check.problems.empty();
  outcome.text = fmt::format("{} customers, {} scans, {} recordings, {} artefacts, {} audit lines\n", check.customers,
                             check.scans, check.recordings, check.artefacts, check.audit_lines);
  for (const std::string& problem : check.problems) outcome.text += problem + "\n";
  outcome.text += outcome.failed ? fmt::format("{} problems\n", check.problems.size()) : "all sound\n";
  outcome.json = {
      {"sound", !outcome.failed},           {"customers", check.customers}, {"scans", check.scans},
      {"recordings", check.recordings},     {"artefacts", check.artefacts}, {"audit_lines", check.audit_lines},
      {"last_hash", check.last_audit_hash}, {"problems", check.problems}};
  return outcome;
}

Result<Outcome> MakeBackup(Store& store, const StoreCommand& command) {
  const auto made = store.Backup(command.out);
  RETURN_IF_ERROR(Note(store, "backup", "", made ? "ok" : made.error().seen));
  if (!made) return Fail(made);
  Outcome outcome;
  outcome.text = fmt::format("{}\n{}-keys (keep it apart, and not for longer than erasures may take)\n", *made, *made);
  outcome.json = {{"backup", *made}, {"keys", *made + "-keys"}};
  return outcome;
}

Json ProofJson(const ErasureProof& proof) {
  return {{"customer_id", proof.customer_id},
          {"time_ms", proof.time.count()},
          {"files", proof.files},
          {"rows", proof.rows},
          {"key_destroyed", proof.key_destroyed},
          {"bytes_searched", proof.bytes_searched},
          {"marker_hits", proof.marker_hits}};
}

std::string ProofText(const ErasureProof& proof) {
  return fmt::format("{} erased: key {}, {} rows, {} files; {} bytes searched, {} places with name, contact or key\n",
                     proof.customer_id, proof.key_destroyed ? "destroyed" : "NOT destroyed", proof.rows, proof.files,
                     proof.bytes_searched, proof.marker_hits);
}

Result<ErasureProof> EraseOne(Store& store, const std::string& customer) {
  const auto proof = store.Erase(customer);
  RETURN_IF_ERROR(Note(store, "erase", customer, proof ? "ok" : proof.error().seen));
  return proof;
}

Result<Outcome> Erase(Store& store, const StoreCommand& command) {
  if (!command.yes) {
    return Fail("erase " + command.customer, "this cannot be undone", "add --yes if it is meant");
  }
  const auto proof = EraseOne(store, command.customer);
  if (!proof) return Fail(proof);
  return Outcome{ProofText(*proof), ProofJson(*proof), !proof->key_destroyed || proof->marker_hits > 0};
}

Result<Outcome> Expire(Store& store, const StoreCommand& command) {
  const auto expired = store.Expired();
  if (!expired) return Fail(expired);
  Outcome outcome;
  outcome.json = {{"expired", Json::array()}, {"erased", Json::array()}};
  for (const Customer& customer : *expired) {
    outcome.json["expired"].push_back({{"id", customer.id}, {"keep_until_ms", customer.keep_until.count()}});
    if (!command.yes) {
      outcome.text += fmt::format("{}  kept until {}\n", customer.id, DayText(customer.keep_until));
      continue;
    }
    const auto proof = EraseOne(store, customer.id);
    if (!proof) return Fail(proof);
    outcome.text += ProofText(*proof);
    outcome.json["erased"].push_back(ProofJson(*proof));
    outcome.failed = outcome.failed || !proof->key_destroyed || proof->marker_hits > 0;
  }
  outcome.text += command.yes ? "" : fmt::format("{} whose time is over; --yes erases them\n", expired->size());
  return outcome;
}

Result<Outcome> ShowAudit(Store& store, const StoreCommand& command) {
  const auto lines = store.AuditLines(command.from, command.limit);
  if (!lines) return Fail(lines);
  const auto verified = store.VerifyAudit();
  Outcome outcome;
  outcome.failed = !verified;
  outcome.json = {{"verified", verified.has_value()}, {"last_hash", verified ? Json(*verified) : Json()}};
  if (!verified) outcome.json["problem"] = verified.error().seen;
  outcome.json["lines"] = Json::array();
  for (const AuditLine& line : *lines) {
    outcome.text += fmt::format("{:6}  {} {:02}:{:02}:{:02}  {:12}  {:10}  {:10}  {:10}  {}\n", line.number,
                                DayText(line.time), line.time / std::chrono::hours(1) % 24,
                                line.time / std::chrono::minutes(1) % 60, line.time / std::chrono::seconds(1) % 60,
                                line.user, line.origin, line.action, line.subject, line.result);
    outcome.json["lines"].push_back({{"number", line.number},
                                     {"time_ms", line.time.count()},
                                     {"user", line.user},
                                     {"origin", line.origin},
                                     {"action", line.action},
                                     {"subject", line.subject},
                                     {"result", line.result},
                                     {"hash", line.hash}});
  }
  outcome.text += verified ? "the chain is whole; last hash " + *verified + "\n" : verified.error().Text() + "\n";
  return outcome;
}

/// By the console's rules: the last admin stays.
Status ChangeUser(Store& store, const StoreCommand& command) {
  const SystemClock clock;
  LoginGuard guard(clock);
  Accounts accounts(store, guard, clock);
  const auto user = store.GetUser(command.user);
  if (!user) return Fail(user);
  if (!*user) return Fail("change the user " + command.user, "there is none of this name", "see 'annulus store users'");
  if (command.user_action == "remove") return accounts.Remove(command.user);
  User changed = **user;
  changed.enabled = command.user_action == "enable";
  return accounts.Change(changed);
}

Result<Outcome> ShowUsers(Store& store, const StoreCommand& command) {
  if (command.user_action != "list") {
    const Status changed = ChangeUser(store, command);
    RETURN_IF_ERROR(Note(store, "user " + command.user_action, command.user, changed ? "ok" : changed.error().seen));
    RETURN_IF_ERROR(changed);
  }
  const auto users = store.Users();
  if (!users) return Fail(users);
  Outcome outcome;
  outcome.json = {{"users", Json::array()}};
  for (const User& user : *users) {
    outcome.text +=
        fmt::format("{:20}  {:10}  {}  last login {}\n", user.name, StationRoleName(user.role),
                    user.enabled ? "enabled " : "disabled", user.last_login ? DayText(*user.last_login) : "never");
    outcome.json["users"].push_back({{"name", user.name},
                                     {"role", StationRoleName(user.role)},
                                     {"enabled", user.enabled},
                                     {"has_pin", user.has_pin},
                                     {"has_totp", user.has_totp}});
  }
  if (outcome.text.empty()) outcome.text = "no users\n";
  return outcome;
}

Status Show(const Outcome& outcome, const StoreCommand& command, CommandIo& io) {
  RETURN_IF_ERROR(command.json.empty() ? io.Print(outcome.text) : io.WriteJson(command.json, outcome.json));
  if (!outcome.failed) return {};
  return Fail("look after the store " + command.folder, "something is not as it should be", "see what was printed");
}

using Action = Result<Outcome> (*)(Store&, const StoreCommand&);

Status RunOnStore(Action action, const StoreCommand& command, CommandIo& io) {
  const SystemClock clock;
  const auto store = OpenStore(command, io, clock);
  if (!store) return Fail(store);
  const auto outcome = action(**store, command);
  if (!outcome) return Fail(outcome);
  return Show(*outcome, command, io);
}

Status Restore(const StoreCommand& command, CommandIo& io) {
  const SystemClock clock;
  const std::string backup = WithoutSlash(command.backup);
  const std::string keys = command.keys.empty() ? backup + "-keys" : command.keys;
  const auto left_out = RestoreStore(OptionsOf(command), backup, keys, io.storage(), clock);
  if (!left_out) return Fail(left_out);
  auto store = Store::Open(OptionsOf(command), io.storage(), clock);
  if (!store) return Fail(store);
  RETURN_IF_ERROR(Note(**store, "restore", "", "ok"));
  Outcome outcome;
  outcome.text = "restored into " + command.folder + "\n";
  for (const std::string& id : *left_out) outcome.text += id + " is left out: its key is not in " + keys + "\n";
  outcome.json = {{"store", command.folder}, {"left_out", *left_out}};
  return Show(outcome, command, io);
}

CLI::App* AddAction(CLI::App& parent, const char* name, const char* purpose, StoreCommand& options) {
  CLI::App* action = parent.add_subcommand(name, purpose);
  action->add_option("--store", options.folder, "folder of the store")->required()->type_name("DIR");
  action->add_option("--key-file", options.key_file, "the station's key file (DIR/station.key)")->type_name("FILE");
  AddJsonOption(*action, options.json);
  return action;
}

}  // namespace

void AddStoreCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<StoreCommand>();
  CLI::App* command = app.add_subcommand("store", "customers, scans and their files");
  command->require_subcommand(1);
  const auto add = [&chosen, options, command](const char* name, const char* purpose, Action action) {
    CLI::App* added = AddAction(*command, name, purpose, *options);
    added->callback([&chosen, options, action] {
      chosen = [options, action](CommandIo& io) { return RunOnStore(action, *options, io); };
    });
    return added;
  };
  CLI::App* list = add("list", "customers by their ids, newest first", List);
  list->add_option("--search", options->search, "part of a name, contact or id")->type_name("TEXT");
  list->add_option("--limit", options->limit, "at most so many")->type_name("N");
  list->add_flag("--names", options->names, "show names too");
  add("verify", "open every row and file, and the audit's chain", Verify);
  add("backup", "write a backup, and its keys beside it", MakeBackup)
      ->add_option("--out", options->out, "folder for it (the store's own)")
      ->type_name("DIR");
  CLI::App* erase = add("erase", "erase a customer, with proof", Erase);
  erase->add_option("customer", options->customer, "K-000042")->required();
  erase->add_flag("--yes", options->yes, "it is meant");
  add("expire", "customers whose time is over", Expire)->add_flag("--yes", options->yes, "erase them");
  CLI::App* audit = add("audit", "lines of the audit, and whether its chain is whole", ShowAudit);
  audit->add_option("--from", options->from, "number of the first line (the newest)")->type_name("N");
  audit->add_option("--limit", options->limit, "at most so many")->type_name("N");
  CLI::App* users = add("users", "who may log in", ShowUsers);
  users->add_option("action", options->user_action, "what to do")
      ->check(CLI::IsMember({"list", "disable", "enable", "remove"}).description(""))
      ->type_name("list|disable|enable|remove");
  users->add_option("user", options->user, "whom");
  CLI::App* restore = AddAction(*command, "restore", "make a store of a backup and its keys", *options);
  restore->add_option("backup", options->backup, "folder of the backup")->required();
  restore->get_option("--key-file")->required()->description("the station's key file, or its copy");
  restore->add_option("--keys", options->keys, "its keys (BACKUP-keys)")->type_name("FILE");
  restore->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Restore(*options, io); }; });
  command->footer("Example: annulus store verify --store /var/lib/annulus/store");
}

}  // namespace annulus
