#include "station/console/job_routes.h"

#include <nlohmann/json.hpp>

#include "station/console/job_folder.h"
#include "station/console/request_keys.h"

namespace annulus {

void AddJobRoutes(RouteTable& table, ConsoleContext& context) {
  using Json = nlohmann::ordered_json;
  table.Add({"GET", "/api/jobs", kLoggedIn, false, "", "", [&context](const ApiRequest& request) -> ApiResult {
               Json list = Json::array();
               for (const JobStatus& job : context.jobs.All()) {
                 if (job.owner == JobOwner(request.caller)) list.push_back(JobJson(job));
               }
               return JsonAnswer({{"jobs", std::move(list)}});
             }});
  table.Add({"GET", "/api/jobs/{job}", kLoggedIn, false, "", "", [&context](const ApiRequest& request) -> ApiResult {
               const auto job = OwnJob(context, request.caller, request.path.at("job"), "");
               if (!job) return tl::unexpected(job.error());
               return JsonAnswer(JobJson(*job));
             }});
  table.Add({"POST", "/api/jobs/{job}/cancel", kLoggedIn, false, "job_cancel", "job",
             [&context](const ApiRequest& request) -> ApiResult {
               if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
               const auto job = OwnJob(context, request.caller, request.path.at("job"), "");
               if (!job) return tl::unexpected(job.error());
               if (const Status done = context.jobs.Cancel(job->id); !done) return Refuse(404, done.error());
               return JsonAnswer(Json::object());
             }});
}

}  // namespace annulus
