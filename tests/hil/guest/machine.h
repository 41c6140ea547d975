#pragma once

#include <string>

namespace annulus::hil {

/// Whether the long plans are to run (ANNULUS_LONG).
[[nodiscard]] bool IsLongRun();

/// Runs a shell command in the guest; its output. A failing command fails the test, naming it.
std::string Shell(const std::string& command);
/// Runs iproute2's `ip` with these arguments, as Shell. By its full path: the guest's shell prefers busybox's own,
/// which knows no CAN.
std::string Ip(const std::string& arguments);

/// Waits until a device node has the rights that the rules of docs/booth.md give it, at most 20 s: group "annulus",
/// mode 0660. Whether it has.
[[nodiscard]] bool HasRightsOfTheBooth(const std::string& node);

/// Asks the runner on the host to do something ("usb kill") and waits for it, at most 60 s; its reply after "ok". A
/// refusal or silence fails the test.
std::string AskHost(const std::string& request);

}  // namespace annulus::hil
