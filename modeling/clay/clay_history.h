#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/clay/clay_json.h"

namespace annulus {

/// The scripts of a history without their last `count` operations; a script that nothing is left of goes. Fails if
/// there are fewer operations, or a text is no script.
Result<std::vector<std::string>> WithoutLast(const std::vector<std::string>& scripts, std::size_t count);

/// Carries out a history on the body that it began with, from script to script through the file as `annulus clay` does,
/// so that the same program comes to the same bytes. Fails as the operations do.
Result<ClayFile> Replay(const ClayBody& beginning, const std::vector<std::string>& scripts);

/// Undo: the file as it was before its last `count` operations, to the byte; `beginning` is the body as it was made.
/// Fails if the history on that body does not lead to the file, within 1e-6 mm.
Result<ClayFile> Undone(const ClayFile& file, const ClayBody& beginning, std::size_t count);

}  // namespace annulus
