#include "station/console/static_files.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

namespace annulus {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 2000;
constexpr std::uintmax_t kMaxBytes = std::uintmax_t{64} << 20;

/// Types that vite's build has. What is of no other type is not served.
constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kTypes{
    {{".html", "text/html; charset=utf-8"},
     {".js", "text/javascript; charset=utf-8"},
     {".mjs", "text/javascript; charset=utf-8"},
     {".css", "text/css; charset=utf-8"},
     {".json", "application/json"},
     {".webmanifest", "application/manifest+json"},
     {".svg", "image/svg+xml"},
     {".png", "image/png"},
     {".jpg", "image/jpeg"},
     {".webp", "image/webp"},
     {".ico", "image/x-icon"},
     {".woff2", "font/woff2"},
     {".wasm", "application/wasm"},
     {".mp3", "audio/mpeg"},
     {".ogg", "audio/ogg"},
     {".wav", "audio/wav"},
     {".txt", "text/plain; charset=utf-8"}}};

constexpr const char* kNoPage = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>annulus</title></head><body>
<h1>The console runs; its page is not built</h1>
<p>Build it and put it beside the program, or say where it is with <code>annulus serve --web FOLDER</code>:</p>
<pre>cd station/web
npm ci
npm run build -- --outDir ../../build/release/web</pre>
<p>Then start <code>annulus serve</code> again. What the console can be asked is in docs/console_api.md.</p>
</body></html>
)";

std::string_view TypeOf(const std::string& name) {
  const std::string extension = fs::path(name).extension().string();
  const auto found = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& t) { return t.first == extension; });
  return found == kTypes.end() ? std::string_view() : found->second;
}

/// Names that vite gives to what lies in assets/ end in a hash of the content: "index-B3xK9q_w.js".
bool IsHashedName(const std::string& path) {
  constexpr std::size_t kHashLength = 8;
  if (!path.starts_with("/assets/")) return false;
  const std::string stem = fs::path(path).stem().string();
  if (stem.size() <= kHashLength || stem[stem.size() - kHashLength - 1] != '-') return false;
  return std::all_of(stem.end() - static_cast<std::ptrdiff_t>(kHashLength), stem.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
}

std::string Etag(const std::string& bytes) {
  std::array<unsigned char, 16> hash{};
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                     nullptr, 0);
  std::array<char, 2 * hash.size() + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), hash.data(), hash.size());
  return '"' + std::string(hex.data()) + '"';
}

/// Whether Accept-Encoding names gzip without a weight of 0 (RFC 9110 §12.5.3, as browsers write it).
bool TakesGzip(const HttpRequest& request) {
  const auto accepted = request.Header("accept-encoding");
  if (!accepted) return false;
  const std::size_t at = accepted->find("gzip");
  if (at == std::string_view::npos) return false;
  std::string_view rest = accepted->substr(at + 4);
  rest = rest.substr(0, std::min(rest.find(','), rest.size()));
  return rest.find("q=0") == std::string_view::npos || rest.find("q=0.") != std::string_view::npos;
}

Error UnreadableFolder(const std::string& folder, const std::string& seen) {
  return {"read the page in " + folder, seen, "give the folder that 'npm run build' wrote with --web"};
}

/// All files below the folder by their path on the server, also those that end in .gz.
Result<std::map<std::string, std::string>> ReadFolder(const std::string& folder) {
  std::map<std::string, std::string> files;
  std::error_code error;
  std::uintmax_t total = 0;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code unknown;
    if (entry->is_symlink(unknown) || !entry->is_regular_file(unknown)) continue;
    std::ifstream file(entry->path(), std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file) return tl::unexpected(UnreadableFolder(folder, "cannot read " + entry->path().string()));
    total += bytes.size();
    if (files.size() >= kMaxFiles || total > kMaxBytes) {
      return tl::unexpected(UnreadableFolder(folder, "it holds more than a page has"));
    }
    files["/" + entry->path().lexically_relative(folder).generic_string()] = std::move(bytes);
  }
  if (error) return tl::unexpected(UnreadableFolder(folder, error.message()));
  return files;
}

HttpResponse PlainAnswer(int status, const std::string& text) {
  HttpResponse response;
  response.status = status;
  response.content_type = "text/plain; charset=utf-8";
  response.headers.emplace_back("Cache-Control", "no-store");
  response.body = text;
  return response;
}

}  // namespace

Result<StaticFiles> StaticFiles::Read(const std::string& folder) {
  std::map<std::string, std::string> found;
  std::error_code unknown;
  if (!folder.empty() && fs::exists(folder, unknown)) {
    auto read = ReadFolder(folder);
    if (!read) return Fail(read);
    found = std::move(*read);
  }
  StaticFiles all;
  all.has_page_ = found.contains("/index.html");
  if (!all.has_page_) found = {{"/index.html", kNoPage}};
  for (auto& [path, bytes] : found) {
    const std::string_view type = TypeOf(path);
    if (type.empty()) continue;
    File file;
    file.content_type = std::string(type);
    file.etag = Etag(bytes);
    file.immutable = IsHashedName(path);
    if (const auto packed = found.find(path + ".gz"); packed != found.end()) file.gzip = packed->second;
    file.bytes = bytes;
    all.files_[path] = std::move(file);
  }
  return all;
}

HttpResponse StaticFiles::Answer(const HttpRequest& request) const {
  const auto found = files_.find(request.path == "/" ? "/index.html" : request.path);
  if (found == files_.end()) return PlainAnswer(404, "there is no such file\n");
  const File& file = found->second;
  HttpResponse response;
  response.content_type = file.content_type;
  response.headers.emplace_back("Cache-Control", file.immutable ? "public, max-age=31536000, immutable" : "no-cache");
  response.headers.emplace_back("ETag", file.etag);
  if (!file.gzip.empty()) response.headers.emplace_back("Vary", "Accept-Encoding");
  const auto known = request.Header("if-none-match");
  if (known && known->find(file.etag) != std::string_view::npos) {
    response.status = 304;
    return response;
  }
  const bool packed = !file.gzip.empty() && TakesGzip(request);
  if (packed) response.headers.emplace_back("Content-Encoding", "gzip");
  response.body = packed ? file.gzip : file.bytes;
  return response;
}

std::string DefaultWebFolder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? std::string() : (program.parent_path() / "web").string();
}

}  // namespace annulus
