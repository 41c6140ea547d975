#include "modeling/glasses/design_request.h"

#include <fmt/format.h>

#include <algorithm>

#include "modeling/glasses/frame_fields.h"

namespace annulus {
namespace {

/// The text asked for a field; empty if it was not.
std::optional<std::string> Asked(const DesignRequest& request, const FrameField& field) {
  const auto found = std::find_if(request.fields.rbegin(), request.fields.rend(),
                                  [&field](const auto& pair) { return pair.first == field.option; });
  if (found == request.fields.rend()) return std::nullopt;
  return found->second;
}

Status CheckNames(const DesignRequest& request) {
  for (const auto& [option, text] : request.fields) {
    if (FindFrameField(option) == nullptr) {
      return Fail(fmt::format("set the frame's {}", option), "there is no such field",
                  "see annulus glasses design --help");
    }
  }
  return {};
}

}  // namespace

Result<ComposedDesign> ComposeDesign(const FrameLibrary& library, const DesignRequest& request) {
  const Result<const LibraryStyle*> style = library.Find(request.style);
  RETURN_IF_ERROR(style);
  RETURN_IF_ERROR(CheckNames(request));
  Result<FrameDesign> design = (*style)->design;
  for (const FrameField& field : FrameFields()) {
    const std::optional<std::string> text = Asked(request, field);
    if (!text) continue;
    design = WithField(*design, field.option, *text);
    RETURN_IF_ERROR(design);
  }
  RETURN_IF_ERROR(Validate(*design));
  ComposedDesign composed;
  composed.file = {*design, (*style)->material, {}};
  return composed;
}

}  // namespace annulus
