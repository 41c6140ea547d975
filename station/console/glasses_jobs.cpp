#include "station/console/glasses_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/sha256.h"
#include "modeling/glasses/frame_json.h"
#include "render/camera.h"
#include "render/environment.h"
#include "station/console/glasses_request.h"
#include "station/console/job_folder.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/console/scan_json.h"
#include "station/look_file.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kKeptPictures = 64;
constexpr std::size_t kLongestReference = 64;

tl::unexpected<ApiError> Away(const Error& error) { return Refuse(503, error); }

/// Names results of the same request alike and those of others differently.
std::string Tag(const std::string& text) { return Sha256Hex(std::as_bytes(std::span(text))).substr(0, 12); }

std::string ScanIn(const ApiRequest& request) { return request.path.at("scan"); }

/// `worn`: an artefact of that kind and scan, put into the folder. False without one.
tl::expected<bool, ApiError> PutWorn(ConsoleContext& context, const ApiRequest& request, JobFolder& folder) {
  const auto worn = OptionalText(request.body, "worn", 64);
  if (!worn) return tl::unexpected(worn.error());
  if (!*worn) return false;
  const auto artefact = context.store.GetArtefact(**worn);
  if (!artefact || artefact->scan_id != ScanIn(request) || artefact->kind != "worn") {
    return BadField("worn", "there are no such glasses of this scan", "fit them first");
  }
  if (const Status put = folder.PutArtefact("worn.json", **worn); !put) return Away(put.error());
  return true;
}

JobRequest NewJob(const ApiRequest& request, std::string kind) {
  JobRequest job;
  job.kind = std::move(kind);
  job.owner = JobOwner(request.caller);
  job.subject = ScanIn(request);
  return job;
}

/// `body` without a key that is null.
bool Has(const nlohmann::json& body, const char* key) { return body.contains(key) && !body.at(key).is_null(); }

/// Only what was printed as JSON; null if that is damaged.
Json PrintedJson(const std::string& printed) { return Json::parse(printed, nullptr, false); }

}  // namespace

ApiResult GlassesJobs::Fit(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"design", "prescription", "free_size"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto composed = ComposedIn(request.body);
  if (!composed) return tl::unexpected(composed.error());
  const auto order = PrescriptionIn(request.body);
  if (!order) return tl::unexpected(order.error());
  const auto free = FlagOr(request.body, "free_size", false);
  if (!free) return tl::unexpected(free.error());
  auto folder = FolderWithModel(context_, ScanIn(request));
  if (!folder) return tl::unexpected(folder.error());
  const std::string frame = FrameToJson(composed->file);
  if (const Status put = folder->PutText("frame.json", frame); !put) return Away(put.error());
  std::vector<std::string> arguments{"glasses",
                                     "fit",
                                     folder->File("model.json"),
                                     "--frame",
                                     folder->File("frame.json"),
                                     "--out",
                                     folder->File("worn.json"),
                                     "--json",
                                     "-"};
  if (*free) arguments.emplace_back("--size-free");
  if (*order) {
    if (const Status put = folder->PutText("rx.json", **order); !put) return Away(put.error());
    arguments.insert(arguments.end(), {"--rx", folder->File("rx.json")});
  }
  JobRequest job = NewJob(request, "glasses_fit");
  job.steps = {{"fit the glasses", arguments}};
  // Shared by the two callbacks, which the runner may copy.
  const auto report = std::make_shared<Json>();
  job.after_step = [report](std::size_t, const std::string& printed) -> Status {
    *report = PrintedJson(printed);
    return report->is_object() ? Status{} : Fail("read the fit's report", "it is no JSON", "try again");
  };
  const std::string name = "worn-" + Tag(frame + order->value_or("") + (*free ? "free" : "")) + ".json";
  const std::string worn = folder->File("worn.json");
  job.finish = [this, report, name, worn, scan = ScanIn(request)]() -> Result<Json> {
    Artefact what;
    what.kind = "worn";
    what.name = name;
    what.derived = false;  // it rests on what a person chose
    const auto kept = KeepResult(context_, scan, worn, std::move(what));
    if (!kept) return Fail(kept);
    return Json{{"worn", ArtefactJson(*kept)}, {"report", *report}};
  };
  return JobAnswer(context_.jobs, folder->Start(std::move(job)));
}

ApiResult GlassesJobs::Rank(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"prescription", "top"}); !known) return tl::unexpected(known.error());
  const auto order = PrescriptionIn(request.body);
  if (!order) return tl::unexpected(order.error());
  const auto top = WholeNumberOr(request.body, "top", 12, 1, 1000);
  if (!top) return tl::unexpected(top.error());
  auto folder = FolderWithModel(context_, ScanIn(request));
  if (!folder) return tl::unexpected(folder.error());
  std::vector<std::string> arguments{"glasses", "rank", folder->File("model.json"), "--top", std::to_string(*top),
                                     "--json",  "-"};
  if (*order) {
    if (const Status put = folder->PutText("rx.json", **order); !put) return Away(put.error());
    arguments.insert(arguments.end(), {"--rx", folder->File("rx.json")});
  }
  JobRequest job = NewJob(request, "glasses_rank");
  job.steps = {{"try the library's frames on", arguments}};
  const auto frames = std::make_shared<Json>(Json::array());
  job.after_step = [frames](std::size_t, const std::string& printed) -> Status {
    const Json report = PrintedJson(printed);
    if (!report.is_object() || !report.contains("frames")) {
      return Fail("read the ranking", "it is no JSON", "try again");
    }
    for (Json frame : report.at("frames")) {
      const Json& advice = frame.at("advice");
      frame["why"] = advice.empty() ? std::string("fits") : advice.front().get<std::string>();
      frame["design"] = DesignJson({frame.at("style").get<std::string>(), frame.at("size").get<std::string>(), {}});
      frames->push_back(std::move(frame));
    }
    return {};
  };
  job.finish = [frames]() -> Result<Json> { return Json{{"frames", *frames}}; };
  return JobAnswer(context_.jobs, folder->Start(std::move(job)));
}

namespace {

/// Whether the customer has said that the body may be shown.
bool IsReleased(const ScanRow& scan) {
  const Json summary = Json::parse(scan.summary_json, nullptr, false);
  return summary.is_object() && summary.value("released", Json()) == true;
}

/// How a picture is taken, as arguments of `annulus render`.
tl::expected<std::vector<std::string>, ApiError> PictureArguments(const nlohmann::json& body) {
  const auto view = OptionalText(body, "view", 32);
  if (!view) return tl::unexpected(view.error());
  const std::string view_text = view->value_or("front");
  if (const auto parsed = ParseView(view_text); !parsed) return BadField("view", parsed.error());
  const auto size = WholeNumberOr(body, "size", 720, 64, 2048);
  if (!size) return tl::unexpected(size.error());
  const auto method = WordOr(body, "method", "zbuffer", {"zbuffer", "trace"});
  if (!method) return tl::unexpected(method.error());
  const auto samples = WholeNumberOr(body, "samples", 64, 1, 4096);
  if (!samples) return tl::unexpected(samples.error());
  const auto& names = LightPresetNames();
  const auto light = WordOr(body, "light", "studio", {names.begin(), names.end()});
  if (!light) return tl::unexpected(light.error());
  return std::vector<std::string>{"--view=" + view_text,
                                  "--size",
                                  std::to_string(*size),
                                  "--method",
                                  *method,
                                  "--samples",
                                  std::to_string(*samples),
                                  "--light",
                                  *light};
}

}  // namespace

ApiResult GlassesJobs::Picture(const ApiRequest& request) {
  const auto scan = context_.store.GetScan(ScanIn(request));
  if (!scan) return Refuse(404, scan);
  if (!IsReleased(*scan)) {
    return Refuse(403, {"draw " + scan->id, "the customer has not released it", "ask the customer, then release it"});
  }
  if (const auto known =
          OnlyKeys(request.body, {"worn", "design", "look", "view", "size", "method", "samples", "light"});
      !known) {
    return tl::unexpected(known.error());
  }
  const auto look = LookIn(request.body);
  if (!look) return tl::unexpected(look.error());
  const auto picture = PictureArguments(request.body);
  if (!picture) return tl::unexpected(picture.error());
  std::string frame;
  if (!Has(request.body, "worn") && Has(request.body, "design")) {
    const auto composed = ComposedIn(request.body);
    if (!composed) return tl::unexpected(composed.error());
    frame = FrameToJson(composed->file);
  }
  auto folder = FolderWithModel(context_, ScanIn(request));
  if (!folder) return tl::unexpected(folder.error());
  const auto worn = PutWorn(context_, request, *folder);
  if (!worn) return tl::unexpected(worn.error());
  const PictureOrder order{*worn ? request.body.at("worn").get<std::string>() : frame, frame, LookToJson(*look),
                           *picture};
  return StartPicture(request, order, std::move(*folder));
}

ApiResult GlassesJobs::StartPicture(const ApiRequest& request, const PictureOrder& order, JobFolder folder) {
  if (const Status put = folder.PutText("look.json", order.look); !put) return Away(put.error());
  JobRequest job = NewJob(request, "glasses_picture");
  if (!order.frame.empty()) {
    if (const Status put = folder.PutText("frame.json", order.frame); !put) return Away(put.error());
    job.steps.push_back({"fit the glasses",
                         {"glasses", "fit", folder.File("model.json"), "--frame", folder.File("frame.json"), "--out",
                          folder.File("worn.json"), "--json", "-"}});
  }
  const std::string file = folder.File("picture.png");
  const std::string so_far = folder.File("so-far.png");
  std::vector<std::string> arguments{
      "render", folder.File("model.json"), "--look", folder.File("look.json"), "--out", file, "--json", "-"};
  if (!order.glasses.empty()) arguments.insert(arguments.end(), {"--worn", folder.File("worn.json")});
  arguments.insert(arguments.end(), order.arguments.begin(), order.arguments.end());
  // The z-buffer makes its picture at once: there is nothing that gets better.
  const bool traced = std::find(arguments.begin(), arguments.end(), "trace") != arguments.end();
  if (traced) arguments.insert(arguments.end(), {"--progressive", so_far});
  job.steps.push_back({"draw the picture", arguments});
  job.limit = std::chrono::seconds(1800);
  std::string all = order.glasses + order.look;
  for (const std::string& argument : order.arguments) all += argument;
  job.finish = [this, name = "picture-" + Tag(all) + ".png", file, scan = ScanIn(request)]() -> Result<Json> {
    Artefact what;
    what.kind = "picture";
    what.name = name;
    const auto kept = KeepResult(context_, scan, file, std::move(what));
    if (!kept) return Fail(kept);
    return Json{{"picture", ArtefactJson(*kept)}};
  };
  const std::string id = folder.Start(std::move(job));
  NotePicture(id, so_far);
  return JobAnswer(context_.jobs, id);
}

ApiResult GlassesJobs::Export(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"worn", "format", "reference", "confirmed_by"}); !known) {
    return tl::unexpected(known.error());
  }
  if (!Has(request.body, "format")) return BadField("format", "it is missing", "give stl, step, dcs, json or pdf");
  const auto format = WordOr(request.body, "format", "", {"stl", "step", "dcs", "json", "pdf"});
  if (!format) return tl::unexpected(format.error());
  const auto reference = OptionalText(request.body, "reference", kLongestReference);
  if (!reference) return tl::unexpected(reference.error());
  const auto confirmed = OptionalText(request.body, "confirmed_by", kLongestReference);
  if (!confirmed) return tl::unexpected(confirmed.error());
  if (*format == "dcs" && confirmed->value_or("").empty()) {
    return BadField("confirmed_by", "nobody has confirmed pupillary distances and heights",
                    "say who has: without a name no file goes to a laboratory");
  }
  if (const auto scan = context_.store.GetScan(ScanIn(request)); !scan) return Refuse(404, scan);
  auto folder = JobFolder::Make(context_);
  if (!folder) return Away(folder.error());
  const auto worn = PutWorn(context_, request, *folder);
  if (!worn) return tl::unexpected(worn.error());
  if (!*worn) return BadField("worn", "it is missing", "fit the glasses first");
  const std::string file = folder->File("glasses." + *format);
  std::vector<std::string> arguments{"glasses", "export", folder->File("worn.json"), "--out", file, "--json", "-"};
  if (*reference) arguments.push_back("--reference=" + **reference);
  if (*confirmed) arguments.push_back("--confirmed-by=" + **confirmed);
  JobRequest job = NewJob(request, "glasses_export");
  job.steps = {{"write the file", arguments}};
  const auto notes = std::make_shared<Json>(Json::array());
  job.after_step = [notes](std::size_t, const std::string& printed) -> Status {
    const Json report = PrintedJson(printed);
    if (report.is_object()) *notes = report.value("notes", Json::array());
    return {};
  };
  const std::string worn_id = request.body.at("worn").get<std::string>();
  job.finish = [this, notes, file, name = "glasses-" + worn_id + "." + *format,
                scan = ScanIn(request)]() -> Result<Json> {
    Artefact what;
    what.kind = "document";
    what.name = name;
    const auto kept = KeepResult(context_, scan, file, std::move(what));
    if (!kept) return Fail(kept);
    return Json{{"document", ArtefactJson(*kept)}, {"notes", *notes}};
  };
  return JobAnswer(context_.jobs, folder->Start(std::move(job)));
}

ApiResult GlassesJobs::PictureSoFar(const ApiRequest& request) {
  const std::string& id = request.path.at("job");
  const auto job = OwnJob(context_, request.caller, id, "glasses_picture");
  if (!job) return tl::unexpected(job.error());
  HttpResponse answer{200, "image/png", {{"X-Annulus-Share", fmt::format("{:.3f}", job->share)}}, {}};
  Result<std::vector<std::byte>> bytes = Fail("show the picture of " + id, "there is none yet", "wait");
  if (job->state == JobState::kDone) {
    const Json result = Json::parse(job->result_json, nullptr, false);
    if (result.is_object()) bytes = context_.store.ReadArtefact(result.at("picture").at("id").get<std::string>());
  } else {
    const std::lock_guard lock(mutex_);
    const auto file = pictures_.find(id);
    if (file != pictures_.end()) bytes = context_.storage.ReadAll(file->second, kMaxInputBytes);
  }
  if (!bytes) return Refuse(404, bytes);
  answer.body.assign(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  return answer;
}

void GlassesJobs::NotePicture(const std::string& job_id, const std::string& file) {
  const std::lock_guard lock(mutex_);
  for (auto known = pictures_.begin(); known != pictures_.end();) {
    const auto job = context_.jobs.Get(known->first);
    const bool over = !job || (job->state != JobState::kWaiting && job->state != JobState::kRunning);
    known = over || pictures_.size() > kKeptPictures ? pictures_.erase(known) : std::next(known);
  }
  pictures_[job_id] = file;
}

}  // namespace annulus
