// Every route of the console with every role, from afar and from the booth's own screen: who is not named in
// docs/console_api.md is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "tests/station_console/console_desk.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using test::Browser;
using test::ConsoleDesk;

constexpr std::array<StationRole, 4> kRoles{StationRole::kNone, StationRole::kOperator, StationRole::kTechnician,
                                            StationRole::kAdmin};

/// All routes, as the console adds them; none is carried out here.
class RouteRolesTest : public testing::Test {
 protected:
  RouteRolesTest() {
    desk_.table = RouteTable();
    AddAllRoutes(desk_.table, desk_.context, desk_.frame);
  }

  /// A path of the pattern.
  static std::string PathOf(std::string pattern) {
    while (pattern.find('{') != std::string::npos) {
      const std::size_t begin = pattern.find('{');
      pattern.replace(begin, pattern.find('}') - begin + 1, "X-1");
    }
    return pattern;
  }
  /// The gate's answer: 200 if it lets the request through.
  int Gate(const Route& route, StationRole role, bool loopback) {
    Browser browser(desk_, loopback);
    if (role == StationRole::kNone) {
      browser.Get("/api/session");
    } else {
      browser.BecomeUser("somebody", role);
    }
    HttpRequest request = route.method == "GET" ? browser.GetRequest(PathOf(route.pattern))
                                                : browser.PostRequest(PathOf(route.pattern), "{}");
    if (TakesBytes(route)) {
      for (HttpField& field : request.headers) {
        if (field.first == "content-type") field.second = "application/octet-stream";
      }
    }
    const auto passed = desk_.gate.Check(desk_.table, request);
    desk_.clock.SleepUntil(desk_.clock.Now() + std::chrono::seconds(61));  // control of the booth is free again
    return passed ? 200 : passed.error().error.status;
  }

  ConsoleDesk desk_;
};

TEST_F(RouteRolesTest, EveryRouteRefusesWhoIsNotNamed) {
  int checked = 0;
  for (const Route& route : desk_.table.routes()) {
    for (const StationRole role : kRoles) {
      for (const bool loopback : {true, false}) {
        const bool allowed = route.roles.Allows(role) && (loopback || !route.local_only);
        const int refused = !route.roles.Allows(role) && role == StationRole::kNone ? 401 : 403;
        EXPECT_EQ(Gate(route, role, loopback), allowed ? 200 : refused)
            << route.method << ' ' << route.pattern << " as " << StationRoleName(role)
            << (loopback ? " here" : " afar");
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 300);
}

TEST_F(RouteRolesTest, WhoeverIsNotLoggedInCanDoOnlyThis) {
  std::set<std::string> open;
  for (const Route& route : desk_.table.routes()) {
    if (route.roles.none) open.insert(route.method + " " + route.pattern);
  }
  EXPECT_EQ(open, (std::set<std::string>{"GET /api/session", "POST /api/setup", "POST /api/login", "POST /api/stop"}));
}

TEST_F(RouteRolesTest, AnAdminCannotMoveTheAxis) {
  for (const Route& route : desk_.table.routes()) {
    const bool moves = route.pattern == "/api/booth/home" || route.pattern == "/api/booth/arm" ||
                       route.pattern == "/api/booth/start" || route.pattern == "/api/booth/jog" ||
                       route.pattern == "/api/calibration/take";
    EXPECT_FALSE(moves && route.roles.admin) << route.pattern;
  }
}

TEST_F(RouteRolesTest, StartAndJogAreAtTheBoothOnly) {
  for (const Route& route : desk_.table.routes()) {
    if (route.pattern == "/api/booth/start" || route.pattern == "/api/booth/jog") {
      EXPECT_TRUE(route.local_only) << route.pattern;
    }
  }
}

TEST_F(RouteRolesTest, WhateverChangesSomethingIsAudited) {
  // These only compute, or write their own audit lines (login).
  const std::set<std::string> silent{"/api/login"};
  for (const Route& route : desk_.table.routes()) {
    const bool computes = route.pattern.starts_with("/api/scans/") || route.pattern.starts_with("/api/technician/") ||
                          route.pattern == "/api/compare" || route.pattern == "/api/colour" ||
                          route.pattern == "/api/booth/jog" || route.pattern.starts_with("/api/jobs/") ||
                          route.pattern.starts_with("/api/designs/") || route.pattern.starts_with("/api/replay/");
    if (route.method != "POST" || computes || silent.contains(route.pattern)) continue;
    EXPECT_FALSE(route.audit_action.empty()) << route.pattern;
  }
}

std::string Trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// Roles and place of every route as the contract's tables say: "METHOD pattern" → "O T, local".
std::map<std::string, std::string> ContractRoutes() {
  std::map<std::string, std::string> routes;
  std::ifstream file(test::SourceFolder() + "/docs/console_api.md");
  std::string line;
  while (std::getline(file, line)) {
    const std::size_t path = line.find("/api");
    if ((!line.starts_with("| GET") && !line.starts_with("| POST")) || path == std::string::npos) continue;
    std::istringstream cells(Replaced(line.substr(2), "\\|", "/"));  // \| is a bar within a cell
    std::string route;
    std::string who;
    std::getline(cells, route, '|');
    std::getline(cells, who, '|');
    const std::string pattern = line.substr(path, line.find_first_of(" ?", path) - path);
    for (const char* method : {"GET", "POST"}) {
      const bool named = line.substr(0, path).find(method) != std::string::npos;
      // "O (recording: T A)": of one kind of document.
      if (named) routes[method + (" " + pattern)] = Replaced(Replaced(Trimmed(who), "(recording: ", ""), ")", "");
    }
  }
  return routes;
}

TEST_F(RouteRolesTest, AreThoseOfTheContract) {
  const auto contract = ContractRoutes();
  ASSERT_GT(contract.size(), 60U);
  for (const Route& route : desk_.table.routes()) {
    const auto found = contract.find(route.method + " " + route.pattern);
    if (found == contract.end()) {
      ADD_FAILURE() << route.method << ' ' << route.pattern << " is not in docs/console_api.md";
      continue;
    }
    std::string who;
    if (route.roles.none) who += " N";
    if (route.roles.operator_) who += " O";
    if (route.roles.technician) who += " T";
    if (route.roles.admin) who += " A";
    if (route.local_only) who += ", local";
    EXPECT_EQ(who.substr(1), found->second) << route.method << ' ' << route.pattern;
  }
}

}  // namespace
}  // namespace annulus
