#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/support/scan_machine_session.h"

// Two bytes are an operation and its argument (see MachineSession): whatever events come, in whatever order and at
// whatever times, the machine breaks none of its rules.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using Session = annulus::test::MachineSession<annulus::ScanMachine>;
  constexpr std::size_t kMostOperations = 12;  // the deepest state needs eight
  Session session;
  const std::size_t operations = std::min(size / 2, kMostOperations);
  for (std::size_t i = 0; i < operations; ++i) {
    const auto operation = static_cast<std::uint8_t>(data[2 * i] % Session::kOperations);
    if (const char* broken = session.Do(operation, data[2 * i + 1])) {
      std::fprintf(stderr, "scan machine: operation %zu of %zu: %s\n", i + 1, operations, broken);
      std::abort();
    }
  }
  return 0;
}
