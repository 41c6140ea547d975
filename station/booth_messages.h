#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "acquisition/scanner.h"
#include "base/result.h"
#include "base/units.h"
#include "firmware_iface/scan_axis.h"

namespace annulus {

/// What `annulus boothd` and its clients say to each other on a Unix socket (docs/wire_protocol.md): frames of a length
/// (u32, little endian) and so many bytes of JSON, one object with "v", "type" and, from clients, "id".
inline constexpr std::uint32_t kBoothProtocol = 1;
/// Largest text that boothd sends; a client may take longer ones for damage.
inline constexpr std::size_t kMaxBoothMessage = std::size_t{1} << 20;
/// Largest text that a client may send.
inline constexpr std::size_t kMaxBoothRequest = std::size_t{64} << 10;

/// Who a client says that it acts for. Whoever may open the socket is believed: the console has asked for passwords.
enum class BoothRole { kOperator, kTechnician };

// What clients send.

/// First of all: who it is. `control`: wants to give orders; one session at a time can.
struct HelloOrder {
  BoothRole role = BoothRole::kOperator;
  bool control = false;
  std::string client;  ///< Name for the log, at most 64 bytes.
};
struct HomeOrder {};
struct ArmOrder {
  std::string profile;                ///< Of the booth's configuration; at most 64 bytes.
  std::optional<Millimetres> height;  ///< Of the subject, if entered: 300 … 2500 mm.
  bool search = false;                ///< Find the subject's top instead of scanning; no recording.
  std::string out;                    ///< File below boothd's folder of recordings; empty only for a search.
  std::string subject_id;             ///< Pseudonym, at most 128 bytes.
  std::string consent;                ///< Reference, at most 256 bytes.
};
/// `version`: of the status that the operator has looked at.
struct StartOrder {
  std::uint64_t version = 0;
};
/// Anybody may, also before hello.
struct CancelOrder {};
struct AcknowledgeOrder {};
/// Wanted again at least every scan_time::kJogBeat.
struct JogOrder {
  Scanner::JogDirection direction = Scanner::JogDirection::kUp;
};
/// Previews: every `levels`-th level of a sweep, of it every `sensors`-th reading. 0 levels: no more.
struct SubscribeOrder {
  std::uint32_t levels = 1;
  std::uint32_t sensors = 1;
};
/// Wants a status now; it comes before the reply.
struct StatusOrder {};
/// Of a newer protocol.
struct UnknownOrder {
  std::string type;
};
using BoothOrder = std::variant<HelloOrder, HomeOrder, ArmOrder, StartOrder, CancelOrder, AcknowledgeOrder, JogOrder,
                                SubscribeOrder, StatusOrder, UnknownOrder>;

struct BoothRequest {
  std::uint64_t id = 0;  ///< The client's choice; its reply carries it.
  BoothOrder order;
};

/// A request that cannot be read. `id` is 0 unless that much could be read.
struct BadRequest {
  std::uint64_t id = 0;
  Error error;
};

// What boothd sends.

/// One concentrator board of the ring.
struct BoothBoard {
  std::uint32_t serial = 0;
  std::uint16_t first_sensor = 0;
  std::uint16_t sensor_count = 0;
  std::string firmware_version;
};
/// The booth as it was opened.
struct BoothDescription {
  std::string station_id;
  std::string program_version;
  bool simulated = false;  ///< Not one real device.
  double ring_radius_mm = 0.0;
  std::vector<BoothBoard> boards;
  AxisLimits axis;
  std::vector<std::string> profiles;  ///< Names that arm takes.
};
/// The answer to a hello that was accepted.
struct WelcomeMessage {
  std::uint64_t id = 0;  ///< Of the hello.
  bool control = false;
  BoothDescription booth;
};
/// The answer to every other request, and to a hello that was not accepted.
struct ReplyMessage {
  std::uint64_t id = 0;
  Status result;
};
inline constexpr std::size_t kChainFaults = static_cast<std::size_t>(InterlockFault::kLampLost) + 1;
/// Of the safety chain, as in `chain` of a status: "lamp_lost".
[[nodiscard]] const char* ChainFaultName(InterlockFault fault);

/// Sent on every change, at least every 500 ms, and after a hello.
struct StatusMessage {
  ScannerStatus scanner;
  bool controlled = false;     ///< Some session holds control.
  std::uint32_t sessions = 0;  ///< That have said hello.
};
/// A preview of one level.
struct LevelMessage {
  std::uint32_t level = 0;
  std::uint16_t sweep = 0;
  std::chrono::nanoseconds time{0};  ///< Host clock of the level's SYNC.
  double z_mm = 0.0;                 ///< Mean height of its readings, station frame.
  std::uint32_t sensor_step = 1;     ///< range_mm[k] is of sensor k · sensor_step.
  std::vector<double> range_mm;      ///< Raw, to 0.01 mm; NaN: no return.
};
/// A scan, or a search, has ended. The same is in every later status.
struct ResultMessage {
  ScanResult result;
};
/// The last that boothd says before it closes a connection.
struct ByeMessage {
  std::string reason;
};
/// Of a newer protocol.
struct UnknownMessage {
  std::string type;
};
using BoothMessage =
    std::variant<WelcomeMessage, ReplyMessage, StatusMessage, LevelMessage, ResultMessage, ByeMessage, UnknownMessage>;

/// JSON texts. Bytes that are no UTF-8 are replaced, overlong texts cut.
[[nodiscard]] std::string EncodeRequest(const BoothRequest& request);
[[nodiscard]] std::string EncodeMessage(const BoothMessage& message);
/// Unknown keys are skipped, an unknown type is UnknownOrder or UnknownMessage; a key that is missing, of a wrong type
/// or out of range is an error that names it. Nesting deeper than 16 is refused before it is read.
[[nodiscard]] tl::expected<BoothRequest, BadRequest> DecodeRequest(std::string_view json);
[[nodiscard]] Result<BoothMessage> DecodeMessage(std::string_view json);

/// The text with its length before it; nothing if it is empty or longer than kMaxBoothMessage.
[[nodiscard]] std::optional<std::string> BoothFrame(std::string_view json);

/// Takes a stream apart into texts.
class BoothFrameReader {
 public:
  /// `max_text`: a longer frame is an error.
  explicit BoothFrameReader(std::size_t max_text) : max_text_(max_text) {}

  void Append(std::string_view bytes) { buffer_.append(bytes); }
  /// The next whole text, nothing if it has not come yet. An Error (an empty or overlong frame) is final: where the
  /// next one would begin is not known.
  Result<std::optional<std::string>> Next();
  /// Bytes that wait.
  [[nodiscard]] std::size_t waiting() const { return buffer_.size() - begin_; }

 private:
  std::size_t max_text_;
  std::string buffer_;
  std::size_t begin_ = 0;
};

}  // namespace annulus
