#include "station/console/route.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace annulus {
namespace {

ApiResult Nothing(const ApiRequest&) { return JsonAnswer(nlohmann::ordered_json::object()); }

RouteTable Table() {
  RouteTable table;
  for (const auto& [method, pattern] :
       {std::pair{"GET", "/api/scans"}, std::pair{"GET", "/api/scans/{scan}"}, std::pair{"POST", "/api/scans/{scan}"},
        std::pair{"POST", "/api/scans/import"}, std::pair{"GET", "/api/replay/{replay}/level/{n}"}}) {
    table.Add({method, pattern, kOperators, false, "", "", Nothing});
  }
  return table;
}

TEST(RouteTable, FindsByMethodAndPathAndNamesTheParameters) {
  const RouteTable table = Table();
  const auto match = table.Find("GET", "/api/replay/R-1/level/17");
  ASSERT_NE(match.route, nullptr);
  EXPECT_EQ(match.parameters, (std::map<std::string, std::string>{{"replay", "R-1"}, {"n", "17"}}));
}

TEST(RouteTable, ThePatternThatLeavesLessOpenWins) {
  const RouteTable table = Table();
  EXPECT_EQ(table.Find("POST", "/api/scans/import").route->pattern, "/api/scans/import");
  EXPECT_EQ(table.Find("GET", "/api/scans/import").route->pattern, "/api/scans/{scan}");
}

TEST(RouteTable, TellsAnotherMethodFromNoSuchPath) {
  const RouteTable table = Table();
  EXPECT_TRUE(table.Find("DELETE", "/api/scans").other_method);
  for (const char* path :
       {"/api/scan", "/api/scans/", "/api/scans/1/2", "/", "", "/api/replay//level/1", "/API/scans"}) {
    const auto match = table.Find("GET", path);
    EXPECT_EQ(match.route, nullptr) << path;
    EXPECT_FALSE(match.other_method) << path;
  }
}

TEST(RouteRoles, AllowNobodyUnlessTheySaySo) {
  for (const StationRole role :
       {StationRole::kNone, StationRole::kOperator, StationRole::kTechnician, StationRole::kAdmin}) {
    EXPECT_FALSE(RouteRoles().Allows(role));
    EXPECT_TRUE(kEverybody.Allows(role));
    EXPECT_EQ(kLoggedIn.Allows(role), role != StationRole::kNone);
    EXPECT_EQ(kAdmins.Allows(role), role == StationRole::kAdmin);
  }
}

TEST(Fields, TextIsOfItsLengthAndWithoutControlCharacters) {
  const nlohmann::json body{{"name", "Tanaka 浩"}, {"long", std::string(65, 'x')},
                            {"bell", "a\x07"},     {"del", "a\x7F"},
                            {"c1", "a\xC2\x85"},   {"lines", "a\nb"},
                            {"number", 3},         {"null", nullptr}};
  EXPECT_EQ(*TextField(body, "name", 64), "Tanaka 浩");
  for (const char* bad : {"long", "bell", "del", "c1", "lines", "number", "null", "missing"}) {
    const auto field = TextField(body, bad, 64);
    ASSERT_FALSE(field) << bad;
    EXPECT_EQ(field.error().status, 400);
    EXPECT_EQ(field.error().field, bad);
  }
  EXPECT_EQ(*TextField(body, "lines", 4096), "a\nb") << "notes have lines";
  EXPECT_FALSE(TextField(body, "bell", 4096));
  EXPECT_FALSE(OptionalText(body, "null", 64)->has_value());
  EXPECT_FALSE(OptionalText(body, "missing", 64)->has_value());
  EXPECT_FALSE(OptionalText(body, "number", 64));
}

TEST(Fields, NumbersAreFiniteAndWithinTheirRange) {
  const nlohmann::json body{{"good", 63.5},  {"whole", 60},  {"low", 4.9},
                            {"high", 1e300}, {"text", "60"}, {"flag", true}};
  EXPECT_EQ(*NumberField(body, "good", 40, 80), 63.5);
  EXPECT_EQ(*NumberField(body, "whole", 60, 60), 60.0);
  for (const char* bad : {"low", "high", "text", "flag", "missing"}) {
    const auto field = NumberField(body, bad, 40, 80);
    ASSERT_FALSE(field) << bad;
    EXPECT_EQ(field.error().field, bad);
  }
  nlohmann::json nan;
  nan["nan"] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(NumberField(nan, "nan", 40, 80));
  EXPECT_FALSE(OptionalNumber(body, "missing", 40, 80)->has_value());
  EXPECT_FALSE(OptionalNumber(body, "low", 40, 80));
}

TEST(Fields, FlagsAreTrueOrFalse) {
  const nlohmann::json body{{"yes", true}, {"no", false}, {"one", 1}, {"text", "true"}};
  EXPECT_TRUE(*FlagField(body, "yes"));
  EXPECT_FALSE(*FlagField(body, "no"));
  for (const char* bad : {"one", "text", "missing"}) EXPECT_FALSE(FlagField(body, bad)) << bad;
}

TEST(JsonAnswer, IsJsonEvenOfBytesThatAreNoText) {
  const HttpResponse response = JsonAnswer({{"seen", "\xFF\xFE"}}, 503);
  EXPECT_EQ(response.status, 503);
  EXPECT_EQ(response.content_type, "application/json");
  EXPECT_FALSE(nlohmann::json::parse(response.body, nullptr, false).is_discarded());
}

}  // namespace
}  // namespace annulus
