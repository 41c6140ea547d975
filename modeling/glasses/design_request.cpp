#include "modeling/glasses/design_request.h"

#include <fmt/format.h>

#include <algorithm>

#include "modeling/glasses/boxing.h"
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

/// A size by its name, or in numbers.
Result<FrameSize> FindSize(const LibraryStyle& style, const std::string& text) {
  if (const FrameSize* named = style.Size(text)) return *named;
  const Result<FrameSize> numbers = ParseSize(text);
  if (numbers || style.sizes.empty()) return numbers;
  std::string names;
  for (const FrameSize& size : style.sizes) names += size.name + ", ";
  Error error = numbers.error();
  error.advice = fmt::format("choose {}or {}", names, error.advice);
  return tl::unexpected(error);
}

/// Gives the composed design its size. What was asked for beside it (a height) is kept.
Status ApplySize(const LibraryStyle& style, const DesignRequest& request, ComposedDesign& composed) {
  for (const char* option : {"width", "bridge-gap"}) {
    if (!Asked(request, *FindFrameField(option))) continue;
    return Fail("size the frame", fmt::format("size and {} are both given", option), "give one of them");
  }
  const Result<FrameSize> size = FindSize(style, request.size);
  RETURN_IF_ERROR(size);
  WantedBox wanted{size->a, size->b, size->dbl};
  if (Asked(request, *FindFrameField("height"))) {
    const Result<FrameBoxing> boxing = BoxingOf(composed.file.design);
    RETURN_IF_ERROR(boxing);
    wanted.b = boxing->b;
  }
  Result<FrameDesign> sized = DesignForBox(composed.file.design, wanted);
  RETURN_IF_ERROR(sized);
  const Result<FrameAdjustment> adjustment = AdjustmentForTemple(*sized, size->temple);
  RETURN_IF_ERROR(adjustment);
  composed.file.design = *std::move(sized);
  composed.file.adjustment = *adjustment;
  composed.size = *size;
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
  if (!request.size.empty()) RETURN_IF_ERROR(ApplySize(**style, request, composed));
  return composed;
}

}  // namespace annulus
