// GpioLines over libgpiod 2.x, compiled where that is installed instead of gpiod_lines.cpp. Not tested on a kernel yet.
// All lines of a chip are one request, with one descriptor and one edge buffer that drops its oldest edges; the
// sequence numbers say so.
#include <gpiod.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/gpio_chip_paths.h"
#include "firmware_iface/gpio_lines.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr const char* kConsumer = "annulus";
constexpr std::size_t kEdgesPerLine = 16;
/// Some kernels do not wake a poll() when a chip goes: we look at least so often.
constexpr nanoseconds kLook = std::chrono::milliseconds(50);

/// Calls the C function that frees `T`.
template <auto kFree>
struct Freer {
  template <class T>
  void operator()(T* handle) const {
    kFree(handle);
  }
};
using ChipHandle = std::unique_ptr<gpiod_chip, Freer<gpiod_chip_close>>;
using ChipInfoHandle = std::unique_ptr<gpiod_chip_info, Freer<gpiod_chip_info_free>>;
using LineInfoHandle = std::unique_ptr<gpiod_line_info, Freer<gpiod_line_info_free>>;
using SettingsHandle = std::unique_ptr<gpiod_line_settings, Freer<gpiod_line_settings_free>>;
using LineConfigHandle = std::unique_ptr<gpiod_line_config, Freer<gpiod_line_config_free>>;
using RequestConfigHandle = std::unique_ptr<gpiod_request_config, Freer<gpiod_request_config_free>>;
using RequestHandle = std::unique_ptr<gpiod_line_request, Freer<gpiod_line_request_release>>;
using BufferHandle = std::unique_ptr<gpiod_edge_event_buffer, Freer<gpiod_edge_event_buffer_free>>;

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
  const ChipInfoHandle chip_info(chip ? gpiod_chip_get_info(chip.get()) : nullptr);
  if (!chip_info) {
    info.problem = std::strerror(errno);
    return info;
  }
  info.label = TextOf(gpiod_chip_info_get_label(chip_info.get()));
  for (unsigned int offset = 0; offset < gpiod_chip_info_get_num_lines(chip_info.get()); ++offset) {
    const LineInfoHandle line(gpiod_chip_get_line_info(chip.get(), offset));
    if (!line) {
      info.problem = std::strerror(errno);
      return info;
    }
    info.lines.push_back({TextOf(gpiod_line_info_get_name(line.get())), gpiod_line_info_is_used(line.get()),
                          TextOf(gpiod_line_info_get_consumer(line.get()))});
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

gpiod_line_bias BiasOf(GpioBias bias) {
  switch (bias) {
    case GpioBias::kAsIs:
      return GPIOD_LINE_BIAS_AS_IS;
    case GpioBias::kPullUp:
      return GPIOD_LINE_BIAS_PULL_UP;
    case GpioBias::kPullDown:
      return GPIOD_LINE_BIAS_PULL_DOWN;
    case GpioBias::kDisabled:
      return GPIOD_LINE_BIAS_DISABLED;
  }
  return GPIOD_LINE_BIAS_AS_IS;
}

/// Adds one line with its settings; false: errno says why not.
bool Configure(gpiod_line_config* config, unsigned int offset, const GpioLineSpec& spec) {
  const SettingsHandle settings(gpiod_line_settings_new());
  if (!settings) return false;
  const bool output = spec.direction == GpioDirection::kOutput;
  gpiod_line_settings* set = settings.get();
  gpiod_line_settings_set_active_low(set, spec.active_low);
  return gpiod_line_settings_set_direction(set, output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT) ==
             0 &&
         gpiod_line_settings_set_bias(set, BiasOf(spec.bias)) == 0 &&
         gpiod_line_settings_set_edge_detection(
             set, !output && spec.edges ? GPIOD_LINE_EDGE_BOTH : GPIOD_LINE_EDGE_NONE) == 0 &&
         gpiod_line_settings_set_event_clock(set, GPIOD_LINE_CLOCK_MONOTONIC) == 0 &&
         gpiod_line_settings_set_output_value(
             set, spec.initial ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE) == 0 &&
         gpiod_line_config_add_line_settings(config, &offset, 1, set) == 0;
}

/// The lines of one chip: the request, and which of our lines its offsets are.
struct ChipRequest {
  ChipHandle chip;
  RequestHandle request;
  BufferHandle buffer;
  std::map<unsigned int, std::size_t> line_of;  ///< By offset.
  unsigned long last_edge = 0;                  ///< Sequence number of the last edge of any line; the first is 1.
};

class GpiodLines final : public GpioLines {
 public:
  GpiodLines(std::vector<GpioLineSpec> specs, std::vector<GpioPlace> places,
             std::map<std::size_t, ChipRequest> requests, Clock& clock)
      : specs_(std::move(specs)), places_(std::move(places)), requests_(std::move(requests)), clock_(clock) {}

  [[nodiscard]] std::size_t count() const override { return specs_.size(); }

  GpioResult<std::vector<bool>> Read() override {
    std::vector<bool> levels;
    for (std::size_t i = 0; i < specs_.size(); ++i) {
      const auto level = LevelOf(i);
      if (!level) return tl::unexpected<GpioFailure>(level.error());
      levels.push_back(*level);
    }
    return levels;
  }

  GpioResult<void> Write(std::size_t line, bool level) override {
    ENSURE(line < specs_.size() && specs_[line].direction == GpioDirection::kOutput, "only outputs can be set");
    const auto value = level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    if (gpiod_line_request_set_value(RequestOf(line), places_[line].offset, value) == 0) return {};
    return Failed("set '" + specs_[line].name + "'");
  }

  GpioResult<std::optional<GpioEdge>> WaitEdge(nanoseconds deadline) override {
    while (true) {
      if (const auto collected = Poll(nanoseconds(0)); !collected)
        return tl::unexpected<GpioFailure>(collected.error());
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

  gpiod_line_request* RequestOf(std::size_t line) { return requests_.at(places_[line].chip).request.get(); }

  GpioResult<bool> LevelOf(std::size_t line) {
    const auto value = gpiod_line_request_get_value(RequestOf(line), places_[line].offset);
    if (value == GPIOD_LINE_VALUE_ERROR) return Failed("read '" + specs_[line].name + "'");
    return value == GPIOD_LINE_VALUE_ACTIVE;
  }

  /// Waits until a request has edges, at most for `timeout`, and collects them in the order of time.
  GpioResult<void> Poll(nanoseconds timeout) {
    std::vector<pollfd> polled;
    std::vector<ChipRequest*> of;
    for (auto& [chip, request] : requests_) {
      polled.push_back({gpiod_line_request_get_fd(request.request.get()), POLLIN, 0});
      of.push_back(&request);
    }
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
    const timespec limit{seconds.count(), (timeout - seconds).count()};
    const int ready = ppoll(polled.data(), polled.size(), &limit, nullptr);
    if (ready < 0 && errno != EINTR) return Failed("wait for edges");
    if (ready == 0 && timeout > nanoseconds(0)) {
      for (const auto& [chip, request] : requests_) {
        const auto level = LevelOf(request.line_of.begin()->second);
        if (!level) return tl::unexpected<GpioFailure>(level.error());
      }
    }
    const std::size_t first_new = edges_.size();
    for (std::size_t i = 0; ready > 0 && i < polled.size(); ++i) {
      if ((polled[i].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
        errno = ENODEV;
        return Failed("wait for edges");
      }
      if ((polled[i].revents & POLLIN) == 0) continue;
      if (auto read = ReadEdges(*of[i]); !read) return read;
    }
    std::stable_sort(edges_.begin() + static_cast<std::ptrdiff_t>(first_new), edges_.end(),
                     [](const GpioEdge& a, const GpioEdge& b) { return a.host_time < b.host_time; });
    return {};
  }

  GpioResult<void> ReadEdges(ChipRequest& request) {
    const std::size_t capacity = gpiod_edge_event_buffer_get_capacity(request.buffer.get());
    const int count = gpiod_line_request_read_edge_events(request.request.get(), request.buffer.get(), capacity);
    if (count < 0) return Failed("read edges");
    bool lost = false;
    for (unsigned long i = 0; i < static_cast<unsigned long>(count); ++i) {
      gpiod_edge_event* event = gpiod_edge_event_buffer_get_event(request.buffer.get(), i);
      if (event == nullptr) return Failed("read edges");
      const unsigned int offset = gpiod_edge_event_get_line_offset(event);
      const unsigned long number = gpiod_edge_event_get_global_seqno(event);
      lost = lost || number != std::exchange(request.last_edge, number) + 1;
      const nanoseconds time(static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event)));
      edges_.push_back({request.line_of.at(offset),
                        gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
                        std::min(time, clock_.Now()), false});
    }
    return lost ? SayLost(request) : GpioResult<void>{};
  }

  /// Edges of any line may be among the lost ones: all levels anew.
  GpioResult<void> SayLost(const ChipRequest& request) {
    for (const auto& [offset, line] : request.line_of) {
      if (!specs_[line].edges) continue;
      const auto level = LevelOf(line);
      if (!level) return tl::unexpected<GpioFailure>(level.error());
      edges_.push_back({line, *level, clock_.Now(), true});
    }
    return {};
  }

  std::vector<GpioLineSpec> specs_;
  std::vector<GpioPlace> places_;
  std::map<std::size_t, ChipRequest> requests_;  ///< By chip.
  Clock& clock_;
  std::deque<GpioEdge> edges_;
};

/// Requests those of `lines` that are on one chip.
Result<ChipRequest> RequestLines(const GpioChipInfo& info, std::size_t chip, const std::vector<GpioPlace>& places,
                                 const std::vector<GpioLineSpec>& lines) {
  const std::string attempted = "request GPIO lines of " + info.path;
  const auto failed = [&] {
    const std::string seen = errno == EBUSY ? "a line is in use: somebody was faster" : std::strerror(errno);
    return Fail(attempted, seen, "see gpioinfo for who uses the lines, and whether the chip knows bias and edges");
  };
  ChipRequest request;
  request.chip.reset(gpiod_chip_open(info.path.c_str()));
  if (!request.chip) return failed();
  const LineConfigHandle config(gpiod_line_config_new());
  const RequestConfigHandle settings(gpiod_request_config_new());
  if (!config || !settings) return failed();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (places[i].chip != chip) continue;
    if (!Configure(config.get(), places[i].offset, lines[i])) return failed();
    request.line_of[places[i].offset] = i;
  }
  gpiod_request_config_set_consumer(settings.get(), kConsumer);
  gpiod_request_config_set_event_buffer_size(settings.get(), kEdgesPerLine * request.line_of.size());
  request.request.reset(gpiod_chip_request_lines(request.chip.get(), settings.get(), config.get()));
  request.buffer.reset(gpiod_edge_event_buffer_new(kEdgesPerLine * request.line_of.size()));
  if (!request.request || !request.buffer) return failed();
  return request;
}

}  // namespace

Result<std::vector<GpioChipInfo>> ListGpioChips() { return DescribeAll({}); }

Result<std::unique_ptr<GpioLines>> OpenGpioLines(const std::string& chip, const std::vector<GpioLineSpec>& lines,
                                                 Clock& clock) {
  const std::vector<GpioChipInfo> infos = DescribeAll(chip);
  const auto places = FindGpioLines(infos, chip, lines);
  if (!places) return Fail(places);
  std::map<std::size_t, ChipRequest> requests;
  for (const GpioPlace& place : *places) {
    if (requests.contains(place.chip)) continue;
    auto request = RequestLines(infos[place.chip], place.chip, *places, lines);
    if (!request) return Fail(request);
    requests.emplace(place.chip, std::move(*request));
  }
  return std::make_unique<GpiodLines>(lines, *places, std::move(requests), clock);
}

}  // namespace annulus
