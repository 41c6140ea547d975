#include "station/console/static_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/station_console/console_desk.h"

namespace annulus {
namespace {

namespace fs = std::filesystem;
using test::HeaderOf;

class StaticFilesTest : public testing::Test {
 protected:
  StaticFilesTest() {
    std::string name = (fs::temp_directory_path() / "annulus_files_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    fs::create_directory(folder_ / "web");
    fs::create_directory(folder_ / "web/assets");
  }
  ~StaticFilesTest() override { fs::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  [[nodiscard]] StaticFiles Read() const { return *StaticFiles::Read((folder_ / "web").string()); }
  static HttpRequest Get(const std::string& path) {
    HttpRequest request;
    request.method = "GET";
    request.path = path;
    return request;
  }

  fs::path folder_;
};

TEST_F(StaticFilesTest, ServesWhatWasBuiltWithItsType) {
  Write("web/index.html", "<!doctype html>page");
  Write("web/assets/index-B3xK9q_w.js", "let a;");
  Write("web/assets/look-abcdefgh.css", "a{}");
  const StaticFiles files = Read();
  EXPECT_TRUE(files.has_page());
  EXPECT_EQ(files.Answer(Get("/")).body, "<!doctype html>page");
  EXPECT_EQ(files.Answer(Get("/")).content_type, "text/html; charset=utf-8");
  EXPECT_EQ(files.Answer(Get("/assets/index-B3xK9q_w.js")).content_type, "text/javascript; charset=utf-8");
  EXPECT_EQ(files.Answer(Get("/assets/look-abcdefgh.css")).content_type, "text/css; charset=utf-8");
}

TEST_F(StaticFilesTest, OnlyHashedNamesMayBeKeptForEver) {
  Write("web/index.html", "page");
  Write("web/assets/index-B3xK9q_w.js", "let a;");
  Write("web/assets/plain.js", "let b;");
  const StaticFiles files = Read();
  EXPECT_EQ(HeaderOf(files.Answer(Get("/")), "Cache-Control"), "no-cache");
  EXPECT_EQ(HeaderOf(files.Answer(Get("/assets/plain.js")), "Cache-Control"), "no-cache");
  EXPECT_EQ(HeaderOf(files.Answer(Get("/assets/index-B3xK9q_w.js")), "Cache-Control"),
            "public, max-age=31536000, immutable");
}

TEST_F(StaticFilesTest, WhatTheBrowserHasIsNotSentAgain) {
  Write("web/index.html", "page");
  const StaticFiles files = Read();
  HttpRequest again = Get("/");
  again.headers = {{"if-none-match", HeaderOf(files.Answer(Get("/")), "ETag")}};
  EXPECT_EQ(files.Answer(again).status, 304);
  EXPECT_EQ(files.Answer(again).body, "");
}

TEST_F(StaticFilesTest, SendsThePackedFileToWhoTakesGzip) {
  Write("web/index.html", "page");
  Write("web/assets/a-12345678.js", "plain");
  Write("web/assets/a-12345678.js.gz", "packed");
  const StaticFiles files = Read();
  HttpRequest request = Get("/assets/a-12345678.js");
  EXPECT_EQ(files.Answer(request).body, "plain");
  request.headers = {{"accept-encoding", "br, gzip, deflate"}};
  EXPECT_EQ(files.Answer(request).body, "packed");
  EXPECT_EQ(HeaderOf(files.Answer(request), "Content-Encoding"), "gzip");
  EXPECT_EQ(files.Answer(request).content_type, "text/javascript; charset=utf-8");
  request.headers = {{"accept-encoding", "gzip;q=0"}};
  EXPECT_EQ(files.Answer(request).body, "plain");
}

TEST_F(StaticFilesTest, NoPathLeadsOutOfTheList) {
  Write("secret.txt", "secret");
  Write("web/index.html", "page");
  fs::create_symlink(folder_ / "secret.txt", folder_ / "web/link.txt");
  fs::create_directory_symlink(folder_, folder_ / "web/up");
  const StaticFiles files = Read();
  for (const char* path : {"/../secret.txt", "/./index.html", "//index.html", "/link.txt", "/up/secret.txt", "/assets",
                           "/assets/", "/INDEX.HTML", "/index.html/", "/etc/passwd", "", "/%2e%2e/secret.txt"}) {
    EXPECT_EQ(files.Answer(Get(path)).status, 404) << path;
  }
}

TEST_F(StaticFilesTest, OfUnknownTypesNothingIsServed) {
  Write("web/index.html", "page");
  Write("web/notes.bak", "x");
  Write("web/.env", "x");
  EXPECT_EQ(Read().size(), 1U);
}

TEST_F(StaticFilesTest, WithoutAPageThereIsOneThatSaysHowItIsBuilt) {
  const StaticFiles files = *StaticFiles::Read((folder_ / "not there").string());
  EXPECT_FALSE(files.has_page());
  EXPECT_EQ(files.Answer(Get("/")).status, 200);
  EXPECT_NE(files.Answer(Get("/")).body.find("npm run build"), std::string::npos);
  EXPECT_EQ(files.Answer(Get("/")).body.find("<script"), std::string::npos);
}

}  // namespace
}  // namespace annulus
