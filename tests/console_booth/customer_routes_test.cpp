#include <fstream>

#include "station/console/consent_texts.h"
#include "station/console/zip_writer.h"
#include "tests/console_booth/console_parts.h"

namespace annulus {
namespace {

using nlohmann::json;
using test::Answer;
using test::ConsoleParts;
using test::FreshFolder;
using test::RouteCaller;
using testing::HasSubstr;

/// What Python's zipfile says of an archive: a line "name size crc mode bytes-in-hex" for each entry, after testzip().
std::string PythonSays(const std::string& archive) {
  FreshFolder folder;
  const std::string path = folder / "a.zip";
  std::ofstream(path, std::ios::binary) << archive;
  const std::string script =
      "import sys,zipfile\n"
      "z=zipfile.ZipFile(sys.argv[1])\n"
      "assert z.testzip() is None\n"
      "for i in z.infolist(): print(i.filename, i.file_size, oct(i.external_attr>>16), i.date_time, "
      "z.read(i).hex()[:64])\n";
  std::ofstream(folder / "look.py") << script;
  const std::string command = "python3 " + (folder / "look.py") + " " + path + " > " + (folder / "out") + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::ifstream out(folder / "out");
  return {std::istreambuf_iterator<char>(out), {}};
}

std::chrono::system_clock::time_point SomeTime() {
  return std::chrono::sys_days(std::chrono::year(2026) / 11 / 29) + std::chrono::hours(22) + std::chrono::seconds(42);
}

TEST(ZipWriter, MakesWhatPythonReads) {
  ZipWriter zip(SomeTime());
  ASSERT_TRUE(zip.Add("customer.json", "{}"));
  ASSERT_TRUE(zip.Add("scans/S-1/空.txt", std::string(100'000, 'a')));
  ASSERT_TRUE(zip.Add("empty", ""));
  const std::string archive = zip.Finish();
  EXPECT_LT(archive.size(), 2'000U) << "deflated";
  EXPECT_EQ(PythonSays(archive),
            "customer.json 2 0o100600 (2026, 11, 29, 22, 0, 42) 7b7d\n"
            "scans/S-1/空.txt 100000 0o100600 (2026, 11, 29, 22, 0, 42) " +
                std::string("61616161616161616161616161616161616161616161616161616161616161"
                            "61") +
                "\nempty 0 0o100600 (2026, 11, 29, 22, 0, 42) \n");
}

TEST(ZipWriter, RefusesNamesThatLeadElsewhere) {
  ZipWriter zip(SomeTime());
  for (const char* name : {"", "/etc/passwd", "../up", "a/../../b", "a\\b", "a//b"}) EXPECT_FALSE(zip.Add(name, "x"));
  EXPECT_TRUE(zip.Add("a", "x"));
  EXPECT_FALSE(zip.Add("a", "y")) << "twice";
}

class CustomerRoutes : public testing::Test {
 protected:
  CustomerRoutes() : parts_(folder_ / "nobody.sock", "/bin/false") {
    AddCustomerRoutes(routes_.table, parts_.context());
  }
  std::string Add(const json& body = {{"name", "Hanako Yamada"}, {"height_mm", 1620}}) {
    const Answer answer = routes_.Post("/api/customers", body);
    EXPECT_EQ(answer.status, 200) << answer.seen;
    return answer.json.at("id");
  }
  FreshFolder folder_;
  ConsoleParts parts_;
  RouteCaller routes_;
};

TEST_F(CustomerRoutes, KeepWhatIsKnownOfACustomer) {
  const std::string id = Add();
  const std::string path = "/api/customers/" + id;
  json prescription = json::parse(R"({"format": "annulus-rx", "version": 1, "date": "2026-05-04", "prescriber": "Dr A",
    "right": {"sph_d": -4, "pd_mm": 31.5}, "left": {"sph_d": -3.5, "pd_mm": 32}})");
  const Answer changed = routes_.Post(path, {{"contact", "h@example.org"}, {"prescription", prescription}});
  ASSERT_EQ(changed.status, 200) << changed.seen;
  const Answer got = routes_.Get(path);
  EXPECT_EQ(got.json.at("name"), "Hanako Yamada");
  EXPECT_EQ(got.json.at("contact"), "h@example.org");
  EXPECT_EQ(got.json.at("height_mm"), 1620);
  EXPECT_EQ(got.json.at("prescription").at("right").at("sph_d"), -4.0);
  EXPECT_EQ(got.json.at("visits"), json::array());
  ASSERT_EQ(routes_.Post(path, {{"height_mm", nullptr}, {"prescription", nullptr}}).status, 200);
  EXPECT_TRUE(routes_.Get(path).json.at("height_mm").is_null());
  EXPECT_TRUE(routes_.Get(path).json.at("prescription").is_null());
  EXPECT_EQ(routes_.Get("/api/customers/K-9").status, 404);
  EXPECT_EQ(routes_.Get("/api/customers?search=Yama").json.at("customers").size(), 1U);
}

// RELIABILITY U2.
TEST_F(CustomerRoutes, NameTheFieldThatIsOutOfRange) {
  const auto field = [&](const json& body) {
    const Answer answer = routes_.Post("/api/customers", body);
    EXPECT_EQ(answer.status, 400) << body.dump().substr(0, 100);
    return answer.field;
  };
  EXPECT_EQ(field({{"name", ""}}), "name");
  EXPECT_EQ(field({{"contact", "x"}}), "name");
  EXPECT_EQ(field({{"name", "A\nB"}}), "name");
  EXPECT_EQ(field({{"name", std::string(10'000'000, 'x')}}), "name");
  EXPECT_EQ(field({{"name", "A"}, {"height_mm", 20}}), "height_mm");
  EXPECT_EQ(field({{"name", "A"}, {"height_mm", std::nan("")}}), "height_mm");
  EXPECT_EQ(field({{"name", "A"}, {"note", std::string(5000, 'x')}}), "note");
  EXPECT_EQ(field({{"name", "A"}, {"prescription", {{"sph_d", -4}}}}), "prescription");
  json rx = json::parse(R"({"format": "annulus-rx", "version": 1, "date": "2026-05-04", "prescriber": "Dr A",
    "right": {"sph_d": -4, "pd_mm": 5}, "left": {"sph_d": -3.5}})");
  EXPECT_EQ(field({{"name", "A"}, {"prescription", rx}}), "prescription") << "PD 5 mm";
  EXPECT_EQ(field({{"name", "A"}, {"id", "K-1"}}), "id") << "not theirs to choose";
  EXPECT_EQ(routes_.Get("/api/customers?limit=0").field, "limit");
}

TEST_F(CustomerRoutes, RecordWhatACustomerAgreesTo) {
  const std::string path = "/api/customers/" + Add();
  const json body{{"purposes", {"measure", "glasses"}},
                  {"text_version", ConsentTextVersion()},
                  {"language", "ja"},
                  {"agreed", true}};
  const Answer given = routes_.Post(path + "/consents", body);
  ASSERT_EQ(given.status, 200) << given.seen;
  EXPECT_TRUE(given.json.at("withdrawn_ms").is_null());
  const auto field = [&](const char* key, const json& value) {
    json other = body;
    other[key] = value;
    return routes_.Post(path + "/consents", other).field;
  };
  EXPECT_EQ(field("agreed", false), "agreed");
  EXPECT_EQ(field("purposes", json::array()), "purposes");
  EXPECT_EQ(field("purposes", {"measure", "measure"}), "purposes");
  EXPECT_EQ(field("purposes", {"sell"}), "purposes");
  EXPECT_EQ(field("text_version", "1999-01"), "text_version");
  EXPECT_EQ(field("language", "tlh"), "language");
  EXPECT_EQ(routes_.Post("/api/consents/" + given.json.at("id").get<std::string>() + "/withdraw").status, 200);
  EXPECT_FALSE(routes_.Get(path).json.at("consents")[0].at("withdrawn_ms").is_null());
  EXPECT_EQ(routes_.Post("/api/consents/C-9/withdraw").status, 404);
}

TEST_F(CustomerRoutes, ShowTheConsentInBothLanguages) {
  for (const std::string language : {"en", "ja"}) {
    const Answer text = routes_.Get("/api/consent-text?language=" + language);
    ASSERT_EQ(text.status, 200);
    EXPECT_EQ(text.json.at("language"), language);
    EXPECT_EQ(text.json.at("version"), ConsentTextVersion());
    EXPECT_EQ(text.json.at("purposes").size(), 4U);
    EXPECT_THAT(text.body, HasSubstr("90"));
    EXPECT_THAT(text.body, HasSubstr("9"));
  }
}

TEST_F(CustomerRoutes, EraseOnlyWhoIsNamedTwice) {
  const std::string id = Add();
  const std::string path = "/api/customers/" + id + "/erase";
  EXPECT_EQ(routes_.Post(path).field, "confirm");
  EXPECT_EQ(routes_.Post(path, {{"confirm", "K-999999"}}).field, "confirm");
  const Answer proof = routes_.Post(path, {{"confirm", id}});
  ASSERT_EQ(proof.status, 200);
  EXPECT_EQ(proof.json.at("key_destroyed"), true);
  EXPECT_EQ(routes_.Get("/api/customers/" + id).status, 404);
  EXPECT_EQ(routes_.Post(path, {{"confirm", id}}).status, 404);
}

TEST_F(CustomerRoutes, ExportAllThatIsKnown) {
  const std::string id = Add();
  const Consent consent = *parts_.store().AddConsent({"", id, {"measure"}, "2026-11", "en", "anna", {}, {}});
  const std::string file = folder_ / "scan.mcap";
  std::ofstream(file) << "a recording";
  ScanRow row;
  row.customer_id = id;
  row.consent_id = consent.id;
  row.summary_json = R"({"levels": 3})";
  const ScanRow scan = *parts_.store().AddScan(row, file, nullptr);
  Artefact artefact;
  artefact.scan_id = scan.id;
  artefact.kind = "design";
  artefact.name = "Round / ../gold";
  const std::string text = "{}";
  ASSERT_TRUE(parts_.store().PutArtefact(artefact, std::as_bytes(std::span(text))));
  const Answer zip = routes_.Get("/api/customers/" + id + "/export");
  ASSERT_EQ(zip.status, 200) << zip.seen;
  const std::string seen = PythonSays(zip.body);
  EXPECT_THAT(seen, HasSubstr("customer.json "));
  EXPECT_THAT(seen, HasSubstr("consents.json "));
  EXPECT_THAT(seen, HasSubstr("scans/" + scan.id + "/recording.mcap 11 "));
  EXPECT_THAT(seen, HasSubstr("Round _ .._gold 2 "));
  EXPECT_EQ(routes_.Get("/api/customers/K-9/export").status, 404);
}

TEST_F(CustomerRoutes, AreForOperatorsAndErasureAndExportForAdministratorsToo) {
  for (const Route& route : routes_.table.routes()) {
    const bool shared = route.pattern.ends_with("/erase") || route.pattern.ends_with("/export");
    EXPECT_TRUE(route.roles.operator_) << route.pattern;
    EXPECT_FALSE(route.roles.technician) << route.pattern;
    EXPECT_FALSE(route.roles.none) << route.pattern;
    EXPECT_EQ(route.roles.admin, shared) << route.pattern;
  }
}

TEST_F(CustomerRoutes, SayThatTheStoreIsAway) {
  parts_.memory().away = true;
  EXPECT_EQ(routes_.Post("/api/customers", {{"name", "A"}}).status, 503);
}

}  // namespace
}  // namespace annulus
