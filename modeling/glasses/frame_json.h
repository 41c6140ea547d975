#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/frame_design.h"
#include "modeling/glasses/frame_material.h"
#include "modeling/glasses/placement.h"

namespace annulus {

/// What FRAME.json holds: a design that builds the same frame to the byte.
struct FrameFile {
  FrameDesign design;
  std::optional<DesignMaterial> material;
  std::optional<FrameAdjustment> adjustment;  ///< Absent: StandardAdjustment of the design.
};

/// FRAME.json, version 2 (docs/formats.md). Numbers read back to the same bits.
[[nodiscard]] std::string FrameToJson(const FrameFile& file);
/// Reads versions 1 and 2 and checks that the frame can be built. `name` of the file is for messages; they name the
/// key.
[[nodiscard]] Result<FrameFile> FrameFromJson(std::string_view json, std::string_view name);

/// Whether a text is one, by its "format".
[[nodiscard]] bool IsFrameJson(std::string_view text);

/// A part of WORN.json that this reader keeps as it is: what the fit found ("fit"), what the lab is to make ("order").
struct WornSection {
  std::string name;
  std::string json;  ///< An object; its values and the order of its keys are kept.
};

/// What WORN.json holds.
struct WornFile {
  WornFrame worn;
  std::optional<DesignMaterial> material;
  std::vector<WornSection> sections;

  /// The JSON of a section; empty if it is not there.
  [[nodiscard]] std::string_view Section(std::string_view name) const;
  /// Adds or replaces a section. Requires `json` to be one JSON object.
  void SetSection(std::string_view name, std::string_view json);
};

/// WORN.json, version 2 (docs/formats.md). Numbers read back to the same bits.
[[nodiscard]] std::string WornFileToJson(const WornFile& file);
/// Reads versions 1 and 2 and checks that the frame can be built. `name` of the file is for messages; they name the
/// key.
[[nodiscard]] Result<WornFile> WornFileFromJson(std::string_view json, std::string_view name);

}  // namespace annulus
