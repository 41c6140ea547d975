#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/recording.h"
#include "acquisition/scan_run.h"
#include "acquisition/tapped_buses.h"
#include "acquisition/tapped_devices.h"
#include "sim/booth.h"

namespace annulus::test {

/// A recording in memory.
class TapeSink final : public ScanSink {
 public:
  Status AppendLevel(const ScanLevel& level) override {
    recording.scan.levels.push_back(level);
    return on_level ? on_level(recording.scan.levels.size()) : Status{};
  }
  Status AppendAxis(std::chrono::nanoseconds time, double z_mm) override {
    recording.axis.push_back({time, z_mm});
    return {};
  }
  Status AppendEvent(std::chrono::nanoseconds time, const std::string& text) override {
    recording.events.push_back({time, text});
    return {};
  }
  Status AppendRaw(RawRecord record) override {
    recording.raw.push_back(std::move(record));
    return {};
  }

  Recording recording;
  std::function<Status(std::size_t count)> on_level;
};

/// A simulated booth whose buses and devices are tapped. With CAN buses in the options, the ring is on them. `between`
/// puts something (faults) between the booth and the taps; the ring is null if it cannot be opened then.
struct TappedBooth {
  struct Between {
    std::function<std::vector<UsbPort*>(const std::vector<UsbPort*>&, Clock&)> usb;
    std::function<std::vector<CanBus*>(const std::vector<CanBus*>&, Clock&)> can;
  };

  explicit TappedBooth(sim::BoothOptions options, const Between& between = {},
                       std::unique_ptr<Clock> other_clock = nullptr)
      : reference(ReferenceOf(options)),
        owned_clock(other_clock != nullptr ? std::move(other_clock) : std::make_unique<ManualClock>()),
        clock(*owned_clock),
        booth(std::move(options), clock),
        link(booth.axis_link(), tap, clock) {
    const TapContext context{tap, clock};
    if (booth.can_buses().empty()) {
      ports = TapUsbPorts(between.usb ? between.usb(booth.usb_ports(), clock) : booth.usb_ports(), tap, clock);
      std::vector<UsbPort*> tapped;
      for (const auto& port : ports) tapped.push_back(port.get());
      UsbRangeRingOptions ring_options;
      ring_options.reference = reference;
      bus_record::RingOpening opening;
      opening.options = ring_options;
      opening.seams = static_cast<std::uint8_t>(tapped.size());
      ring = Opened(OpenTappedRing(context, opening, [&] { return MakeUsbRangeRing(tapped, ring_options, clock); }));
    } else {
      buses = TapCanBuses(between.can ? between.can(booth.can_buses(), clock) : booth.can_buses(), tap, clock);
      std::vector<CanBus*> tapped;
      for (const auto& bus : buses) tapped.push_back(bus.get());
      CanRangeRingOptions ring_options;
      ring_options.reference = reference;
      bus_record::RingOpening opening;
      opening.options = ring_options;
      opening.seams = static_cast<std::uint8_t>(tapped.size());
      ring = Opened(OpenTappedRing(context, opening, [&] { return MakeCanRangeRing(tapped, ring_options, clock); }));
    }
    axis = Opened(OpenTappedAxis(context, {}, [&] { return MakeModbusScanAxis(link, {}, clock); }));
    tap.EndPrelude();
  }

  Result<ScanSummary> Scan(const ScanPlan& plan, ScanSink& sink) {
    EXPECT_TRUE(tap.Attach(sink));
    auto summary = RunScan(*ring, *axis, plan, sink, clock, {{}, stop.get_token()});
    tap.Detach();
    EXPECT_TRUE(tap.status());
    return summary;
  }

  /// The ring's options for the sensors that stand in this booth.
  static std::optional<ReferenceBoardOptions> ReferenceOf(const sim::BoothOptions& options) {
    if (options.reference.empty()) return std::nullopt;
    ReferenceBoardOptions board{sim::BoothDevices::kReferenceSerial, {}};
    for (const ReferenceSensor& sensor : options.reference) board.channels.push_back(sensor.channel);
    return board;
  }

  template <class Device>
  static std::unique_ptr<Device> Opened(Result<std::unique_ptr<Device>> opened) {
    return opened ? std::move(*opened) : nullptr;
  }

  std::optional<ReferenceBoardOptions> reference;
  BusTap tap;
  std::unique_ptr<Clock> owned_clock;
  Clock& clock;
  sim::BoothDevices booth;
  TappedModbusLink link;
  std::vector<std::unique_ptr<UsbPort>> ports;
  std::vector<std::unique_ptr<CanBus>> buses;
  std::unique_ptr<RangeRing> ring;
  std::unique_ptr<ScanAxis> axis;
  std::stop_source stop;
};

}  // namespace annulus::test
