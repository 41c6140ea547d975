#pragma once

namespace annulus::faults {

/// Whether this thread is in the program's own code, and not in the simulated machine or the test: allocations fail
/// only there (memory_rows_test.cpp).
inline thread_local bool in_program = false;

/// Sets it for a block.
class ProgramScope {
 public:
  enum class Code { kProgram, kOther };
  explicit ProgramScope(Code code) : before_(in_program) { in_program = code == Code::kProgram; }
  ProgramScope(const ProgramScope&) = delete;
  ProgramScope& operator=(const ProgramScope&) = delete;
  ~ProgramScope() { in_program = before_; }

 private:
  bool before_;
};

}  // namespace annulus::faults
