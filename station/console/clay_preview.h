#pragma once

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/clay/clay_body.h"
#include "modeling/clay/clay_script.h"

namespace annulus {

/// A scan's main segment as clay, made when somebody first asks (about a second of a torso). Thread-safe.
class ClaySlot {
 public:
  /// Fails as ClayFromSurface.
  [[nodiscard]] Result<std::shared_ptr<const ClayBody>> Get(const SurfaceSegment& segment);

 private:
  std::mutex mutex_;
  std::shared_ptr<const ClayBody> body_;
};

/// A body after a script, to look at.
struct ClayPreview {
  std::string mesh;              ///< MeshBytes, one part.
  nlohmann::ordered_json notes;  ///< {volume_mm3, area_mm2, patches, girths, operations}: docs/console_api.md §9a.
};

/// Carries a script out on a copy of the body, with girths at these heights (mm) followed from operation to operation.
/// Fails, naming the operation, as Perform.
[[nodiscard]] Result<ClayPreview> PreviewClay(const ClayBody& body, const ClayScript& script,
                                              const std::vector<double>& girths);

}  // namespace annulus
