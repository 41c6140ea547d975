#pragma once

#include <map>
#include <optional>
#include <string>

#include "tests/station_store/store_folder.h"
#include "tests/support/dice.h"

namespace annulus::test {

/// What a store should hold, in the simplest form: the same operations are done on both.
struct StoreModel {
  struct Person {
    std::string name;
    std::string consent;
    bool withdrawn = false;
  };
  struct Scan {
    std::string customer;
    std::string recording;
    std::string verdict;
  };
  struct Thing {
    std::string scan;
    std::string name;
    std::string content;
    bool derived = true;
  };
  std::map<std::string, Person> people;
  std::map<std::string, Scan> scans;
  std::map<std::string, Thing> things;
  std::uint64_t audit_lines = 0;

  void Erase(const std::string& customer);
};

/// Draws operations and does them on a store and, if the store said that they were done, on the model.
class StoreExercise {
 public:
  StoreExercise(std::uint64_t seed, std::string spool) : dice_(seed), spool_(std::move(spool)) {}

  /// One operation. False if the store refused it, which leaves the model as it is.
  bool Step(Store& store);
  /// Holds all that is in the store against the model: the first difference, or nothing. With `at_least`, the store may
  /// hold what an operation whose answer was lost has brought.
  std::string Difference(Store& store) const;
  [[nodiscard]] const StoreModel& model() const { return model_; }

  /// One line that says what an operation did, for another process to follow: see Follow.
  [[nodiscard]] const std::string& done() const { return done_; }
  /// Brings the model to where a Step of another process has brought its own.
  void Follow(const std::string& done);

 private:
  bool AddPerson(Store& store);
  bool AddScan(Store& store);
  bool PutThing(Store& store);
  bool DropOrRemove(Store& store);
  bool ChangePerson(Store& store);
  bool Erase(Store& store);
  template <class Map>
  std::optional<std::string> AnyOf(const Map& map);
  std::string Text(const char* what);
  void Done(std::initializer_list<std::string> fields);

  Dice dice_;
  std::string spool_;
  StoreModel model_;
  std::string done_;
};

}  // namespace annulus::test
