#pragma once

#include <functional>
#include <memory>
#include <string>

#include "base/result.h"
#include "modeling/landmarks/landmark.h"
#include "station/console/clay_preview.h"
#include "station/console/glasses_wearer.h"
#include "station/loaded_model.h"

namespace annulus {

class Store;

/// A scan's model as the routes work on it. Never changed once made; a change of landmarks makes a new one.
struct OpenModel {
  std::string scan_id;
  std::string artefact_id;  ///< Of the model; changes when it was fitted again.
  LoadedModel loaded;
  Landmarks landmarks;  ///< As they are now: found, and moved by hand.
  /// The head as the designer works on it; it ends with the model.
  std::shared_ptr<GlassesWearerSlot> wearer = std::make_shared<GlassesWearerSlot>();
  /// The body as clay.
  std::shared_ptr<ClaySlot> clay = std::make_shared<ClaySlot>();
};

/// The few models that were used last, opened. At most four, dropped after five minutes and at the end of a visit: what
/// is in memory is not sealed. Thread-safe.
class ModelCache {
 public:
  using Opener = std::function<Result<std::shared_ptr<const OpenModel>>(const std::string& scan_id)>;
  static std::unique_ptr<ModelCache> Make(Opener opener);
  virtual ~ModelCache() = default;
  virtual Result<std::shared_ptr<const OpenModel>> Open(const std::string& scan_id) = 0;
  /// Puts a model with other landmarks, which are in the store already, in the place of the one that it was made from.
  /// If another is there by now, the scan's model is opened anew.
  virtual void Change(const OpenModel& from, std::shared_ptr<const OpenModel> to) = 0;
  virtual void Drop(const std::string& scan_id) = 0;
  virtual void DropAll() = 0;
};

/// What a ModelCache opens: the newest model of a scan in the store, its landmarks found again, and those that were set
/// by hand (artefact "landmarks") put in their place; one of these that no longer fits is left out. Takes one to
/// three seconds of a body. Fails if the scan has no model, or it cannot be read.
[[nodiscard]] Result<std::shared_ptr<const OpenModel>> OpenStoredModel(Store& store, const std::string& scan_id);

}  // namespace annulus
