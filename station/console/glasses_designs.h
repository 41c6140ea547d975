#pragma once

#include "station/console/console_context.h"
#include "station/console/route.h"

namespace annulus {

// Designs that are kept: artefacts of kind "design", named by their titles. Titles of one scan differ.
ApiResult ListDesigns(ConsoleContext& context, const ApiRequest& request);
ApiResult AddDesign(ConsoleContext& context, const ApiRequest& request);
/// Changes what the body names. A new title gives it a new id.
ApiResult ChangeDesign(ConsoleContext& context, const ApiRequest& request);
ApiResult RemoveDesign(ConsoleContext& context, const ApiRequest& request);

}  // namespace annulus
