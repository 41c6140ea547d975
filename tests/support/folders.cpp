// The one file that holds absolute paths, so that the compiler cache serves every other one to any checkout.
#include "tests/support/folders.h"

namespace annulus::test {

std::string SourceFolder() { return ANNULUS_SOURCE_DIR; }

std::string BinaryFolder() { return ANNULUS_BINARY_DIR; }

}  // namespace annulus::test
