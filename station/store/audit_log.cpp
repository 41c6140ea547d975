#include "station/store/audit_log.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <sstream>
#include <utility>

#include "base/sha256.h"
#include "station/store/sealed_text.h"

namespace annulus {
namespace {

constexpr std::size_t kMaxText = 1000;
constexpr std::size_t kHashDigits = 64;

std::string FirstHash() { return std::string(kHashDigits, '0'); }
std::string HeadContext() { return SealContext({"audit head"}); }

/// At most kMaxText bytes, not ending within a character.
void Cut(std::string& text) {
  if (text.size() <= kMaxText) return;
  std::size_t end = kMaxText;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  text.resize(end);
}

AuditLine LineFrom(const SqlRow& row) {
  AuditLine line;
  line.number = static_cast<std::uint64_t>(row.Number(0));
  line.time = StoreTime(row.Number(1));
  line.monotonic_ns = row.Number(2);
  line.user = row.Text(3);
  line.origin = row.Text(4);
  line.action = row.Text(5);
  line.subject = row.Text(6);
  line.result = row.Text(7);
  line.hash = row.Text(8);
  return line;
}

constexpr std::string_view kColumns =
    "SELECT number, time_ms, monotonic_ns, user, origin, action, subject, result, hash FROM audit ";

tl::unexpected<Error> BadLine(std::uint64_t number, const std::string& seen) {
  return Fail("verify the audit", "line " + std::to_string(number) + " " + seen,
              "somebody has changed the database; keep it as it is, and compare with the anchors that were printed");
}

/// "2026-11-29", UTC.
std::string DayOf(StoreTime time) {
  const auto seconds = static_cast<std::time_t>(std::chrono::floor<std::chrono::seconds>(time).count());
  std::tm day{};
  gmtime_r(&seconds, &day);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d", &day)};
}

}  // namespace

std::string AuditHash(const std::string& before, const AuditLine& line) {
  std::string text = before;
  for (const std::string& field :
       {std::to_string(line.number), std::to_string(line.time.count()), std::to_string(line.monotonic_ns), line.user,
        line.origin, line.action, line.subject, line.result}) {
    text += std::to_string(field.size()) + ":" + field;
  }
  return Sha256Hex(BytesOf(text));
}

Result<AuditLog::Head> AuditLog::LastLine() {
  Head head{0, FirstHash()};
  const Status status =
      database_.ForEach("SELECT number, hash FROM audit ORDER BY number DESC LIMIT 1", {}, [&](const SqlRow& row) {
        head = {static_cast<std::uint64_t>(row.Number(0)), row.Text(1)};
        return Status();
      });
  if (!status) return Fail(status);
  return head;
}

Status AuditLog::Append(AuditLine line) {
  const auto last = LastLine();
  if (!last) return Fail(last);
  for (std::string* text : {&line.user, &line.origin, &line.action, &line.subject, &line.result}) Cut(*text);
  line.number = last->number + 1;
  line.hash = AuditHash(last->hash, line);
  RETURN_IF_ERROR(database_.Run("INSERT INTO audit VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
                                {static_cast<std::int64_t>(line.number), line.time.count(), line.monotonic_ns,
                                 line.user, line.origin, line.action, line.subject, line.result, line.hash}));
  const auto head = vault_.SealForStation(std::to_string(line.number) + " " + line.hash, HeadContext());
  if (!head) return Fail(head);
  return database_.Run("INSERT OR REPLACE INTO audit_head VALUES (1, ?1)", {*head});
}

Result<bool> AuditLog::KeepAnchor() {
  std::vector<AuditLine> last;
  RETURN_IF_ERROR(database_.ForEach(std::string(kColumns) + "ORDER BY number DESC LIMIT 1", {}, [&](const SqlRow& row) {
    last.push_back(LineFrom(row));
    return Status();
  }));
  if (last.empty()) return false;
  const std::string day = DayOf(last.front().time);
  if (day == anchored_day_) return false;
  std::string anchors;
  if (storage_.Exists(anchors_path_)) {
    auto text = ReadTextFile(storage_, anchors_path_);
    if (!text) return Fail(text);
    anchors = std::move(*text);
  }
  const bool missing = ("\n" + anchors).find("\n" + day + " ") == std::string::npos;
  if (missing) {
    const std::uint64_t number = last.front().number - 1;
    const auto before = Lines(std::max<std::uint64_t>(number, 1), 1);
    if (!before) return Fail(before);
    const std::string hash = number == 0 || before->empty() ? FirstHash() : before->front().hash;
    anchors += day + " " + std::to_string(number) + " " + hash + "\n";
    RETURN_IF_ERROR(WriteFileAtomically(storage_, anchors_path_, anchors));
  }
  anchored_day_ = day;
  return missing;
}

Result<std::vector<AuditLine>> AuditLog::Lines(std::uint64_t from_number, std::size_t limit) {
  std::vector<AuditLine> lines;
  const auto keep = [&lines](const SqlRow& row) {
    lines.push_back(LineFrom(row));
    return Status();
  };
  const auto most = static_cast<std::int64_t>(limit);
  const Status status = from_number == 0
                            ? database_.ForEach(std::string(kColumns) + "ORDER BY number DESC LIMIT ?1", {most}, keep)
                            : database_.ForEach(std::string(kColumns) + "WHERE number >= ?1 ORDER BY number LIMIT ?2",
                                                {static_cast<std::int64_t>(from_number), most}, keep);
  if (!status) return Fail(status);
  if (from_number == 0) std::reverse(lines.begin(), lines.end());
  return lines;
}

Result<std::string> AuditLog::Verify() {
  Head last{0, FirstHash()};
  const Status status = database_.ForEach(std::string(kColumns) + "ORDER BY number", {}, [&](const SqlRow& row) {
    const AuditLine line = LineFrom(row);
    if (line.number != last.number + 1) return Status(BadLine(last.number + 1, "is missing"));
    if (line.hash != AuditHash(last.hash, line)) return Status(BadLine(line.number, "was changed"));
    last = {line.number, line.hash};
    return Status();
  });
  if (!status) return Fail(status);
  RETURN_IF_ERROR(VerifyHead(last));
  RETURN_IF_ERROR(VerifyAnchors());
  return last.hash;
}

Status AuditLog::VerifyHead(const Head& last) {
  std::vector<std::byte> sealed;
  RETURN_IF_ERROR(database_.ForEach("SELECT sealed FROM audit_head", {}, [&](const SqlRow& row) {
    sealed = row.Bytes(0);
    return Status();
  }));
  if (sealed.empty() && last.number == 0) return {};
  const auto head = vault_.OpenForStation(sealed, HeadContext(), "the head of the audit");
  if (!head) return BadLine(last.number + 1, "cannot be told to be missing or not: the sealed head is damaged");
  if (*head == std::to_string(last.number) + " " + last.hash) return {};
  const std::uint64_t sealed_number = std::strtoull(head->c_str(), nullptr, 10);
  if (sealed_number > last.number) return BadLine(last.number + 1, "is missing, it was cut off at the end");
  return BadLine(std::max<std::uint64_t>(sealed_number, 1), "and those before it were written anew");
}

Status AuditLog::VerifyAnchors() {
  if (!storage_.Exists(anchors_path_)) return {};
  const auto text = ReadTextFile(storage_, anchors_path_);
  if (!text) return Fail(text);
  std::istringstream anchors(*text);
  std::string day;
  std::uint64_t number = 0;
  std::string hash;
  while (anchors >> day >> number >> hash) {
    if (number == 0) continue;
    const auto line = Lines(number, 1);
    if (!line) return Fail(line);
    if (line->empty() || line->front().number != number || line->front().hash != hash) {
      return BadLine(number, "is not the one of the anchor of " + day);
    }
  }
  return {};
}

}  // namespace annulus
