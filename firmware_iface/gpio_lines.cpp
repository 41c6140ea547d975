#include "firmware_iface/gpio_lines.h"

#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "firmware_iface/gpio_chip_paths.h"

namespace annulus {
namespace {

std::string Attempt(const std::string& chip) {
  return "request GPIO lines of " + (chip.empty() ? std::string("any chip") : "chip '" + chip + "'");
}

std::string Joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text.append(text.empty() ? "" : "; ").append(part);
  return text;
}

bool IsCalled(const GpioChipInfo& info, const std::string& chip) {
  return chip == info.path || chip == info.name || (!info.label.empty() && chip == info.label);
}

std::string ChipText(const GpioChipInfo& info) {
  return info.name + (info.label.empty() ? "" : " (" + info.label + ")") +
         (info.problem.empty() ? "" : ", which cannot be opened: " + info.problem);
}

std::string ChipTexts(const std::vector<GpioChipInfo>& chips) {
  if (chips.empty()) return "this system has no GPIO chip";
  std::vector<std::string> texts;
  texts.reserve(chips.size());
  for (const GpioChipInfo& info : chips) texts.push_back(ChipText(info));
  return "chips are " + Joined(texts);
}

/// Indices of the chips on which to look.
Result<std::vector<std::size_t>> ChipsCalled(const std::vector<GpioChipInfo>& chips, const std::string& chip) {
  std::vector<std::size_t> called;
  for (std::size_t i = 0; i < chips.size(); ++i) {
    if (chip.empty() ? chips[i].problem.empty() : IsCalled(chips[i], chip)) called.push_back(i);
  }
  if (called.empty()) {
    return Fail(
        Attempt(chip), (chip.empty() ? "none can be used" : "there is no such chip") + ("; " + ChipTexts(chips)),
        "connect the I/O board, load its driver, allow access to it (docs/booth.md), or correct the chip's name");
  }
  if (!chip.empty() && called.size() > 1) {
    return Fail(Attempt(chip), "there are two: " + ChipText(chips[called[0]]) + " and " + ChipText(chips[called[1]]),
                "name the chip by its path");
  }
  if (const GpioChipInfo& info = chips[called[0]]; !info.problem.empty()) {
    return Fail(Attempt(chip), ChipText(info), "allow access to it with the udev rule of docs/booth.md");
  }
  return called;
}

/// The one free line that is called so, or what is wrong with it.
tl::expected<GpioPlace, std::string> FindLine(const std::vector<GpioChipInfo>& chips,
                                              const std::vector<std::size_t>& called, const std::string& name) {
  if (name.empty()) return tl::make_unexpected("a line without a name is asked for");
  const std::string line = "line '" + name + "'";
  std::vector<GpioPlace> found;
  for (const std::size_t index : called) {
    for (unsigned int offset = 0; offset < chips[index].lines.size(); ++offset) {
      if (chips[index].lines[offset].name == name) found.push_back({index, offset});
    }
  }
  if (found.empty()) return tl::make_unexpected("there is no " + line);
  const GpioChipInfo& chip = chips[found[0].chip];
  if (found.size() > 1) {
    return tl::make_unexpected(line + " is there twice, on " + chip.name + " and " + chips[found[1].chip].name);
  }
  const GpioLineInfo& info = chip.lines[found[0].offset];
  if (!info.used) return found[0];
  return tl::make_unexpected(line + " is in use by " +
                             (info.consumer.empty() ? std::string("somebody unknown") : "'" + info.consumer + "'"));
}

}  // namespace

std::vector<std::string> GpioChipPaths() {
  const std::string stem = "gpiochip";
  std::map<unsigned long, std::string> by_number;
  std::error_code failed;  // No /dev: no chips.
  for (std::filesystem::directory_iterator entry("/dev", failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(stem) || name.size() == stem.size() || name.size() > stem.size() + 6) continue;
    const std::string number = name.substr(stem.size());
    if (number.find_first_not_of("0123456789") != std::string::npos) continue;
    by_number.emplace(std::stoul(number), entry->path().string());
  }
  std::vector<std::string> paths;
  paths.reserve(by_number.size());
  for (const auto& [number, path] : by_number) paths.push_back(path);
  return paths;
}

Result<std::vector<GpioPlace>> FindGpioLines(const std::vector<GpioChipInfo>& chips, const std::string& chip,
                                             const std::vector<GpioLineSpec>& lines) {
  const auto called = ChipsCalled(chips, chip);
  if (!called) return Fail(called);
  std::vector<GpioPlace> places;
  std::vector<std::string> wrong;
  std::set<std::string> asked;
  for (const GpioLineSpec& line : lines) {
    const auto place = FindLine(chips, *called, line.name);
    if (!place) {
      wrong.push_back(place.error());
    } else if (!asked.insert(line.name).second) {
      wrong.push_back("line '" + line.name + "' is asked for twice");
    } else {
      places.push_back(*place);
    }
  }
  if (!wrong.empty()) {
    return Fail(Attempt(chip), Joined(wrong),
                "compare with gpioinfo; correct the line names in [interlock] or on the chip, or end what uses them");
  }
  return places;
}

Error GpioError(std::string attempted, const GpioFailure& failure) {
  if (failure.fault == GpioFault::kGone) {
    return {std::move(attempted),
            "the GPIO chip was removed" + (failure.detail.empty() ? "" : " (" + failure.detail + ")"),
            "check the I/O board, its cable and its supply; then start again"};
  }
  return {std::move(attempted), failure.detail.empty() ? "the GPIO chip refused" : failure.detail,
          "see the kernel's log (dmesg)"};
}

}  // namespace annulus
