#pragma once

#include <string>

#include "acquisition/recording.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// Writes a recording as HDF5 (docs/formats.md): one dataset per number, with its unit as the attribute `units`; the
/// header as JSON in the dataset `header_json`. The same recording gives the same bytes. Replaces an existing file
/// atomically.
Status WriteHdf5Recording(Storage& storage, const std::string& path, const Recording& recording);

}  // namespace annulus
