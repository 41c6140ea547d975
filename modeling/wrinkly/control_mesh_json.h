#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

/// Reads a control mesh file (docs/formats.md, "Control mesh"); `name` is for messages. What it describes need not be a
/// good mesh yet: ControlMesh::Make says that. Fails, naming the key, on anything that the format does not have.
[[nodiscard]] Result<ControlMeshParts> ControlMeshFromJson(std::string_view text, std::string_view name);

/// The file of a control mesh. Numbers read back to the same bits.
[[nodiscard]] std::string ControlMeshToJson(const ControlMeshParts& parts);

}  // namespace annulus
