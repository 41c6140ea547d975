#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/store/store_parts.h"

namespace annulus {

/// What comes of scans: names, recipes and contents are sealed with the customer's key. Thread-bound.
class ArtefactTable {
 public:
  explicit ArtefactTable(StoreParts& parts) : parts_(parts) {}

  /// An artefact whose file is to be kept once its row is on the disk.
  struct Put {
    Artefact row;
    std::unique_ptr<StagedFile> file;
  };
  /// Replaces that of the same scan, kind and name, which keeps its id.
  Result<Put> Write(Artefact artefact, std::span<const std::byte> bytes);
  Result<std::vector<std::byte>> Read(const std::string& id);
  Result<Artefact> Get(const std::string& id);
  /// A scan's, oldest first.
  Result<std::vector<Artefact>> Of(const std::string& scan_id);
  Status Remove(const std::string& id);
  /// Removes the derived ones of a scan, or of all ("").
  Status DropDerived(const std::string& scan_id);

 private:
  struct Row {
    Artefact artefact;
    std::string file;
    std::vector<std::byte> sealed;
  };
  static Row RowFrom(const class SqlRow& row);
  Result<Row> Find(const std::string& id);
  Result<Artefact> Opened(Row row);

  StoreParts& parts_;
};

}  // namespace annulus
