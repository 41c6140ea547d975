#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "base/storage.h"
#include "sim/parametric_body.h"
#include "sim/subject.h"
#include "station/config.h"

namespace annulus {

/// True if `subject` of a configuration is a built-in one: "body" or "head".
[[nodiscard]] bool IsBuiltInSubject(const std::string& subject);

/// The built-in subject, still and undressed: the source of true values. Requires IsBuiltInSubject.
[[nodiscard]] sim::ParametricBody BareSubject(const std::string& subject);

/// Who stands in the simulated booth, dressed and moving as `config` says. Fails if a mesh file cannot be read, or if
/// spectacles are asked for on a mesh, whose face is not known.
Result<std::unique_ptr<sim::Subject>> MakeSimSubject(const SimConfig& config, Storage& storage);

}  // namespace annulus
