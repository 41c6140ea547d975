#include "station/store/content_files.h"

#include <algorithm>
#include <array>

#include "base/ensure.h"
#include "station/store/sealed_text.h"

namespace annulus {
namespace {

constexpr std::size_t kPrefixDigits = 2;
constexpr unsigned kFolders = 256;

std::string PlaceOf(const std::string& folder, const std::string& hash) {
  return folder + "/" + hash.substr(0, kPrefixDigits) + "/" + hash;
}

std::string IncomingFolder(const std::string& folder) { return folder + "/incoming"; }

}  // namespace

bool IsContentHash(std::string_view text) {
  constexpr std::size_t kDigits = 64;
  return text.size() == kDigits && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

StagedFile::StagedFile(Storage& storage, std::string folder, std::string part, std::unique_ptr<AppendFile> file)
    : storage_(storage), folder_(std::move(folder)), path_(std::move(part)), file_(std::move(file)) {}

StagedFile::~StagedFile() {
  file_.reset();
  if (!kept_) static_cast<void>(storage_.Remove(path_));  // else it is an orphan, which the next start removes
}

Status StagedFile::Append(std::span<const std::byte> bytes) {
  RETURN_IF_ERROR(file_->Append(bytes));
  hash_.Update(bytes);
  bytes_ += bytes.size();
  return {};
}

Result<std::string> StagedFile::Place() {
  RETURN_IF_ERROR(file_->Sync());
  std::string hash = hash_.Hex();
  const std::string place = PlaceOf(folder_, hash);
  RETURN_IF_ERROR(storage_.CreateFolder(folder_ + "/" + hash.substr(0, kPrefixDigits)));
  RETURN_IF_ERROR(storage_.Rename(path_, place));
  path_ = place;
  return hash;
}

Result<std::unique_ptr<StagedFile>> ContentFiles::Stage() {
  RETURN_IF_ERROR(storage_.CreateFolder(IncomingFolder(folder_)));
  const SealKey name = RandomSealKey();  // only for its digits: no two files share a name
  const std::string part =
      IncomingFolder(folder_) + "/" + HexOf(std::as_bytes(std::span(name.bytes)).first(SealKey::kBytes / 2));
  auto file = storage_.Create(part);
  if (!file) return Fail(file);
  return std::make_unique<StagedFile>(storage_, folder_, part, std::move(*file));
}

std::string ContentFiles::PathOf(const std::string& hash) const {
  ENSURE(IsContentHash(hash), "content files are named by hashes");
  return PlaceOf(folder_, hash);
}

bool ContentFiles::Has(const std::string& hash) const { return IsContentHash(hash) && storage_.Exists(PathOf(hash)); }

Result<std::vector<std::byte>> ContentFiles::Read(const std::string& hash) {
  const std::string attempted = "read the store's file " + hash;
  if (!Has(hash)) return Fail(attempted, "it is not there", "restore the last backup");
  auto bytes = storage_.ReadAll(PathOf(hash), kMaxInputBytes);
  if (bytes && Sha256Hex(*bytes) != hash) return Fail(attempted, "it is damaged", "restore the last backup");
  return bytes;
}

Status ContentFiles::Remove(const std::string& hash) {
  if (!Has(hash)) return {};
  RETURN_IF_ERROR(storage_.Remove(PathOf(hash)));
  return storage_.SyncFolder(PathOf(hash));
}

Result<std::vector<std::string>> ContentFiles::All() {
  std::vector<std::string> all;
  for (unsigned i = 0; i < kFolders; ++i) {
    const std::array<std::byte, 1> first{static_cast<std::byte>(i)};
    const std::string folder = folder_ + "/" + HexOf(first);
    if (!storage_.Exists(folder)) continue;
    const auto names = storage_.List(folder);
    if (!names) return Fail(names);
    std::copy_if(names->begin(), names->end(), std::back_inserter(all), IsContentHash);
  }
  return all;
}

Status ContentFiles::RemoveAbandoned() {
  const std::string incoming = IncomingFolder(folder_);
  if (!storage_.Exists(incoming)) return {};
  const auto names = storage_.List(incoming);
  if (!names) return Fail(names);
  for (const std::string& name : *names) {
    const std::string path = incoming + "/" + name;
    if (!storage_.InUse(path)) RETURN_IF_ERROR(storage_.Remove(path));
  }
  return {};
}

}  // namespace annulus
