#include "modeling/glasses/design_request.h"

#include <fmt/format.h>

#include <algorithm>

#include "modeling/glasses/boxing.h"
#include "modeling/glasses/frame_adjust.h"
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

/// A groove needs a width and a hinge an end piece: usual ones where neither the style nor the request says any.
void AddCompanions(const DesignRequest& request, FrameDesign& design) {
  constexpr double kGrooveOpening = 2.0;  // width : depth
  constexpr double kEndPiece = 5.0;       // mm
  FrameDetails& details = design.details;
  if (details.groove_depth > 0.0 && details.groove_width == 0.0 && !Asked(request, *FindFrameField("groove-width"))) {
    details.groove_width = kGrooveOpening * details.groove_depth;
  }
  const bool hinged = details.hinge != HingeForm::kNone;
  if (hinged && details.end_piece == 0.0 && !Asked(request, *FindFrameField("end-piece"))) {
    details.end_piece = kEndPiece;
  }
  if (!hinged && !Asked(request, *FindFrameField("end-piece"))) details.end_piece = 0.0;
}

/// A size by its name, or in numbers.
Result<SoldSize> FindSize(const LibraryStyle& style, const std::string& text) {
  if (const SoldSize* named = style.Size(text)) return *named;
  Result<SoldSize> numbers = ParseSize(text);
  if (numbers || style.sizes.empty()) return numbers;
  std::string names;
  for (const SoldSize& size : style.sizes) names += size.name + ", ";
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
  const Result<SoldSize> size = FindSize(style, request.size);
  if (!size) return Fail(size);
  WantedBox wanted{size->a, size->b, size->dbl};
  if (Asked(request, *FindFrameField("height"))) {
    const Result<FrameBoxing> boxing = BoxingOf(composed.file.design);
    if (!boxing) return Fail(boxing);
    wanted.b = boxing->b;
  }
  Result<FrameDesign> sized = DesignForBox(composed.file.design, wanted);
  if (!sized) return Fail(sized);
  const Result<FrameAdjustment> adjustment = AdjustmentForTemple(*sized, size->temple);
  if (!adjustment) return Fail(adjustment);
  composed.file.design = *std::move(sized);
  composed.file.adjustment = *adjustment;
  composed.size = *size;
  return {};
}

}  // namespace

Result<ComposedDesign> ComposeDesign(const FrameLibrary& library, const DesignRequest& request) {
  const Result<const LibraryStyle*> style = library.Find(request.style);
  if (!style) return Fail(style);
  RETURN_IF_ERROR(CheckNames(request));
  Result<FrameDesign> design = (*style)->design;
  for (const FrameField& field : FrameFields()) {
    const std::optional<std::string> text = Asked(request, field);
    if (!text) continue;
    design = WithField(*design, field.option, *text);
    if (!design) return Fail(design);
  }
  AddCompanions(request, *design);
  const Result<AdjustedDesign> adjusted = AdjustDesign(*design);
  if (!adjusted) return Fail(adjusted);
  ComposedDesign composed;
  composed.file = {adjusted->design, (*style)->material, {}};
  composed.messages = adjusted->messages;
  if (!request.size.empty()) RETURN_IF_ERROR(ApplySize(**style, request, composed));
  return composed;
}

}  // namespace annulus
