#include "station/store/store_parts.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "station/store/search_text.h"

namespace annulus {

StoreTime StoreParts::Now() const { return std::chrono::floor<StoreTime>(clock.WallNow()); }

Result<RowId> NextRowId(Database& database, char series) {
  const std::string name(1, series);
  RETURN_IF_ERROR(database.Run("INSERT INTO sequences VALUES (?1, 1) ON CONFLICT(name) DO UPDATE SET last = last + 1",
                               {std::string_view(name)}));
  const auto number = database.Number("SELECT last FROM sequences WHERE name = ?1", {std::string_view(name)});
  if (!number) return Fail(number);
  return RowId{number->value_or(0), fmt::format("{}-{:06}", series, number->value_or(0))};
}

Status CheckText(const std::string& what, std::string_view text) {
  if (IsUtf8(text)) return {};
  return Fail("store the " + what, "it is not well-formed UTF-8 text", "enter it again");
}

tl::unexpected<Error> NoSuchRow(const std::string& what, const std::string& id) {
  return Fail("find the " + what + " " + id, "the store does not have it", "check the id; it may have been erased");
}

Status MakePrivateFolder(Storage& storage, const std::string& path) {
  RETURN_IF_ERROR(storage.CreateFolder(path));
  if (::chmod(path.c_str(), S_IRWXU) == 0) return {};
  return Fail("make the folder " + path, std::generic_category().message(errno), "choose a folder of your own");
}

std::string DatabasePath(const std::string& folder) { return folder + "/annulus.db"; }
std::string KeysFolder(const std::string& folder) { return folder + "/keys"; }
std::string FilesFolder(const std::string& folder) { return folder + "/files"; }
std::string BackupsFolder(const std::string& folder) { return folder + "/backups"; }
std::string AnchorsPath(const std::string& folder) { return folder + "/audit-anchors.txt"; }

}  // namespace annulus
