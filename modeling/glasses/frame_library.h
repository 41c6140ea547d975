#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/frame_design.h"
#include "modeling/glasses/frame_material.h"

namespace annulus {

/// A size as frames are sold, in the boxing system.
struct SoldSize {
  std::string name;         ///< "small", "medium", "large".
  double a = 0.0;           ///< Lens width A, mm.
  std::optional<double> b;  ///< Lens height B, mm; absent: as the style's shape has it.
  double dbl = 0.0;         ///< Distance between lenses, mm.
  double temple = 0.0;      ///< Overall temple length from the hinge along the bend to the tip, mm.

  [[nodiscard]] bool operator==(const SoldSize&) const = default;
};

/// Whether spectacles have such sizes. The error names the value and its range.
[[nodiscard]] Status Validate(const SoldSize& size);

/// A named starting point of a design.
struct LibraryStyle {
  std::string name;  ///< "wellington".
  std::string description;
  DesignMaterial material = DesignMaterial::kAcetate;
  FrameDesign design;           ///< The shape; `design.style` is `name`.
  std::vector<SoldSize> sizes;  ///< Empty for the paper's examples, which are scaled to the face only.

  /// The size of this name; null if there is none.
  [[nodiscard]] const SoldSize* Size(std::string_view size_name) const;
};

/// Named styles.
struct FrameLibrary {
  std::vector<LibraryStyle> styles;

  /// The style of this name. Fails with a list of the known ones.
  [[nodiscard]] Result<const LibraryStyle*> Find(std::string_view name) const;
};

/// The styles that come with the program (frame_library.json, built in).
[[nodiscard]] const FrameLibrary& BuiltInFrameLibrary();

/// Reads a library file: {"format": "annulus-frame-library", "version": 1, "styles": […]} (docs/formats.md). Fails on
/// what is no JSON, naming the line, and on an entry that is wrong, naming the style and the key; every design must be
/// valid. `name` of the file is for messages.
[[nodiscard]] Result<FrameLibrary> FrameLibraryFromJson(std::string_view json, std::string_view name);

/// The library as a file that reads back to the same bits.
[[nodiscard]] std::string FrameLibraryToJson(const FrameLibrary& library);

/// `first`, and the styles of `second` whose names it does not have.
[[nodiscard]] FrameLibrary Merged(FrameLibrary first, const FrameLibrary& second);

}  // namespace annulus
