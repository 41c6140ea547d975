#include "station/http/http_message.h"

#include <algorithm>

namespace annulus {
namespace {

std::optional<std::string_view> FirstOf(const std::vector<HttpField>& fields, std::string_view name) {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const HttpField& f) { return f.first == name; });
  if (found == fields.end()) return std::nullopt;
  return found->second;
}

std::string_view Trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

}  // namespace

std::optional<std::string_view> HttpRequest::Header(std::string_view name) const { return FirstOf(headers, name); }

std::size_t HttpRequest::HeaderCount(std::string_view name) const {
  const auto count = std::count_if(headers.begin(), headers.end(), [&](const HttpField& f) { return f.first == name; });
  return static_cast<std::size_t>(count);
}

std::optional<std::string_view> HttpRequest::Query(std::string_view name) const { return FirstOf(query, name); }

std::optional<std::string_view> HttpRequest::Cookie(std::string_view name) const {
  std::optional<std::string_view> value;
  for (const HttpField& header : headers) {
    if (header.first != "cookie") continue;
    std::string_view rest = header.second;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(';'), rest.size());
      const std::string_view pair = Trim(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
      const std::size_t equals = pair.find('=');
      if (equals == std::string_view::npos || pair.substr(0, equals) != name) continue;
      // Twice: a page of a neighbouring name may have planted one; which is ours cannot be told.
      if (value) return std::nullopt;
      value = pair.substr(equals + 1);
    }
  }
  return value;
}

}  // namespace annulus
