#pragma once

#include <map>
#include <string>

#include "base/result.h"
#include "station/http/http_message.h"

namespace annulus {

/// The page: what vite built, read into memory at start. What a request asks for is looked up in that list and never
/// reaches the disk, so there is no path to climb. Immutable, hence thread-safe.
class StaticFiles {
 public:
  /// Reads the regular files of known types below `folder` (links are not followed; at most 2,000 files and 64 MiB).
  /// A name with ".gz" behind that of another is what is sent to those who take gzip. Without an index.html in it, or
  /// without the folder, the page says how it is built. An Error: the folder is there and cannot be read.
  static Result<StaticFiles> Read(const std::string& folder);

  /// The answer to GET `request`: the file, 304 if the browser has it, 404. "/" is index.html.
  [[nodiscard]] HttpResponse Answer(const HttpRequest& request) const;
  /// Files that are served.
  [[nodiscard]] std::size_t size() const { return files_.size(); }
  /// The page was there; else a plain one stands in for it.
  [[nodiscard]] bool has_page() const { return has_page_; }

 private:
  struct File {
    std::string content_type;
    std::string bytes;
    std::string gzip;  ///< Empty: there is none.
    std::string etag;  ///< Of its content, in quotes.
    bool immutable = false;
  };

  std::map<std::string, File> files_;  ///< By path, "/assets/index-4f2a.js".
  bool has_page_ = false;
};

/// The folder `web` beside the program that runs, where the build installs the page; "" if that cannot be found out.
[[nodiscard]] std::string DefaultWebFolder();

}  // namespace annulus
