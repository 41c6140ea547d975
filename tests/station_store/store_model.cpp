#include "tests/station_store/store_model.h"

#include <iterator>
#include <sstream>
#include <vector>

namespace annulus::test {
namespace {

std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, '|');) fields.push_back(field);
  return fields;
}

template <class T>
std::string Differs(const std::string& what, const T& stored, const T& expected) {
  if (stored == expected) return {};
  std::ostringstream text;
  text << what << ": '" << stored << "' in the store, '" << expected << "' expected";
  return text.str();
}

}  // namespace

void StoreModel::Erase(const std::string& customer) {
  people.erase(customer);
  std::erase_if(things, [&](const auto& entry) {
    const auto scan = scans.find(entry.second.scan);
    return scan != scans.end() && scan->second.customer == customer;
  });
  std::erase_if(scans, [&](const auto& entry) { return entry.second.customer == customer; });
}

std::string StoreExercise::Text(const char* what) { return what + std::to_string(dice_.Next()); }

template <class Map>
std::optional<std::string> StoreExercise::AnyOf(const Map& map) {
  if (map.empty()) return std::nullopt;
  return std::next(map.begin(), static_cast<std::ptrdiff_t>(dice_.Below(map.size())))->first;
}

void StoreExercise::Done(std::initializer_list<std::string> fields) {
  done_.clear();
  for (const std::string& field : fields) done_ += (done_.empty() ? "" : "|") + field;
  Follow(done_);
}

void StoreExercise::Follow(const std::string& done) {
  const std::vector<std::string> f = Fields(done);
  const std::string& what = f.at(0);
  if (what == "person") model_.people[f.at(1)] = {f.at(2), f.at(3), false};
  if (what == "scan") model_.scans[f.at(1)] = {f.at(2), f.at(3), ""};
  if (what == "thing") model_.things[f.at(1)] = {f.at(2), f.at(3), f.at(4), f.at(5) == "derived"};
  if (what == "remove") model_.things.erase(f.at(1));
  if (what == "drop") {
    std::erase_if(model_.things,
                  [&](const auto& thing) { return thing.second.derived && thing.second.scan == f.at(1); });
  }
  if (what == "rename") model_.people[f.at(1)].name = f.at(2);
  if (what == "withdraw") model_.people[f.at(1)].withdrawn = true;
  if (what == "judge") model_.scans[f.at(1)].verdict = f.at(2);
  if (what == "erase") model_.Erase(f.at(1));
  if (what == "audit") ++model_.audit_lines;
}

bool StoreExercise::Step(Store& store) {
  done_.clear();
  switch (dice_.Below(12)) {
    case 0:
    case 1:
      return AddPerson(store);
    case 2:
    case 3:
    case 4:
      return AddScan(store);
    case 5:
    case 6:
    case 7:
      return PutThing(store);
    case 8:
      return DropOrRemove(store);
    case 9:
      return ChangePerson(store);
    case 10:
      return dice_.Below(3) == 0 ? Erase(store) : AddPerson(store);
    default: {
      AuditLine line;
      line.action = "step";
      if (!store.Audit(line)) return false;
      Done({"audit"});
      return true;
    }
  }
}

bool StoreExercise::AddPerson(Store& store) {
  Customer customer;
  customer.name = Text("name");
  const auto added = store.AddCustomer(customer);
  if (!added) return false;
  Consent consent;
  consent.customer_id = added->id;
  consent.purposes = {"measure"};
  const auto given = store.AddConsent(consent);
  Done({"person", added->id, customer.name, given ? given->id : ""});
  return given.has_value();
}

bool StoreExercise::AddScan(Store& store) {
  const auto person = AnyOf(model_.people);
  if (!person) return true;
  ScanRow scan;
  scan.customer_id = *person;
  scan.consent_id = model_.people[*person].consent;
  const std::string recording = Text("recording") + std::string(dice_.Below(3000), 'r');
  WriteBytes(spool_, recording);
  const auto added = store.AddScan(scan, spool_, nullptr);
  if (!added) return false;
  Done({"scan", added->id, *person, recording});
  return true;
}

bool StoreExercise::PutThing(Store& store) {
  const auto scan = AnyOf(model_.scans);
  if (!scan) return true;
  Artefact artefact;
  artefact.scan_id = *scan;
  artefact.kind = "model";
  artefact.name = "m" + std::to_string(dice_.Below(3));
  artefact.derived = dice_.Below(2) == 0;
  const std::string content = Text("content") + std::string(dice_.Below(3000), 'm');
  const auto put = store.PutArtefact(artefact, BytesFrom(content));
  if (!put) return false;
  Done({"thing", put->id, *scan, artefact.name, content, artefact.derived ? "derived" : "made"});
  return true;
}

bool StoreExercise::DropOrRemove(Store& store) {
  if (dice_.Below(2) == 0) {
    const auto thing = AnyOf(model_.things);
    if (!thing) return true;
    if (!store.RemoveArtefact(*thing)) return false;
    Done({"remove", *thing});
    return true;
  }
  const auto scan = AnyOf(model_.scans);
  if (!scan) return true;
  if (!store.DropDerived(*scan)) return false;
  Done({"drop", *scan});
  return true;
}

bool StoreExercise::ChangePerson(Store& store) {
  const auto person = AnyOf(model_.people);
  if (!person) return true;
  if (dice_.Below(6) == 0) {
    if (!store.WithdrawConsent(model_.people[*person].consent)) return false;
    Done({"withdraw", *person});
    return true;
  }
  if (const auto scan = AnyOf(model_.scans); scan && dice_.Below(2) == 0) {
    if (!store.JudgeScan(*scan, "usable", "{}")) return false;
    Done({"judge", *scan, "usable"});
    return true;
  }
  Customer customer;
  customer.id = *person;
  customer.name = Text("renamed");
  if (!store.ChangeCustomer(customer)) return false;
  Done({"rename", *person, customer.name});
  return true;
}

bool StoreExercise::Erase(Store& store) {
  const auto person = AnyOf(model_.people);
  if (!person) return true;
  const bool erased = store.Erase(*person).has_value();
  Done({"erase", *person});  // also if it was interrupted: there is no way back, the next start finishes it
  return erased;
}

std::string StoreExercise::Difference(Store& store) const {
  for (const auto& [id, person] : model_.people) {
    const auto stored = store.GetCustomer(id);
    if (!stored) return WordsOf(stored);
    if (auto text = Differs(id, stored->name, person.name); !text.empty()) return text;
    const auto found = store.FindCustomers(person.name, 5);
    if (!found || found->size() != 1 || found->front().id != id) return "searching for the name of " + id;
  }
  for (const auto& [id, scan] : model_.scans) {
    const auto stored = store.GetScan(id);
    if (!stored) return WordsOf(stored);
    if (auto text = Differs(id, stored->verdict, scan.verdict); !text.empty()) return text;
    const auto recording = store.ReadRecording(id);
    if (!recording) return WordsOf(recording);
    if (auto text = Differs(id, TextFrom(*recording), scan.recording); !text.empty()) return text;
  }
  for (const auto& [id, thing] : model_.things) {
    const auto stored = store.GetArtefact(id);
    if (!stored) return WordsOf(stored);
    if (auto text = Differs(id, stored->name, thing.name); !text.empty()) return text;
    const auto content = store.ReadArtefact(id);
    if (!content) return WordsOf(content);
    if (auto text = Differs(id, TextFrom(*content), thing.content); !text.empty()) return text;
  }
  const auto audit = store.VerifyAudit();
  if (!audit) return WordsOf(audit);
  const auto lines = store.AuditLines(1, 1'000'000);
  if (!lines || lines->size() < model_.audit_lines) return "lines of the audit are missing";
  return {};
}

}  // namespace annulus::test
