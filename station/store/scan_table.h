#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/sealed_file.h"
#include "base/result.h"
#include "station/store/store_parts.h"

namespace annulus {

/// Scans and their recordings: sealed files (acquisition/sealed_file.h) under the customer's key. Thread-bound.
class ScanTable {
 public:
  explicit ScanTable(StoreParts& parts) : parts_(parts) {}

  /// A scan that was added; the file is to be kept once the row is on the disk (null: nothing was recorded, or the
  /// same recording of this customer is there already: `row` is then the row of it).
  struct Added {
    ScanRow row;
    std::unique_ptr<StagedFile> file;
  };
  /// Reads and seals `file` ("": nothing was recorded); the consent has been checked.
  Result<Added> Add(ScanRow scan, const std::string& file, const KeySource* keys);
  Status Judge(const std::string& id, const std::string& verdict, const std::string& summary_json);
  Result<ScanRow> Get(const std::string& id);
  /// A customer's, oldest first.
  Result<std::vector<ScanRow>> Of(const std::string& customer_id);
  /// Of all, newest first. One that cannot be opened comes without its summary.
  Result<std::vector<ScanRow>> Latest(std::size_t limit);
  Result<std::vector<std::byte>> ReadRecording(const std::string& id);

 private:
  Result<ScanRow> Opened(ScanRow row, const std::vector<std::byte>& sealed);
  Result<std::string> Take(StagedFile& staged, const std::vector<std::byte>& bytes, const std::string& file,
                           const KeySource* keys, const std::string& customer_id);

  StoreParts& parts_;
};

}  // namespace annulus
