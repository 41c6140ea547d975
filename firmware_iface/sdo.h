#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "firmware_iface/canopen.h"

namespace annulus {

/// Service data objects of CiA 301, expedited and segmented, as pure bytes: one side's frames in, its frames out.

/// An object of a node's dictionary.
struct SdoAddress {
  std::uint16_t index = 0;
  std::uint8_t sub_index = 0;
  bool operator==(const SdoAddress&) const = default;
};
/// "2004h:01".
[[nodiscard]] std::string SdoAddressText(SdoAddress address);

/// Abort codes of CiA 301 that are sent here.
enum class SdoAbort : std::uint32_t {
  kToggle = 0x05030000,
  kTimeout = 0x05040000,
  kCommand = 0x05040001,
  kWriteOnly = 0x06010001,
  kReadOnly = 0x06010002,
  kNoObject = 0x06020000,
  kLength = 0x06070010,
  kNoSubIndex = 0x06090011,
  kValueRange = 0x06090030,
  kGeneral = 0x08000000,
  kDeviceState = 0x08000022,
};
[[nodiscard]] std::string SdoAbortText(std::uint32_t code);

/// The largest object that a client accepts, bytes.
inline constexpr std::size_t kMostSdoBytes = 256;

/// One transfer seen from the client: send what TakeRequest() has, give it what the node answers. A transfer that the
/// client itself gave up has a last frame to send, which ends it at the node too. Frames that do not belong to this
/// transfer (another object, the wrong toggle bit) change nothing.
class SdoTransfer {
 public:
  enum class State { kRunning, kDone, kAborted };

  static SdoTransfer Upload(NodeId node, SdoAddress address);
  /// `data`: 1 … kMostSdoBytes bytes.
  static SdoTransfer Download(NodeId node, SdoAddress address, std::vector<std::byte> data);

  /// The frame to send now, once; nothing while an answer is awaited.
  std::optional<CanFrame> TakeRequest();
  [[nodiscard]] bool wants_to_send() const { return request_.has_value(); }
  /// True if the frame was the awaited answer.
  bool Take(const CanFrame& frame);
  /// The frame that tells the node that this transfer is given up.
  [[nodiscard]] CanFrame AbortFrame(SdoAbort reason) const;

  [[nodiscard]] State state() const { return state_; }
  /// What was uploaded, once done.
  [[nodiscard]] const std::vector<std::byte>& data() const { return data_; }
  [[nodiscard]] std::uint32_t abort_code() const { return abort_code_; }
  [[nodiscard]] SdoAddress address() const { return address_; }

 private:
  SdoTransfer(NodeId node, SdoAddress address) : node_(node), address_(address) {}
  bool TakeUpload(const CanFrame& frame, std::uint8_t command);
  bool TakeUploadSegment(const CanFrame& frame, std::uint8_t command);
  bool TakeDownload(const CanFrame& frame, std::uint8_t command);
  void RequestSegment();
  void SendSegment();
  bool GiveUp(SdoAbort reason);
  [[nodiscard]] bool IsOfThisObject(const CanFrame& frame) const;

  NodeId node_;
  SdoAddress address_;
  bool upload_ = true;
  State state_ = State::kRunning;
  bool segmented_ = false;
  bool toggle_ = false;
  std::size_t size_ = 0;  ///< Announced by the node; 0: not told.
  std::size_t sent_ = 0;
  std::vector<std::byte> data_;
  std::optional<CanFrame> request_;
  std::uint32_t abort_code_ = 0;
};

/// A node's objects, as its server reads and writes them.
struct ObjectDictionary {
  std::function<tl::expected<std::vector<std::byte>, SdoAbort>(SdoAddress address)> read;
  std::function<tl::expected<void, SdoAbort>(SdoAddress address, const std::vector<std::byte>& data)> write;
};

/// The server side: one answer to each request of the default SDO.
class SdoServer {
 public:
  SdoServer(NodeId node, ObjectDictionary objects) : node_(node), objects_(std::move(objects)) {}

  /// The answer, if the frame is a request to this node that wants one.
  std::optional<CanFrame> Answer(const CanFrame& request);

 private:
  enum class Mode { kIdle, kUploading, kDownloading };

  [[nodiscard]] CanFrame Reply(std::span<const std::byte> bytes) const;
  CanFrame Abort(SdoAbort reason);
  CanFrame BeginUpload();
  CanFrame UploadSegment(std::uint8_t command);
  CanFrame BeginDownload(const CanFrame& request, std::uint8_t command);
  CanFrame DownloadSegment(const CanFrame& request, std::uint8_t command);
  [[nodiscard]] CanFrame Acknowledge(std::uint8_t command) const;

  NodeId node_;
  ObjectDictionary objects_;
  Mode mode_ = Mode::kIdle;
  SdoAddress address_;
  std::vector<std::byte> data_;
  std::size_t at_ = 0;
  std::size_t announced_ = 0;
  bool toggle_ = false;
};

}  // namespace annulus
