#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "base/clock.h"
#include "base/result.h"

namespace annulus {

enum class GpioDirection { kInput, kOutput };
enum class GpioBias { kAsIs, kPullUp, kPullDown, kDisabled };

/// One line as it is asked for. Levels are logical: `active_low` inverts at the edge, once.
struct GpioLineSpec {
  std::string name;  ///< Of the line (gpio-line-names of the device tree or firmware).
  GpioDirection direction = GpioDirection::kInput;
  bool active_low = false;
  GpioBias bias = GpioBias::kAsIs;
  bool edges = false;    ///< Inputs: report both edges.
  bool initial = false;  ///< Outputs: level from the request on.
};

/// A change of level of an input.
struct GpioEdge {
  std::size_t line = 0;  ///< Index into the request.
  bool level = false;    ///< After the edge.
  std::chrono::nanoseconds host_time{0};
  bool after_loss = false;  ///< Edges before this one may have been lost: the line may have been at any level.
};

enum class GpioFault {
  kGone,  ///< A chip was removed: its lines never answer again. Those of other chips can still be written.
  kError,
};
struct GpioFailure {
  GpioFault fault = GpioFault::kError;
  std::string detail;  ///< What the system said.
};
template <class T>
using GpioResult = tl::expected<T, GpioFailure>;

/// The seam to a set of requested GPIO lines: levels and edges. Below it lies libgpiod, or a simulated safety chain.
/// The kernel keeps 16 edges per line and drops more, which `GpioEdge::after_loss` says: levels are always read again
/// after edges. The last edge of a line that is delivered has the level that the line then had. Lines are free again
/// when the object ends; the level of an output is then no longer defined, and an external resistor has to define it.
/// Thread-bound.
class GpioLines {
 public:
  virtual ~GpioLines() = default;

  [[nodiscard]] virtual std::size_t count() const = 0;
  /// The levels of all lines now, in the order of the request; outputs read back what the pin really has where the
  /// hardware can.
  virtual GpioResult<std::vector<bool>> Read() = 0;
  /// Sets one output. Always asks the chip, whatever happened before, on whatever chip.
  virtual GpioResult<void> Write(std::size_t line, bool level) = 0;
  /// The next edge of any input; nothing if none has come when the host clock reaches `deadline`. A deadline in the
  /// past only collects.
  virtual GpioResult<std::optional<GpioEdge>> WaitEdge(std::chrono::nanoseconds deadline) = 0;
};

/// A line as the system lists it.
struct GpioLineInfo {
  std::string name;  ///< Empty if it has none.
  bool used = false;
  std::string consumer;  ///< Who uses it, where known.
};
/// A chip of the system.
struct GpioChipInfo {
  std::string name;  ///< "gpiochip0"
  std::string label;
  std::string path;                 ///< "/dev/gpiochip0"
  std::vector<GpioLineInfo> lines;  ///< By offset.
  std::string problem;              ///< Why it cannot be opened (it then has neither label nor lines); else empty.
};
/// The system's chips; empty where the kernel has none.
Result<std::vector<GpioChipInfo>> ListGpioChips();

/// Requests lines by name on a chip, for this program alone. `chip` is its label, name ("gpiochip0") or path; empty
/// finds each name on any chip. The clock is borrowed and must be the host's. Fails, naming all such lines, on lines
/// that are missing, there twice, or in use (and by whom).
Result<std::unique_ptr<GpioLines>> OpenGpioLines(const std::string& chip, const std::vector<GpioLineSpec>& lines,
                                                 Clock& clock);

/// Where a line is: chip and offset in a list of chips.
struct GpioPlace {
  std::size_t chip = 0;
  unsigned int offset = 0;
};
/// Finds the lines that OpenGpioLines would request, in the order of `lines`; fails as it does. `chips` as
/// ListGpioChips gives them.
Result<std::vector<GpioPlace>> FindGpioLines(const std::vector<GpioChipInfo>& chips, const std::string& chip,
                                             const std::vector<GpioLineSpec>& lines);

/// A failure of a request as an Error: "`attempted`: …", with what to do.
[[nodiscard]] Error GpioError(std::string attempted, const GpioFailure& failure);

}  // namespace annulus
