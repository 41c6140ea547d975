#include "station/command_io.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace annulus {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr auto kQuietStart = std::chrono::milliseconds(1000);
constexpr auto kTerminalPeriod = std::chrono::milliseconds(100);
constexpr auto kJsonPeriod = std::chrono::milliseconds(50);

double SecondsBetween(SteadyClock::time_point from, SteadyClock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

ProgressDisplay::ProgressDisplay(ProgressMode mode)
    : mode_(mode), terminal_(::isatty(STDERR_FILENO) == 1), stage_start_(SteadyClock::now()) {}

ProgressDisplay::~ProgressDisplay() { Clear(); }

void ProgressDisplay::Show(std::string_view stage, double done, double total) {
  if (mode_ == ProgressMode::kNone || (mode_ == ProgressMode::kAuto && !terminal_)) return;
  const auto now = SteadyClock::now();
  const bool new_stage = stage != stage_;
  const double share = total > 0.0 ? std::clamp(done / total, 0.0, 1.0) : 0.0;
  if (new_stage) {
    stage_ = stage;
    if (share <= 0.0 || share < last_share_) stage_start_ = now;
  }
  last_share_ = share;
  const bool finished = share >= 1.0;
  const double elapsed = SecondsBetween(stage_start_, now);
  const double eta = share > 0.0 ? elapsed * (1.0 - share) / share : 0.0;
  if (mode_ == ProgressMode::kJson) {
    if (!new_stage && !finished && now - last_shown_ < kJsonPeriod) return;
    last_shown_ = now;
    ShowJson(stage, std::min(done, total), total, eta);
    return;
  }
  if (!new_stage && !finished && now - last_shown_ < kTerminalPeriod) return;
  if (!new_stage && !finished && now - stage_start_ < kQuietStart) return;
  last_shown_ = now;
  ShowLine(stage, share, eta);
}

void ProgressDisplay::ShowLine(std::string_view stage, double share, double eta_s) {
  std::array<char, 160> line{};
  const int width = static_cast<int>(std::min<std::size_t>(stage.size(), 60));
  // Of what has not begun to go on (it may wait for a hand) nobody knows how long it takes.
  const int length = share > 0.0 ? std::snprintf(line.data(), line.size(), "\r\x1b[K%-32.*s %3.0f %%  eta %.0f s",
                                                 width, stage.data(), std::floor(100.0 * share), std::ceil(eta_s))
                                 : std::snprintf(line.data(), line.size(), "\r\x1b[K%.*s …", width, stage.data());
  if (length > 0)
    (void)!::write(STDERR_FILENO, line.data(),
                   std::min<std::size_t>(line.size() - 1, static_cast<std::size_t>(length)));
  line_shown_ = true;
}

void ProgressDisplay::ShowJson(std::string_view stage, double done, double total, double eta_s) {
  const nlohmann::ordered_json json{{"stage", stage}, {"done", done}, {"total", total}, {"eta_s", eta_s}};
  const std::string line = json.dump() + "\n";
  (void)!::write(STDERR_FILENO, line.data(), line.size());
}

void ProgressDisplay::Clear() {
  if (!line_shown_) return;
  constexpr std::string_view kErase = "\r\x1b[K";
  (void)!::write(STDERR_FILENO, kErase.data(), kErase.size());
  line_shown_ = false;
}

Status CommandIo::Print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    return Fail("write to standard output", std::strerror(errno), "check where the output goes");
  }
  return {};
}

Status CommandIo::WriteText(const std::string& path, const std::string& text) {
  return WriteFileAtomically(storage_, path, text);
}

Status CommandIo::WriteJson(const std::string& target, const nlohmann::ordered_json& json) {
  const std::string text = json.dump(1) + "\n";
  return target == "-" ? Print(text) : WriteText(target, text);
}

Error InterruptedError(const std::string& attempted) { return {attempted, "stopped by Ctrl-C", "run it again"}; }

}  // namespace annulus
