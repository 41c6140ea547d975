#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/result.h"

namespace annulus::hil {

/// A GPIO chip that the kernel's gpio-sim simulates: named lines, pulled and looked at from outside. Needs root,
/// configfs at /sys/kernel/config and the module gpio-sim. The chip goes when the object ends, or before.
class GpioSimChip {
 public:
  /// Fails if the kernel has no gpio-sim or refuses.
  static Result<std::unique_ptr<GpioSimChip>> Make(const std::string& label, std::vector<std::string> lines) {
    static int count = 0;
    auto chip = std::unique_ptr<GpioSimChip>(new GpioSimChip("annulus" + std::to_string(count++), std::move(lines)));
    const Status made = chip->Configure(label);
    if (!made) return Fail(made);
    return chip;
  }
  GpioSimChip(const GpioSimChip&) = delete;
  GpioSimChip& operator=(const GpioSimChip&) = delete;
  ~GpioSimChip() {
    Remove();
    std::error_code ignored;
    for (std::size_t i = 0; i < lines_.size(); ++i) std::filesystem::remove(LineFolder(i), ignored);
    std::filesystem::remove(config_ / "bank0", ignored);
    std::filesystem::remove(config_, ignored);
  }

  [[nodiscard]] std::string path() const { return "/dev/" + chip_name_; }
  /// Pulls an input's pin up or down.
  void Pull(const std::string& line, bool up) { (void)Put(Pin(line) / "pull", up ? "pull-up" : "pull-down"); }
  /// What a pin has, also that of an output.
  [[nodiscard]] bool Value(const std::string& line) const { return Get(Pin(line) / "value") == "1"; }
  /// Unplugs the chip, whoever uses it.
  void Remove() {
    if (live_) (void)Put(config_ / "live", "0");
    live_ = false;
  }

 private:
  GpioSimChip(const std::string& name, std::vector<std::string> lines)
      : config_("/sys/kernel/config/gpio-sim/" + name), lines_(std::move(lines)) {}

  [[nodiscard]] std::filesystem::path LineFolder(std::size_t i) const {
    return config_ / "bank0" / ("line" + std::to_string(i));
  }
  [[nodiscard]] std::filesystem::path Pin(const std::string& line) const {
    const auto found = std::find(lines_.begin(), lines_.end(), line);
    return pins_ / ("sim_gpio" + std::to_string(found - lines_.begin()));
  }
  static Status Put(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text << std::flush;
    if (out) return {};
    return Fail("write '" + text + "' to " + file.string(), "refused", "load gpio-sim, be root");
  }
  static std::string Get(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string text;
    std::getline(in, text);
    return text;
  }

  Status Configure(const std::string& label) {
    std::error_code failed;
    std::filesystem::create_directory(config_, failed);
    if (!failed) std::filesystem::create_directory(config_ / "bank0", failed);
    if (failed) return Fail("make " + config_.string(), failed.message(), "mount configfs, load gpio-sim, be root");
    RETURN_IF_ERROR(Put(config_ / "bank0" / "num_lines", std::to_string(lines_.size())));
    RETURN_IF_ERROR(Put(config_ / "bank0" / "label", label));
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      std::filesystem::create_directory(LineFolder(i), failed);
      RETURN_IF_ERROR(Put(LineFolder(i) / "name", lines_[i]));
    }
    RETURN_IF_ERROR(Put(config_ / "live", "1"));
    live_ = true;
    chip_name_ = Get(config_ / "bank0" / "chip_name");
    pins_ = std::filesystem::path("/sys/devices/platform") / Get(config_ / "dev_name") / chip_name_;
    // devtmpfs makes the node a little later.
    for (int i = 0; i < 100 && !std::filesystem::exists(path()); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return {};
  }

  std::filesystem::path config_;
  std::vector<std::string> lines_;
  std::filesystem::path pins_;
  std::string chip_name_;
  bool live_ = false;
};

/// The kernel sees a pull a little later than its cause.
inline void LetTheKernelSee() { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }

}  // namespace annulus::hil
