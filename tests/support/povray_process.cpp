#include "tests/support/povray_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>

namespace annulus::test {
namespace {

constexpr const char* kAttempted = "render with povray";

std::string Contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Runs a program in `folder`, its output in `log`; the exit status, or -1.
int Run(const std::vector<std::string>& words, const std::filesystem::path& folder, const std::filesystem::path& log) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (failed != 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

/// The number behind `mark` in the part of the log that begins with `title`, at most two lines long; 0 if there is
/// none.
double NumberAfter(const std::string& log, const std::string& title, const std::string& mark) {
  const std::size_t begin = log.find(title);
  if (begin == std::string::npos) return 0.0;
  const std::string part = log.substr(begin, log.find('\n', log.find('\n', begin) + 1) - begin);
  const std::size_t found = part.find(mark);
  double number = 0.0;
  if (found != std::string::npos) {
    std::from_chars(part.data() + found + mark.size(), part.data() + part.size(), number);
  }
  return number;
}

PovrayTimes TimesOf(const std::string& log, const std::string& title) {
  return {NumberAfter(log, title, "seconds ("), NumberAfter(log, title, "thread(s) with ")};
}

std::vector<std::string> Command(const PovraySampling& sampling, const std::string& name) {
  std::vector<std::string> words = {"povray",
                                    "+I" + name + ".pov",
                                    "+O" + name + ".ppm",
                                    "+FP16",
                                    "File_Gamma=1.0",
                                    fmt::format("+W{}", sampling.width),
                                    fmt::format("+H{}", sampling.height),
                                    fmt::format("+WT{}", sampling.threads),
                                    "-D",
                                    "-V",
                                    "-J"};
  if (sampling.threshold > 0.0) {
    words.insert(words.end(), {"+AM2", fmt::format("+A{:.6f}", sampling.threshold), fmt::format("+R{}", sampling.depth),
                               "Antialias_Gamma=2.2"});
  } else {
    words.emplace_back("-A");
  }
  words.insert(words.end(), sampling.more.begin(), sampling.more.end());
  return words;
}

/// Reads the next number of a PPM's head, comments skipped.
std::optional<int> NextNumber(std::span<const char> bytes, std::size_t& at) {
  while (at < bytes.size() && (bytes[at] == '#' || std::isspace(static_cast<unsigned char>(bytes[at])) != 0)) {
    if (bytes[at] == '#') {
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    } else {
      ++at;
    }
  }
  int number = 0;
  const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), number);
  if (error != std::errc()) return std::nullopt;
  at = static_cast<std::size_t>(end - bytes.data());
  return number;
}

}  // namespace

bool HasPovray() {
  static const bool has = Run({"povray", "--version"}, "/tmp", "/dev/null") == 0;
  return has;
}

Result<RgbImage> ReadLinearPpm(std::span<const char> bytes) {
  constexpr const char* kAdvice = "give a binary PPM of 16 bits";
  if (bytes.size() < 2 || bytes[0] != 'P' || bytes[1] != '6') return Fail("read a picture", "it is no PPM", kAdvice);
  std::size_t at = 2;
  const std::optional<int> width = NextNumber(bytes, at);
  const std::optional<int> height = NextNumber(bytes, at);
  const std::optional<int> white = NextNumber(bytes, at);
  ++at;  // one white-space character
  if (!width || !height || !white || *white != 65535) return Fail("read a picture", "its head is not read", kAdvice);
  RgbImage image = RgbImage::Filled(*width, *height, LinearRgb::Zero());
  if (bytes.size() < at + 6 * image.rgb.size()) return Fail("read a picture", "it ends early", kAdvice);
  for (LinearRgb& pixel : image.rgb) {
    for (int channel = 0; channel < 3; ++channel, at += 2) {
      const int value = 256 * static_cast<unsigned char>(bytes[at]) + static_cast<unsigned char>(bytes[at + 1]);
      pixel[channel] = static_cast<float>(value) / 65535.0F;
    }
  }
  return image;
}

Result<PovrayPicture> RunPovray(const std::string& scene, const PovraySampling& sampling,
                                const std::filesystem::path& folder, const std::string& name) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const std::filesystem::path picture = folder / (name + ".ppm");
  std::filesystem::remove(picture, error);
  std::ofstream(folder / (name + ".pov"), std::ios::binary) << scene;
  const std::filesystem::path log_path = folder / (name + ".log");
  const int status = Run(Command(sampling, name), folder, log_path);
  const std::string log = Contents(log_path);
  if (status != 0) {
    return Fail(
        kAttempted,
        fmt::format("it ended with {}: {}", status, log.substr(log.size() - std::min<std::size_t>(log.size(), 600))),
        "read " + log_path.string());
  }
  const std::string bytes = Contents(picture);
  Result<RgbImage> image = ReadLinearPpm(bytes);
  if (!image) return Fail(image);
  const PovrayTimes radiosity = TimesOf(log, "Radiosity Time:    ");
  const PovrayTimes trace = TimesOf(log, "Trace Time:");
  return PovrayPicture{*std::move(image),
                       {trace.seconds + radiosity.seconds, trace.cpu_seconds + radiosity.cpu_seconds},
                       TimesOf(log, "Parse Time:")};
}

}  // namespace annulus::test
