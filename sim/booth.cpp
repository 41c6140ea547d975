#include "sim/booth.h"

#include <algorithm>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/usb_frame_codec.h"

namespace annulus::sim {
namespace {

constexpr std::uint64_t kForAxis = 1;
constexpr std::uint64_t kForBoards = 2;
constexpr std::uint32_t kFirstBoardSerial = 1001;

AxisDriveOptions Seeded(AxisDriveOptions options, std::uint64_t seed) {
  options.seed = MixSeed(seed, kForAxis);
  return options;
}

/// The ring as it really is, at the temperature that its boards have.
RingCalibration TrueRing(const BoothOptions& options) {
  const RingCalibration ring =
      options.calibration ? *options.calibration : RingCalibration::Ideal(options.ring_radius_mm);
  return ring.range_mm_per_c == 0.0 ? ring : ring.AtTemperature(options.board.temperature_c);
}

std::unique_ptr<Subject> Present(std::unique_ptr<Subject> subject) {
  ENSURE(subject != nullptr, "somebody stands in the booth");
  return subject;
}

}  // namespace

BoothDevices::BoothDevices(BoothOptions options, Clock& clock)
    : subject_(Present(std::move(options.subject))),
      calibration_(TrueRing(options)),
      beam_(options.beam),
      drive_(Seeded(options.axis, options.seed), clock),
      world_{*subject_, beam_, calibration_, drive_, 2.0 * options.ring_radius_mm},
      safety_({}, clock) {
  ENSURE(calibration_.sensors.size() == kBoards * kSensorsPerBoard, "a booth's ring has 180 sensors");
  const std::size_t boards = kBoards + (options.reference.empty() ? 0 : 1);
  for (std::size_t i = 0; i < boards; ++i) {
    boards_.push_back(std::make_unique<RingBoardModel>(BoardAt(i, options), world_, sync_, clock));
  }
  if (options.hardwired) {
    safety_.Wire(drive_);
    drive_.Wire(safety_);
  }
  if (options.can_buses > 0) HangOnCan(options, clock);
}

RingBoardOptions BoothDevices::BoardAt(std::size_t index, const BoothOptions& options) {
  RingBoardOptions board = options.board;
  board.serial = kFirstBoardSerial + static_cast<std::uint32_t>(index);
  board.first_sensor = static_cast<std::uint16_t>(index * kSensorsPerBoard);
  board.seed = MixSeed(options.seed, kForBoards);
  if (index == kReference) board.reference = options.reference;
  return board;
}

void BoothDevices::HangOnCan(const BoothOptions& options, Clock& clock) {
  ENSURE(options.can_buses <= kBoards, "each bus has a board");
  CanWireOptions wire = options.can_wire;
  wire.fd = options.can_fd;
  for (std::size_t bus = 0; bus < options.can_buses; ++bus) {
    can_wires_.push_back(std::make_unique<CanWire>(wire, clock));
    can_hosts_.push_back(&can_wires_.back()->Connect("can" + std::to_string(bus)));
  }
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    CanBoardOptions board;
    board.board = BoardAt(i, options);
    board.node = static_cast<NodeId>(i + 1);
    board.fd = options.can_fd;
    can_boards_.push_back(std::make_unique<CanBoardModel>(board, world_, can_sync_, clock.Now()));
    // The reference board is the last on the last bus.
    can_wires_[std::min(i, kBoards - 1) * options.can_buses / kBoards]->Attach(*can_boards_.back());
  }
}

std::vector<UsbPort*> BoothDevices::usb_ports() {
  std::vector<UsbPort*> ports;
  for (const auto& board : boards_) ports.push_back(board.get());
  return ports;
}

}  // namespace annulus::sim
