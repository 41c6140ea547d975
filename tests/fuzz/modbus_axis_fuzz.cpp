#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "firmware_iface/scan_axis.h"

namespace {

using annulus::ModbusFailure;
using annulus::ModbusFault;
using annulus::ModbusReply;
using annulus::ModbusRequest;
using std::chrono::nanoseconds;

void Require(bool condition) {
  if (!condition) std::abort();
}

/// The input, byte by byte; zeros when it is used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  [[nodiscard]] bool empty() const { return at_ >= size_; }
  std::uint8_t Take() { return empty() ? std::uint8_t{0} : data_[at_++]; }
  std::uint16_t TakeWord() {
    const std::uint16_t high = Take();
    return static_cast<std::uint16_t>(high << 8 | Take());
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
};

/// A link whose every reply the input decides: right echo with any content, an earlier reply again, anything, nothing.
class FuzzedLink final : public annulus::ModbusLink {
 public:
  FuzzedLink(Bytes& bytes, annulus::ManualClock& clock) : bytes_(bytes), clock_(clock) {}

  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    Require(request.function == annulus::ModbusFunction::kWriteReadRegisters);
    Require(!request.values.empty() && request.values.size() <= 121);
    Require(request.read_count > 0 && request.read_count <= 125);
    fitting_.reset();
    const std::uint8_t kind = bytes_.Take();
    if (bytes_.empty() || kind % 8 == 0) {
      clock_.SleepUntil(clock_.Now() + timeout);
      return Failure(ModbusFault::kTimeout);
    }
    clock_.SleepUntil(clock_.Now() + std::chrono::milliseconds(2));
    if (kind % 8 == 1) return Failure(static_cast<ModbusFault>(kind / 8 % 4));
    std::vector<std::uint16_t> registers = last_;
    if (kind % 8 != 2) {
      registers.assign(kind % 8 == 3 ? bytes_.Take() % 130 : request.read_count, 0);
      const std::size_t told = kind % 8 == 7 ? registers.size() : std::min<std::size_t>(registers.size(), 8);
      for (std::size_t i = 0; i < told; ++i) registers[i] = bytes_.TakeWord();
    }
    const annulus::AxisRegisterMap map;
    if (kind % 8 >= 5 && registers.size() == request.read_count) {
      registers[map.echo - request.read_address] = request.values[map.counter - request.write_address];
      if (request.read_count > 8 && kind >= 128) FillIdentity(registers, request.read_address);
    }
    last_ = registers;
    const bool echoes =
        registers.size() == request.read_count &&
        registers[map.echo - request.read_address] == request.values[map.counter - request.write_address];
    if (echoes) fitting_ = registers;
    return registers;
  }
  void DiscardInput() override {}
  void Close() override {}
  tl::expected<void, ModbusFailure> Reopen() override { return {}; }

  /// The registers of the last transaction, if they answered it.
  [[nodiscard]] const std::optional<std::vector<std::uint16_t>>& fitting() const { return fitting_; }

 private:
  static ModbusReply Failure(ModbusFault fault) { return tl::unexpected<ModbusFailure>(ModbusFailure{fault, 6, {}}); }
  static void FillIdentity(std::vector<std::uint16_t>& registers, std::uint16_t first) {
    const annulus::AxisRegisterMap map;
    const auto put = [&](std::uint16_t address, std::uint32_t value) {
      registers[address - first] = static_cast<std::uint16_t>(value >> 16);
      registers[static_cast<std::size_t>(address - first) + 1] = static_cast<std::uint16_t>(value);
    };
    registers[map.protocol_version - first] = annulus::kAxisProtocolVersion;
    registers[map.heartbeat_timeout - first] = 200;
    registers[map.start_window - first] = 25;
    put(map.z_min, 0);
    put(map.z_max, 2'000'000);
    put(map.max_speed, 300'000);
    put(map.max_acceleration, 1'500'000);
  }

  Bytes& bytes_;
  annulus::ManualClock& clock_;
  std::vector<std::uint16_t> last_;
  std::optional<std::vector<std::uint16_t>> fitting_;
};

void CheckPosition(annulus::ScanAxis& axis, const FuzzedLink& link) {
  const auto position = axis.Position();
  if (!position || !position->fresh) return;
  Require(link.fitting().has_value());
  const auto& registers = *link.fitting();
  const auto um = static_cast<std::int32_t>(static_cast<std::uint32_t>(registers[3]) << 16 | registers[4]);
  Require(position->z.value() == um / 1000.0);
}

}  // namespace

// Whatever the drive replies: no crash, no wait without end, and a fresh position is the one of the reply to the very
// transaction that asked for it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, std::min<std::size_t>(size, 512));
  annulus::ManualClock clock;
  FuzzedLink link(bytes, clock);
  auto made = annulus::MakeModbusScanAxis(link, {}, clock);
  if (!made) return 0;
  annulus::ScanAxis& axis = **made;
  for (int call = 0; call < 24 && !bytes.empty(); ++call) {
    const nanoseconds before = clock.Now();
    switch (bytes.Take() % 8) {
      case 0:
        static_cast<void>(axis.Enable());
        break;
      case 1:
        static_cast<void>(axis.StartHoming());
        break;
      case 2:
        static_cast<void>(axis.MoveTo(annulus::Millimetres(bytes.TakeWord() / 10.0 - 100.0),
                                      annulus::MillimetresPerSecond(bytes.TakeWord() / 100.0)));
        break;
      case 3:
        static_cast<void>(axis.Halt());
        break;
      case 4:
        static_cast<void>(axis.QuickStop());
        break;
      case 5:
        static_cast<void>(axis.Disable());
        break;
      default:
        CheckPosition(axis, link);
    }
    Require(clock.Now() - before < std::chrono::seconds(10));
  }
  return 0;
}
