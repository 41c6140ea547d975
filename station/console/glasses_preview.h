#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "base/result.h"
#include "modeling/glasses/design_request.h"
#include "modeling/glasses/fit_goals.h"
#include "render/look.h"
#include "station/console/glasses_wearer.h"

namespace annulus {

/// How a preview puts the frame on.
enum class PreviewPlacement {
  /// By the fit, without what only reports need, from where the style's last frame sat; where that fails as the last
  /// frame sat, or as kPaper.
  kQuick,
  kPaper,  ///< By the four steps of paper 000, §5, which scale the frame to the face.
};

/// A frame to show.
struct PreviewRequest {
  ComposedDesign design;
  Look look;
  PreviewPlacement placement = PreviewPlacement::kQuick;
  FitSize size = FitSize::kKept;
};

/// A frame with its lenses where they sit.
struct GlassesPreview {
  std::string mesh;              ///< MeshBytes: frame above, frame below its middle, right lens, left lens.
  std::size_t triangles = 0;     ///< At most kMostPreviewTriangles.
  nlohmann::ordered_json notes;  ///< {adjusted, placement, textures, …}: docs/console_api.md §9.
};
inline constexpr std::size_t kMostPreviewTriangles = 20'000;

/// Puts a design on a head at the speed of a slider: about 20 ms. Remembers the pose. Fails if no placement is
/// possible.
[[nodiscard]] Result<GlassesPreview> PreviewGlasses(GlassesWearer& wearer, const PreviewRequest& request);

}  // namespace annulus
