# Writes a C++ source with a function that returns a file's bytes. Run with cmake -P:
#   INPUT file, OUTPUT source, HEADER that declares the function, FUNCTION its name.
# Bytes, not a string literal: literals may hold at most 65,536 characters.
file(READ ${INPUT} bytes HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
file(WRITE ${OUTPUT} "#include \"${HEADER}\"

namespace annulus {
namespace {
constexpr char kBytes[] = {${bytes}};
}  // namespace

std::string_view ${FUNCTION}() { return {kBytes, sizeof kBytes}; }

}  // namespace annulus
")
