#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "station/console/console_context.h"
#include "station/console/job_folder.h"
#include "station/console/route.h"

namespace annulus {

/// The designer's long work: fits, rankings, pictures and exports by our own commands, on copies of the customer's
/// files in a folder of the job's. Borrows the context. Thread-safe.
class GlassesJobs {
 public:
  explicit GlassesJobs(ConsoleContext& context) : context_(context) {}

  ApiResult Fit(const ApiRequest& request);
  ApiResult Rank(const ApiRequest& request);
  ApiResult Picture(const ApiRequest& request);
  ApiResult Export(const ApiRequest& request);
  /// The picture of a job as far as it has come.
  ApiResult PictureSoFar(const ApiRequest& request);

 private:
  struct PictureOrder {
    std::string glasses;                 ///< Worn artefact's id, or the design; "": none are worn.
    std::string frame;                   ///< FRAME.json of a design that is to be fitted first; "": none.
    std::string look;                    ///< LOOK.json
    std::vector<std::string> arguments;  ///< Of `annulus render`: view, size, method, light.
  };
  ApiResult StartPicture(const ApiRequest& request, const PictureOrder& order, JobFolder folder);
  void NotePicture(const std::string& job_id, const std::string& file);

  ConsoleContext& context_;
  std::mutex mutex_;
  std::map<std::string, std::string> pictures_;  ///< File that a picture's job replaces while it gets better.
};

}  // namespace annulus
