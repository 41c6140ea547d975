#pragma once

#include <functional>
#include <memory>

#include "acquisition/bus_record.h"
#include "acquisition/bus_tap.h"
#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

// Devices whose calls are told to a tap, so that a replay can make the same calls at the same times. With the taps of
// the buses below (tapped_buses.h) that is all it needs:
//
//     BusTap tap;
//     auto ports = TapUsbPorts(booth ports, tap, clock);
//     auto ring = OpenTappedRing({tap, clock}, {.options = o, .seams = n}, [&] { return MakeUsbRangeRing(…, o, clock);
//     });
//     auto axis = OpenTappedAxis({tap, clock}, map, [&] { return MakeModbusScanAxis(tapped link, map, clock); });
//     tap.EndPrelude();
//
// Both borrow tap and clock, which must live longer than the devices.

/// Where taps tell, and by which clock.
struct TapContext {
  BusTap& tap;
  Clock& clock;
};

/// Opens a ring by `open` and taps its calls. `opening` says what it is made of: the same options that `open` gives to
/// the ring, and how many ports or buses it has.
Result<std::unique_ptr<RangeRing>> OpenTappedRing(TapContext context, bus_record::RingOpening opening,
                                                  const std::function<Result<std::unique_ptr<RangeRing>>()>& open);

/// Opens an axis by `open` and taps its positions.
Result<std::unique_ptr<ScanAxis>> OpenTappedAxis(TapContext context, const AxisRegisterMap& map,
                                                 const std::function<Result<std::unique_ptr<ScanAxis>>()>& open);

}  // namespace annulus
