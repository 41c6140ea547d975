#pragma once

#include <array>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "acquisition/scan_machine.h"
#include "tests/support/folders.h"

namespace annulus::test {

/// The table as it is drawn in acquisition/scan_machine.h: what an event does in a state, as it stands there ("-",
/// "no", "IDLE*"); empty if the drawing lacks it.
class DrawnTable {
 public:
  DrawnTable() {
    std::ifstream file(test::SourceFolder() + "/acquisition/scan_machine.h");
    std::vector<std::string> heads;
    for (std::string line; std::getline(file, line);) {
      if (line.rfind("///     ", 0) != 0 || line.find('|') == std::string::npos) continue;
      std::vector<std::string> words = Cells(line.substr(3));
      if (words.front() == "event") heads.assign(words.begin() + 1, words.end());
      if (words.front() != "event" && words.front().front() != '-') Put(heads, words);
    }
  }

  [[nodiscard]] const std::string& At(ScanState state, ScanEventKind kind) const {
    return cells_.at(static_cast<std::size_t>(kind)).at(static_cast<std::size_t>(state));
  }
  /// Rows that no event has, and columns that no state has.
  [[nodiscard]] const std::vector<std::string>& strangers() const { return strangers_; }

 private:
  static std::vector<std::string> Cells(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, '|');) {
      const auto begin = cell.find_first_not_of(' ');
      const auto end = cell.find_last_not_of(' ');
      cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
    }
    return cells;
  }

  void Put(const std::vector<std::string>& heads, const std::vector<std::string>& words) {
    std::size_t kind = 0;
    while (kind < kScanEventKinds && words.front() != ScanEventText(static_cast<ScanEventKind>(kind))) ++kind;
    if (kind == kScanEventKinds) strangers_.push_back(words.front());
    for (std::size_t column = 0; column < heads.size() && kind < kScanEventKinds; ++column) {
      std::size_t state = 0;
      while (state < kScanStates && heads.at(column) != ScanStateText(static_cast<ScanState>(state))) ++state;
      if (state == kScanStates) strangers_.push_back(heads.at(column));
      if (state < kScanStates && column + 1 < words.size()) cells_.at(kind).at(state) = words.at(column + 1);
    }
  }

  std::array<std::array<std::string, kScanStates>, kScanEventKinds> cells_;
  std::vector<std::string> strangers_;
};

}  // namespace annulus::test
