// Status, home, arm, start, cancel, acknowledge, jog (docs/console_api.md §4).

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "station/console/booth_link.h"
#include "station/console/booth_link_json.h"
#include "station/console/booth_words.h"
#include "station/console/console_context.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/console/scan_tickets.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLargestVersion = 9007199254740991.0;  // what a number of JSON holds exactly

/// boothd's refusal: the booth is not in a state for it (409); or it could not be asked (503).
ApiResult AnswerOf(const BoothLink& booth, const Status& outcome) {
  if (outcome) return JsonAnswer(Json::object());
  return Refuse(booth.status() ? 409 : 503, outcome.error());
}

/// An order without anything in its body.
ApiResult Simply(BoothLink& booth, const ApiRequest& request, const BoothOrder& order) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  return AnswerOf(booth, booth.Ask(order));
}

/// What a scan of this profile is for, as consents name it: a head alone may be scanned for glasses.
bool Covers(const Consent& consent, const std::string& profile) {
  const auto has = [&](std::string_view purpose) {
    return std::find(consent.purposes.begin(), consent.purposes.end(), purpose) != consent.purposes.end();
  };
  return has("measure") || (profile == "head" && has("glasses"));
}

/// The consent if it is the customer's, in force, and for this.
tl::expected<Consent, ApiError> ConsentFor(Store& store, const std::string& customer_id, const std::string& consent_id,
                                           const std::string& profile) {
  const auto consents = store.Consents(customer_id);
  if (!consents) return NotThere(consents.error());
  const auto found = std::find_if(consents->begin(), consents->end(),
                                  [&](const Consent& consent) { return consent.id == consent_id; });
  if (found == consents->end()) {
    return BadField("consent_id", "the customer has not given this consent", "ask for it, then prepare the scan again");
  }
  if (found->withdrawn) {
    return BadField("consent_id", "the consent was withdrawn", "ask for a new one, or do not scan");
  }
  if (!Covers(*found, profile)) {
    return BadField("consent_id", "the consent does not cover such a scan",
                    "ask for the consent to be measured, then prepare the scan again");
  }
  return *found;
}

struct ArmBody {
  ScanTicket ticket;
  std::optional<double> height_mm;
};

tl::expected<ArmBody, ApiError> ReadArm(const ApiRequest& request) {
  constexpr double kLowest = 300.0;
  constexpr double kHighest = 2500.0;
  if (const auto known = OnlyKeys(request.body, {"customer_id", "consent_id", "profile", "height_mm"}); !known)
    return tl::unexpected(known.error());
  ArmBody body;
  for (const auto& [name, into] :
       {std::pair("customer_id", &body.ticket.customer_id), std::pair("consent_id", &body.ticket.consent_id),
        std::pair("profile", &body.ticket.profile)}) {
    auto text = TextField(request.body, name, 64);
    if (!text) return tl::unexpected(std::move(text.error()));
    *into = std::move(*text);
  }
  auto height = OptionalNumber(request.body, "height_mm", kLowest, kHighest);
  if (!height) return tl::unexpected(std::move(height.error()));
  body.height_mm = *height;
  body.ticket.user = request.caller.user;
  return body;
}

/// Binds the scan to customer and consent: the ticket is on the disk before the booth knows of it.
ApiResult Arm(ConsoleContext& context, ScanTickets& tickets, const ApiRequest& request) {
  auto body = ReadArm(request);
  if (!body) return tl::unexpected(std::move(body.error()));
  const auto booth = context.booth.booth();
  if (!booth) return Refuse(503, {"prepare the scan", context.booth.why(), "see whether boothd runs"});
  if (std::find(booth->profiles.begin(), booth->profiles.end(), body->ticket.profile) == booth->profiles.end()) {
    return BadField("profile", "the booth has no such profile", "choose one of GET /api/booth");
  }
  const auto customer = context.store.GetCustomer(body->ticket.customer_id);
  if (!customer) return NotThere(customer.error());
  auto consent = ConsentFor(context.store, customer->id, body->ticket.consent_id, body->ticket.profile);
  if (!consent) return tl::unexpected(std::move(consent.error()));
  body->ticket.armed = std::chrono::duration_cast<StoreTime>(context.clock.WallNow());
  const auto ticket = tickets.Add(std::move(body->ticket));
  if (!ticket) return StoreAway(ticket.error());

  ArmOrder order;
  order.profile = ticket->profile;
  if (body->height_mm) order.height = Millimetres(*body->height_mm);
  if (!body->height_mm && customer->height_mm) order.height = Millimetres(*customer->height_mm);
  order.out = ticket->recording();
  order.subject_id = ticket->customer_id;
  order.consent = ticket->consent_id;
  if (const Status armed = context.booth.Ask(order); !armed) {
    static_cast<void>(tickets.Remove(ticket->id));  // one that stays is of no recording
    return AnswerOf(context.booth, armed);
  }
  return JsonAnswer({{"scan_ticket", ticket->id}});
}

/// Of two that were given for the same state one is carried out (fault rows N2, N3); boothd alone decides.
ApiResult Start(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"version"}); !known) return tl::unexpected(known.error());
  const auto version = NumberField(request.body, "version", 0.0, kLargestVersion);
  if (!version) return tl::unexpected(version.error());
  if (*version != static_cast<double>(static_cast<std::uint64_t>(*version))) {
    return BadField("version", "it is not a whole number", "give the version of the status that was looked at");
  }
  return AnswerOf(context.booth, context.booth.Ask(StartOrder{static_cast<std::uint64_t>(*version)}));
}

ApiResult Acknowledge(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const bool technician = request.caller.role == StationRole::kTechnician;
  return AnswerOf(context.booth, technician ? context.booth.AskAsTechnician(AcknowledgeOrder{})
                                            : context.booth.Ask(AcknowledgeOrder{}));
}

ApiResult Jog(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"direction"}); !known) return tl::unexpected(known.error());
  const auto direction = TextField(request.body, "direction", 8);
  if (!direction) return tl::unexpected(direction.error());
  if (*direction != "up" && *direction != "down") {
    return BadField("direction", "it is '" + *direction + "'", "give \"up\" or \"down\"");
  }
  const JogOrder order{*direction == "up" ? Scanner::JogDirection::kUp : Scanner::JogDirection::kDown};
  return AnswerOf(context.booth, context.booth.AskAsTechnician(order));
}

}  // namespace

void AddBoothRoutes(RouteTable& table, ConsoleContext& context) {
  table.Add(
      {"GET", "/api/booth", kOperatorsTechnicians, false, "", "", [&context](const ApiRequest& request) -> ApiResult {
         return JsonAnswer(BoothToJson(context.booth, LanguageOf(LanguageName(request.http))));
       }});
  table.Add({"POST", "/api/booth/home", kOperatorsTechnicians, false, "home", "",
             [&context](const ApiRequest& request) { return Simply(context.booth, request, HomeOrder{}); }});
  const auto tickets = std::make_shared<ScanTickets>(context.store);  // shared: std::function wants to be copied
  table.Add({"POST", "/api/booth/arm", kOperators, false, "arm", "customer_id",
             [&context, tickets](const ApiRequest& request) { return Arm(context, *tickets, request); }});
  table.Add({"POST", "/api/booth/start", kOperators, true, "start", "",
             [&context](const ApiRequest& request) { return Start(context, request); }});
  table.Add({"POST", "/api/booth/cancel", kOperatorsTechnicians, false, "cancel", "",
             [&context](const ApiRequest& request) -> ApiResult {
               if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
               return AnswerOf(context.booth, context.booth.Cancel());
             }});
  table.Add({"POST", "/api/booth/acknowledge", kOperatorsTechnicians, false, "acknowledge", "",
             [&context](const ApiRequest& request) { return Acknowledge(context, request); }});
  table.Add({"POST", "/api/booth/jog", kTechnicians, true, "jog", "",
             [&context](const ApiRequest& request) { return Jog(context, request); }});
}

}  // namespace annulus
