#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/clock.h"
#include "firmware_iface/range_ring.h"

namespace annulus::hil {

/// What the runner plugs into the machine (tests/hil/peers.py): twelve boards around a cylinder of 150 mm radius.
inline constexpr std::size_t kBoards = 12;
inline constexpr std::uint32_t kFirstSerial = 1001;
inline constexpr double kExpectedRangeMm = 450.0;

/// Waits until the kernel has found all boards and udev has made their device nodes, at most 60 s.
[[nodiscard]] bool WaitForBoards(Clock& clock);
/// The ring's options with time-outs for a slow emulated machine.
[[nodiscard]] UsbRangeRingOptions PatientRingOptions();

/// Serial number of a board's USB descriptor.
[[nodiscard]] std::string SerialOf(std::size_t board);

void Unplug(std::size_t board);
void Plug(std::size_t board);
/// SIGKILL to the program that plays the boards: all are gone without a word.
void KillBoards();
void StartBoards();

}  // namespace annulus::hil
