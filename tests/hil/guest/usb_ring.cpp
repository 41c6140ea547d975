#include "tests/hil/guest/usb_ring.h"

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/hil/guest/machine.h"

namespace annulus::hil {

bool WaitForBoards(Clock& clock) {
  const std::chrono::nanoseconds deadline = clock.Now() + std::chrono::seconds(60);
  std::size_t found = 0;
  while (found < kBoards && clock.Now() < deadline) {
    found = 0;
    for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/usb/devices")) {
      std::ifstream product(entry.path() / "idProduct");
      std::string text;
      if (product >> text && text == "a180") ++found;
    }
    if (found < kBoards) clock.SleepUntil(clock.Now() + std::chrono::milliseconds(50));
  }
  Shell("udevadm settle --timeout=30");
  return found == kBoards;
}

UsbRangeRingOptions PatientRingOptions() {
  UsbRangeRingOptions options;
  options.control_timeout = std::chrono::seconds(1);
  return options;
}

std::string SerialOf(std::size_t board) { return "RB" + std::to_string(kFirstSerial + board); }

void Unplug(std::size_t board) { AskHost("usb unplug " + std::to_string(board)); }
void Plug(std::size_t board) { AskHost("usb plug " + std::to_string(board)); }
void KillBoards() { AskHost("usb kill"); }
void StartBoards() { AskHost("usb start"); }

}  // namespace annulus::hil
