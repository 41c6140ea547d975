#include "firmware_iface/can_ring_orders.h"

#include <string>
#include <utility>

#include "firmware_iface/ring_objects.h"

namespace annulus {
namespace {

/// The board that drives the SYNC wire: that of sensor 0.
constexpr std::size_t kDriver = 0;

}  // namespace

std::optional<std::size_t> CanRingOrders::ProducerOf(std::size_t bus) const {
  for (std::size_t board = 0; board < boards_.size(); ++board) {
    if (boards_[board].bus == bus) return board;
  }
  return std::nullopt;
}

Status CanRingOrders::Write(std::size_t board, SdoAddress address, std::vector<std::byte> data, int attempts) {
  return BusOf(board).Download(boards_[board].node, address, std::move(data), sdo_timeout_, attempts);
}

Status CanRingOrders::WriteAndReadBack(std::size_t board, SdoAddress address, std::uint32_t value) {
  RETURN_IF_ERROR(Write(board, address, ObjectBytes(value), kSdoAttempts));
  const auto read = ReadNumber<std::uint32_t>(BusOf(board), boards_[board].node, address, sdo_timeout_);
  if (!read) return Fail(read);
  if (*read == value) return {};
  return Fail("set object " + SdoAddressText(address) + " of " + BusOf(board).NodeName(boards_[board].node),
              "it reads " + std::to_string(*read) + " instead of " + std::to_string(value), "start the ring again");
}

Status CanRingOrders::SetProducer(std::size_t board, std::uint32_t producer_bit, int attempts) {
  const auto value = static_cast<std::uint32_t>(CobId::kSync) | producer_bit;
  return Write(board, kObjectSyncId, ObjectBytes(value), attempts);
}

Status CanRingOrders::Prepare(std::uint32_t period_us) {
  // Only the change to operational sets a board's sequence back, so each must have been out of it.
  RETURN_IF_ERROR(EnterAll(NmtCommand::kEnterPreOperational, NmtState::kPreOperational));
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    const auto producer = ProducerOf(bus);
    if (!producer) continue;
    RETURN_IF_ERROR(WriteAndReadBack(*producer, kObjectSyncPeriod, period_us));
    const auto drives = static_cast<std::uint8_t>(*producer == kDriver ? 1 : 0);
    RETURN_IF_ERROR(Write(*producer, kObjectDrivesSyncWire, ObjectBytes(drives), kSdoAttempts));
  }
  return EnterAll(NmtCommand::kStart, NmtState::kOperational);
}

Status CanRingOrders::StartSync() {
  // Those that follow the SYNC wire wait for its first edge; the one that drives it comes last.
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    const auto producer = ProducerOf(bus);
    if (producer && *producer != kDriver) {
      RETURN_IF_ERROR(SetProducer(*producer, kSyncProducerBit, kSdoAttempts));
    }
  }
  return SetProducer(kDriver, kSyncProducerBit, kSdoAttempts);
}

Status CanRingOrders::EnterAll(NmtCommand command, NmtState state) {
  const std::string attempted = std::string("make the boards ") + NmtStateText(state);
  for (CanRingBus& bus : buses_) RETURN_IF_ERROR(bus.Send(EncodeNmt({command, 0}), attempted));
  for (std::size_t board = 0; board < boards_.size(); ++board) {
    CanRingBus& bus = BusOf(board);
    const NodeId node = boards_[board].node;
    for (int attempt = 1;; ++attempt) {
      const auto told = ReadNumber<std::uint8_t>(bus, node, kObjectNmtState, sdo_timeout_);
      if (!told) return Fail(told);
      if (*told == static_cast<std::uint8_t>(state)) break;
      if (attempt == kSdoAttempts) {
        return Fail(attempted, bus.NodeName(node) + " is " + NmtStateText(static_cast<NmtState>(*told)) + " instead",
                    "power-cycle the board");
      }
      RETURN_IF_ERROR(bus.Send(EncodeNmt({command, node}), attempted));
    }
    CanNode& known = bus.nodes().at(node);
    known.state = state == NmtState::kOperational ? CanNodeState::kOperational : CanNodeState::kPreOperational;
    known.last_heard = clock_.Now();
  }
  return {};
}

Status CanRingOrders::StopAll(int attempts) {
  Status result;
  const auto keep = [&](Status done) {
    if (!done && result) result = std::move(done);
  };
  const auto end_sync = [&](std::size_t board) {
    if (BusOf(board).health().state != CanState::kDown) keep(SetProducer(board, 0, attempts));
  };
  // The driver of the SYNC wire first: then no board fires, whatever else goes wrong.
  end_sync(kDriver);
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    const auto producer = ProducerOf(bus);
    if (producer && *producer != kDriver) end_sync(*producer);
  }
  for (CanRingBus& bus : buses_) {
    if (bus.health().state == CanState::kDown) continue;
    keep(bus.Send(EncodeNmt({NmtCommand::kEnterPreOperational, 0}), "stop the boards on " + bus.name()));
    bus.CollectAll();
  }
  return result;
}

}  // namespace annulus
