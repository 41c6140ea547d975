#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/storage.h"
#include "station/store/store.h"

namespace annulus::test {

/// A folder of its own on the disk, removed when it goes.
class DiskFolder {
 public:
  DiskFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "annulus-store-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~DiskFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  DiskFolder(const DiskFolder&) = delete;
  DiskFolder& operator=(const DiskFolder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline std::vector<std::byte> BytesFrom(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

inline std::string TextFrom(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline void WriteBytes(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// All files below a folder.
inline std::vector<std::string> FilesBelow(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  }
  return files;
}

/// The files below a folder that hold `marker`. Only while no store is open there: it would lose its locks.
inline std::vector<std::string> FilesWith(const std::string& folder, const std::string& marker) {
  std::vector<std::string> found;
  for (const std::string& path : FilesBelow(folder)) {
    if (ReadBytes(path).find(marker) != std::string::npos) found.push_back(path);
  }
  return found;
}

/// A store on the disk that can be closed and opened again.
class StoreOnDisk {
 public:
  StoreOnDisk() {
    options.folder = disk.path() + "/store";
    options.station_key_file = disk.path() + "/station.key";
    options.make_key = true;
  }
  /// Closes it, if it is open, and opens it.
  Result<std::unique_ptr<Store>> TryOpen() {
    store_.reset();
    return Store::Open(options, *storage, clock);
  }
  Store& Open() {
    auto opened = TryOpen();
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().Text());
    if (!opened) throw std::runtime_error("the store does not open");
    store_ = std::move(*opened);
    return *store_;
  }
  void Close() { store_.reset(); }
  Store& operator*() { return *store_; }
  Store* operator->() { return store_.get(); }

  /// A customer with a consent.
  std::pair<Customer, Consent> AddPerson(const std::string& name, const std::string& contact = "") {
    Customer customer;
    customer.name = name;
    customer.contact = contact;
    auto added = store_->AddCustomer(customer);
    EXPECT_TRUE(added) << (added ? "" : added.error().Text());
    Consent consent;
    consent.customer_id = added->id;
    consent.purposes = {"measure"};
    consent.text_version = "2026-1";
    consent.language = "ja";
    consent.taken_by = "sato";
    auto given = store_->AddConsent(consent);
    EXPECT_TRUE(given) << (given ? "" : given.error().Text());
    return {*added, *given};
  }
  /// A scan with a recording of these bytes, not sealed.
  Result<ScanRow> AddScan(const Consent& consent, const std::string& recording) {
    const std::string path = disk.path() + "/spool.mcap";
    WriteBytes(path, recording);
    ScanRow scan;
    scan.customer_id = consent.customer_id;
    scan.consent_id = consent.id;
    scan.profile = "body";
    scan.summary_json = R"({"levels":360})";
    return store_->AddScan(scan, path, nullptr);
  }
  Result<Artefact> PutArtefact(const std::string& scan_id, const std::string& kind, const std::string& name,
                               const std::string& content) {
    Artefact artefact;
    artefact.scan_id = scan_id;
    artefact.kind = kind;
    artefact.name = name;
    artefact.recipe = R"(["fit","scan.mcap","--out","model.json"])";
    return store_->PutArtefact(artefact, BytesFrom(content));
  }
  [[nodiscard]] std::string database() const { return options.folder + "/annulus.db"; }
  [[nodiscard]] std::string content(const std::string& hash) const {
    return options.folder + "/files/" + hash.substr(0, 2) + "/" + hash;
  }

  DiskFolder disk;
  StoreOptions options;
  ManualClock clock;
  PosixStorage posix;
  Storage* storage = &posix;

 private:
  std::unique_ptr<Store> store_;
};

/// What a failed result says.
template <class T>
std::string WordsOf(const Result<T>& result) {
  return result ? "" : result.error().Text();
}

}  // namespace annulus::test
