// GpioLines over libgpiod 1.x (its version 2 has another API: gpiod_v2_lines.cpp). One request per line, because the
// first ABI of the kernel gives every line with edges a file descriptor, and a FIFO of 16 edges, of its own.
#include <gpiod.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <memory>
#include <set>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/gpio_chip_paths.h"
#include "firmware_iface/gpio_lines.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr const char* kConsumer = "annulus";
constexpr std::size_t kFifo = 16;
/// Some kernels do not wake a poll() when a chip goes: we look at least so often.
constexpr nanoseconds kLook = std::chrono::milliseconds(50);

struct ChipCloser {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
struct LineReleaser {
  void operator()(gpiod_line* line) const { gpiod_line_release(line); }
};
struct LineIterFreer {
  void operator()(gpiod_line_iter* iter) const { gpiod_line_iter_free(iter); }
};
using ChipHandle = std::unique_ptr<gpiod_chip, ChipCloser>;
using LineHandle = std::unique_ptr<gpiod_line, LineReleaser>;

tl::unexpected<GpioFailure> Failure(const std::string& attempted, int number) {
  // Not ENXIO: an I2C adapter says that of an expander that did not answer once.
  return tl::unexpected<GpioFailure>(
      GpioFailure{number == ENODEV ? GpioFault::kGone : GpioFault::kError, attempted + ": " + std::strerror(number)});
}

std::string TextOf(const char* text) { return text == nullptr ? std::string() : text; }

GpioChipInfo Describe(const std::string& path) {
  GpioChipInfo info;
  info.path = path;
  info.name = path.substr(path.rfind('/') + 1);
  const ChipHandle chip(gpiod_chip_open(path.c_str()));
  if (!chip) {
    info.problem = std::strerror(errno);
    return info;
  }
  info.label = TextOf(gpiod_chip_label(chip.get()));
  const std::unique_ptr<gpiod_line_iter, LineIterFreer> iter(gpiod_line_iter_new(chip.get()));
  if (!iter) {
    info.problem = std::strerror(errno);
    return info;
  }
  while (gpiod_line* line = gpiod_line_iter_next(iter.get())) {
    info.lines.push_back({TextOf(gpiod_line_name(line)), gpiod_line_is_used(line), TextOf(gpiod_line_consumer(line))});
  }
  return info;
}

std::vector<GpioChipInfo> DescribeAll(const std::string& also) {
  std::vector<std::string> paths = GpioChipPaths();
  // A path of the user's own, such as a link that udev made.
  const bool another = also.starts_with('/') && std::find(paths.begin(), paths.end(), also) == paths.end();
  if (another) paths.push_back(also);
  std::vector<GpioChipInfo> chips;
  chips.reserve(paths.size());
  for (const std::string& path : paths) chips.push_back(Describe(path));
  return chips;
}

int FlagsOf(const GpioLineSpec& spec) {
  int flags = spec.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (spec.bias == GpioBias::kPullUp) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  if (spec.bias == GpioBias::kPullDown) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  if (spec.bias == GpioBias::kDisabled) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  return flags;
}

int TypeOf(const GpioLineSpec& spec) {
  if (spec.direction == GpioDirection::kOutput) return GPIOD_LINE_REQUEST_DIRECTION_OUTPUT;
  return spec.edges ? GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES : GPIOD_LINE_REQUEST_DIRECTION_INPUT;
}

/// Requests one line. Its chip stays the owner of the handle's memory.
Result<LineHandle> RequestLine(gpiod_chip* chip, unsigned int offset, const GpioLineSpec& spec) {
  const std::string attempted = "request GPIO line '" + spec.name + "' of " + gpiod_chip_name(chip);
  gpiod_line* line = gpiod_chip_get_line(chip, offset);
  if (line == nullptr) return Fail(attempted, std::strerror(errno), "look whether the chip is still there");
  const gpiod_line_request_config config{kConsumer, TypeOf(spec), FlagsOf(spec)};
  if (gpiod_line_request(line, &config, spec.initial ? 1 : 0) == 0) return LineHandle(line);
  const int number = errno;
  if (number == EBUSY) {
    std::string consumer;
    if (gpiod_line_update(line) == 0) consumer = TextOf(gpiod_line_consumer(line));
    return Fail(attempted,
                "it is in use by " + (consumer.empty() ? std::string("somebody unknown") : "'" + consumer + "'"),
                "end that program; only one may hold the line");
  }
  return Fail(attempted, std::strerror(number),
              number == EINVAL || number == ENOTSUP
                  ? "the chip may know no bias or no edges: set bias = \"as_is\", or take another chip"
                  : "see the kernel's log (dmesg)");
}

class GpiodLines final : public GpioLines {
 public:
  GpiodLines(std::vector<GpioLineSpec> specs, std::vector<ChipHandle> chips, std::vector<LineHandle> lines,
             Clock& clock)
      : specs_(std::move(specs)), chips_(std::move(chips)), lines_(std::move(lines)), clock_(clock) {
    std::set<gpiod_chip*> seen;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (seen.insert(gpiod_line_get_chip(lines_[i].get())).second) one_of_each_chip_.push_back(i);
      if (!specs_[i].edges) continue;
      polled_.push_back({gpiod_line_event_get_fd(lines_[i].get()), POLLIN, 0});
      polled_line_.push_back(i);
    }
  }

  [[nodiscard]] std::size_t count() const override { return lines_.size(); }

  GpioResult<std::vector<bool>> Read() override {
    std::vector<bool> levels;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const auto level = LevelOf(i);
      if (!level) return tl::unexpected<GpioFailure>(level.error());
      levels.push_back(*level);
    }
    return levels;
  }

  GpioResult<void> Write(std::size_t line, bool level) override {
    ENSURE(line < lines_.size() && specs_[line].direction == GpioDirection::kOutput, "only outputs can be set");
    if (gpiod_line_set_value(lines_[line].get(), level ? 1 : 0) != 0) return Failed("set '" + specs_[line].name + "'");
    return {};
  }

  GpioResult<std::optional<GpioEdge>> WaitEdge(nanoseconds deadline) override {
    while (true) {
      if (const auto collected = CollectEdges(); !collected) return tl::unexpected<GpioFailure>(collected.error());
      if (!edges_.empty()) {
        const GpioEdge edge = edges_.front();
        edges_.pop_front();
        return edge;
      }
      const nanoseconds left = deadline - clock_.Now();
      if (left <= nanoseconds(0)) return std::nullopt;
      if (const auto waited = Poll(std::min(left, kLook)); !waited) return tl::unexpected<GpioFailure>(waited.error());
    }
  }

 private:
  static tl::unexpected<GpioFailure> Failed(const std::string& attempted) { return Failure(attempted, errno); }

  GpioResult<bool> LevelOf(std::size_t line) {
    const int level = gpiod_line_get_value(lines_[line].get());
    if (level < 0) return Failed("read '" + specs_[line].name + "'");
    return level != 0;
  }

  /// Waits until a descriptor has edges. A chip that goes is seen here at the latest.
  GpioResult<void> Poll(nanoseconds timeout) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
    const timespec limit{seconds.count(), (timeout - seconds).count()};
    const int ready = ppoll(polled_.data(), polled_.size(), &limit, nullptr);
    if (ready < 0 && errno != EINTR) return Failed("wait for edges");
    if (ready != 0) return {};
    for (const std::size_t line : one_of_each_chip_) {
      if (const auto level = LevelOf(line); !level) return tl::unexpected<GpioFailure>(level.error());
    }
    return {};
  }

  /// Moves what the kernel has into edges_, in the order of time.
  GpioResult<void> CollectEdges() {
    if (polled_.empty()) return {};
    const timespec now{0, 0};
    const int ready = ppoll(polled_.data(), polled_.size(), &now, nullptr);
    if (ready < 0 && errno != EINTR) return Failed("look for edges");
    if (ready <= 0) return {};
    const std::size_t first_new = edges_.size();
    for (std::size_t i = 0; i < polled_.size(); ++i) {
      if ((polled_[i].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
        errno = ENODEV;
        return Failed("wait for edges of '" + specs_[polled_line_[i]].name + "'");
      }
      if ((polled_[i].revents & POLLIN) == 0) continue;
      if (auto read = ReadEdges(polled_[i].fd, polled_line_[i]); !read) return read;
    }
    std::stable_sort(edges_.begin() + static_cast<std::ptrdiff_t>(first_new), edges_.end(),
                     [](const GpioEdge& a, const GpioEdge& b) { return a.host_time < b.host_time; });
    return {};
  }

  GpioResult<void> ReadEdges(int fd, std::size_t line) {
    std::array<gpiod_line_event, kFifo> events{};
    const int count = gpiod_line_event_read_fd_multiple(fd, events.data(), kFifo);
    if (count < 0) return Failed("read edges of '" + specs_[line].name + "'");
    for (int i = 0; i < count; ++i) {
      const gpiod_line_event& event = events[static_cast<std::size_t>(i)];
      // The edges of an active-low line come in logical terms already, as its levels do.
      edges_.push_back({line, event.event_type == GPIOD_LINE_EVENT_RISING_EDGE, HostTime(event.ts), false});
    }
    if (static_cast<std::size_t>(count) < kFifo) return {};
    // The FIFO was full: what came after is lost. The line's own level is the last word.
    const auto level = LevelOf(line);
    if (!level) return tl::unexpected<GpioFailure>(level.error());
    edges_.push_back({line, *level, clock_.Now(), true});
    return {};
  }

  /// Since Linux 5.7 the stamps are of CLOCK_MONOTONIC, which is the host clock; before, of the wall clock, which lies
  /// far in this clock's future and is worth nothing: then the edge is as old as our knowledge of it.
  [[nodiscard]] nanoseconds HostTime(const timespec& stamp) const {
    const nanoseconds time = std::chrono::seconds(stamp.tv_sec) + nanoseconds(stamp.tv_nsec);
    return std::min(time, clock_.Now());
  }

  std::vector<GpioLineSpec> specs_;
  std::vector<ChipHandle> chips_;
  std::vector<LineHandle> lines_;  ///< After their chips: released before those are closed.
  Clock& clock_;
  std::vector<pollfd> polled_;
  std::vector<std::size_t> polled_line_;
  std::vector<std::size_t> one_of_each_chip_;
  std::deque<GpioEdge> edges_;
};

}  // namespace

Result<std::vector<GpioChipInfo>> ListGpioChips() { return DescribeAll({}); }

Result<std::unique_ptr<GpioLines>> OpenGpioLines(const std::string& chip, const std::vector<GpioLineSpec>& lines,
                                                 Clock& clock) {
  const std::vector<GpioChipInfo> infos = DescribeAll(chip);
  const auto places = FindGpioLines(infos, chip, lines);
  if (!places) return Fail(places);
  std::vector<ChipHandle> chips(infos.size());
  std::vector<LineHandle> handles;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const GpioPlace place = (*places)[i];
    ChipHandle& open = chips[place.chip];
    if (!open) open.reset(gpiod_chip_open(infos[place.chip].path.c_str()));
    if (!open) {
      return Fail("open GPIO chip " + infos[place.chip].path, std::strerror(errno), "look whether it is still there");
    }
    auto handle = RequestLine(open.get(), place.offset, lines[i]);
    if (!handle) return Fail(handle);
    handles.push_back(std::move(*handle));
  }
  return std::make_unique<GpiodLines>(lines, std::move(chips), std::move(handles), clock);
}

}  // namespace annulus
