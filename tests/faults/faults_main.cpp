// The fault matrix as a program: runs its tests, then prints one line per row. `--matrix FILE`, or ANNULUS_FAULT_MATRIX
// in the environment, writes it as JSON, too.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace {

/// Rows that other programs show, where they need other means: a disk that keeps a journal of its calls, raw bytes.
constexpr std::pair<const char*, const char*> kElsewhere[] = {
    {"D6", "unit_crash Damaged.D6_CutAtAnyByteGivesBackExactlyWhatIsWhole"},
    {"D7", "unit_crash Damaged.D7_AnyFlippedBitCostsAtMostOneLevelAndChangesNone"},
    {"D11", "unit_crash PowerCut.D11_KeepsEverySyncedLevelAndReturnsNoFalseOne"},
    {"H7", "unit_crash Damaged.H7_TheRecordingThatWasInterruptedOutlivesTheNextOne"},
    {"R1", "unit_acquisition ReplayOnBuses.GivesTheSameLevelsToTheLastBit (a replay has no axis)"},
    {"R2", "unit_acquisition Replay.RefusesANewerFormat, Replay.PassesOverRecordsOfUnknownKind"},
};

struct Row {
  int passed = 0;
  int failed = 0;
  int skipped = 0;
  int safe_ms = -1;  ///< The longest; negative: nothing moved.
  std::string note;
};

/// E2 before E10.
struct ByNumber {
  bool operator()(const std::string& a, const std::string& b) const {
    const auto key = [](const std::string& id) { return std::pair(id.substr(0, 1), std::atoi(id.c_str() + 1)); };
    return key(a) < key(b);
  }
};

/// Keeps what became of the rows: the tests of suite FaultMatrix whose names begin with "<row>_".
class Matrix final : public testing::EmptyTestEventListener {
 public:
  void OnTestEnd(const testing::TestInfo& info) override {
    const std::string name = info.name();
    const std::size_t end = name.find('_');
    if (std::string(info.test_suite_name()).find("FaultMatrix") == std::string::npos || end == std::string::npos)
      return;
    Row& row = rows_[name.substr(0, end)];
    const testing::TestResult& result = *info.result();
    ++(result.Skipped() ? row.skipped : result.Passed() ? row.passed : row.failed);
    for (int i = 0; i < result.test_property_count(); ++i) {
      const testing::TestProperty& property = result.GetTestProperty(i);
      if (std::string(property.key()) == "safe_ms") row.safe_ms = std::max(row.safe_ms, std::atoi(property.value()));
      if (std::string(property.key()) == "note")
        row.note += (row.note.empty() ? "" : "; ") + std::string(property.value());
    }
  }
  void Print() const {
    std::printf("\nrow   passed  failed  time to safe  note\n");
    for (const auto& [id, row] : rows_) {
      const std::string safe = row.safe_ms < 0 ? "-" : std::to_string(row.safe_ms) + " ms";
      std::printf("%-5s %6d  %6d  %12s  %s\n", id.c_str(), row.passed, row.failed, safe.c_str(), row.note.c_str());
    }
    for (const auto& [id, test] : kElsewhere) {
      if (!rows_.contains(id)) std::printf("%-5s %6s  %6s  %12s  %s\n", id, "", "", "", test);
    }
  }
  void Write(const std::string& path) const {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const auto& [id, row] : rows_) {
      nlohmann::ordered_json one{{"row", id}, {"passed", row.passed}, {"failed", row.failed}, {"skipped", row.skipped}};
      if (row.safe_ms >= 0) one["time_to_safe_ms"] = row.safe_ms;
      one["note"] = row.note;
      rows.push_back(std::move(one));
    }
    for (const auto& [id, test] : kElsewhere) {
      if (!rows_.contains(id)) rows.push_back({{"row", id}, {"shown_by", test}});
    }
    std::ofstream(path) << rows.dump(2) << "\n";
  }

 private:
  std::map<std::string, Row, ByNumber> rows_;
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  std::string path;
  if (const char* from_environment = std::getenv("ANNULUS_FAULT_MATRIX")) path = from_environment;
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::string(argv[i]) == "--matrix") path = argv[i + 1];
  }
  auto* matrix = new Matrix;  // the listeners own it
  testing::UnitTest::GetInstance()->listeners().Append(matrix);
  const int outcome = RUN_ALL_TESTS();
  matrix->Print();
  if (!path.empty()) matrix->Write(path);
  return outcome;
}
