#include "station/http/http_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

/// Reason phrases of RFC 9110 §15 and RFC 6585; clients pass them over.
std::string_view ReasonPhrase(int status) {
  constexpr std::pair<int, std::string_view> kPhrases[] = {{200, "OK"},
                                                           {201, "Created"},
                                                           {202, "Accepted"},
                                                           {204, "No Content"},
                                                           {206, "Partial Content"},
                                                           {301, "Moved Permanently"},
                                                           {302, "Found"},
                                                           {303, "See Other"},
                                                           {304, "Not Modified"},
                                                           {307, "Temporary Redirect"},
                                                           {308, "Permanent Redirect"},
                                                           {400, "Bad Request"},
                                                           {401, "Unauthorized"},
                                                           {403, "Forbidden"},
                                                           {404, "Not Found"},
                                                           {405, "Method Not Allowed"},
                                                           {406, "Not Acceptable"},
                                                           {408, "Request Timeout"},
                                                           {409, "Conflict"},
                                                           {410, "Gone"},
                                                           {411, "Length Required"},
                                                           {412, "Precondition Failed"},
                                                           {413, "Content Too Large"},
                                                           {414, "URI Too Long"},
                                                           {415, "Unsupported Media Type"},
                                                           {416, "Range Not Satisfiable"},
                                                           {417, "Expectation Failed"},
                                                           {421, "Misdirected Request"},
                                                           {422, "Unprocessable Content"},
                                                           {426, "Upgrade Required"},
                                                           {428, "Precondition Required"},
                                                           {429, "Too Many Requests"},
                                                           {431, "Request Header Fields Too Large"},
                                                           {500, "Internal Server Error"},
                                                           {501, "Not Implemented"},
                                                           {503, "Service Unavailable"},
                                                           {505, "HTTP Version Not Supported"}};
  const auto* found =
      std::find_if(std::begin(kPhrases), std::end(kPhrases), [&](const auto& p) { return p.first == status; });
  return found == std::end(kPhrases) ? std::string_view("Status") : found->second;
}

/// IMF-fixdate of RFC 9110 §5.6.7: "Sun, 06 Nov 1994 08:49:37 GMT", in any locale.
std::string DateText(std::chrono::sys_seconds now) {
  constexpr std::array<std::string_view, 7> kDays{"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  constexpr std::array<std::string_view, 12> kMonths{"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                                     "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const auto midnight = std::chrono::floor<std::chrono::days>(now);
  const std::chrono::year_month_day date(midnight);
  const std::chrono::hh_mm_ss time(now - midnight);
  return fmt::format("{}, {:02} {} {:04} {:02}:{:02}:{:02} GMT", kDays[std::chrono::weekday(midnight).c_encoding()],
                     static_cast<unsigned>(date.day()), kMonths[static_cast<unsigned>(date.month()) - 1],
                     static_cast<int>(date.year()), time.hours().count(), time.minutes().count(),
                     time.seconds().count());
}

bool IsSafeValue(std::string_view value) {
  return std::none_of(value.begin(), value.end(),
                      [](char c) { return (c >= 0 && c < 0x20 && c != '\t') || c == 0x7F; });
}

bool IsName(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

bool IsOurs(std::string_view name) {
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  constexpr std::array<std::string_view, 5> kOurs{"content-length", "content-type", "date", "connection",
                                                  "transfer-encoding"};
  return std::find(kOurs.begin(), kOurs.end(), lower) != kOurs.end();
}

std::string_view AdviceFor(int status) {
  switch (status) {
    case 408:
      return "send the whole request without a pause";
    case 413:
      return "send less";
    case 429:
      return "wait as long as Retry-After says";
    case 500:
      return "try again; if it stays so, tell the technician what you did";
    case 503:
      return "try again in a few seconds";
    default:
      return "use a current browser and the console's own page";
  }
}

}  // namespace

std::string AnswerHead(const HttpResponse& response, AfterAnswer after, std::chrono::sys_seconds now) {
  ENSURE(response.status >= 200 && response.status <= 599, "a handler answers with a final status");
  ENSURE(IsSafeValue(response.content_type), "a handler's Content-Type has no line ends");
  std::string head = fmt::format("HTTP/1.1 {} {}\r\n", response.status, ReasonPhrase(response.status));
  for (const auto& [name, value] : response.headers) {
    ENSURE(IsName(name) && IsSafeValue(value), "a handler's header is well-formed");
    ENSURE(!IsOurs(name), "a handler leaves the server's headers alone");
    head += fmt::format("{}: {}\r\n", name, value);
  }
  if (!response.content_type.empty()) head += fmt::format("Content-Type: {}\r\n", response.content_type);
  if (!IsBodiless(response.status)) head += fmt::format("Content-Length: {}\r\n", response.body.size());
  head += fmt::format("Date: {}\r\n", DateText(now));
  head += after == AfterAnswer::kClose ? "Connection: close\r\n\r\n" : "Connection: keep-alive\r\n\r\n";
  return head;
}

bool IsBodiless(int status) { return status == 204 || status == 304; }

HttpResponse ProblemAnswer(const HttpProblem& problem) {
  HttpResponse response;
  response.status = problem.status;
  response.content_type = "application/json; charset=utf-8";
  response.headers = {{"Cache-Control", "no-store"}, {"X-Content-Type-Options", "nosniff"}};
  // The reasons are ours: nothing in them needs escaping.
  response.body = fmt::format(R"({{"error":{{"attempted":"read the request","seen":"{}","advice":"{}"}}}})",
                              problem.reason, AdviceFor(problem.status));
  if (problem.status == 426) response.headers.emplace_back("Sec-WebSocket-Version", "13");
  return response;
}

}  // namespace annulus
