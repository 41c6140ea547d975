#pragma once

#include <string>

namespace annulus::test {

// The root of the source tree that the tests were built from, absolute.
std::string SourceFolder();

// The root of the build tree, absolute: where a test may write.
std::string BinaryFolder();

}  // namespace annulus::test
